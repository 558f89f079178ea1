#include "srmp/scene/shape_geometry.hpp"

#include <coal/BVH/BVH_model.h>
#include <coal/octree.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <boost/sort/spreadsort/integer_sort.hpp>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"
#include "srmp/core/run_interruptibly.hpp"
#include "srmp/geometry/mesh_geometry.hpp"
#include "srmp/geometry/morton.hpp"

namespace srmp {

namespace {

using Geometry = std::shared_ptr<coal::CollisionGeometry>;

template <class... Calls>
struct Overloaded : Calls... {
  using Calls::operator()...;
};

std::string of(const char* what, const std::string& object) {
  return std::string(what) + " of object '" + object + "'";
}

Geometry build(const Box& box, const std::string& object) {
  for (double edge : box.size) require_length(edge, of("box size", object));
  return std::make_shared<coal::Box>(box.size);
}

Geometry build(const Sphere& sphere, const std::string& object) {
  require_length(sphere.radius, of("sphere radius", object));
  return std::make_shared<coal::Sphere>(sphere.radius);
}

template <class CoalShape, class Round>
Geometry build_round(const Round& round, const char* kind, const std::string& object) {
  require_length(round.radius, of((std::string(kind) + " radius").c_str(), object));
  require_length(round.length, of((std::string(kind) + " length").c_str(), object));
  return std::make_shared<CoalShape>(round.radius, round.length);
}

void check_mesh(const Mesh& mesh, const std::string& object) {
  const std::string mesh_of = of("mesh", object);
  if (mesh.vertices.empty()) throw InvalidArgument(mesh_of + " has no vertices");
  if (mesh.triangles.empty() && !mesh.convex)
    throw InvalidArgument(mesh_of + " has no triangles; give some, or ask for its convex hull");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (!mesh.vertices[i].allFinite())
      throw InvalidArgument(mesh_of + ": vertex " + std::to_string(i) +
                            " has a component that is NaN or infinite; only finite numbers are allowed");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    require_position(mesh.vertices[i], mesh_of + ": vertex " + std::to_string(i));
  const int count = static_cast<int>(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (int index : mesh.triangles[i])
      if (index < 0 || index >= count)
        throw InvalidArgument(mesh_of + ": triangle " + std::to_string(i) + " names vertex " + std::to_string(index) +
                              ", but there are " + std::to_string(count) + " vertices, counted from 0");
}

/// The triangles without those of zero area, which have no plane, and whose edges belong to their neighbours.
std::vector<std::array<int, 3>> with_area(const Mesh& mesh) {
  std::vector<std::array<int, 3>> kept;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d u = mesh.vertices[t[1]] - mesh.vertices[t[0]], v = mesh.vertices[t[2]] - mesh.vertices[t[0]];
    if (u.cross(v).norm() > 1e-12 * std::max(u.squaredNorm(), v.squaredNorm())) kept.push_back(t);
  }
  return kept;
}

/// What the mesh consists of: without vertices that no triangle has, if there are triangles.
std::vector<Eigen::Vector3d> used_vertices(const Mesh& mesh) {
  std::vector<char> used(mesh.vertices.size(), mesh.triangles.empty());
  for (const auto& triangle : mesh.triangles)
    for (const int index : triangle) used[static_cast<std::size_t>(index)] = true;
  std::vector<Eigen::Vector3d> vertices;
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i]) vertices.push_back(mesh.vertices[i]);
  return vertices;
}

std::shared_ptr<const coal::CollisionGeometry> build_mesh(const Mesh& mesh, const std::string& object) {
  check_mesh(mesh, object);
  try {
    if (mesh.convex) return make_mesh_geometry({used_vertices(mesh), {}}, MeshModel::hull);
    const TriangleSoup soup{mesh.vertices, with_area(mesh)};
    if (soup.triangles.empty()) throw InvalidArgument("every triangle has zero area");
    return make_mesh_geometry(soup, MeshModel::surface);
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(of("mesh", object) + ": " + error.what());
  }
}

