#include "srmp/planning/obstacles/plan_in_time.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/trajectory/certify.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

constexpr std::size_t first_points = 128;  // of the first roadmap; then four times as many more, and again
constexpr int max_repairs = 32;            // of ways that cannot be proved
constexpr int max_rounds = 4;              // of improvements
constexpr double min_gain = 1e-6;          // [s, rad] of an improvement
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
  for (const Move& move : moves) sum += path_length(move.waypoints);
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
  PlanInTime(const TimedTask& task, const TimedEffort& effort)
      : task_(task),
        effort_(effort),
        workspace_(task.alone.make_workspace()),
        map_(task, effort.deadline),
        watch_(task.others, effort.deadline) {}

  TimedAnswer run() {
    std::size_t points = first_points;
    for (int k = 0; k < effort_.roadmaps && answer_.status == Status::exhausted; ++k, points *= 4) {
      map_.add_points(points);
      if (const auto moves = find()) answer_.motion = joined(improved(*moves));
    }
    answer_.edge_checks = map_.edge_checks();
    answer_.memory_bytes = map_.memory();
    effort_.looks -= std::min(effort_.looks, looks());
    return std::move(answer_);
  }

 private:
  std::uint64_t looks() const { return map_.looks() + watch_.looks(); }
  std::uint64_t looks_left() const { return effort_.looks - std::min(effort_.looks, looks()); }

  /// On this roadmap; where what was found cannot be proved, again without it.
  std::optional<Moves> find() {
    for (int repair = 0; repair < max_repairs; ++repair) {
      const SafeIntervals::Result found = map_.run(effort_.before, looks_left());
      answer_.expansions += found.expansions;
      answer_.status = found.status;
      if (found.status != Status::solved) return std::nullopt;
      Moves moves = moves_of(found.stops);
      const Trajectory motion = joined(moves);
      const auto met = watch_.find(motion);
      if (!met) return moves;
      const Meeting all = watch_.extended(motion, *met);
      map_.forbid(found.stops, all.from, all.to);
    }
    answer_.status = Status::exhausted;
    return std::nullopt;
  }

  Moves moves_of(const std::vector<TimedStop>& stops) const {
    std::vector<Eigen::VectorXd> places;
    for (const TimedStop& stop : stops) places.push_back(stop.q);
    const RowMatrix all = unwrap_waypoints(stack_waypoints(places), task_.limits.continuous);
    Moves moves;
    for (std::size_t k = 1; k < stops.size(); ++k) {
      const RowMatrix rows = all.middleRows(static_cast<Eigen::Index>(k - 1), 2);
      if (rows.row(0) != rows.row(1)) moves.push_back({rows, stops[k - 1].leaves(), task_.in_time(rows)});
    }
    return moves;
  }

  /// In a row, with the waits between them.
  Trajectory joined(const Moves& moves) const {
    if (moves.empty()) return rest(task_.alone.robot().joint_names(), task_.start.transpose(), 0.0);
    Trajectory all = delayed(moves.front().motion, moves.front().leaves);
    for (std::size_t k = 1; k < moves.size(); ++k) {
      const double wait = moves[k].leaves - end_of(all);
      all = all.followed_by(delayed(moves[k].motion, wait > min_gain ? wait : 0.0));
    }
    return all;
  }

  // --- better

  /// Fewer waypoints, fewer stops, sooner: as long as the whole is proved apart from the others.
  Moves improved(Moves moves) {
    for (int round = 0; round < max_rounds; ++round) {
      bool better = false;
      for (std::size_t k = 0; k < moves.size(); ++k) {
        while (k + 1 < moves.size() && merge(moves, k)) better = true;
        for (Eigen::Index row = 1; row + 1 < moves[k].waypoints.rows(); ++row)
          while (row + 1 < moves[k].waypoints.rows() && leave_out(moves, k, 1, moves[k].waypoints, row)) better = true;
        if (replace(moves, k, 1, moves[k].waypoints)) better = true;  // sooner
        if (stops()) return moves;
      }
      if (!better) break;
    }
    return moves;
  }

  bool stops() const { return effort_.improve_until.stop_requested() || looks_left() == 0; }

  bool merge(Moves& moves, std::size_t k) {
    const RowMatrix rows = both(moves[k].waypoints, moves[k + 1].waypoints);
    return leave_out(moves, k, 2, rows, moves[k].waypoints.rows() - 1) || replace(moves, k, 2, rows);
  }

  bool leave_out(Moves& moves, std::size_t k, std::size_t count, const RowMatrix& rows, Eigen::Index row) {
    const Eigen::VectorXd from = rows.row(row - 1).transpose(), to = rows.row(row + 1).transpose();
    if ((task_.alone.robot().difference(from, to) - (to - from)).cwiseAbs().maxCoeff() > 1e-6) return false;  // winds
    return task_.alone.is_motion_free(from, to, *workspace_, {.start_is_free = true}) &&
           replace(moves, k, count, without_row(rows, row));
  }

  /// One move along `rows` in place of moves[k] and those after it, `count` in all, begun as soon as it gets by. Taken
  /// if it arrives sooner, or no later on a shorter way.
  bool replace(Moves& moves, std::size_t k, std::size_t count, const RowMatrix& rows) {
    const auto first = moves.begin() + static_cast<std::ptrdiff_t>(k),
               last = first + static_cast<std::ptrdiff_t>(count);
    const double arrived = std::prev(last)->arrives();
    Moves now(moves.begin(), first);
    now.push_back({rows, k > 0 ? moves[k - 1].arrives() : 0.0, task_.in_time(rows)});
    now.insert(now.end(), last, moves.end());
    const bool shorter = length(now) < length(moves) - min_gain;
    Move& move = now[k];
    const double latest = arrived - (shorter ? 0.0 : min_gain) - end_of(move.motion);
    for (double leaves = move.leaves; leaves <= latest; leaves += time_step) {
      if (stops()) return false;
      move.leaves = leaves;
      const Trajectory all = joined(now);
      if (watch_.look(all, leaves, k + 1 < now.size() ? now[k + 1].leaves : infinity)) continue;
      if (watch_.prove(all)) continue;
      if (rows.rows() > 2 && !proved_alone(move.motion)) return false;
      moves = std::move(now);
      return true;
    }
    return false;
  }

  bool proved_alone(const Trajectory& motion) const {
    return certify(motion, task_.judge, task_.limits,
                   {.limits = false, .gap_tolerance = 0.01, .deadline = &effort_.deadline})
        .proved_free();
  }

  const TimedTask& task_;
  const TimedEffort& effort_;
  Checker::WorkspacePtr workspace_;
  SafeIntervals map_;
  Watch watch_;
  TimedAnswer answer_;
};

}  // namespace

TimedAnswer plan_in_time(const TimedTask& task, const TimedEffort& effort) { return PlanInTime(task, effort).run(); }

}  // namespace srmp
