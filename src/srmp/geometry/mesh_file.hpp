#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

namespace coal {
class CollisionGeometry;
}

namespace srmp {

/// Triangles over shared vertices [m].
struct TriangleSoup {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
  std::size_t parts{1};  ///< meshes (materials) of the file it was read from
};

/// Reads any format that assimp reads, all parts with their transforms. Lengths are taken in the file's own unit
/// (Collada's <unit> is honoured, its up axis is not, as in RViz), times `scale`. Vertices at the same place are
/// merged; faces left with fewer than three different vertices are dropped. Throws FileError: missing, empty,
/// unreadable.
TriangleSoup read_mesh_file(const std::string& path, const Eigen::Vector3d& scale = {1, 1, 1});

/// Adds the triangles that Coal's own loader, and so Pinocchio, sees in the file. Of a node with several materials Coal
/// 3.0.3 takes the vertices of the first for all, which gives triangles that are not in the file. A path must be free
/// for those who check it with Pinocchio too, so a robot's link is both readings.
void add_coal_reading(const std::string& path, const Eigen::Vector3d& scale, TriangleSoup& mesh);

/// What a mesh stands for.
enum class MeshModel {
  surface,         ///< the triangles, hollow
  hull,            ///< the convex hull of the vertices, solid
  hull_if_convex,  ///< the hull where the triangles are a closed convex surface (to 1 µm), else the triangles
};

/// Is the mesh a closed surface that coincides with its own convex hull, to 1 µm?
bool is_convex(const TriangleSoup& mesh);

/// Do the vertices span a volume, so that they have a hull?
bool spans_volume(const std::vector<Eigen::Vector3d>& vertices);

/// The convex hull: its corners, and triangles that face outwards. Throws InvalidArgument for fewer than four points,
/// all in one plane, or not finite.
TriangleSoup convex_hull(const std::vector<Eigen::Vector3d>& points);

/// Coal geometry of a mesh, local bounding box included. Throws InvalidArgument where there is nothing to build: no
/// triangles for a surface; fewer than four points, or all in one plane, for a hull.
std::shared_ptr<const coal::CollisionGeometry> make_mesh_geometry(const TriangleSoup& mesh, MeshModel model);

}  // namespace srmp
