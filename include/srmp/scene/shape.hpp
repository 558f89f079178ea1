#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <variant>
#include <vector>

namespace srmp {

// Shapes are solid unless stated otherwise, and centred at the origin of their own frame. Lengths are in metres,
// positive and finite. The axis of cylinders, capsules and cones is z.

/// A box, centred.
struct Box {
  Eigen::Vector3d size;  ///< full edge lengths
};
/// A sphere, centred.
struct Sphere {
  double radius;  ///< [m], > 0
};
/// A cylinder along z, centred.
struct Cylinder {
  double radius;  ///< [m], > 0
  double length;  ///< [m], > 0
};
/// A cylinder of `length` with a half sphere at each end; the total height is length + 2 radius.
struct Capsule {
  double radius;  ///< [m], > 0
  double length;  ///< [m], > 0
};
/// The base is at z = -length/2 and the apex at z = +length/2.
struct Cone {
  double radius;  ///< [m], > 0
  double length;  ///< [m], > 0
};
/// The triangles as a surface, or the convex hull of the vertices as a solid.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;      ///< [m]
  std::vector<std::array<int, 3>> triangles;  ///< indices into vertices; may be empty if convex
  bool convex{false};                         ///< the convex hull

  /// Reads a mesh in any format that assimp reads; vertices are multiplied by `scale`. Throws FileError for files that
  /// are missing or unreadable, and InvalidArgument for a scale that is 0 or not finite.
  static Mesh from_file(const std::string& path, const Eigen::Vector3d& scale = {1, 1, 1}, bool convex = false);
  /// The same with vertices multiplied by `scale`. Throws InvalidArgument for a scale that is 0 or not finite.
  Mesh scaled(const Eigen::Vector3d& scale) const;
};
/// The points' voxels, occupied cells of an octree.
struct PointCloud {
  std::vector<Eigen::Vector3d> points;  ///< [m]
  double resolution;                    ///< edge length of a voxel [m]
};

/// Any shape of an object.
using Shape = std::variant<Box, Sphere, Cylinder, Capsule, Cone, Mesh, PointCloud>;

/// The name of the shape's kind: "box", "sphere", "cylinder", "capsule", "cone", "mesh" or "point cloud".
std::string shape_kind(const Shape& shape);

}  // namespace srmp
