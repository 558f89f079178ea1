#include "srmp/cover/cover_solid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/cover/enclosing_sphere.hpp"
#include "srmp/cover/solid_geometry.hpp"

namespace srmp {

namespace {

using Eigen::Vector3d;

constexpr int kFacets = 64;  // of the polygonal approximation of a curved solid

void set_corners(SolidGeometry& geometry) {
  for (const Triangle& t : geometry.triangles) geometry.vertices.insert(geometry.vertices.end(), t.begin(), t.end());
  for (const Vector3d& v : geometry.vertices) geometry.box.extend(v);
}

/// Sets the half-spaces of a convex solid: the planes of the faces and of a few more directions, each moved outwards
/// until it contains every vertex.
void set_planes(SolidGeometry& geometry, const CoverSolid::Vertices& vertices) {
  std::vector<Vector3d> normals;
  std::vector<double> inner;
  for (const Triangle& t : geometry.triangles) {
    const Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
    const double area = n.norm();
    if (area < 1e-12) continue;
    Vector3d unit = n / area;
    if (unit.dot(t[0] - geometry.box.center()) < 0) unit = -unit;
    normals.push_back(unit);
    inner.push_back(std::min({unit.dot(t[0]), unit.dot(t[1]), unit.dot(t[2])}));
  }
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z)
        if (x || y || z) {
          normals.push_back(Vector3d(x, y, z).normalized());
          inner.push_back(std::numeric_limits<double>::infinity());
        }
  const auto count = static_cast<Eigen::Index>(normals.size());
  geometry.normals.resize(count, 3);
  geometry.offsets.resize(count);
  geometry.inner_offsets.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    double support = -std::numeric_limits<double>::infinity();
    for (const Vector3d& v : vertices) support = std::max(support, normals[i].dot(v));
    geometry.normals.row(i) = normals[i];
    geometry.offsets[i] = support;
    geometry.inner_offsets[i] = std::min(inner[i], support) - 1e-9;
  }
  geometry.convex = true;
}

/// The triangles with their corners. Throws InvalidArgument for vertices that are not finite and for wrong indices.
std::vector<Triangle> gather(const CoverSolid::Vertices& vertices, const CoverSolid::Triangles& triangles) {
  std::vector<Triangle> result;
  for (std::size_t k = 0; k < vertices.size(); ++k)
    if (!vertices[k].allFinite()) throw InvalidArgument("mesh: vertex " + std::to_string(k) + " is not finite");
  for (const auto& t : triangles) {
    for (int i : t)
      if (i < 0 || i >= static_cast<int>(vertices.size()))
        throw InvalidArgument("mesh: a triangle names vertex " + std::to_string(i) + ", but there are only " +
                              std::to_string(vertices.size()) + " vertices");
    result.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
  }
  if (result.empty()) throw InvalidArgument("mesh: there are no triangles to cover");
  return result;
}

/// Does every edge belong to an even number of triangles? Equal vertices count as one.
bool every_edge_is_shared(const std::vector<Triangle>& triangles) {
  std::map<std::array<double, 3>, int> ids;
  std::vector<std::pair<int, int>> edges;
  for (const Triangle& t : triangles) {
    std::array<int, 3> id;
    for (int k = 0; k < 3; ++k) id[k] = ids.try_emplace({t[k].x(), t[k].y(), t[k].z()}, ids.size()).first->second;
    if (id[0] == id[1] || id[1] == id[2] || id[2] == id[0]) continue;
    for (int k = 0; k < 3; ++k) edges.push_back(std::minmax(id[k], id[(k + 1) % 3]));
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0, j; i < edges.size(); i = j) {
    for (j = i; j < edges.size() && edges[j] == edges[i];) ++j;
    if ((j - i) % 2) return false;
  }
  return true;
}

/// The mean of the surface.
Vector3d middle_of(const std::vector<Triangle>& triangles) {
  Vector3d sum = Vector3d::Zero();
  double area = 0;
  for (const Triangle& t : triangles) {
    const double twice = (t[1] - t[0]).cross(t[2] - t[0]).norm();
    sum += twice * (t[0] + t[1] + t[2]) / 3;
    area += twice;
  }
  return sum / area;
}

