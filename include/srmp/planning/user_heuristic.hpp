#pragma once

#include <functional>
#include <map>
#include <string>

#include "srmp/core/matrix.hpp"

namespace srmp {

/// The user's estimate of the way [rad; prismatic joints in m] from each of `configurations` (n, dof) to the nearest of
/// `goals` (m, dof): n numbers, finite and >= 0. Searches from the goals are on their way to the start: that is what
/// `goals` holds then. The same question must have the same answer; plan_many, and plan_multi with
/// num_threads above 1, ask from several threads at once.
using HeuristicFunction = std::function<Eigen::VectorXd(ConstRows configurations, ConstRows goals)>;

struct UserHeuristic {
  HeuristicFunction function;
  /// The user's word that h(a) <= |b - a| + h(b) for all configurations and h = 0 at the goals: then bounds count as
  /// proven.
  bool consistent{false};
};

using UserHeuristics = std::map<std::string, UserHeuristic>;  ///< by name

/// Throws InvalidArgument for a name that options could not hold or that is taken, or an empty function.
void require_new_heuristic(const std::string& name, const UserHeuristic& heuristic, const UserHeuristics& known);

/// Asks it, and throws InvalidArgument with name, value and configuration unless the answer is what it should be.
Eigen::VectorXd ask(const std::string& name, const UserHeuristic& heuristic, ConstRows configurations, ConstRows goals);

}  // namespace srmp
