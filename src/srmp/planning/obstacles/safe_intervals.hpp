#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "srmp/core/status.hpp"
#include "srmp/planning/obstacles/timed_motion.hpp"
#include "srmp/search/rrt_connect.hpp"
#include "srmp/trajectory/motion_limits.hpp"
#include "srmp/trajectory/placed_constraints.hpp"

namespace srmp {

/// One robot's problem among others that move. References outlive the call.
struct TimedTask {
  const Checker& checker;                 ///< of the robot among all that is static: the quick one
  const Checker& exact_checker;           ///< the same by exact geometry (Coal) alone
  std::vector<MovingRobot> other_robots;  ///< that it may collide with
  Eigen::VectorXd start;                  ///< free
  std::vector<Eigen::VectorXd> targets;   ///< free among all that is static; none: it may end anywhere
  std::vector<Eigen::VectorXd> path;      ///< free among all that is static, from start to a target; may be empty
  MotionLimits limits;                    ///< scaled
  const PlacedConstraints* constraints;   ///< of its path; null: there are none
  /// The time-optimal trajectory along waypoints (m, dof), stationary at both ends. Throws PlanningError once the
  /// deadline has passed.
  std::function<Trajectory(const RowMatrix&)> parameterize;
};

/// Where the robot stops, and when it leaves.
struct TimedStop {
  static constexpr int never = std::numeric_limits<int>::max();

  Eigen::VectorXd q;
  std::uint32_t vertex{};                             ///< of the roadmap
  int step{never};                                    ///< at which it leaves; never: it is at a target
  double leaves() const { return step * time_step; }  ///< [s], if it does
};

struct SafeIntervalOptions {
  /// Nearest neighbours that a vertex is connected with, beside start and targets: more find shorter paths, and make
  /// more edges to check.
  std::size_t neighbours{12};
  /// Distance between vertices along the given path [rad, prismatic joints m], > 0: less lets the robot wait in more
  /// places.
  double spacing{0.6};
  /// Sampled vertices: the probability that a joint is displaced from the path, and how far at most [rad] and [m].
  /// Larger displacements get farther out of the way of others, and are free more rarely.
  double displaced_fraction{0.4};
  double max_displacement{1.6};
  double max_prismatic_displacement{0.5};
  /// Samples drawn for a vertex, at most: more help where little is free, and cost time where nothing is.
  std::size_t max_samples_per_vertex{50};
  /// A departure that is not free is tried again after its wait so far divided by this, at least a step: more finds
  /// earlier departures after long waits, with more checks.
  int wait_divisor{64};
  /// Steps of a wait that are checked between two polls of the deadline.
  int block{256};
};

/// Safe-interval path planning (SIPP: Phillips, Likhachev 2011, "SIPP: Safe Interval Path Planning for Dynamic
/// Environments") on a roadmap of one robot, with lazy edges: straight motions, stationary at both ends, between
/// vertices at which the robot may wait. Time is discrete, in steps of `time_step`; a state is a vertex and an interval
/// of time during which the robot can wait there.
///
/// Guarantee: of all paths on the roadmap in these steps, the one found arrives first, except that departures after
/// waits of more than wait_divisor steps are tried at intervals that grow with the wait. Other robots are taken to move
/// straight between steps: the path must be proved collision-free, and forbidden where that fails.
///
/// The roadmap: start, targets, the given path, and vertices around the path with some joints displaced, drawn from a
/// fixed pseudo-random sequence. Path constraints: samples are projected onto them, and edges have to keep them.
class SafeIntervals {
 public:
  /// References outlive this. Once the deadline has passed, run() says so, and nothing here takes long.
  SafeIntervals(const TimedTask& task, const Deadline& deadline, const SafeIntervalOptions& options = {});

  /// Samples up to `count` more vertices.
  void add_vertices(std::size_t count);

  struct Result {
    /// solved, exhausted (no path on this roadmap arrives early enough), timed_out (also when max_checks are used up)
    /// or cancelled
    Status status{Status::exhausted};
    std::vector<TimedStop> stops;
    std::uint64_t expansions{};
  };
  /// Only paths that arrive earlier than `max_arrival` [s]. `max_checks`: of configurations against the other robots.
  Result run(double max_arrival, std::uint64_t max_checks);
  /// What run() found is not collision-free from one time to another [s]: it is not found again, nor are waits there at
  /// that time, nor departures of the same edge that are later by less than the interval's length.
  void forbid(const std::vector<TimedStop>& stops, double from, double to);

  /// Is the straight motion free of all that is static, and does it keep the path constraints? `a` is free.
  bool is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

  std::uint64_t checks() const { return checks_; }  ///< of configurations against the other robots, so far
  std::uint64_t edge_checks() const { return edge_checks_; }
  std::size_t memory() const;  ///< [bytes]

 private:
  using Vertex = std::uint32_t;
  static constexpr int forever = TimedStop::never;
  struct Interval {
    int from, to;  // steps, both included
  };
  struct Edge {
    bool free{};     // among all that is static
    RowMatrix rows;  // the robot's configurations at each step since its departure
    int steps() const { return static_cast<int>(rows.rows()) - 1; }
  };
  /// An arrival at a vertex.
  struct Node {
    Vertex vertex;
    int interval{-1};  // of the vertex; < 0: not known yet which
    int departure{};   // step at which the robot left the parent's vertex
    int arrival{};     // step
    double length{};   // of the path to here
    bool checked{};    // against the other robots
  };
  class Query;

  void add(Eigen::VectorXd q);
  Eigen::VectorXd sample();
  void connect();
  void find_neighbours(Vertex p);
  void compute_steps_to_go();
  int min_steps(Vertex a, Vertex b) const;
  const Edge& edge(Vertex from, Vertex to);
  Edge checked_edge(Vertex from, Vertex to);
  const std::vector<Interval>& intervals(Vertex p);
  std::vector<char> free_waits(Vertex p);
  void check_waits(std::size_t other, Vertex p, int first, int count, std::vector<char>& free);
  bool is_free(const RowMatrix& rows, int step);
  bool is_goal(Vertex p) const { return task_.targets.empty() || (p > 0 && p <= task_.targets.size()); }
  RowMatrix with_other(std::size_t other, const RowMatrix& rows, int step) const;

  const TimedTask& task_;
  const Deadline& deadline_;
  SafeIntervalOptions options_;
  Checker::WorkspacePtr workspace_;
  std::unique_ptr<ConstraintChecker> constraints_;      // null: there are none
  std::vector<Checker::WorkspacePtr> pair_workspaces_;  // by other robot
  std::vector<RowMatrix> motions_;                      // of the other robots, at each step
  int last_step_{};                                     // from which on all others are stationary
  search::RandomSequence random_{1};
  std::vector<Eigen::VectorXd> vertices_;  // 0: the start; then the targets
  using Neighbours = std::vector<std::pair<double, Vertex>>;
  std::vector<Neighbours> neighbours_;      // of each vertex, the nearest first
  std::vector<std::vector<Vertex>> edges_;  // by vertex: both ways
  std::vector<int> steps_to_go_;            // to a target if there were no other robots
  std::map<std::pair<Vertex, Vertex>, Edge> checked_edges_;
  std::vector<std::optional<std::vector<Interval>>> intervals_;               // by vertex, as far as computed
  std::set<std::pair<Vertex, int>> forbidden_waits_;                          // from this step to the next
  std::set<std::pair<std::pair<Vertex, Vertex>, int>> forbidden_departures_;  // along an edge, at this step
  std::uint64_t checks_{}, edge_checks_{};
  std::size_t max_nodes_{};  // of a search
};

}  // namespace srmp