/// Is the mesh its own convex hull, but for rounding? Measures how deep its surface lies below the hull's planes. Where
/// no triangle lies deeper, one point there tells whether the surface closes the hull.
bool is_nearly_convex(const SolidGeometry& mesh, const CoverSolid::Vertices& vertices) {
  if (!mesh.closed || mesh.triangles.size() > 4000) return false;
  const double size = mesh.box.diagonal().norm();
  for (const Triangle& t : mesh.triangles) {  // rejects most meshes at little cost
    interruption_point();
    const Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
    if (n.norm() < 1e-5 * size * size) continue;
    double low = 0, high = 0;
    for (const Vector3d& v : vertices) {
      const double d = n.normalized().dot(v - t[0]);
      low = std::min(low, d);
      high = std::max(high, d);
    }
    if (std::min(-low, high) > 0.02 * size) return false;
  }
  SolidGeometry hull;
  hull.triangles = mesh.triangles;
  hull.box = mesh.box;
  set_planes(hull, vertices);
  bool near = true;
  for (const Triangle& t : mesh.triangles)
    split_triangle(t, size / 40, [&](const Triangle& part) {
      interruption_point();
      if (near) near = hull.depth((part[0] + part[1] + part[2]) / 3) <= 1.5e-3 * size;
    });
  if (!near) return false;
  hull.closed = true;
  hull.all = TriangleBvh(mesh.triangles);
  const Vector3d middle = middle_of(mesh.triangles);
  return hull.inner_depth(middle) > 0 && hull.is_odd(middle);
}

Triangle flipped_if(bool flip, Triangle t) {
  if (flip) std::swap(t[1], t[2]);
  return t;
}

/// A solid of revolution about z with the given profile (radius, z), bottom to top, as triangles inscribed in it.
std::vector<Triangle> revolve(const std::vector<std::pair<double, double>>& profile) {
  std::vector<Triangle> triangles;
  const auto at = [&](std::size_t ring, int k) {
    const double angle = 2 * std::numbers::pi * k / kFacets;
    return Vector3d(profile[ring].first * std::cos(angle), profile[ring].first * std::sin(angle), profile[ring].second);
  };
  const Vector3d bottom(0, 0, profile.front().second), top(0, 0, profile.back().second);
  for (int k = 0; k < kFacets; ++k) {
    if (profile.front().first > 0) triangles.push_back(flipped_if(true, {bottom, at(0, k), at(0, k + 1)}));
    if (profile.back().first > 0) triangles.push_back({top, at(profile.size() - 1, k), at(profile.size() - 1, k + 1)});
    for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
      if (profile[i].first > 0) triangles.push_back({at(i, k), at(i, k + 1), at(i + 1, k)});
      if (profile[i + 1].first > 0) triangles.push_back({at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)});
    }
  }
  return triangles;
}

/// Planes tangent to a solid of revolution: kFacets around it, with unit normals (normal_r, normal_z) in the radial
/// plane and offset `side_offset`, and the two caps at z = `low` and z = `high`.
void set_planes_around(SolidGeometry& geometry, double normal_r, double normal_z, double side_offset, double low,
                       double high) {
  geometry.normals.resize(kFacets + 2, 3);
  geometry.offsets.resize(kFacets + 2);
  for (int k = 0; k < kFacets; ++k) {
    const double angle = 2 * std::numbers::pi * k / kFacets;
    geometry.normals.row(k) << normal_r * std::cos(angle), normal_r * std::sin(angle), normal_z;
    geometry.offsets[k] = side_offset;
  }
  geometry.normals.row(kFacets) << 0, 0, 1;
  geometry.normals.row(kFacets + 1) << 0, 0, -1;
  geometry.offsets[kFacets] = high;
  geometry.offsets[kFacets + 1] = -low;
  geometry.inner_offsets = geometry.offsets;
  geometry.convex = true;
  set_corners(geometry);
}

}  // namespace

CoverSolid CoverSolid::sphere(double radius) {
  require_positive(radius, "sphere radius");
  auto geometry = std::make_shared<SolidGeometry>();
  geometry->kind = SolidGeometry::Kind::sphere;
  geometry->radius = radius;
  geometry->convex = true;
  geometry->curved_depth = [radius](const Vector3d& p) { return radius - p.norm(); };
  geometry->box = Eigen::AlignedBox3d(Vector3d::Constant(-radius), Vector3d::Constant(radius));
  return CoverSolid(geometry);
}

CoverSolid CoverSolid::capsule(double radius, double length) {
  require_positive(radius, "capsule radius");
  require_positive(length, "capsule length");
  auto geometry = std::make_shared<SolidGeometry>();
  geometry->kind = SolidGeometry::Kind::capsule;
  geometry->radius = radius;
  geometry->length = length;
  geometry->convex = true;
  geometry->curved_depth = [radius, half = length / 2](const Vector3d& p) {
    return radius - (p - Vector3d(0, 0, std::clamp(p.z(), -half, half))).norm();
  };
  const Vector3d corner(radius, radius, length / 2 + radius);
  geometry->box = Eigen::AlignedBox3d(-corner, corner);
  return CoverSolid(geometry);
}

