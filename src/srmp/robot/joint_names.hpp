#pragma once

#include <string>
#include <vector>

#include "srmp/robot/robot_description.hpp"

namespace srmp {

struct RobotModelImpl;

/// The joint of this name; null: there is none.
const Joint* find_joint(const std::vector<Joint>& joints, const std::string& name);

/// The end of a sentence about a position [rad] outside the limits of a joint: whether it may be in degrees, or "".
std::string degrees_hint(const Joint& joint, double value);

/// Why no position can be given for this name of a joint, as a sentence: it mimics another joint, is fixed, has more
/// than one degree of freedom, or does not exist (with the nearest name).
std::string why_not_a_joint(const RobotModelImpl& robot, const std::string& name);

}  // namespace srmp
