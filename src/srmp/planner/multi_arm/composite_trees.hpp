#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/planner/multi_arm/composite_space.hpp"

namespace srmp {

/// Two trees of motions of all arms' joints, from the start and from the goals, that grow towards each other (Kuffner,
/// LaValle 2000, "RRT-Connect"), by a sequence of configurations that is the same every time. Arms are often told to
/// stay at an end of their way, for they get by each other where only some of them move. Quick where arms are in each
/// other's way from start to goal, of which no lattice of so many joints holds a way that is found soon; proves
/// nothing.
class CompositeTrees {
 public:
  /// The space outlives this. `sequence`: another number is another sequence, which mostly leads to another path.
  explicit CompositeTrees(const CompositeSpace& space, std::uint64_t sequence = 0);

  /// Goes on until there is a path, or `attempts` were made since the first call.
  std::optional<CoupledPath> grow(std::uint64_t attempts, const Deadline& deadline);
  std::uint64_t attempts() const { return attempts_; }

 private:
  struct Node {
    Eigen::VectorXd q;
    std::size_t parent;  // its own number: the root
  };
  using Tree = std::vector<Node>;

  double random();
  Eigen::VectorXd sample();
  static std::size_t nearest(const Tree& tree, const Eigen::VectorXd& q);
  bool extend(Tree& tree, std::size_t from, const Eigen::VectorXd& towards);
  bool connect(Tree& tree, const Eigen::VectorXd& q);
  CoupledPath path(const Tree& from, const Tree& to, bool backward) const;

  const CompositeSpace& space_;
  Tree trees_[2];  // from the start; from the targets
  std::uint64_t attempts_{};
  std::uint64_t random_;
};

}  // namespace srmp
