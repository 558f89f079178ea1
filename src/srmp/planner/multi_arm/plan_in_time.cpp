#include "srmp/planner/multi_arm/plan_in_time.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/planner/multi_arm/timed_motion.hpp"
#include "srmp/trajectory/certify.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

constexpr std::size_t first_points = 128;  // of the first roadmap; each next one has four times as many
constexpr int most_levels = 3;
constexpr int levels_for_sooner = 1;  // where there is a motion already
constexpr std::uint64_t looks_for_sooner = 500'000;
constexpr std::uint64_t most_looks = 20'000'000;
constexpr int most_repairs = 32;     // of ways that cannot be proved
constexpr int most_rounds = 4;       // of improvements
constexpr double step_time = 0.05;   // [s] between the departures that are tried
constexpr double least_gain = 1e-6;  // [s, rad] of an improvement
constexpr double infinity = std::numeric_limits<double>::infinity();

/// One motion from rest to rest.
struct Move {
  RowMatrix waypoints;
  double leaves{};    // [s]
  Trajectory motion;  // from time 0
  double arrives() const { return leaves + end_of(motion); }
};
using Moves = std::vector<Move>;

double length(const Moves& moves) {
  double sum = 0.0;
  for (const Move& move : moves)
    for (Eigen::Index k = 1; k < move.waypoints.rows(); ++k)
      sum += (move.waypoints.row(k) - move.waypoints.row(k - 1)).norm();
  return sum;
}

RowMatrix without_row(const RowMatrix& rows, Eigen::Index left_out) {
  RowMatrix kept(rows.rows() - 1, rows.cols());
  kept << rows.topRows(left_out), rows.bottomRows(rows.rows() - 1 - left_out);
  return kept;
}

/// The moves of two, one after the other.
RowMatrix both(const RowMatrix& a, const RowMatrix& b) {
  RowMatrix rows(a.rows() + b.rows() - 1, a.cols());
  rows << a, b.bottomRows(b.rows() - 1);
  return rows;
}

class PlanInTime {
 public:
  PlanInTime(const TimedTask& task, double before, const Deadline& deadline)
      : task_(task), before_(before), deadline_(deadline), workspace_(task.alone.make_workspace()) {}

  TimedAnswer run() {
    SafeIntervals map(task_);
    TimedAnswer answer;
    const bool sooner = before_ < infinity;
    std::size_t points = first_points;
    for (int level = 0; level < (sooner ? levels_for_sooner : most_levels); ++level, points *= 4) {
      map.add_points(points);
      answer.status = Status::exhausted;
      for (int repair = 0; repair < most_repairs; ++repair) {
        const SafeIntervals::Result found = map.run(before_, sooner ? looks_for_sooner : most_looks, deadline_);
        answer.expansions += found.expansions;
        answer.status = found.status;
        if (found.status != Status::solved) break;
        Moves moves = moves_of(found.stops);
        const auto met = when_met(joined(moves), task_.others, deadline_);
        if (!met) {
          answer.motion = joined(improved(std::move(moves)));
          return answer;
        }
        answer.status = Status::exhausted;
        if (deadline_.stop_requested()) break;
        map.forbid(found.stops, *met);
      }
      if (deadline_.stop_requested()) {
        answer.status = deadline_.cancelled() ? Status::cancelled : Status::timed_out;
        return answer;
      }
    }
    answer.status = Status::exhausted;
    return answer;
  }

 private:
  Moves moves_of(const std::vector<TimedStop>& stops) const {
    Moves moves;
    Eigen::RowVectorXd last = stops.front().q.transpose();
    for (std::size_t k = 1; k < stops.size(); ++k) {
      RowMatrix rows(2, last.size());
      rows.row(0) = last;
      rows.row(1) = last + task_.alone.robot().difference(stops[k - 1].q, stops[k].q).transpose();
      for (Eigen::Index j = 0; j < last.size(); ++j)  // without rounding, but where it has gone round
        if (std::abs(rows(1, j) - stops[k].q[j]) < 1e-9) rows(1, j) = stops[k].q[j];
      last = rows.row(1);
      if (rows.row(0) != rows.row(1)) moves.push_back({rows, stops[k - 1].leaves, task_.in_time(rows)});
    }
    return moves;
  }

