#pragma once

#include <string>

#include "srmp/collision/checker.hpp"

namespace srmp {

inline constexpr double limit_tolerance =
    1e-6;  ///< [rad or m] starts and goals outside a limit by no more are moved onto it

/// Why the robot cannot be at q: the limit that it exceeds or what it touches, as the end of a sentence; "": it can.
std::string invalidity(const Checker& checker, const Eigen::VectorXd& q, Checker::Workspace& workspace);

}  // namespace srmp
