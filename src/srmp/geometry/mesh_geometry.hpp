#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "srmp/geometry/mesh_file.hpp"

namespace coal {
class CollisionGeometry;
class ConvexBase;
}  // namespace coal

namespace srmp {

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

/// The convex hull of the vertices as Coal makes it, without its bounding box; nullptr when they span no volume, or so
/// little that qhull finds no hull.
std::shared_ptr<coal::ConvexBase> solid_hull(const std::vector<Eigen::Vector3d>& vertices);

/// The convex hull: its corners, and triangles that face outwards. Throws InvalidArgument for fewer than four points,
/// points in one plane, or points that are not finite.
TriangleSoup convex_hull(const std::vector<Eigen::Vector3d>& points);

/// The Coal geometry of a mesh, with its local bounding box. Throws InvalidArgument for a surface without triangles,
/// and for a hull of fewer than four points or of points in one plane.
std::shared_ptr<const coal::CollisionGeometry> make_mesh_geometry(const TriangleSoup& mesh, MeshModel model);

}  // namespace srmp