CoverSolid CoverSolid::box(const Vector3d& size) {
  for (int k = 0; k < 3; ++k) require_positive(size[k], "box size");
  Vertices vertices;
  for (int i = 0; i < 8; ++i)
    vertices.push_back(0.5 * size.cwiseProduct(Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  const Triangles triangles{{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                            {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return convex(vertices, triangles);
}

CoverSolid CoverSolid::cylinder(double radius, double length) {
  require_positive(radius, "cylinder radius");
  require_positive(length, "cylinder length");
  auto geometry = std::make_shared<SolidGeometry>();
  const double half = length / 2;
  geometry->triangles = revolve({{radius, -half}, {radius, half}});
  geometry->curved_depth = [radius, half](const Vector3d& p) {
    return std::min(radius - p.head<2>().norm(), half - std::abs(p.z()));
  };
  set_planes_around(*geometry, 1, 0, radius, -half, half);
  return CoverSolid(geometry);
}

CoverSolid CoverSolid::cone(double radius, double length) {
  require_positive(radius, "cone radius");
  require_positive(length, "cone length");
  auto geometry = std::make_shared<SolidGeometry>();
  const double half = length / 2, slant = std::hypot(radius, length);
  const double nr = length / slant, nz = radius / slant, offset = nz * half;
  geometry->triangles = revolve({{radius, -half}, {0, half}});
  geometry->curved_depth = [=](const Vector3d& p) {
    return std::min(offset - (nr * p.head<2>().norm() + nz * p.z()), p.z() + half);
  };
  set_planes_around(*geometry, nr, nz, offset, -half, half);
  return CoverSolid(geometry);
}

CoverSolid CoverSolid::convex(const Vertices& vertices, const Triangles& triangles) {
  auto geometry = std::make_shared<SolidGeometry>();
  geometry->triangles = gather(vertices, triangles);
  geometry->vertices = vertices;
  set_corners(*geometry);
  set_planes(*geometry, vertices);
  return CoverSolid(geometry);
}

CoverSolid CoverSolid::mesh(const Vertices& vertices, const Triangles& triangles, double closing) {
  auto geometry = std::make_shared<SolidGeometry>();
  geometry->triangles = gather(vertices, triangles);
  set_corners(*geometry);
  geometry->closed = every_edge_is_shared(geometry->triangles);
  if (is_nearly_convex(*geometry, vertices)) {
    set_planes(*geometry, vertices);
    return CoverSolid(geometry);
  }
  geometry->all = TriangleBvh(geometry->triangles);
  const double voxel = std::max(geometry->box.sizes().maxCoeff() / 128, 2.5e-4);
  geometry->enclosed = EnclosedSpace(geometry->triangles, voxel);
  geometry->filled = closing > voxel ? EnclosedSpace(geometry->triangles, voxel, closing) : geometry->enclosed;
  std::vector<Triangle> outer = geometry->filled.plugs();
  for (const Triangle& t : geometry->triangles) {
    bool reachable = false;
    split_triangle(t, voxel, [&](const Triangle& part) {
      interruption_point();
      if (!reachable) reachable = geometry->filled.reachable_near(part);
    });
    if (reachable) outer.push_back(t);
  }
  geometry->outer = TriangleBvh(outer);
  return CoverSolid(geometry);
}

bool CoverSolid::is_convex() const { return geometry_->convex; }

bool CoverSolid::is_closed() const { return geometry_->convex || geometry_->closed; }

double CoverSolid::depth(const Vector3d& point) const { return geometry_->depth(point); }

PlacedSphere CoverSolid::bounding_sphere() const {
  const SolidGeometry& geometry = *geometry_;
  if (geometry.kind == SolidGeometry::Kind::sphere) return {Vector3d::Zero(), geometry.radius};
  if (geometry.kind == SolidGeometry::Kind::capsule) return {Vector3d::Zero(), geometry.radius + geometry.length / 2};
  const auto farthest = [&](const Vector3d& c) {
    Vector3d far = c;
    for (const Vector3d& v : geometry.vertices)
      if ((v - c).squaredNorm() > (far - c).squaredNorm()) far = v;
    return far;
  };
  PlacedSphere sphere{approach_center(geometry.box.center(), 60, farthest), 0};
  if (geometry.curved_depth)
    sphere.center.head<2>().setZero();  // by symmetry; the ring of vertices then gives the radius
  sphere.radius = (farthest(sphere.center) - sphere.center).norm() * (1 + 1e-12);
  return sphere;
}

}  // namespace srmp
