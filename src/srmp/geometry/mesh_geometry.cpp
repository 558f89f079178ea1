#include "srmp/geometry/mesh_geometry.hpp"

#include <coal/BVH/BVH_model.h>
#include <coal/shape/convex.h>
#include <libqhull_r/libqhull_r.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/core/lengths.hpp"

namespace srmp {

namespace {

using Hull = coal::Convex<coal::Triangle>;
constexpr double kThin = 1e-9;  // relative to the size: points this near to a plane span no volume
constexpr double kFlat = 1e-6;  // [m] how far a surface may be from its hull and still count as convex

struct Plane {
  Eigen::Vector3d normal;
  double offset;
  double distance(const Eigen::Vector3d& p) const { return std::abs(normal.dot(p) - offset); }
};

/// Does qhull compute the hull without a message? Coal 3.0.3 gives it no file to write messages to, so that the process
/// ends with the first one; the same computation is made here before, with a file.
bool qhull_is_silent(const std::vector<Eigen::Vector3d>& points) {
  char* text = nullptr;
  std::size_t size = 0;
  FILE* messages = open_memstream(&text, &size);
  if (!messages) return false;
  qhT qhull;
  qh_zero(&qhull, messages);
  std::string command = "qhull Qt";  // as Coal has it
  const int status = qh_new_qhull(&qhull, 3, static_cast<int>(points.size()), const_cast<double*>(points[0].data()),
                                  False, command.data(), nullptr, messages);
  qh_freeqhull(&qhull, !qh_ALL);
  int remaining = 0, blocks = 0;
  qh_memfreeshort(&qhull, &remaining, &blocks);
  std::fclose(messages);
  std::free(text);
  return status == qh_ERRnone && size == 0;
}

std::shared_ptr<Hull> coal_hull(const std::vector<Eigen::Vector3d>& vertices) {
  return std::dynamic_pointer_cast<Hull>(solid_hull(vertices));
}

std::shared_ptr<Hull> require_hull(const std::vector<Eigen::Vector3d>& vertices) {
  if (auto hull = coal_hull(vertices)) return hull;
  throw InvalidArgument("the convex hull of " + std::to_string(vertices.size()) +
                        (spans_volume(vertices) ? " points is too nearly flat, or too irregular, to be computed"
                                                : " points has no volume; it needs four points that are not in one "
                                                  "plane"));
}

/// Is every edge used exactly once in each direction?
bool is_closed(const TriangleSoup& mesh) {
  std::vector<std::pair<int, int>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    for (int i = 0; i < 3; ++i) edges.emplace_back(t[i], t[(i + 1) % 3]);
  std::sort(edges.begin(), edges.end());
  if (std::adjacent_find(edges.begin(), edges.end()) != edges.end()) return false;
  return std::all_of(edges.begin(), edges.end(), [&](const auto& edge) {
    return std::binary_search(edges.begin(), edges.end(), std::pair(edge.second, edge.first));
  });
}

double signed_volume(const TriangleSoup& mesh) {
  double sum = 0.0;
  const Eigen::Vector3d& o = mesh.vertices.front();
  for (const auto& t : mesh.triangles)
    sum += (mesh.vertices[t[0]] - o).dot((mesh.vertices[t[1]] - o).cross(mesh.vertices[t[2]] - o));
  return sum / 6.0;
}

/// Planes of the hull's faces, and its volume and area.
struct HullFaces {
  explicit HullFaces(const Hull& hull) {
    const auto& points = *hull.points;
    for (const coal::Triangle& t : *hull.polygons) {
      const Eigen::Vector3d &a = points[t[0]], &b = points[t[1]], &c = points[t[2]];
      const Eigen::Vector3d normal = (b - a).cross(c - a);
      area += normal.norm() / 2;
      volume += std::abs((a - hull.center).dot(normal)) / 6;
      if (normal.norm() > 0) planes.push_back({normal.normalized(), normal.normalized().dot(a)});
    }
  }
  std::vector<Plane> planes;
  double volume{}, area{};
};

bool is_convex(const TriangleSoup& mesh, const Hull& hull) {
  const HullFaces faces(hull);
  if (std::abs(std::abs(signed_volume(mesh)) - faces.volume) > kFlat * faces.area) return false;
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& t) {
    interruption_point();
    return std::any_of(faces.planes.begin(), faces.planes.end(), [&](const Plane& plane) {
      return plane.distance(mesh.vertices[t[0]]) <= kFlat && plane.distance(mesh.vertices[t[1]]) <= kFlat &&
             plane.distance(mesh.vertices[t[2]]) <= kFlat;
    });
  });
}

