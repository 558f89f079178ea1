#pragma once

#include <string>
#include <vector>

#include "srmp/io/moveit_frames.h"
#include "srmp/planning/goal.hpp"
#include "srmp/trajectory/path_constraint.hpp"

namespace srmp {

/// [rad] MoveIt's tolerance 0 is met by no number; this one stands for it.
inline constexpr double least_rotation = 1e-4;

/// The largest box, in the directions of `axes`' columns, of proportions as the shadow of the box with these half
/// extents, that lies in it: its half extents. `axes` is a rotation; both boxes have the same centre.
Eigen::Vector3d inner_box(const Eigen::Matrix3d& axes, const Eigen::Vector3d& half_extents);

/// Tolerances of a rotation about the end effector's axes [rad] within which MoveIt's constraint holds.
/// `to_constraint` turns rotation vectors from the end effector's axes to those of the constraint's tolerances (of the
/// constrained frame for angles, of the constraint's header for a rotation vector). An axis is left free (infinity)
/// only where a rotation about it keeps `point`, in the end effector's frame [m], in place.
Eigen::Vector3d rotation_tolerance(const io::OrientationConstraint& constraint, const Eigen::Matrix3d& to_constraint,
                                   const Eigen::Vector3d& point);

/// Does the constraint allow every orientation?
bool allows_all(const io::OrientationConstraint& constraint);

/// The goals of a request for a robot of the scene, of which `frames` knows where it starts. Throws InvalidArgument and
/// NotSupported (see apply_moveit_request).
std::vector<GoalConstraint> moveit_goals(const io::RequestFile& request, const Scene& scene,
                                         const io::FrameLookup& frames, const std::string& robot,
                                         const Eigen::VectorXd& start);

/// The path constraints of a request for a robot of the scene, of which `frames` knows where it starts: every motion
/// that keeps them keeps MoveIt's. Frames that the planned joints move, move with them. Throws InvalidArgument for
/// names that do not exist.
std::vector<PathConstraint> moveit_path_constraints(const io::RequestFile& request, const Scene& scene,
                                                    const io::FrameLookup& frames, const std::string& robot);

}  // namespace srmp
