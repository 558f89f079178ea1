#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "srmp/core/status.hpp"
#include "srmp/planning/strategies/retreats.hpp"
#include "srmp/planning/world_paths.hpp"
#include "srmp/search/graph.hpp"

namespace srmp {

struct CompositeRoadmapOptions {
  /// Retreat configurations kept for each branch point, > 0: more let more robots pass each other, and make more edges.
  std::size_t retreats{2};
  /// Candidates checked for each retreat kept, > 0: more find retreats that are out of the other robots' way more
  /// often, and take longer to check.
  std::size_t retreat_candidates{32};
  /// Vertices of a robot's own path from which edges to retreats lead, at most, evenly spread over it: more allow
  /// shorter detours on larger roadmaps.
  std::uint32_t branch_points{2};
  /// Distance between vertices of a straight edge [rad, prismatic joints m], > 0: a finer roadmap lets robots wait in
  /// more places, and has more vertices to check against each other.
  double spacing{0.25};
  /// No retreats are added beyond so many vertices of a robot, < 65 536.
  std::size_t max_vertices{10'000};
  /// Vertices of the other robot that are checked in one call, >= 1: what the checker evaluates at once.
  std::size_t block{16};
  /// Cost of a step in itself [rad], >= 0: more makes robots move at the same time rather than one after the other.
  double step_cost{0.02};
  RetreatOffsets offsets{};  ///< of the retreat candidates from a branch point
};

/// One robot's factor of a CompositeRoadmap: its single-robot path from start to goal, and edges from it to retreat
/// configurations, where it is out of the other robots' way.
struct Roadmap {
  struct Edge {
    std::uint32_t to{};
    double length{};  ///< [rad, prismatic joints m]
  };
  std::vector<Eigen::VectorXd> vertices;  ///< free configurations; 0: the start
  std::vector<std::vector<Edge>> edges;   ///< by vertex: free straight motions, in both directions
  std::uint32_t goal{};
  std::vector<std::uint32_t> retreats;       ///< vertices
  std::vector<double> cost_to_go;            ///< by vertex: length of the shortest path to the goal
  std::vector<std::optional<Edge>> to_goal;  ///< by vertex: the first edge of that path; none at the goal
};

/// Robots on roadmaps of their own, searched jointly: weighted best-first search with lazy edges over the product of
/// the roadmaps (Švestka, Overmars 1998, "Coordinated path planning for multiple robots"; Solovey, Salzman, Halperin
/// 2016, "Finding a needle in an exponential haystack"). Pairs of vertices, and then of edges, are checked once and
/// remembered. Quick where robots need only wait for each other or retreat; `exhausted` says nothing about paths off
/// these roadmaps. Threads may share it, each with robots of its own.
class CompositeRoadmap {
 public:
  /// Of all robots of the world, which must outlive this; the retreats of each are found when first needed. Throws
  /// InvalidArgument for options out of range.
  explicit CompositeRoadmap(MultiRobotWorld& world, CompositeRoadmapOptions options = {});

  struct Result {
    Status status{Status::exhausted};  ///< solved, exhausted (no path on these roadmaps within max_cost), timed_out
                                       ///< (also when the budget is used up) or cancelled
    JointPath path;
    double cost{};  ///< of the path: its length and step_cost for each step
    std::uint64_t expansions{};
    std::size_t memory{};  ///< bytes of the search
  };
  struct SearchBudget {
    std::uint64_t max_expansions{};
    std::uint64_t max_checks{};  ///< of simultaneous motions of two robots
    /// Of a search before it, which has as many checks: without retreats of the robots that have none yet. 0: none.
    std::uint64_t path_expansions{};
    double weight{12.0};                ///< of the cost-to-go, >= 1
    double max_cost{search::infinity};  ///< only paths that cost less
  };
  /// `robots`: numbers in the world, increasing. Where they need only wait for each other, retreats would be found in
  /// vain: SearchBudget::path_expansions says how long to try without.
  Result run(const std::vector<std::size_t>& robots, const SearchBudget& budget, const Deadline& deadline);
  /// Configurations of a robot; none while run() has not needed them.
  std::vector<Eigen::VectorXd> retreats(std::size_t robot) const;
  std::size_t memory() const;  ///< bytes of the roadmaps and of the remembered checks

 private:
  using Vertex = std::uint32_t;
  class Query;

  static constexpr char not_checked = 2;  ///< an entry of Pair::collision_free

  /// What is known of two robots that may conflict: a < b.
  struct Pair {
    Pair(std::size_t first, std::size_t second) : a(first), b(second) {}

    std::size_t a, b;
    /// [vertex of a][vertex of b], as far as checked: are the robots collision-free there?
    std::vector<std::vector<char>> collision_free;
    /// Are two edges collision-free at the same time? By their vertices, 16 bits each: from and to of a, of b.
    std::unordered_map<std::uint64_t, bool> edges_collision_free;
    std::uint64_t checks{};  ///< of simultaneous motions
  };

  void require_options() const;
  Roadmap single_robot_roadmap(std::size_t robot) const;
  void add_edge(Roadmap& map, std::size_t robot, Vertex from, const Eigen::VectorXd& q,
                std::optional<Vertex> known = {}) const;
  std::vector<Vertex> branch_points(const Roadmap& map) const;
  std::vector<Eigen::VectorXd> candidates_of(std::size_t robot) const;
  std::vector<std::size_t> ranked(std::size_t robot, const std::vector<Eigen::VectorXd>& candidates,
                                  const Deadline& deadline);
  void add_retreats(std::size_t robot, const Deadline& deadline);
  void compute_cost_to_go(std::size_t robot);

  bool collision_free(Pair& pair, Vertex p, Vertex q) {
    if (p < pair.collision_free.size())
      if (const std::vector<char>& row = pair.collision_free[p]; q < row.size() && row[q] != not_checked) return row[q];
    return check_collision_free(pair, p, q);
  }
  bool check_collision_free(Pair& pair, Vertex p, Vertex q);
  void check_block(Pair& pair, std::vector<char>& row, Vertex p, Vertex q);
  bool edges_collision_free(Pair& pair, Vertex from_a, Vertex to_a, Vertex from_b, Vertex to_b);

  MultiRobotWorld& world_;
  CompositeRoadmapOptions options_;
  std::vector<Roadmap> maps_;
  /// By robot: the vertices from start to goal. Other robots' threads read them while its roadmap grows.
  std::vector<std::vector<Eigen::VectorXd>> paths_;
  std::vector<char> has_retreats_;  // by robot
  std::map<std::pair<std::size_t, std::size_t>, Pair> pairs_;
};

}  // namespace srmp