std::shared_ptr<coal::CollisionGeometry> triangle_model(const TriangleSoup& mesh) {
  auto model = std::make_shared<coal::BVHModel<coal::OBBRSS>>();
  std::vector<coal::Vec3s> points(mesh.vertices.begin(), mesh.vertices.end());
  std::vector<coal::Triangle> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  model->beginModel();
  model->addSubModel(points, triangles);
  model->endModel();
  return model;
}

}  // namespace

bool spans_volume(const std::vector<Eigen::Vector3d>& vertices) {
  if (vertices.size() < 4) return false;
  const auto farthest = [&](auto&& measure) {
    return *std::max_element(vertices.begin(), vertices.end(),
                             [&](const auto& a, const auto& b) { return measure(a) < measure(b); });
  };
  const Eigen::Vector3d& a = vertices.front();
  const Eigen::Vector3d b = farthest([&](const Eigen::Vector3d& v) { return (v - a).norm(); });
  const double size = (b - a).norm();
  if (size == 0.0) return false;
  const Eigen::Vector3d along = (b - a) / size;
  const Eigen::Vector3d c = farthest([&](const Eigen::Vector3d& v) { return along.cross(v - a).norm(); });
  const Eigen::Vector3d across = along.cross(c - a);
  if (across.norm() <= kThin * size) return false;
  const Eigen::Vector3d normal = across.normalized();
  const Eigen::Vector3d d = farthest([&](const Eigen::Vector3d& v) { return std::abs(normal.dot(v - a)); });
  return std::abs(normal.dot(d - a)) > kThin * size;
}

std::shared_ptr<coal::ConvexBase> solid_hull(const std::vector<Eigen::Vector3d>& vertices) {
  if (!spans_volume(vertices) || !qhull_is_silent(vertices)) return nullptr;
  auto points = std::make_shared<std::vector<coal::Vec3s>>(vertices.begin(), vertices.end());
  try {
    return std::shared_ptr<coal::ConvexBase>(
        coal::ConvexBase::convexHull(points, static_cast<unsigned>(points->size()), true));
  } catch (const std::exception&) {  // a corner with too many edges for Coal
    return nullptr;
  }
}

TriangleSoup convex_hull(const std::vector<Eigen::Vector3d>& points) {
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!points[i].allFinite())
      throw InvalidArgument(
          "point " + std::to_string(i) +
          " of a convex hull has a component that is NaN or infinite; only finite numbers are allowed");
  for (std::size_t i = 0; i < points.size(); ++i)
    require_position(points[i], "point " + std::to_string(i) + " of a convex hull");
  const auto hull = require_hull(points);
  const std::vector<coal::Vec3s>& corners = *hull->points;
  TriangleSoup surface;
  std::vector<int> number(corners.size(), -1);
  for (const coal::Triangle& t : *hull->polygons) {
    std::array<int, 3> triangle{};
    for (int i = 0; i < 3; ++i) {
      int& known = number[t[i]];
      if (known < 0) {
        known = static_cast<int>(surface.vertices.size());
        surface.vertices.push_back(corners[t[i]]);
      }
      triangle[static_cast<std::size_t>(i)] = known;
    }
    const Eigen::Vector3d &a = corners[t[0]], &b = corners[t[1]], &c = corners[t[2]];
    if ((b - a).cross(c - a).dot(a - hull->center) < 0) std::swap(triangle[1], triangle[2]);
    surface.triangles.push_back(triangle);
  }
  return surface;
}

bool is_convex(const TriangleSoup& mesh) {
  if (mesh.triangles.empty() || !is_closed(mesh)) return false;
  const auto hull = coal_hull(mesh.vertices);
  return hull && is_convex(mesh, *hull);
}

std::shared_ptr<const coal::CollisionGeometry> make_mesh_geometry(const TriangleSoup& mesh, MeshModel model) {
  std::shared_ptr<coal::CollisionGeometry> geometry;
  if (model == MeshModel::hull) {
    geometry = require_hull(mesh.vertices);
  } else {
    if (mesh.triangles.empty()) throw InvalidArgument("a mesh needs at least one triangle");
    if (model == MeshModel::hull_if_convex && is_closed(mesh)) {
      const auto hull = coal_hull(mesh.vertices);
      if (hull && is_convex(mesh, *hull)) geometry = hull;
    }
    if (!geometry) geometry = triangle_model(mesh);
  }
  geometry->computeLocalAABB();
  return geometry;
}

}  // namespace srmp
