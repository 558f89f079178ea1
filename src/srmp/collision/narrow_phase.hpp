#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "srmp/geometry/primitive_bvh.hpp"

// Distance queries with Coal, as the checker needs them: a result depends on the arguments alone.
namespace srmp::detail {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// Bounding volumes of a geometry, in its own frame.
struct Bounds {
  Eigen::Vector3d center;      ///< of the bounding sphere
  double radius{};             ///< of the bounding sphere
  Eigen::Vector3d box_center;  ///< of the bounding box
  Eigen::Vector3d box_half;    ///< half edge lengths of the bounding box
};
Bounds bounds_of(const coal::CollisionGeometry& geometry);

/// A geometry is all that is within some distance of its core, so that its distances change by no more than the core
/// moves: of a sphere the center, which turning does not move; of a capsule its axis; of others all of it. A core is
/// given as all that is within `radius` of a segment through the bounding sphere's center.
struct Core {
  Eigen::Vector3d half;  ///< of the segment, in the geometry's frame
  double radius{};
};
Core core_of(const coal::CollisionGeometry& geometry, const Bounds& bounds);

/// Is it one convex solid, whose distance GJK computes? A mesh or an octree is many primitives.
bool is_convex_solid(const coal::CollisionGeometry& geometry);

/// A geometry at a pose.
struct Placed {
  const coal::CollisionGeometry* geometry;
  const PrimitiveBvh* bvh;  ///< make_primitive_bvh(*geometry): null for a convex solid
  const Bounds& bounds;
  const Eigen::Isometry3d& pose;
  const Eigen::Vector3d& center;  ///< of its bounding sphere, in the frame of the pose's parent
};

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

/// Parts of two bodies, with planes between them; in the frame of the poses' parent.
struct SeparatedParts {
  Eigen::Vector3d direction;              ///< a unit vector across the planes, either way
  double gap{};                           ///< [m] between the planes
  std::span<const Eigen::Vector3d> a, b;  ///< corners of the part; none: all of the body
};
/// Is it known that these two parts stay separated?
using StaysSeparated = std::function<bool(const SeparatedParts&)>;

/// Primitives of two geometries by their numbers, one of each; beside a convex solid, `b` is 0 and `a` the other's.
struct PrimitivePair {
  std::uint32_t a{}, b{};
};

/// A query for the distance of two geometries of which at least one is many primitives.
struct PrimitiveQuery {
  /// Calls of stays_separated: two bodies that pass each other have few primitives that are near, and where many are,
  /// parts of the motion are quicker.
  static constexpr int max_separations = 64;
  static constexpr std::size_t max_candidates = 32;
  static constexpr int max_boxes = 1024;  ///< pairs of boxes that are visited for candidates

  double margin{};                         ///< a distance that exceeds it is infinity
  double enough{};                         ///< may return the distance of any two primitives that is at most this
  StaysSeparated stays_separated{};        ///< leaves out primitives that stay so; none: leaves out none
  std::span<const PrimitivePair> among{};  ///< no others; none: all
  /// Receives all primitives that are neither left out nor farther apart than `margin`; not to be that of `among`. None
  /// where that would be too many, or take too many boxes: the query goes on without them.
  std::vector<PrimitivePair>* candidates{};
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

  /// GJK converges to 1e-6 m: nearer than this is contact. (Coal's own threshold of 1e-12 calls some overlapping boxes
  /// free, where GJK stops at a distance below its tolerance but above 0.)
  static constexpr double contact_distance = 1e-6;
  /// A pair reported farther apart than a margin may be nearer by this much [m], contact_distance included.
  static constexpr double tolerance = 2e-6;

  /// The distance of two convex solids, 0 in contact; infinity when it exceeds `margin` + contact_distance.
  double solids(int formula, const Placed& a, const Placed& b, double margin, Separation* separation = nullptr);
  /// The same for two geometries of which at least one has a BVH: branch and bound over the primitives.
  double primitives(const Placed& a, const Placed& b, const PrimitiveQuery& query);

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
