#include "srmp/cover/quick_cover.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <span>
#include <utility>

#include "srmp/core/interruption.hpp"
#include "srmp/cover/enclosing_sphere.hpp"
#include "srmp/cover/geometry_content.hpp"
#include "srmp/geometry/triangle_bvh.hpp"

namespace srmp {

namespace {

using Eigen::Vector3d;

constexpr std::size_t coarse_patches = 12, fine_patches = 128;  // of a mesh
constexpr double edges_along_mesh = 24;                         // triangles are split until they are this small
constexpr double above = 1 + 1e-9;                              // larger than the rounding errors of a radius

/// What is inside of a mesh, as far as rays tell.
class Inside {
 public:
  explicit Inside(std::vector<Triangle> triangles) : surface_(std::move(triangles)) {}

  /// Distance to the surface [m], < 0 outside.
  double depth(const Vector3d& point) const {
    static const Vector3d direction = Vector3d(0.48, 0.31, 0.82).normalized();  // along no axis
    const double distance = surface_.nearest(point).distance;
    return surface_.crossings(point, direction) % 2 == 1 ? distance : -distance;
  }

 private:
  TriangleBvh surface_;
};

/// Triangles of a mesh that one sphere contains.
struct Patch {
  std::size_t begin{}, end{};
  Eigen::AlignedBox3d box;
};

/// The triangles of a mesh, sorted into patches: each patch's are consecutive.
class Patches {
 public:
  explicit Patches(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {}

  Patch whole() const { return patch(0, triangles_.size()); }

  /// Splits patches, always the largest, until there are `count`.
  std::vector<Patch> split(std::vector<Patch> patches, std::size_t count) {
    const auto smaller = [](const Patch& a, const Patch& b) {
      const double size_a = a.box.sizes().squaredNorm(), size_b = b.box.sizes().squaredNorm();
      return size_a != size_b ? size_a < size_b : a.begin > b.begin;
    };
    std::priority_queue<Patch, std::vector<Patch>, decltype(smaller)> queue(smaller, std::move(patches));
    std::vector<Patch> result;
    while (!queue.empty() && queue.size() + result.size() < count) {
      const Patch largest = queue.top();
      queue.pop();
      const std::size_t middle = divide(largest);
      if (middle == largest.begin || middle == largest.end) {
        result.push_back(largest);
        continue;
      }
      queue.push(patch(largest.begin, middle));
      queue.push(patch(middle, largest.end));
    }
    for (; !queue.empty(); queue.pop()) result.push_back(queue.top());
    std::sort(result.begin(), result.end(), [](const Patch& a, const Patch& b) { return a.begin < b.begin; });
    return result;
  }

  /// A sphere around the patch that sticks out of the mesh by little: its centre lies behind the surface where that
  /// helps.
  PlacedSphere enclosing(const Patch& patch, const Inside& inside) const {
    rare_interruption_point();
    const PlacedSphere smallest = bound(patch);
    PlacedSphere best = smallest;
    double least = smallest.radius - inside.depth(smallest.center);
    const Vector3d normal = normal_of(patch);
    for (const double steps : {0.5, 1.0, 1.5, 2.0, 3.0, 4.0})
      for (const double side : {-1.0, 1.0}) {
        const PlacedSphere sphere = sphere_at(patch, smallest.center + side * steps * smallest.radius * normal);
        const double inflation = sphere.radius - inside.depth(sphere.center);
        if (inflation >= least) continue;
        least = inflation;
        best = sphere;
      }
    return best;
  }

  /// The smallest sphere found around the patch.
  PlacedSphere bound(const Patch& patch) const {
    const auto far = [&](const Vector3d& c) { return farthest(patch, c); };
    const PlacedSphere of_box = sphere_at(patch, patch.box.center()),
                       near = sphere_at(patch, approach_center(patch.box.center(), 12, far));
    return of_box.radius < near.radius ? of_box : near;
  }

 private:
  Patch patch(std::size_t begin, std::size_t end) const {
    Patch patch{begin, end, {}};
    for (std::size_t i = begin; i < end; ++i)
      for (const Vector3d& v : triangles_[i]) patch.box.extend(v);
    return patch;
  }
  Vector3d farthest(const Patch& patch, const Vector3d& c) const {
    Vector3d far = c;
    for (std::size_t i = patch.begin; i < patch.end; ++i)
      for (const Vector3d& v : triangles_[i])
        if ((v - c).squaredNorm() > (far - c).squaredNorm()) far = v;
    return far;
  }
  PlacedSphere sphere_at(const Patch& patch, const Vector3d& c) const {
    return {c, (farthest(patch, c) - c).norm() * above};
  }
  /// The mean normal, of length 1 or 0.
  Vector3d normal_of(const Patch& patch) const {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = patch.begin; i < patch.end; ++i) {
      const Triangle& t = triangles_[i];
      sum += (t[1] - t[0]).cross(t[2] - t[0]);
    }
    const double length = sum.norm();
    return length > 0 && std::isfinite(length) ? Vector3d(sum / length) : Vector3d::Zero();
  }
  /// Sorts the patch's triangles so that those on the low side of the middle of the box's longest edge come first, and
  /// returns the place of the first other one.
  std::size_t divide(const Patch& patch) {
    interruption_point();
    int axis = 0;
    patch.box.sizes().maxCoeff(&axis);
    const double middle = 3 * patch.box.center()[axis];
    const auto first = triangles_.begin();
    const auto place =
        std::partition(first + static_cast<std::ptrdiff_t>(patch.begin), first + static_cast<std::ptrdiff_t>(patch.end),
                       [&](const Triangle& t) { return t[0][axis] + t[1][axis] + t[2][axis] < middle; });
    return static_cast<std::size_t>(place - first);
  }

