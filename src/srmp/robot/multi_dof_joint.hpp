#pragma once

#include <map>
#include <string>

#include "srmp/core/pose.hpp"
#include "srmp/robot/robot_description.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp {

struct Srdf;
struct Urdf;

// Planar and floating joints are planned as joints of one degree of freedom each.

/// Replaces a planar or a floating joint by joints of one degree of freedom, in the texts of `description` (urdf_text,
/// srdf_text; `urdf` and `srdf`, or nullptr, are what they say) and in its joint_names:
///   planar_bounds: "<joint>/x" and "<joint>/y" [m], prismatic within the bounds, and "<joint>/theta" [rad],
///   continuous; the names are MoveIt's;
///   floating_bounds: "<joint>/x", "<joint>/y" and "<joint>/z" [m], prismatic within the bounds, "<joint>/yaw" and
///   "<joint>/roll" [rad], continuous, with "<joint>/pitch" within ±pi/2 between them, as of Pose::from_rpy.
/// The joint is the first one of its type of the URDF, otherwise the virtual joint of that type of the SRDF, otherwise
/// one called "base" above the root link. The planned group gets the new joints, and states that do not give them have
/// them at 0. Clears the bounds; without any it does nothing. Throws InvalidArgument for bounds of both kinds, bounds
/// that are not finite, empty, or beyond max_length, and names that are taken; FileError for a state of the SRDF that
/// gives the joint another number of values than MoveIt takes, or a quaternion of zeros.
void expand_multi_dof_joint(RobotDescription& description, const Urdf& urdf, const Srdf* srdf);

/// The positions of the joints that planar or floating joint `joint` was replaced by, at its transform, by name; empty:
/// the robot has no such joint. Throws InvalidArgument for a transform that leaves the plane of a planar joint.
std::map<std::string, double> multi_dof_positions(const RobotModel& robot, const std::string& joint,
                                                  const Pose& transform);

}  // namespace srmp
