#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

namespace coal {
class CollisionGeometry;
}

// Coal, as the checker needs it: one query, whose answer depends on its arguments alone.
namespace srmp::detail {

/// Bounding volumes of a geometry, in its own frame.
struct Bounds {
  Eigen::Vector3d center;      ///< of the bounding sphere
  double radius{};             ///< of the bounding sphere
  Eigen::Vector3d box_center;  ///< of the bounding box
  Eigen::Vector3d box_half;    ///< half edge lengths of the bounding box
};
Bounds bounds_of(const coal::CollisionGeometry& geometry);

/// One convex solid: GJK knows its distance, while a mesh or an octree is many pieces.
bool is_convex_solid(const coal::CollisionGeometry& geometry);

/// A geometry at a place; `center` is of its bounding sphere, in the frame of the pose's parent.
struct Placed {
  const coal::CollisionGeometry* geometry;
  const Eigen::Isometry3d& pose;
  const Eigen::Vector3d& center;
};

/// The deepest point of two bodies, or the nearest points.
struct Proximity {
  double distance{};  ///< signed [m]
  Eigen::Vector3d point_a, point_b;
};

/// Which Coal functor decides a pair, by the geometries' types.
class FunctorTable {
 public:
  using Pair = std::pair<const coal::CollisionGeometry*, const coal::CollisionGeometry*>;
  std::uint8_t index(const coal::CollisionGeometry& a, const coal::CollisionGeometry& b);
  const std::vector<Pair>& examples() const { return examples_; }  ///< one pair of each kind

 private:
  std::vector<Pair> examples_;
  std::map<std::pair<int, int>, std::uint8_t> known_;
};

/// One thread's Coal functors and result buffers: no allocation once warm.
class NarrowPhase {
 public:
  explicit NarrowPhase(const FunctorTable& table);
  ~NarrowPhase();

  /// Coal's GJK converges to 1e-6 m; a pair reported farther than a margin may be nearer by this much [m].
  static constexpr double tolerance = 2e-6;

  /// Are the two within `margin` of each other? For two convex solids that are, `distance` is theirs (0 in contact).
  bool within(std::uint8_t functor, const Placed& a, const Placed& b, double margin, double& distance);
  /// The deepest contact of a pair within `margin` of each other; distance = margin when there is none. Allocates.
  static Proximity deepest(const Placed& a, const Placed& b, double margin);
  /// Signed distance. Allocates.
  static Proximity distance(const Placed& a, const Placed& b);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace srmp::detail
