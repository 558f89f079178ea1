#pragma once

#include "srmp/robot/robot_description.hpp"
#include "srmp/robot/srdf.hpp"
#include "srmp/robot/urdf.hpp"

namespace srmp {

/// Replaces a planar joint by three joints of one degree of freedom, in the texts of `description` (urdf_text,
/// srdf_text; `urdf` and `srdf`, or nullptr, are what they say) and in its joint_names: "<joint>/x" and "<joint>/y"
/// [m], prismatic within description.planar_bounds, which it clears, and "<joint>/theta" [rad], continuous; the names
/// are MoveIt's. The joint is the first planar one of the URDF, otherwise the planar virtual joint of the SRDF,
/// otherwise one called "base" above the root link. The planned group gets the three joints, and states that do not
/// give them have them at 0. Without planar_bounds it does nothing. Throws InvalidArgument for bounds that are not
/// finite, empty, or beyond max_length.
void expand_planar_joint(RobotDescription& description, const Urdf& urdf, const Srdf* srdf);

}  // namespace srmp
