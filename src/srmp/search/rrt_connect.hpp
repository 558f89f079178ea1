#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "srmp/core/deadline.hpp"

namespace srmp::search {

/// Numbers in [0, 1) that look random and are the same every time: splitmix64 (Steele, Lea, Flood 2014).
class RandomSequence {
 public:
  explicit RandomSequence(std::uint64_t seed) : state_(seed) {}
  double next();

 private:
  std::uint64_t state_;
};

/// Configurations, vectors of one size, between which motions are straight.
struct RrtSpace {
  std::vector<Eigen::VectorXd> starts;  ///< free
  std::vector<Eigen::VectorXd> goals;   ///< free
  std::vector<char> turns{};            ///< by component: an angle that may go round [rad]; empty: none may
  double longest_step{1.0};             ///< of a motion, > 0
  std::function<Eigen::VectorXd(RandomSequence&)> sample;
  std::function<bool(const Eigen::VectorXd& a, const Eigen::VectorXd& b)> is_motion_free;  ///< `a` is free
};

/// Two trees of motions, from the starts and from the goals, that grow towards each other (Kuffner, LaValle 2000,
/// "RRT-Connect: An Efficient Approach to Single-Query Path Planning"), by a sequence of configurations that is the
/// same every time. The first attempt is the straight way; then whichever is smaller grows, so the end in a narrow
/// place has the most attempts. Quick where a lattice has no way that is found soon; proves nothing.
class RrtConnect {
 public:
  /// `sequence`: another number is another sequence, which mostly leads to another path. Throws InvalidArgument for a
  /// step that is not positive and for vectors of different sizes.
  explicit RrtConnect(RrtSpace space, std::uint64_t sequence = 0);

  /// Goes on until there is a path, from a start to a goal, or `attempts` were made since the first call.
  std::optional<std::vector<Eigen::VectorXd>> grow(std::uint64_t attempts, const Deadline& deadline);
  std::uint64_t attempts() const { return attempts_; }
  std::size_t memory() const;

 private:
  struct Tree {
    std::vector<std::vector<double>> columns;  // one a component; rows are nodes
    std::vector<std::size_t> parents;          // its own number: a root
    std::size_t size() const { return parents.size(); }
  };

  Eigen::VectorXd node(const Tree& tree, std::size_t i) const;
  void add(Tree& tree, const Eigen::VectorXd& q, std::size_t parent);
  Eigen::VectorXd difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;
  std::size_t nearest(const Tree& tree, const Eigen::VectorXd& q);
  bool extend(Tree& tree, std::size_t from, const Eigen::VectorXd& towards);
  bool connect(Tree& tree, const Eigen::VectorXd& q);
  std::optional<std::vector<Eigen::VectorXd>> straight_way() const;
  std::vector<Eigen::VectorXd> path() const;

  RrtSpace space_;
  Tree trees_[2];  // from the starts; from the goals
  std::uint64_t attempts_{};
  RandomSequence random_;
  std::vector<double> distances_;  // scratch
};

}  // namespace srmp::search
