#include <coal/shape/geometric_shapes.h>

#include <cmath>
#include <filesystem>
#include <limits>

#include "srmp/core/error.hpp"
#include "srmp/robot/mesh_file.hpp"
#include "srmp/robot/mesh_path.hpp"
#include "srmp/robot/robot_impl.hpp"

namespace srmp {

namespace {

/// Rounding must not let a bounding sphere cut what it bounds.
double rounded_up(double radius) { return radius * (1.0 + 8 * std::numeric_limits<double>::epsilon()); }

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
  geometry.shape = shape;
}

void build_mesh(const RobotModelBuilder::Impl& m, const UrdfGeometry& g, LinkGeometry& geometry) {
  namespace fs = std::filesystem;
  const std::string where = m.urdf.label + ":" + std::to_string(g.line) + ": ";
  const std::string folder =
      m.description.urdf_path.empty() ? "" : fs::absolute(m.description.urdf_path).parent_path().string();
  const std::string path = find_mesh(g.filename, folder, m.description.package_dirs, where);
  try {
    const TriangleSoup mesh = read_mesh_file(path, g.scale);
    geometry.shape = make_mesh_geometry(mesh, MeshModel::hull_if_convex);
    bound_by_vertices(mesh.vertices, geometry);
  } catch (const FileError& error) {
    throw FileError(where + error.what());
  }
}

}  // namespace

void RobotModelBuilder::build_geometries(Impl& m) {
  for (std::size_t i = 0; i < m.urdf.links.size(); ++i) {
    const UrdfLink& link = m.urdf.links[i];
    for (std::size_t n = 0; n < link.collisions.size(); ++n) {
      const UrdfGeometry& g = link.collisions[n];
      LinkGeometry geometry;
      geometry.link = link.name;
      geometry.name = link.name + "_" + std::to_string(n);
      geometry.link_index = i;
      if (g.kind == UrdfGeometry::Kind::mesh)
        build_mesh(m, g, geometry);
      else
        build_primitive(g, geometry);
      const KinematicTree::Mount& mount = m.tree->mount(i);
      geometry.movers = m.joint_movers[mount.joint];
      m.geometry_mounts.push_back({mount.joint, mount.placement * g.origin});
      m.geometries.push_back(std::move(geometry));
    }
  }
}

}  // namespace srmp
