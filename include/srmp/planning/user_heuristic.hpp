#pragma once

#include <functional>
#include <map>
#include <string>

#include "srmp/core/matrix.hpp"

namespace srmp {

/// A heuristic of the user: estimates the joint-space path length [rad; prismatic joints in m] from each of
/// `configurations` (n, dof) to the nearest of `goals` (m, dof), as n numbers, finite and >= 0. A search from the goals
/// leads to the start: `goals` is the start then. The same arguments must give the same values; plan_many, and
/// plan_multi with num_threads above 1, call it from several threads at once.
using HeuristicFunction = std::function<Eigen::VectorXd(ConstRows configurations, ConstRows goals)>;

/// A heuristic of the user, and what is known of it.
struct UserHeuristic {
  HeuristicFunction function;  ///< computes the estimates
  /// The user declares that h(a) <= |b - a| + h(b) for all configurations and h = 0 at the goals; only then do
  /// bounds count as proven.
  bool consistent{false};
};

using UserHeuristics = std::map<std::string, UserHeuristic>;  ///< heuristics of the user, by name

/// Throws InvalidArgument for a name that is in use, empty, or has spaces, commas or brackets, and for an empty
/// function.
void require_new_heuristic(const std::string& name, const UserHeuristic& heuristic, const UserHeuristics& known);

/// Evaluates the heuristic: n values. Throws InvalidArgument, with name, value and configuration, unless all are finite
/// and >= 0.
Eigen::VectorXd evaluate(const std::string& name, const UserHeuristic& heuristic, ConstRows configurations,
                         ConstRows goals);

}  // namespace srmp
