#pragma once

#include <array>
#include <span>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

/// Breadth-first distances in the workspace: how far a sphere of `radius` must travel from the goal positions around
/// the scene's objects (Cohen, Chitta, Likhachev 2010). 26-connected grid; steps cost their length.
///
/// InadmissibleHeuristics the end effector, not the arm: neither admissible nor consistent for joint-space costs. Use
/// it with a weight, or beside a consistent anchor in MHA*.
class TaskSpaceBfs {
 public:
  struct Options {
    double resolution{0.05};  ///< edge of a cell [m], > 0
    double radius{0.05};      ///< objects are inflated by this [m], >= 0
  };

  /// The grid is the box `low`..`high` (world frame), grown where needed to hold the goals. Objects of the scene that
  /// are not attached to a robot are obstacles. Once the deadline has passed, the rest of the grid stays undone.
  TaskSpaceBfs(const Scene& scene, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
               std::span<const Eigen::Vector3d> goals, const Options& options, const Deadline& deadline = {});

  /// Travelled distance [m] from `point` to the nearest goal; 0 in a goal's cell; infinity where walls leave no way.
  /// Points outside the grid count from the nearest cell; points inside obstacles from the nearest free neighbour.
  double distance(const Eigen::Vector3d& point) const;
  /// Is the middle of this point's cell nearer than the radius to an object?
  bool occupied(const Eigen::Vector3d& point) const;
  std::size_t memory() const { return distance_.capacity() * sizeof(float); }

 private:
  using Cell = std::array<int, 3>;
  Cell cell_of(const Eigen::Vector3d& point) const;
  std::size_t index(const Cell& cell) const;
  void wall_in();
  void mark(const Object& object, double radius, const Deadline& deadline);
  void flood(std::span<const Eigen::Vector3d> goals, const Deadline& deadline);

  double resolution_;
  Eigen::Vector3d low_;
  Cell size_{};                  // without the wall around the grid, which saves asking where it ends
  std::vector<float> distance_;  // by cell, x runs fastest; negative in walls and obstacles
};

}  // namespace srmp
