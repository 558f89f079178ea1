#include "srmp/planning/obstacles/plan_in_time.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/core/stopping.hpp"
#include "srmp/trajectory/certify.hpp"
#include "srmp/trajectory/path.hpp"
#include "srmp/trajectory/prove_constraints.hpp"

namespace srmp {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double winding_tolerance = 1e-6;  // [rad] of a motion to differ from the shortest one by full turns

/// One motion, stationary at both ends.
struct Move {
  RowMatrix waypoints;
  double leaves{};    // [s]
  Trajectory motion;  // from time 0
  double arrives() const { return leaves + end_of(motion); }
};
using Moves = std::vector<Move>;

double length(const Moves& moves) {
  double sum = 0.0;
  for (const Move& move : moves) sum += path_length(move.waypoints);
  return sum;
}

RowMatrix without_row(const RowMatrix& rows, Eigen::Index left_out) {
  RowMatrix kept(rows.rows() - 1, rows.cols());
  kept << rows.topRows(left_out), rows.bottomRows(rows.rows() - 1 - left_out);
  return kept;
}

/// Waypoints of two consecutive moves.
RowMatrix joined(const RowMatrix& a, const RowMatrix& b) {
  RowMatrix rows(a.rows() + b.rows() - 1, a.cols());
  rows << a, b.bottomRows(b.rows() - 1);
  return rows;
}

class PlanInTime {
 public:
  PlanInTime(const TimedTask& task, const TimedBudget& budget, const PlanInTimeOptions& options)
      : task_(task),
        budget_(budget),
        options_(options),
        roadmap_(task, budget.deadline, options.roadmap),
        monitor_(task.other_robots, budget.deadline) {}

  TimedResult run() {
    std::size_t vertices = options_.first_vertices;
    try {
      for (int k = 0; k < budget_.roadmaps && result_.status == Status::exhausted; ++k, vertices *= options_.growth) {
        roadmap_.add_vertices(vertices);
        if (const auto moves = find()) result_.motion = in_sequence(improved(*moves));
      }
    } catch (const MotionCheckStopped&) {
      result_.status = stop_status(budget_.deadline).value_or(Status::timed_out);
    }
    result_.edge_checks = roadmap_.edge_checks();
    result_.memory_bytes = roadmap_.memory();
    budget_.checks -= std::min(budget_.checks, checks());
    return std::move(result_);
  }

 private:
  std::uint64_t checks() const { return roadmap_.checks() + monitor_.checks(); }
  std::uint64_t checks_left() const { return budget_.checks - std::min(budget_.checks, checks()); }

  /// Searches the roadmap until what is found can be proved; what cannot is forbidden.
  std::optional<Moves> find() {
    for (int repair = 0; repair < options_.max_repairs; ++repair) {
      const SafeIntervals::Result found = roadmap_.run(budget_.max_arrival, checks_left());
      result_.expansions += found.expansions;
      result_.status = found.status;
      if (found.status != Status::solved) return std::nullopt;
      Moves moves = moves_of(found.stops);
      const Trajectory motion = in_sequence(moves);
      const auto collision = monitor_.find(motion);
      if (!collision) return moves;
      const CollisionInterval whole = monitor_.extended(motion, *collision);
      roadmap_.forbid(found.stops, whole.from, whole.to);
    }
    result_.status = Status::exhausted;
    return std::nullopt;
  }

  Moves moves_of(const std::vector<TimedStop>& stops) const {
    std::vector<Eigen::VectorXd> configurations;
    for (const TimedStop& stop : stops) configurations.push_back(stop.q);
    const RowMatrix all = unwrap_waypoints(stack_waypoints(configurations), task_.limits.continuous);
    Moves moves;
    for (std::size_t k = 1; k < stops.size(); ++k) {
      const RowMatrix rows = all.middleRows(static_cast<Eigen::Index>(k - 1), 2);
      if (rows.row(0) != rows.row(1)) moves.push_back({rows, stops[k - 1].leaves(), task_.parameterize(rows)});
    }
    return moves;
  }

  /// The whole motion, with the waits between the moves.
  Trajectory in_sequence(const Moves& moves) const {
    if (moves.empty()) return stationary(task_.checker.robot().joint_names(), task_.start.transpose(), 0.0);
    Trajectory all = delayed(moves.front().motion, moves.front().leaves);
    for (std::size_t k = 1; k < moves.size(); ++k) {
      const double wait = moves[k].leaves - end_of(all);
      all = all.followed_by(delayed(moves[k].motion, wait > options_.min_gain ? wait : 0.0));
    }
    return all;
  }

