#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/core/matrix.hpp"
#include "srmp/search/configuration_tree.hpp"

namespace srmp::search {

/// A pseudo-random sequence of numbers in [0, 1): splitmix64 (Steele, Lea, Flood 2014, "Fast splittable pseudorandom
/// number generators"). The same seed gives the same sequence on every machine.
class RandomSequence {
 public:
  explicit RandomSequence(std::uint64_t seed) : state_(seed) {}
  double next();

 private:
  std::uint64_t state_;
};

/// The planning problem: configurations are vectors of one size, motions between them are straight.
struct RrtSpace {
  std::vector<Eigen::VectorXd> starts;  ///< free
  std::vector<Eigen::VectorXd> goals;   ///< free
  std::vector<char> wraps{};            ///< by component: is it an angle that wraps around [rad]? empty: none
  double max_step{1.0};                 ///< length of a motion, finite and > 0
  std::function<Eigen::VectorXd(RandomSequence&)> sample;
  std::function<bool(const Eigen::VectorXd& a, const Eigen::VectorXd& b)> is_motion_free;  ///< `a` is free
  /// Which rows of `ends` are seen to be in contact with little work: motions to these need no check. Empty: none.
  /// on_colliding is called for each motion that got none.
  std::function<void(const RowMatrix& ends, std::span<bool> colliding)> find_colliding{};
  std::function<void()> on_colliding{};
  /// Moves a configuration onto the constraint's surface, or says false; empty: there is none. Every step of a tree is
  /// projected (CBiRRT: Berenson et al. 2009, "Manipulation planning on constraint manifolds").
  std::function<bool(Eigen::VectorXd&)> project{};
  /// Directions in which a tree in a narrow passage may leave it, which samples seldom have there: advance(q, d) moves
  /// q by a step in one of them, 0 <= d < directions, or says false. Not used where there is `project`.
  std::size_t directions{};
  std::function<bool(Eigen::VectorXd&, std::size_t)> advance{};
};

/// RRT-Connect (Kuffner, LaValle 2000, "RRT-Connect: An Efficient Approach to Single-Query Path Planning") with a fixed
/// pseudo-random sequence, so that results repeat: two trees of motions, from the starts and from the goals, grow
/// towards each other. The first attempt is the straight motion; then the smaller tree grows, so the end in a narrow
/// passage has the most attempts. Where the space has directions, a tree that many samples in a row left as it was
/// grows in these. Guarantee: paths are valid; none is ever proved not to exist.
class RrtConnect {
 public:
  /// Another `seed` mostly leads to another path. Throws InvalidArgument for a max_step that is not positive and for
  /// vectors of different sizes.
  explicit RrtConnect(RrtSpace space, std::uint64_t seed = 0);

  /// Grows both trees along this path, from the first configuration, a start, and from the last one, a goal, each as
  /// far as it is free, or until the deadline. Its motions may be longer than max_step. Throws InvalidArgument for an
  /// empty path, and for configurations of another size than the starts and goals.
  void follow(const std::vector<Eigen::VectorXd>& path, const Deadline& deadline);
  /// Grows the trees until there is a path, from a start to a goal, or `attempts` were made since construction, or the
  /// deadline, at which each eighth attempt looks. May be called again with more attempts.
  std::optional<std::vector<Eigen::VectorXd>> grow(std::uint64_t attempts, const Deadline& deadline);
  std::uint64_t attempts() const { return attempts_; }
  /// From the starts, or from the goals.
  const ConfigurationTree& tree(bool from_goals) const { return trees_[from_goals].nodes; }
  std::size_t memory() const;

 private:
  struct Tree {
    ConfigurationTree nodes;
    std::uint64_t failures{};      // samples in a row that left it as it was
    std::uint64_t patience{};      // with these, before it grows in directions
    std::size_t next_direction{};  // of RrtSpace::directions
  };

  /// An attempt that is to come.
  struct Attempt {
    Eigen::VectorXd sample{};
    std::size_t nearest{};
    bool collides{};  // is the step towards the sample known to end in contact?
  };

  const Attempt& next_attempt(const Tree& tree);
  void look_ahead(const Tree& tree);
  Eigen::VectorXd step_end(const Tree& tree, std::size_t from, const Eigen::VectorXd& towards) const;
  std::size_t size() const { return trees_[0].nodes.size() + trees_[1].nodes.size(); }
  void follow(Tree& tree, const std::vector<Eigen::VectorXd>& path, const Deadline& deadline);
  bool extend(Tree& tree, std::size_t from, const Eigen::VectorXd& towards);
  bool extend_projected(Tree& tree, std::size_t from, Eigen::VectorXd to, const Eigen::VectorXd& towards);
  bool grows_in_directions(const Tree& tree) const;
  bool grow_in_directions(Tree& tree, std::size_t from, Tree& other);
  bool connect(Tree& tree, const Eigen::VectorXd& q);
  std::optional<std::vector<Eigen::VectorXd>> straight_path() const;
  std::vector<Eigen::VectorXd> path() const;

  RrtSpace space_;
  Tree trees_[2];  // from the starts; from the goals
  std::uint64_t attempts_{};
  RandomSequence random_;
  std::vector<Attempt> ahead_;  // in order; those before next_ are done
  std::size_t next_{};
  std::size_t seen_size_{};  // of both trees, when the attempts ahead were last looked at
  std::size_t failures_{};   // attempts since a step towards a sample was free
};

}  // namespace srmp::search