  std::vector<Triangle> triangles_;
};

std::vector<Triangle> mesh_triangles(const GeometryContent& content) {
  std::vector<Triangle> triangles;
  const auto corner = [&](int i) { return content.vertices[static_cast<std::size_t>(i)]; };
  for (const auto& [a, b, c] : content.triangles) triangles.push_back({corner(a), corner(b), corner(c)});
  return triangles;
}

std::vector<Triangle> small_triangles(const std::vector<Triangle>& triangles) {
  Eigen::AlignedBox3d box;
  for (const Triangle& triangle : triangles)
    for (const Vector3d& corner : triangle) box.extend(corner);
  const double edge = std::max(box.sizes().maxCoeff() / edges_along_mesh, 1e-9);
  std::vector<Triangle> small;
  for (const Triangle& triangle : triangles) {
    split_triangle(triangle, edge, [&](const Triangle& part) { small.push_back(part); });
    interruption_point();
  }
  return small;
}

GeometryCover mesh_cover(const GeometryContent& content) {
  std::vector<Triangle> triangles = mesh_triangles(content);
  Patches patches(small_triangles(triangles));
  const Inside inside(std::move(triangles));
  const Patch whole = patches.whole();
  const std::vector<Patch> coarse = patches.split({whole}, coarse_patches);
  const std::vector<Patch> fine = patches.split(coarse, fine_patches);
  GeometryCover cover;
  cover.quick = cover.hollow = true;
  cover.bound = patches.bound(whole);
  for (const Patch& patch : fine) cover.fine.push_back(patches.enclosing(patch, inside));
  for (const Patch& patch : coarse) {
    cover.coarse.push_back(patches.enclosing(patch, inside));
    std::vector<std::uint32_t>& children = cover.children.emplace_back();
    for (std::uint32_t i = 0; i < fine.size(); ++i)
      if (fine[i].begin >= patch.begin && fine[i].end <= patch.end) children.push_back(i);
  }
  return cover;
}

/// Cells along each edge of a box: as many as `longest` along the longest, and near cubes.
Vector3d cells_of(const Vector3d& half, int longest) {
  const double edge = half.maxCoeff() / longest;
  if (!(edge > 0)) return Vector3d::Ones();
  return (half / edge - Vector3d::Constant(1e-9)).array().ceil().max(1.0);
}

std::vector<PlacedSphere> spheres_around_cells(const Vector3d& center, const Vector3d& half, int longest) {
  const Vector3d cells = cells_of(half, longest), cell = half.cwiseQuotient(cells);
  const double radius = cell.norm() * above + 1e-12;
  std::vector<PlacedSphere> spheres;
  for (int x = 0; x < cells.x(); ++x)
    for (int y = 0; y < cells.y(); ++y)
      for (int z = 0; z < cells.z(); ++z)
        spheres.push_back({center - half + cell.cwiseProduct(Vector3d(2 * x + 1, 2 * y + 1, 2 * z + 1)), radius});
  return spheres;
}

}  // namespace

GeometryCover box_cells_cover(const Vector3d& center, const Vector3d& half) {
  GeometryCover cover;
  cover.quick = cover.hollow = true;  // the cells do not tell
  cover.bound = {center, half.norm() * above};
  cover.coarse = spheres_around_cells(center, half, 3);
  const Vector3d cell = half.cwiseQuotient(cells_of(half, 3));
  for (const PlacedSphere& sphere : cover.coarse) {
    const auto first = static_cast<std::uint32_t>(cover.fine.size());
    for (const PlacedSphere& fine : spheres_around_cells(sphere.center, cell, 2)) cover.fine.push_back(fine);
    cover.children.emplace_back(cover.fine.size() - first);
    std::iota(cover.children.back().begin(), cover.children.back().end(), first);
  }
  return cover;
}

GeometryCover quick_cover(const coal::CollisionGeometry& shape) {
  using enum GeometryContent::Kind;
  const GeometryContent content = content_of(shape);
  const Vector3d& size = content.size;
  switch (content.kind) {
    case sphere: {
      const PlacedSphere one{Vector3d::Zero(), size[0]};
      return {.bound = one, .coarse = {one}, .exact = true};
    }
    case box: return box_cells_cover(Vector3d::Zero(), size / 2);
    case capsule: return box_cells_cover(Vector3d::Zero(), {size[0], size[0], size[1] / 2 + size[0]});
    case cylinder:
    case cone: return box_cells_cover(Vector3d::Zero(), {size[0], size[0], size[1] / 2});
    case convex: {
      Eigen::AlignedBox3d bounds;
      for (const Vector3d& v : content.vertices) bounds.extend(v);
      return box_cells_cover(bounds.center(), bounds.sizes() / 2);
    }
    case mesh: break;
  }
  return mesh_cover(content);
}

}  // namespace srmp
