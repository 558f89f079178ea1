#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "srmp/geometry/primitive_bvh.hpp"

// What queries for distances are made of.
namespace srmp::detail {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// GJK converges to 1e-6 m: nearer than this is contact. (Coal's own threshold of 1e-12 calls some overlapping boxes
/// free, where GJK stops at a distance below its tolerance but above 0.)
inline constexpr double contact_distance = 1e-6;
/// A pair reported farther apart than a margin may be nearer by this much [m], contact_distance included.
inline constexpr double distance_tolerance = 2e-6;

/// Bounding volumes of a geometry, in its own frame.
struct Bounds {
  Eigen::Vector3d center;      ///< of the bounding sphere
  double radius{};             ///< of the bounding sphere
  Eigen::Vector3d box_center;  ///< of the bounding box
  Eigen::Vector3d box_half;    ///< half edge lengths of the bounding box
};

/// A geometry at a pose.
struct Placed {
  const coal::CollisionGeometry* geometry;
  const PrimitiveBvh* bvh;  ///< make_primitive_bvh(*geometry): null for a convex solid
  const Bounds& bounds;
  const Eigen::Isometry3d& pose;
  const Eigen::Vector3d& center;  ///< of its bounding sphere, in the frame of the pose's parent
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
  static constexpr std::size_t max_candidates = 64;
  static constexpr int max_boxes = 16384;  ///< pairs of boxes that are visited for candidates

  double margin{};                         ///< a distance that exceeds it is infinity
  double enough{};                         ///< may return the distance of any two primitives that is at most this
  StaysSeparated stays_separated{};        ///< leaves out primitives that stay so; none: leaves out none
  std::span<const PrimitivePair> among{};  ///< no others; none: all
  /// Receives all primitives that are neither left out nor farther apart than `margin`; not to be that of `among`. None
  /// where that would be too many, or take too many boxes: the query goes on without them.
  std::vector<PrimitivePair>* candidates{};
};

}  // namespace srmp::detail