/// Equal to coal::makeOctree, but faster: inserts every cell once, in the order of the octree, and updates inner nodes
/// at the end.
Geometry octree_of(const PointCloud& cloud) {
  std::vector<std::uint64_t> codes;
  codes.reserve(cloud.points.size());
  const auto cell = [&](double x) { return static_cast<std::int32_t>(std::floor(x / cloud.resolution)); };
  for (const Eigen::Vector3d& p : cloud.points) codes.push_back(morton_code({cell(p.x()), cell(p.y()), cell(p.z())}));
  boost::sort::spreadsort::integer_sort(codes.begin(), codes.end());
  codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
  const auto octree = std::make_shared<octomap::OcTree>(cloud.resolution);
  const auto middle = static_cast<std::int32_t>(1u << (octree->getTreeDepth() - 1));
  for (const std::uint64_t code : codes) {
    const auto key = morton_key(code);
    const auto part = [&](std::size_t i) { return static_cast<octomap::key_type>(key[i] + middle); };
    octree->setNodeValue(octomap::OcTreeKey(part(0), part(1), part(2)), octree->getProbHitLog(), true);
  }
  octree->updateInnerOccupancy();
  return std::make_shared<coal::OcTree>(octree);
}

Geometry build(const PointCloud& cloud, const std::string& object) {
  require_length(cloud.resolution, of("point cloud resolution", object));
  if (cloud.points.empty()) throw InvalidArgument(of("point cloud", object) + " is empty; it needs at least one point");
  constexpr double octree_reach = 32766;  // voxels from the centre to the boundary of an octree with 16 levels
  const double reach = octree_reach * cloud.resolution;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (!cloud.points[i].allFinite())
      throw InvalidArgument(of("point cloud", object) + ": point " + std::to_string(i) +
                            " has a component that is NaN or infinite; only finite numbers are allowed");
    if (cloud.points[i].cwiseAbs().maxCoeff() > max_length)
      require_position(cloud.points[i], of("point cloud", object) + ": point " + std::to_string(i));
    if (cloud.points[i].cwiseAbs().maxCoeff() > reach)
      throw InvalidArgument(of("point cloud", object) + ": point " + std::to_string(i) + " is more than " +
                            to_text(reach) + " m from the origin, the octree's limit at resolution " +
                            to_text(cloud.resolution) + "; use a coarser resolution");
  }
  return octree_of(cloud);
}

void require_scale(const Eigen::Vector3d& scale, const std::string& what) {
  for (double factor : scale)
    if (!std::isfinite(factor) || factor == 0.0)
      throw InvalidArgument("scale of " + what + " has a component " + to_text(factor) +
                            "; each must be finite and not 0");
}

}  // namespace

Mesh Mesh::from_file(const std::string& path, const Eigen::Vector3d& scale, bool convex) {
  require_scale(scale, "mesh file '" + path + "'");
  TriangleSoup soup = run_interruptibly([path, scale] { return read_mesh_file(path, scale); });
  return {std::move(soup.vertices), std::move(soup.triangles), convex};
}

Mesh Mesh::scaled(const Eigen::Vector3d& scale) const {
  require_scale(scale, "a mesh");
  Mesh result = *this;
  for (Eigen::Vector3d& vertex : result.vertices) vertex = vertex.cwiseProduct(scale);
  return result;
}

std::string shape_kind(const Shape& shape) {
  return std::visit(Overloaded{[](const Box&) { return "box"; }, [](const Sphere&) { return "sphere"; },
                               [](const Cylinder&) { return "cylinder"; }, [](const Capsule&) { return "capsule"; },
                               [](const Cone&) { return "cone"; }, [](const Mesh&) { return "mesh"; },
                               [](const PointCloud&) { return "point cloud"; }},
                    shape);
}

std::shared_ptr<const coal::CollisionGeometry> make_geometry(const Shape& shape, const std::string& object) {
  if (const auto* mesh = std::get_if<Mesh>(&shape)) return build_mesh(*mesh, object);
  const Geometry geometry =
      std::visit(Overloaded{[&](const Cylinder& s) { return build_round<coal::Cylinder>(s, "cylinder", object); },
                            [&](const Capsule& s) { return build_round<coal::Capsule>(s, "capsule", object); },
                            [&](const Cone& s) { return build_round<coal::Cone>(s, "cone", object); },
                            [&](const Mesh&) { return Geometry(); }, [&](const auto& s) { return build(s, object); }},
                 shape);
  geometry->computeLocalAABB();
  return geometry;
}

GeometryParts parts_of(const std::shared_ptr<const coal::CollisionGeometry>& geometry) {
  return {outer_hull(geometry), make_primitive_bvh(*geometry)};
}

std::shared_ptr<const coal::CollisionGeometry> outer_hull(std::shared_ptr<const coal::CollisionGeometry> geometry) {
  const auto* mesh = dynamic_cast<const coal::BVHModelBase*>(geometry.get());
  if (!mesh) return geometry;
  const auto hull = solid_hull({mesh->vertices->begin(), mesh->vertices->begin() + mesh->num_vertices});
  if (!hull) return geometry;
  hull->computeLocalAABB();
  return hull;
}

}  // namespace srmp
