#include "srmp/cover/quick_cover.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
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

/// Parts along each edge of a box, near cubes: as many along the longest edge as make at most `max_count` in all, up to
/// nine.
Vector3d parts_of(const Vector3d& edges, double max_count) {
  const double longest = edges.maxCoeff();
  Vector3d parts = Vector3d::Ones();
  for (int along = 2; along <= 9 && longest > 0; ++along) {
    const Vector3d next = (edges * along / longest - Vector3d::Constant(1e-9)).array().ceil().max(1.0);
    if (!(next.prod() <= max_count)) break;
    parts = next;
  }
  return parts;
}

/// Calls `add` with the centre of each of these parts of a box with this centre and these half edges.
template <class Add>
void for_each_part(const Vector3d& center, const Vector3d& half, const Vector3d& parts, Add&& add) {
  const Vector3d part = half.cwiseQuotient(parts);
  for (int x = 0; x < parts.x(); ++x)
    for (int y = 0; y < parts.y(); ++y)
      for (int z = 0; z < parts.z(); ++z)
        add(Vector3d(center - half + part.cwiseProduct(Vector3d(2 * x + 1, 2 * y + 1, 2 * z + 1))));
}

/// Spheres around parts of a box, as many along each edge as `coarse` tells, and around parts of each of these.
/// `radius` is that of the sphere around a part, by its half edges.
template <class Radius>
GeometryCover parts_cover(const Vector3d& center, const Vector3d& half, const Vector3d& coarse, const Vector3d& fine,
                          Radius&& radius) {
  GeometryCover cover;
  cover.quick = true;
  const auto around = [&](const Vector3d& half_edges) { return radius(half_edges) * above + 1e-12; };
  cover.bound = {center, around(half)};
  const Vector3d part = half.cwiseQuotient(coarse), fine_part = part.cwiseQuotient(fine);
  for_each_part(center, half, coarse, [&](const Vector3d& at) {
    cover.coarse.push_back({at, around(part)});
    std::vector<std::uint32_t>& children = cover.children.emplace_back();
    for_each_part(at, part, fine, [&](const Vector3d& place) {
      children.push_back(static_cast<std::uint32_t>(cover.fine.size()));
      cover.fine.push_back({place, around(fine_part)});
    });
  });
  return cover;
}

/// The cover of what is round about the z axis and within a box; where that is long, of slabs.
GeometryCover round_cover(const Vector3d& half) {
  const double radius = half.x(), slimness = half.z() / radius;
  if (!(slimness >= 2)) return box_cover(Vector3d::Zero(), half);
  const double slabs = std::clamp(std::ceil(slimness / 2.5), 1.0, 9.0);
  return parts_cover(Vector3d::Zero(), half, {1, 1, slabs}, {1, 1, 5},
                     [](const Vector3d& part) { return std::hypot(part.x(), part.z()); });
}

/// Spheres inside of what contains all points within `radius` of a box with these half edges around the origin; they
/// overlap where so few can.
std::vector<PlacedSphere> inner_spheres(const Vector3d& half, double radius) {
  constexpr double max_count = 16, spacing = 1.9;
  std::vector<PlacedSphere> spheres;
  if (!(radius > 0) || !half.allFinite()) return spheres;
  Vector3d parts;
  for (double step = std::max(spacing * radius, half.maxCoeff() / max_count);; step *= 1.1) {
    parts = (2 * half / step).array().ceil() + 1.0;
    if (!(parts.prod() > max_count)) break;
  }
  const Vector3d spread = half.cwiseProduct(parts).cwiseQuotient((parts - Vector3d::Ones()).cwiseMax(1.0));
  for_each_part(Vector3d::Zero(), spread, parts, [&](const Vector3d& at) { spheres.push_back({at, radius / above}); });
  return spheres;
}

}  // namespace

GeometryCover box_cover(const Vector3d& center, const Vector3d& half) {
  const Vector3d coarse = parts_of(half, 27);
  GeometryCover cover = parts_cover(center, half, coarse, parts_of(half.cwiseQuotient(coarse), 8),
                                    [](const Vector3d& part) { return part.norm(); });
  cover.hollow = true;
  return cover;
}

GeometryCover quick_cover(const coal::CollisionGeometry& shape) {
  using enum GeometryContent::Kind;
  const GeometryContent content = content_of(shape);
  const Vector3d& size = content.size;
  const auto solid = [](GeometryCover cover, const Vector3d& half = Vector3d::Zero(), double radius = 0) {
    cover.hollow = false;
    cover.inner = inner_spheres(half, radius);
    return cover;
  };
  switch (content.kind) {
    case sphere: {
      const PlacedSphere one{Vector3d::Zero(), size[0]};
      return {.bound = one, .coarse = {one}, .exact = true};
    }
    case box: {
      const double radius = size.minCoeff() / 2;
      return solid(box_cover(Vector3d::Zero(), size / 2), size / 2 - Vector3d::Constant(radius), radius);
    }
    case capsule: return solid(round_cover({size[0], size[0], size[1] / 2 + size[0]}), {0, 0, size[1] / 2}, size[0]);
    case cylinder: {
      const double radius = std::min(size[0], size[1] / 2), flat = size[0] - radius;
      return solid(round_cover({size[0], size[0], size[1] / 2}), {flat / 2, flat / 2, size[1] / 2 - radius}, radius);
    }
    case cone: return solid(round_cover({size[0], size[0], size[1] / 2}));
    case convex: {
      Eigen::AlignedBox3d bounds;
      for (const Vector3d& v : content.vertices) bounds.extend(v);
      return solid(box_cover(bounds.center(), bounds.sizes() / 2));
    }
    case mesh: break;
  }
  return mesh_cover(content);
}

}  // namespace srmp
