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

/// Triangles that share vertices [m].
struct TriangleSoup {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;  ///< indices into the vertices
  std::size_t parts{1};                       ///< number of meshes (materials) in the file that was read
};

/// Reads any format that assimp reads, all parts with their transforms. Lengths are taken in the file's own unit
/// (Collada's <unit> is honoured, its up axis is not, as in RViz), times `scale`. Vertices at the same place are
/// merged; faces left with fewer than three different vertices are dropped. Throws FileError: missing, empty,
/// unreadable.
TriangleSoup read_mesh_file(const std::string& path, const Eigen::Vector3d& scale = {1, 1, 1});

/// Adds the triangles that Coal's own loader, and so Pinocchio, reads from the file. For a node with several materials,
/// Coal 3.0.3 uses the vertices of the first material for all, which gives triangles that are not in the file. A path
/// must also be collision-free for users who check it with Pinocchio, so the geometry of a robot's link is the union of
/// both readings.
void add_coal_reading(const std::string& path, const Eigen::Vector3d& scale, TriangleSoup& mesh);

/// Which geometry a mesh stands for.
enum class MeshModel {
  surface,         ///< the triangles, hollow
  hull,            ///< the convex hull of the vertices, solid
  hull_if_convex,  ///< the hull if the triangles are a closed convex surface (to 1 µm), otherwise the triangles
};

/// Is the mesh a closed surface that coincides with its own convex hull, to 1 µm?
bool is_convex(const TriangleSoup& mesh);

/// Do the vertices span a volume, so that their convex hull is a solid?
bool spans_volume(const std::vector<Eigen::Vector3d>& vertices);

/// The convex hull: its corners, and triangles that face outwards. Throws InvalidArgument for fewer than four points,
/// points in one plane, or points that are not finite.
TriangleSoup convex_hull(const std::vector<Eigen::Vector3d>& points);

/// The Coal geometry of a mesh, with its local bounding box. Throws InvalidArgument for a surface without triangles,
/// and for a hull of fewer than four points or of points in one plane.
std::shared_ptr<const coal::CollisionGeometry> make_mesh_geometry(const TriangleSoup& mesh, MeshModel model);

}  // namespace srmp
