#pragma once

#include <memory>
#include <string>
#include <vector>

#include "srmp/scene/scene.hpp"
#include "srmp/trajectory/placed_constraints.hpp"

namespace srmp {

/// The path constraints of a robot of the scene, whose links, held objects and frames are looked up; null: there are
/// none. Throws InvalidArgument as PathConstraint::validate, for names that do not exist (with the nearest one), for
/// objects that the robot does not hold, for constraints that no planned joint can change, and for frames of the other
/// robots that are `moving` at the same time, or of what they hold.
std::shared_ptr<const PlacedConstraints> place_constraints(const Scene& scene, const std::string& robot,
                                                           const std::vector<PathConstraint>& constraints,
                                                           const std::vector<std::string>& moving = {});

}  // namespace srmp
