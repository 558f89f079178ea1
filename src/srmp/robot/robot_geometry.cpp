#include "srmp/robot/robot_geometry.hpp"

#include <coal/shape/geometric_shapes.h>

#include <cmath>
#include <limits>
#include <map>

#include "srmp/core/error.hpp"
#include "srmp/geometry/mesh_geometry.hpp"
#include "srmp/robot/mesh_path.hpp"
#include "srmp/robot/robot_impl.hpp"

namespace srmp {

namespace {

/// A radius that is larger than the true one in spite of rounding, so that a bounding sphere contains its geometry.
double rounded_up(double radius) { return radius * (1.0 + 8 * std::numeric_limits<double>::epsilon()); }

/// Sets the bounding sphere to one around the vertices.
void bound_by_vertices(const std::vector<Eigen::Vector3d>& vertices, LinkGeometry& geometry) {
  Eigen::Vector3d low = vertices.front(), high = vertices.front();
  for (const Eigen::Vector3d& v : vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  geometry.center = (low + high) / 2;
  double farthest = 0.0;
  for (const Eigen::Vector3d& v : vertices) farthest = std::max(farthest, (v - geometry.center).norm());
  geometry.radius = rounded_up(farthest);
}

void build_primitive(const UrdfGeometry& g, LinkGeometry& geometry) {
  using Kind = UrdfGeometry::Kind;
  std::shared_ptr<coal::ShapeBase> shape;
  geometry.center.setZero();
  if (g.kind == Kind::box) {
    shape = std::make_shared<coal::Box>(g.size);
    geometry.radius = rounded_up(g.size.norm() / 2);
  } else if (g.kind == Kind::sphere) {
    shape = std::make_shared<coal::Sphere>(g.radius);
    geometry.radius = g.radius;
  } else if (g.kind == Kind::cylinder) {
    shape = std::make_shared<coal::Cylinder>(g.radius, g.length);
    geometry.radius = rounded_up(std::hypot(g.radius, g.length / 2));
  } else {
    shape = std::make_shared<coal::Capsule>(g.radius, g.length);
    geometry.radius = rounded_up(g.radius + g.length / 2);
  }
  shape->computeLocalAABB();
  geometry.shape = geometry.envelope = shape;
}

/// Reads each mesh file once, however many links use it.
class MeshLoader {
 public:
  MeshLoader(const Urdf& urdf, const std::string& urdf_directory, const std::vector<std::string>& package_dirs)
      : label_(urdf.label), directory_(urdf_directory), package_dirs_(package_dirs) {}

  void load(const UrdfGeometry& g, LinkGeometry& geometry) {
    const std::string where = label_ + ":" + std::to_string(g.line) + ": ";
    const std::string path = find_mesh(g.filename, directory_, package_dirs_, where);
    const auto [it, is_new] = known_.try_emplace({path, {g.scale.x(), g.scale.y(), g.scale.z()}});
    if (is_new) it->second = read(path, g.scale, where);
    geometry.shape = it->second.shape;
    geometry.envelope = it->second.envelope;
    geometry.center = it->second.center;
    geometry.radius = it->second.radius;
  }

 private:
  static LinkGeometry read(const std::string& path, const Eigen::Vector3d& scale, const std::string& where) {
    LinkGeometry result;
    try {
      TriangleSoup mesh = read_mesh_file(path, scale);
      if (mesh.parts > 1) add_coal_reading(path, scale, mesh);
      result.shape = result.envelope = make_mesh_geometry(mesh, MeshModel::hull_if_convex);
      if (mesh.parts > 1 && spans_volume(mesh.vertices)) result.envelope = make_mesh_geometry(mesh, MeshModel::hull);
      bound_by_vertices(mesh.vertices, result);
    } catch (const FileError& error) {
      throw FileError(where + error.what());
    }
    return result;
  }

  const std::string& label_;
  const std::string& directory_;
  const std::vector<std::string>& package_dirs_;
  std::map<std::pair<std::string, std::array<double, 3>>, LinkGeometry> known_;
};

}  // namespace

std::vector<PlacedGeometry> load_geometries(const Urdf& urdf, const std::string& urdf_directory,
                                            const std::vector<std::string>& package_dirs) {
  MeshLoader meshes(urdf, urdf_directory, package_dirs);
  std::vector<PlacedGeometry> geometries;
  for (std::size_t i = 0; i < urdf.links.size(); ++i) {
    const UrdfLink& link = urdf.links[i];
    for (std::size_t n = 0; n < link.collisions.size(); ++n) {
      const UrdfGeometry& g = link.collisions[n];
      LinkGeometry geometry;
      geometry.link = link.name;
      geometry.name = link.name + "_" + std::to_string(n);
      geometry.link_index = i;
      if (g.kind == UrdfGeometry::Kind::mesh)
        meshes.load(g, geometry);
      else
        build_primitive(g, geometry);
      geometries.push_back({std::move(geometry), g.origin});
    }
  }
  return geometries;
}

void RobotModelBuilder::build_geometries(Impl& m) {
  for (PlacedGeometry& placed :
       load_geometries(m.urdf, m.self_contained.urdf_directory, m.self_contained.package_dirs)) {
    const KinematicTree::FixedPlacement& fixed = m.tree->fixed_placement(placed.geometry.link_index);
    placed.geometry.support = m.joint_support[fixed.joint];
    m.geometry_placements.push_back({fixed.joint, fixed.placement * placed.in_link});
    m.geometries.push_back(std::move(placed.geometry));
  }
}

}  // namespace srmp
