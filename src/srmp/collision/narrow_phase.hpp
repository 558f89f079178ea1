#pragma once

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "srmp/collision/distance_query.hpp"

// Distance queries with Coal, as the checker needs them: a result depends on the arguments alone.
namespace srmp::detail {

Bounds bounds_of(const coal::CollisionGeometry& geometry);

/// A geometry is all that is within some distance of its core, so that its distances change by no more than the core
/// moves: of a sphere the center, which turning does not move; of a capsule its axis; of others all of it. A core is
/// given as all that is within `radius` of a segment through the bounding sphere's center.
struct Core {
  Eigen::Vector3d half;  ///< of the segment, in the geometry's frame
  double radius{};

  bool is_point() const { return radius == 0.0 && half.isZero(0.0); }
};
Core core_of(const coal::CollisionGeometry& geometry, const Bounds& bounds);

/// Is it one convex solid, whose distance GJK computes? A mesh or an octree is many primitives.
bool is_convex_solid(const coal::CollisionGeometry& geometry);

/// The deepest point of two bodies, or the nearest points.
struct Proximity {
  double distance{};  ///< signed [m]
  Eigen::Vector3d point_a, point_b;
};

/// Planes that separate two solids. Given to the next query for the same two, which are about where they were, it
/// shortens that; the distance changes by no more than GJK's tolerance.
struct Separation {
  Eigen::Vector3d direction{Eigen::Vector3d::Zero()};  ///< from b to a, in the frame of a; 0: none
  std::array<int, 2> vertices{};                       ///< of the two, where the last search ended
  double gap{};                                        ///< [m] between the planes, across the direction; 0: not known
};

/// How the points of a body move along a direction: p by s * (shift + slope . p), for an s from -1 to 1, and by `rest`
/// at most besides. In the frame of the poses' parent.
struct DirectedMotion {
  double shift{};
  Eigen::Vector3d slope{Eigen::Vector3d::Zero()};
  double rest{};
};

/// The kinds of solids for whose distance Coal has a formula, so that it does not use GJK.
class FormulaTable {
 public:
  FormulaTable();

  using Pair = std::pair<const coal::CollisionGeometry*, const coal::CollisionGeometry*>;
  /// Index of the formula for these two; -1: there is none.
  int index(const coal::CollisionGeometry& a, const coal::CollisionGeometry& b);
  const std::vector<Pair>& examples() const { return examples_; }  ///< one pair of each kind

 private:
  std::vector<Pair> examples_;
  static constexpr int not_known = -2;
  std::vector<int> known_;  // [type * types + type]
};

/// One thread's Coal functors and scratch memory. Once warm, nothing is allocated.
class NarrowPhase {
 public:
  explicit NarrowPhase(const FormulaTable& table);
  ~NarrowPhase();

  static constexpr double contact_distance = detail::contact_distance;
  static constexpr double tolerance = distance_tolerance;

  /// The distance of two convex solids, 0 in contact; infinity when it exceeds `margin` + contact_distance.
  double solids(int formula, const Placed& a, const Placed& b, double margin, Separation* separation = nullptr);
  /// The same for two geometries of which at least one has a BVH: branch and bound over the primitives.
  double primitives(const Placed& a, const Placed& b, const PrimitiveQuery& query);
  /// The distance [m] that planes across the direction, a unit vector from b to a, keep between two convex solids while
  /// these move, s being the same for both. Negative where they do not separate the two all the time.
  double gap_in_motion(const Placed& a, const Placed& b, const Eigen::Vector3d& direction, const DirectedMotion& of_a,
                       const DirectedMotion& of_b);

  /// From now on the queries above call `poll` every some microseconds, whichever query it is then; what it throws
  /// ends that one.
  void poll_with(std::function<void()> poll);

  /// The deepest contact of a pair within `margin` of each other; distance = margin when there is none. Allocates.
  static Proximity deepest(const Placed& a, const Placed& b, double margin);
  /// Signed distance. Allocates.
  static Proximity distance(const Placed& a, const Placed& b);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace srmp::detail
