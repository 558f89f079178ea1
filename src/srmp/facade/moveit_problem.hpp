#pragma once

#include <string>

#include "srmp/moveit_request.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

/// PlannerInterface::apply_moveit_request in this scene. A call that throws leaves the scene as it was.
MoveItProblem moveit_problem(const io::RequestFile& request, const std::string& robot, Scene& scene);

}  // namespace srmp
