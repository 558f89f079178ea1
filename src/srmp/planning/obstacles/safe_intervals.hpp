#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "srmp/core/status.hpp"
#include "srmp/planning/obstacles/timed_motion.hpp"
#include "srmp/search/rrt_connect.hpp"
#include "srmp/trajectory/motion_limits.hpp"

namespace srmp {

/// What an arm is to do among robots that move. References outlive the call.
struct TimedTask {
  const Checker& alone;                  ///< the arm among all that stands still
  const Checker& judge;                  ///< the same by Coal alone
  std::vector<MovingRobot> others;       ///< that it can meet
  Eigen::VectorXd start;                 ///< free
  std::vector<Eigen::VectorXd> targets;  ///< free among all that stands still; none: it may end anywhere
  std::vector<Eigen::VectorXd> way;      ///< from the start to a target among all that stands still; may be empty
  MotionLimits limits;                   ///< scaled
  /// Along waypoints (m, dof) as fast as it can, from rest to rest.
  std::function<Trajectory(const RowMatrix&)> in_time;
};

/// Where an arm stops, and when it leaves.
struct TimedStop {
  static constexpr int never = std::numeric_limits<int>::max();

  Eigen::VectorXd q;
  std::uint32_t point{};                              ///< of the roadmap
  int step{never};                                    ///< at which it leaves; never: it is at a target
  double leaves() const { return step * time_step; }  ///< [s], if it does
};

/// Safe interval path planning (Phillips, Likhachev 2011) on a roadmap of one arm, with lazy edges: straight motions
/// from rest to rest between points at which it may wait. In steps of 50 ms; a state is a point and an interval of time
/// during which the arm can rest there, so of all ways on the roadmap, in these steps, the one found arrives first (but
/// for waits of more than 6 s: how long they last is tried in steps of a 64th).
///
/// The roadmap: start, targets, the way, and points about the way, some joints moved, by a fixed sequence. Between
/// steps the others are taken to move straight: what is found is to be proved, and forbidden where it cannot be.
class SafeIntervals {
 public:
  /// References outlive this. Once the deadline passes, run says so, and the rest does nothing that takes long.
  SafeIntervals(const TimedTask& task, const Deadline& deadline);

  void add_points(std::size_t count);

  struct Result {
    /// solved, exhausted (this roadmap holds no way that arrives sooner than asked), timed_out (also for too many
    /// looks) or cancelled
    Status status{Status::exhausted};
    std::vector<TimedStop> stops;
    std::uint64_t expansions{};
  };
  /// Only ways that arrive sooner than `before` [s]. `max_looks`: at configurations among the others.
  Result run(double before, std::uint64_t max_looks);
  /// What run found does not hold from one time to another [s]: it will not be found again, nor rests there then, nor
  /// departures that are later by less than this takes.
  void forbid(const std::vector<TimedStop>& stops, double from, double to);

  std::uint64_t looks() const { return looks_; }              ///< at configurations among the others, so far
  std::uint64_t edge_checks() const { return edge_checks_; }  ///< motions looked at
  std::size_t memory() const;                                 ///< [bytes]

 private:
  using Point = std::uint32_t;
  static constexpr int forever = TimedStop::never;
  struct Interval {
    int from, to;  // steps, both included
  };
  struct Way {
    bool known{}, free{};
    RowMatrix rows;  // where the arm is at each step since it left
    int steps() const { return static_cast<int>(rows.rows()) - 1; }
  };
  /// An arrival, known to be possible or still to be looked at.
  struct Node {
    Point point;
    int interval{-1};  // < 0: not known yet which
    int left{};        // step at which it left the parent's point
    int arrival{};
    std::uint32_t parent{};
    double length{};
    bool possible{};
  };
  class Query;

  void add(Eigen::VectorXd q);
  void connect();
  void find_nearest(Point p);
  void find_steps_left();
  int min_steps(Point a, Point b) const;
  const Way& way(Point from, Point to);
  const std::vector<Interval>& intervals(Point p);
  std::vector<char> rests_free(Point p);
  void look_at_rest(std::size_t other, Point p, int first, int count, std::vector<char>& free);
  bool is_free(const RowMatrix& rows, int step);
  bool is_goal(Point p) const { return task_.targets.empty() || (p > 0 && p <= task_.targets.size()); }
  RowMatrix beside(std::size_t other, const RowMatrix& rows, int step) const;

  const TimedTask& task_;
  const Deadline& deadline_;
  Checker::WorkspacePtr workspace_;
  std::vector<Checker::WorkspacePtr> pairs_;  // of the others
  std::vector<RowMatrix> motions_;            // of the others, at each step
  int last_{};                                // step from which all the others rest
  search::RandomSequence sequence_{1};
  std::vector<Eigen::VectorXd> points_;  // 0: the start; then the targets
  using Near = std::vector<std::pair<double, Point>>;
  std::vector<Near> nearest_;             // of each point, the nearest first
  std::vector<std::vector<Point>> next_;  // neighbours
  std::vector<int> left_;                 // steps to a target if nobody were in the way
  std::map<std::pair<Point, Point>, Way> ways_;
  std::vector<std::optional<std::vector<Interval>>> intervals_;
  std::set<std::pair<Point, int>> no_rest_;                         // from this step to the next
  std::set<std::pair<std::pair<Point, Point>, int>> no_departure_;  // along a way, at this step
  std::uint64_t looks_{}, edge_checks_{};
  std::size_t max_nodes_{};  // of a search
};

}  // namespace srmp
