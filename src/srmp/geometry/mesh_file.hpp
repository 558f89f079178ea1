#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace srmp {

/// Triangles that share vertices [m].
struct TriangleSoup {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;  ///< indices into the vertices
  std::size_t parts{1};                       ///< number of meshes (materials) in the file that was read
};

/// Reads STL, OBJ, Collada (.dae), PLY, OFF and glTF (.gltf, .glb), all parts with their transforms. Lengths are taken
/// in the file's own unit (Collada's <unit> is honoured, its up axis is not, as in RViz), times `scale`. Vertices at
/// the same place are merged; faces left with fewer than three different vertices are dropped. Throws FileError:
/// missing, empty, unreadable, of another format, larger than max_length, or of more nodes or triangles than any mesh
/// has.
TriangleSoup read_mesh_file(const std::string& path, const Eigen::Vector3d& scale = {1, 1, 1});

/// Adds the triangles that Coal's own loader, and so Pinocchio, reads from the file. For a node with several materials,
/// Coal 3.0.3 uses the vertices of the first material for all, which gives triangles that are not in the file. A path
/// must also be collision-free for users who check it with Pinocchio, so the geometry of a robot's link is the union of
/// both readings.
void add_coal_reading(const std::string& path, const Eigen::Vector3d& scale, TriangleSoup& mesh);

}  // namespace srmp