  /// In a row, with the waits between them.
  Trajectory joined(const Moves& moves) const {
    if (moves.empty()) return rest(task_.alone.robot().joint_names(), task_.start.transpose(), 0.0);
    Trajectory all = delayed(moves.front().motion, moves.front().leaves);
    for (std::size_t k = 1; k < moves.size(); ++k) {
      const double wait = moves[k].leaves - end_of(all);
      all = all.followed_by(delayed(moves[k].motion, wait > least_gain ? wait : 0.0));
    }
    return all;
  }

  // --- better

  /// Fewer waypoints, fewer stops, sooner: as long as the whole is proved apart from the others.
  Moves improved(Moves moves) const {
    for (int round = 0; round < most_rounds; ++round) {
      bool better = false;
      for (std::size_t k = 0; k < moves.size(); ++k) {
        while (k + 1 < moves.size() && merge(moves, k)) better = true;
        for (Eigen::Index row = 1; row + 1 < moves[k].waypoints.rows(); ++row)
          while (row + 1 < moves[k].waypoints.rows() && leave_out(moves, k, 1, moves[k].waypoints, row)) better = true;
        if (replace(moves, k, 1, moves[k].waypoints)) better = true;  // sooner
        if (deadline_.stop_requested()) return moves;
      }
      if (!better) break;
    }
    return moves;
  }

  bool merge(Moves& moves, std::size_t k) const {
    const RowMatrix rows = both(moves[k].waypoints, moves[k + 1].waypoints);
    return leave_out(moves, k, 2, rows, moves[k].waypoints.rows() - 1) || replace(moves, k, 2, rows);
  }

  bool leave_out(Moves& moves, std::size_t k, std::size_t count, const RowMatrix& rows, Eigen::Index row) const {
    const Eigen::VectorXd from = rows.row(row - 1).transpose(), to = rows.row(row + 1).transpose();
    if ((task_.alone.robot().difference(from, to) - (to - from)).cwiseAbs().maxCoeff() > 1e-6) return false;  // winds
    return task_.alone.is_motion_free(from, to, *workspace_, true) && replace(moves, k, count, without_row(rows, row));
  }

  /// One move along `rows` in place of moves[k] and those after it, `count` in all, begun as soon as it gets by. Taken
  /// if it arrives sooner, or no later on a shorter way.
  bool replace(Moves& moves, std::size_t k, std::size_t count, const RowMatrix& rows) const {
    const auto first = moves.begin() + static_cast<std::ptrdiff_t>(k),
               last = first + static_cast<std::ptrdiff_t>(count);
    const double arrived = std::prev(last)->arrives();
    Moves now(moves.begin(), first);
    now.push_back({rows, k > 0 ? moves[k - 1].arrives() : 0.0, task_.in_time(rows)});
    now.insert(now.end(), last, moves.end());
    const bool shorter = length(now) < length(moves) - least_gain;
    Move& move = now[k];
    const double latest = arrived - (shorter ? 0.0 : least_gain) - end_of(move.motion);
    for (double leaves = move.leaves; leaves <= latest; leaves += step_time) {
      if (deadline_.stop_requested()) return false;
      move.leaves = leaves;
      const Trajectory all = joined(now);
      if (touches(all, leaves, k + 1 < now.size() ? now[k + 1].leaves : infinity)) continue;
      if (when_met(all, task_.others, deadline_)) continue;
      if (rows.rows() > 2 && !proved_alone(move.motion)) return false;
      moves = std::move(now);
      return true;
    }
    return false;
  }

  bool touches(const Trajectory& motion, double from, double to) const {
    for (const MovingRobot& other : task_.others) {
      const double end = std::min(to, std::max(end_of(motion), end_of(*other.motion)));
      if (look(motion, other, from, end, *other.judge->make_workspace())) return true;
    }
    return false;
  }

  bool proved_alone(const Trajectory& motion) const {
    return certify(motion, task_.judge, task_.limits, {.limits = false, .tightness = 0.01, .deadline = &deadline_})
        .proved_free();
  }

  const TimedTask& task_;
  double before_;
  const Deadline& deadline_;
  Checker::WorkspacePtr workspace_;
};

}  // namespace

TimedAnswer plan_in_time(const TimedTask& task, double before, const Deadline& deadline) {
  return PlanInTime(task, before, deadline).run();
}

}  // namespace srmp
