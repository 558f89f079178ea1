#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "srmp/core/status.hpp"
#include "srmp/planning/world_paths.hpp"
#include "srmp/search/graph.hpp"

namespace srmp {

/// What one arm may do in RoadmapSearch: points on its own way from start to goal and on ways aside, to places where it
/// is in nobody's way.
struct Roadmap {
  struct Way {
    std::uint32_t to{};
    double length{};  ///< [rad, prismatic joints m]
  };
  std::vector<Eigen::VectorXd> points;  ///< free; 0: the start
  std::vector<std::vector<Way>> next;   ///< of each point: where free straight motions lead
  std::uint32_t goal{};
  std::vector<std::uint32_t> asides;  ///< where the ways aside lead
  std::vector<double> to_goal;        ///< of each point: length of the way that is left
};

/// Arms on roadmaps of their own, searched together: a greedy search over the product of the roadmaps (tensor roadmaps:
/// Svestka, Overmars 1998; Solovey, Salzman, Halperin 2016) whose pairs of points, and then of motions, are looked at
/// once and remembered. Quick where arms need only wait for each other or step aside; says nothing when it fails.
/// Threads may share it, each with arms of its own.
class RoadmapSearch {
 public:
  /// Of all arms of the world; the ways aside of each are found when first needed: so many for each corner of its way.
  RoadmapSearch(MultiRobotWorld& world, std::size_t asides);

  struct Result {
    Status status{Status::exhausted};  ///< solved, exhausted (these roadmaps hold no way that will do), timed_out (also
                                       ///< for too many expansions or checks) or cancelled
    JointPath path;
    double cost{};  ///< of the path: its length and a little for each step
    std::uint64_t expansions{};
    std::size_t memory{};  ///< bytes of the search
  };
  struct Effort {
    std::uint64_t max_expansions{}, max_checks{};  ///< checks: of motions of two arms
    double greed{12.0};                            ///< weight of the way that is left
    double below{search::infinity};                ///< only paths that cost less will do
  };
  /// `arms`: in order.
  Result run(const std::vector<std::size_t>& arms, const Effort& effort, const Deadline& deadline);
  /// Of an arm; none when its roadmap is not made yet.
  std::vector<Eigen::VectorXd> places_aside(std::size_t arm) const;
  std::size_t memory() const;  ///< bytes of the roadmaps and of what is known of pairs of points and motions

 private:
  using Point = std::uint32_t;
  class Query;

  Roadmap way_of(std::size_t arm) const;
  void make_asides(std::size_t arm);
  void add_straight(Roadmap& map, std::size_t arm, Point from, const Eigen::VectorXd& q,
                    std::optional<Point> known = {}) const;
  static std::vector<Point> stations(const Roadmap& map);
  std::vector<Eigen::VectorXd> asides(std::size_t arm);
  double out_of_the_way(std::size_t arm, const Eigen::VectorXd& q);

  /// What is known of two arms that may meet: a < b.
  struct Pair {
    Pair(std::size_t first, std::size_t second) : a(first), b(second) {}

    std::size_t a, b;
    /// Of each point of a, of each point of b, as far as asked: do they go together?
    std::vector<std::vector<char>> together;
    /// Do motions of both go together? By the numbers of their points, 16 bits each: from and to of a, of b.
    std::unordered_map<std::uint64_t, bool> passes;
    std::uint64_t checks{};  ///< of their motions
  };
  bool together(Pair& pair, Point p, Point q);
  void look(Pair& pair, std::vector<char>& row, Point p, Point q);
  bool pass(Pair& pair, Point from_a, Point to_a, Point from_b, Point to_b);

  MultiRobotWorld& world_;
  std::size_t asides_;
  std::vector<Roadmap> maps_;
  /// Of each arm: points from start to goal. Other arms' threads read them while its map grows.
  std::vector<std::vector<Eigen::VectorXd>> ways_;
  std::vector<char> has_asides_;  // by arm
  std::map<std::pair<std::size_t, std::size_t>, Pair> pairs_;
};

}  // namespace srmp
