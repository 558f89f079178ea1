#pragma once

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "srmp/collision/checker.hpp"

namespace srmp {

// The rule by which a start in collision may be left. Of samples along the way, at most `recovery_step` apart in every
// joint, none shows a pair in contact that was not in contact at the sample before, or one that is deeper, by more than
// `recovery_tolerance`, than at any sample before.
inline constexpr double recovery_step = 2.5e-4;     ///< [rad or m]
inline constexpr double recovery_tolerance = 2e-5;  ///< [m]

/// A way by that rule from `start`, in collision but within limits, to a free configuration: straight pieces, within
/// limits, along each of which the sum of the depths falls; a millimetre or so beyond contact where there is room.
/// Empty: there is none, or it is not found within a fixed number of looks.
///
/// Best first (Pearl 1984): from the state with the least sum of depths, along the shortest step that takes all pairs
/// apart to first order (numeric gradients of the depths), along the same for the deepest pair, then joint by joint.
/// The answer depends on checker and start alone. `keep_going` is called at every look; what it throws ends the search.
std::vector<Eigen::VectorXd> find_start_recovery(const Checker& checker, const Eigen::VectorXd& start,
                                                 Checker::Workspace& workspace,
                                                 const std::function<void()>& keep_going = {});

/// The pair by which the path breaks the rule or its end is not free, as Contact::describe has it; "" when it is right.
std::string recovery_violation(const Checker& checker, const std::vector<Eigen::VectorXd>& path,
                               Checker::Workspace& workspace);

}  // namespace srmp
