#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/core/status.hpp"
#include "srmp/planning/joint_path.hpp"

namespace srmp {

/// FoundPath::graph where its bound is the straight line.
inline constexpr char every_path[] = "every path";

/// A path from start to goal as a strategy found it, before it is smoothed.
struct FoundPath {
  JointPath path;
  int goal_index{-1};      ///< of one robot alone: PlanStatistics::goal_index
  double cost{};           ///< joint-space length [rad, prismatic joints m]
  double lower{};          ///< no path of `graph` costs less
  std::string graph{};     ///< as Solution::graph
  std::string found_by{};  ///< as PlanStatistics::found_by
};

/// How much one attempt may do. Budgets are counted in work, never in time, so that results do not depend on the clock.
struct AttemptBudget {
  int round{};  ///< 0, 1, 2, …: each strategy says what work it may do in a round
  double max_cost{std::numeric_limits<double>::infinity()};  ///< a path that costs more is of no use
};

struct Attempt {
  /// solved: `found` is a path. exhausted: the strategy has proved that its graph holds none. timed_out: neither,
  /// within the budget or the deadline. cancelled.
  Status status{Status::timed_out};
  FoundPath found{};
  double lower{};        ///< whatever the status: no path at all costs less
  std::string reason{};  ///< why there is no path: a sentence; may be empty
  bool of_all_paths{};   ///< exhausted: there is no path at all, on whatever graph
};

/// One way to find a path of one robot, or of several robots together. An attempt goes on where the one before it
/// ended, or starts anew with a larger budget; the deadline only stops it.
class Strategy {
 public:
  virtual ~Strategy() = default;
  virtual Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) = 0;
  /// Does the strategy ever prove that there is no path (Status::exhausted)?
  virtual bool can_exhaust() const = 0;
};
using Strategies = std::vector<std::unique_ptr<Strategy>>;

/// Asked after each round: has the plan done all the work that it may do? Then the sentence that says so.
using WorkUsedUp = std::function<std::optional<std::string>()>;

/// Attempts by all strategies in their order, round after round, until one finds a path that costs no more than
/// `weight` times the lower bound known by then, which begins with `lower` (a portfolio: Huberman, Lukose, Hogg 1997,
/// "An Economics Approach to Hard Computational Problems"). Throws PlanningError with the reason of the last strategy
/// that gave one: exhausted when all strategies that can exhaust their graphs have, or one has proved that there is no
/// path at all; timed_out, also when the work is used up, or cancelled.
FoundPath attempt_in_rounds(const Strategies& strategies, double lower, double weight, const Deadline& deadline,
                            const WorkUsedUp& used_up = {});

}  // namespace srmp
