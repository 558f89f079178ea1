#pragma once

#include <string>

#include "srmp/collision/checker.hpp"

namespace srmp {

inline constexpr double limit_tolerance =
    1e-6;  ///< [rad or m] starts and goals outside a limit by no more are moved onto it

/// What a configuration is in contact with or too close to, as the end of a sentence; "": it is free.
std::string contact_sentence(const Checker& checker, const Eigen::VectorXd& q, Checker::Workspace& workspace);
/// The same of one pair of that checker.
std::string contact_sentence(const Checker& checker, Contact contact);

/// Why the robot cannot be at q: the limit that it exceeds or what it touches, as the end of a sentence; "": it can.
std::string invalidity(const Checker& checker, const Eigen::VectorXd& q, Checker::Workspace& workspace);

}  // namespace srmp
