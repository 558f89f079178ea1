#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <variant>
#include <vector>

namespace srmp {

// Shapes are solid and centred at their own frame; lengths in metres. Cylinder, capsule and cone lie along z.
struct Box {
  Eigen::Vector3d size;  ///< full edge lengths
};
struct Sphere {
  double radius;
};
struct Cylinder {
  double radius;
  double length;
};
/// A cylinder of `length` with a half sphere on each end (total height length + 2 radius).
struct Capsule {
  double radius;
  double length;
};
/// Base at z = -length/2, tip at z = +length/2.
struct Cone {
  double radius;
  double length;
};
/// Triangles as a surface, or, when asked, their convex hull as a solid.
struct Mesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;  ///< indices into vertices; may be empty when convex
  bool convex{false};

  /// Reads any format that assimp reads. Throws FileError.
  static Mesh from_file(const std::string& path, const Eigen::Vector3d& scale = {1, 1, 1}, bool convex = false);
};
/// Points become occupied voxels of an octree.
struct PointCloud {
  std::vector<Eigen::Vector3d> points;
  double resolution;  ///< edge length of a voxel
};

using Shape = std::variant<Box, Sphere, Cylinder, Capsule, Cone, Mesh, PointCloud>;

/// The shape's kind as users say it: "box", "sphere", …
std::string shape_kind(const Shape& shape);

}  // namespace srmp
