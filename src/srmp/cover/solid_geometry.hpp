#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "srmp/cover/enclosed_space.hpp"
#include "srmp/geometry/triangle_bvh.hpp"

namespace srmp {

/// The representation behind a CoverSolid, which the functions of this directory read. Lengths in metres, in the
/// solid's frame. Members of the other kinds of solid are empty.
struct SolidGeometry {
  // Convex solids are contained in { x : normals * x <= offsets } and contain { x : normals * x <= inner_offsets }; the
  // two differ because a mesh may be convex but for rounding.
  bool convex{false};
  Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor> normals;  ///< unit rows
  Eigen::VectorXd offsets;
  Eigen::VectorXd inner_offsets;
  /// Exact depth of curved convex solids; empty for polytopes.
  std::function<double(const Eigen::Vector3d&)> curved_depth;

  std::vector<Triangle> triangles;        ///< the surface; an inscribed polygonal approximation of curved solids
  std::vector<Eigen::Vector3d> vertices;  ///< corners of the same
  Eigen::AlignedBox3d box;

  // Meshes.
  bool closed{false};      ///< every edge has an even number of triangles, so the parity of a ray's crossings is valid
  TriangleBvh all;         ///< every triangle
  TriangleBvh outer;       ///< triangles that can be reached from outside, and the plugs of holes
  EnclosedSpace enclosed;  ///< what a cover must contain
  EnclosedSpace filled;    ///< what a cover may contain: that and what lies behind holes

  // Spheres and capsules, whose covers are formulas.
  enum class Kind { general, sphere, capsule } kind{Kind::general};
  double radius{}, length{};

  /// Is the point certainly between the walls of a closed mesh?
  bool is_odd(const Eigen::Vector3d& point) const;
  /// CoverSolid::depth. It may be slightly too large for nearly convex meshes.
  double depth(const Eigen::Vector3d& point) const;
  /// A lower bound on the depth; minus infinity where the point is not certainly inside.
  double inner_depth(const Eigen::Vector3d& point) const;
};

}  // namespace srmp
