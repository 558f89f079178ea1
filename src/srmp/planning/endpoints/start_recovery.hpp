#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "srmp/collision/checker.hpp"

namespace srmp {

// The rule for leaving a start in collision. At samples of the path, at most `recovery_step` apart in every joint, no
// pair is in contact that was not in contact at the sample before, and none is deeper, by more than
// `recovery_tolerance`, than at any sample before.
inline constexpr double recovery_step = 2.5e-4;     ///< [rad or m]
inline constexpr double recovery_tolerance = 2e-5;  ///< [m]

struct StartRecoveryOptions {
  /// Displacement of a joint for the numeric gradients of penetration depths [rad or m], > 0: smaller is more exact
  /// near edges of the geometry, larger less sensitive to the collision checker's rounding.
  double gradient_step{1e-3};
  /// Aimed at beyond contact [m], >= 0: closer than that, motions are hard to prove collision-free.
  double clearance{1e-3};
  /// Samples of one straight segment, at most: longer segments need fewer expansions.
  int max_segment_samples{400};
  /// Configurations checked for contacts, at most: bounds the time where there is no path.
  int max_checks{20'000};
  /// In (0, 1]: of recovery_tolerance, what the search itself allows; the rest is for depths between samples.
  double tolerance_fraction{0.25};
  /// Of the least squares, > 0: less is more exact, more keeps parallel gradients from doing harm.
  double damping{1e-6};
};

/// A path by the rule above from `start`, which is in collision but within limits, to a free configuration: straight
/// segments, within limits, along each of which the sum of penetration depths falls; about a millimetre beyond contact
/// where there is room. Empty: none was found within max_checks.
///
/// Greedy best-first search (Pearl 1984, "Heuristics"): from the configuration with the least sum of depths, along the
/// shortest step that separates all pairs to first order (damped least squares on numeric gradients), then the same for
/// the deepest pair alone, then joint by joint. The result depends on checker, start and options alone. `keep_going` is
/// called at every check; what it throws ends the search.
std::vector<Eigen::VectorXd> find_start_recovery(const Checker& checker, const Eigen::VectorXd& start,
                                                 Checker::Workspace& workspace,
                                                 const std::function<void()>& keep_going = {},
                                                 const StartRecoveryOptions& options = {});

/// A pair by which the path breaks the rule, where it does; nothing: it keeps it, and may end in contact.
std::optional<Contact> contact_rule_violation(const Checker& checker, const std::vector<Eigen::VectorXd>& path,
                                              Checker::Workspace& workspace);

/// The pair by which the path breaks the rule, or by which its end is in collision, as Contact::describe has it; ""
/// when the path is valid.
std::string recovery_violation(const Checker& checker, const std::vector<Eigen::VectorXd>& path,
                               Checker::Workspace& workspace);

}  // namespace srmp