  // --- improvement

  /// Fewer waypoints, fewer stops, earlier moves, as long as the whole can be proved.
  Moves improved(Moves moves) {
    try {
      improve(moves);
    } catch (const PlanningError&) {       // The deadline passed while a move was timed,
    } catch (const MotionCheckStopped&) {  // or was checked: `moves` are those before it.
    }
    return moves;
  }

  void improve(Moves& moves) {
    last_check_ = std::min(budget_.checks, 2 * checks() + options_.improvement_checks);
    for (int round = 0; round < options_.max_rounds; ++round) {
      bool better = false;
      for (std::size_t k = 0; k < moves.size(); ++k) {
        while (k + 1 < moves.size() && merge(moves, k)) better = true;
        for (Eigen::Index row = 1; row + 1 < moves[k].waypoints.rows(); ++row)
          while (row + 1 < moves[k].waypoints.rows() && leave_out(moves, k, 1, moves[k].waypoints, row)) better = true;
        if (replace(moves, k, 1, moves[k].waypoints)) better = true;  // earlier
        if (must_stop()) return;
      }
      if (!better) return;
    }
  }

  bool must_stop() const { return budget_.deadline.stop_requested() || checks() >= last_check_; }

  /// Moves k and k + 1 become one.
  bool merge(Moves& moves, std::size_t k) {
    const RowMatrix rows = joined(moves[k].waypoints, moves[k + 1].waypoints);
    return leave_out(moves, k, 2, rows, moves[k].waypoints.rows() - 1) || replace(moves, k, 2, rows);
  }

  /// The same as replace(), without one of the waypoints.
  bool leave_out(Moves& moves, std::size_t k, std::size_t count, const RowMatrix& rows, Eigen::Index row) {
    const Eigen::VectorXd from = rows.row(row - 1).transpose(), to = rows.row(row + 1).transpose();
    const Eigen::VectorXd shortest = task_.checker.robot().difference(from, to);
    if ((shortest - (to - from)).cwiseAbs().maxCoeff() > winding_tolerance) return false;
    return roadmap_.is_motion_free(from, to) && replace(moves, k, count, without_row(rows, row));
  }

  /// Puts one move along `rows` in place of `count` moves from moves[k] on, begun as early as it is collision-free. It
  /// is taken if it arrives earlier, or no later on a shorter path.
  bool replace(Moves& moves, std::size_t k, std::size_t count, const RowMatrix& rows) {
    const auto first = moves.begin() + static_cast<std::ptrdiff_t>(k),
               last = first + static_cast<std::ptrdiff_t>(count);
    const double arrived = std::prev(last)->arrives();
    Moves now(moves.begin(), first);
    now.push_back({rows, k > 0 ? moves[k - 1].arrives() : 0.0, task_.parameterize(rows)});
    now.insert(now.end(), last, moves.end());
    const bool shorter = length(now) < length(moves) - options_.min_gain;
    Move& move = now[k];
    const double latest = arrived - (shorter ? 0.0 : options_.min_gain) - end_of(move.motion);
    for (double leaves = move.leaves; leaves <= latest; leaves += time_step) {
      if (must_stop()) return false;
      move.leaves = leaves;
      const Trajectory all = in_sequence(now);
      const double until = k + 1 < now.size() ? now[k + 1].leaves : infinity;
      if (monitor_.find_collision_at_samples(all, leaves, until)) continue;
      if (monitor_.prove(all)) continue;
      if (rows.rows() > 2 && !is_proved(move.motion)) return false;  // its corners were blended
      moves = std::move(now);
      return true;
    }
    return false;
  }

  /// Among all that is static, and to keep the path constraints.
  bool is_proved(const Trajectory& motion) const {
    Certificate certificate =
        certify(motion, task_.exact_checker, task_.limits,
                {.limits = false, .gap_tolerance = options_.gap_tolerance, .deadline = &budget_.deadline});
    if (!certificate.proved_free()) return false;
    if (task_.constraints) add_constraints(certificate, motion, *task_.constraints, budget_.deadline);
    return keeps_constraints(certificate);
  }

  const TimedTask& task_;
  const TimedBudget& budget_;
  const PlanInTimeOptions& options_;
  SafeIntervals roadmap_;
  CollisionMonitor monitor_;
  std::uint64_t last_check_{};  // of the improvements
  TimedResult result_;
};

}  // namespace

TimedResult plan_in_time(const TimedTask& task, const TimedBudget& budget, const PlanInTimeOptions& options) {
  return PlanInTime(task, budget, options).run();
}

}  // namespace srmp
