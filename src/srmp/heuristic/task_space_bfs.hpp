#pragma once

#include <array>
#include <span>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

/// Shortest distances in the workspace for a sphere of `radius` around the scene's objects to the nearest goal position
/// (the 3D search heuristic of Cohen, Chitta, Likhachev 2010), on a 26-connected grid whose edges cost their length.
///
/// It guides the end effector alone, not the robot: neither admissible nor consistent for joint-space costs. Use it as
/// an inadmissible heuristic beside a consistent anchor in MHA*.
class TaskSpaceBfs {
 public:
  struct Options {
    double resolution{0.05};  ///< edge of a cell [m], > 0
    double radius{0.05};      ///< objects are inflated by this [m], >= 0
  };

  /// The grid is the box `low`..`high` (world frame), grown where needed to hold the goals. Objects of the scene that
  /// are not attached to a robot are obstacles. Throws InvalidArgument for a resolution that is not positive or makes
  /// more than 50 million cells. Once the deadline has passed, the grid stays incomplete: distances are then wrong, but
  /// can be queried.
  TaskSpaceBfs(const Scene& scene, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
               std::span<const Eigen::Vector3d> goals, const Options& options, const Deadline& deadline = {});

  /// Shortest distance [m] from `point` (world frame) to the nearest goal; 0 in a goal's cell; infinity where there is
  /// no path. Points outside the grid count as in the nearest cell, points in obstacles as in the nearest free
  /// neighbour cell.
  double distance(const Eigen::Vector3d& point) const;
  /// Is the centre of this point's cell nearer to an object than the radius?
  bool occupied(const Eigen::Vector3d& point) const;
  std::size_t memory() const { return distance_.capacity() * sizeof(float); }

 private:
  using Cell = std::array<int, 3>;
  Cell cell_of(const Eigen::Vector3d& point) const;
  std::size_t index(const Cell& cell) const;
  void add_border();
  void mark(const Object& object, double radius, const Deadline& deadline);
  void flood(std::span<const Eigen::Vector3d> goals, const Deadline& deadline);

  double resolution_;
  Eigen::Vector3d low_;
  Cell size_{};                  // without the border, which saves range checks
  std::vector<float> distance_;  // by cell, x runs fastest; negative in the border and in obstacles
};

}  // namespace srmp
