#include "srmp/geometry/distance_field.hpp"

#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "srmp/core/interruption.hpp"
#include "srmp/geometry/mesh_geometry.hpp"

namespace srmp {

using Eigen::Vector3d;

namespace {

constexpr double max_voxels = 4e6;
constexpr double voxels_along = 64;  // the longest edge of a mesh
constexpr double max_reach = 0.25;   // [m]

/// The lower corner and the edge lengths of the bounding box.
std::pair<Vector3d, Vector3d> box_around(const PrimitiveBvh& primitives) {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const PrimitiveBvh::Triangle& triangle : primitives.triangles())
    for (const Vector3d& v : triangle) low = low.cwiseMin(v), high = high.cwiseMax(v);
  for (const Vector3d& cube : primitives.cubes()) {
    low = low.cwiseMin((cube.array() - primitives.edge() / 2).matrix());
    high = high.cwiseMax((cube.array() + primitives.edge() / 2).matrix());
  }
  return {low, high - low};
}

/// Does the triangle intersect the cube, enlarged a little? Separating axes (Akenine-Moller 2001).
bool intersects(const PrimitiveBvh::Triangle& triangle, const Vector3d& middle, double half) {
  const double h = half * (1 + 1e-6);
  const Vector3d a = triangle[0] - middle, b = triangle[1] - middle, c = triangle[2] - middle;
  const auto separates = [&](const Vector3d& axis) {
    const double x = axis.dot(a), y = axis.dot(b), z = axis.dot(c), r = h * axis.cwiseAbs().sum();
    return std::min({x, y, z}) > r || std::max({x, y, z}) < -r;
  };
  for (int i = 0; i < 3; ++i)
    if (separates(Vector3d::Unit(i))) return false;
  const std::array<Vector3d, 3> edges{b - a, c - b, a - c};
  if (separates(edges[0].cross(edges[1]))) return false;
  for (const Vector3d& edge : edges)
    for (int i = 0; i < 3; ++i)
      if (separates(Vector3d::Unit(i).cross(edge))) return false;
  return true;
}

}  // namespace

/// Voxels that together contain the geometry; each occupied one intersects it.
struct DistanceField::Voxels {
  double edge{};
  Vector3d corner;
  std::array<int, 3> size{};
  std::vector<char> occupied;  // x runs fastest

  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(x);
  }

  explicit Voxels(const PrimitiveBvh& primitives) {
    const auto [low, extent] = box_around(primitives);
    if (primitives.of_cubes()) {
      edge = primitives.edge();
      const auto count = [&] { return ((extent.array() / edge).ceil() + 1).prod(); };
      while (count() > max_voxels) edge *= 2;
      corner = (low.array() / edge + 1e-6).floor() * edge;
    } else {
      edge = std::max(extent.maxCoeff() / voxels_along, 1e-4);
      corner = low.array() - edge / 2;
    }
    for (int i = 0; i < 3; ++i)
      size[static_cast<std::size_t>(i)] =
          std::max(1, static_cast<int>(std::ceil((low[i] + extent[i] - corner[i]) / edge - 1e-6)));
    occupied.assign(index(0, 0, size[2]), 0);
    if (primitives.of_cubes())
      for (const Vector3d& cube : primitives.cubes()) occupy(cube);
    else
      for (const PrimitiveBvh::Triangle& triangle : primitives.triangles()) occupy(triangle);
  }

  std::array<int, 3> cell_of(const Vector3d& p) const {
    std::array<int, 3> cell{};
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      cell[k] = std::clamp(static_cast<int>(std::floor((p[i] - corner[i]) / edge)), 0, size[k] - 1);
    }
    return cell;
  }

  void occupy(const Vector3d& cube) {
    const auto cell = cell_of(cube);
    occupied[index(cell[0], cell[1], cell[2])] = 1;
  }

  void occupy(const PrimitiveBvh::Triangle& t) {
    interruption_point();
    const Vector3d margin = Vector3d::Constant(1e-6 * edge);
    const auto from = cell_of(t[0].cwiseMin(t[1]).cwiseMin(t[2]) - margin),
               to = cell_of(t[0].cwiseMax(t[1]).cwiseMax(t[2]) + margin);
    for (int z = from[2]; z <= to[2]; ++z)
      for (int y = from[1]; y <= to[1]; ++y)
        for (int x = from[0]; x <= to[0]; ++x) {
          char& cell = occupied[index(x, y, z)];
          if (!cell) cell = intersects(t, corner + edge * Vector3d(x + 0.5, y + 0.5, z + 0.5), edge / 2);
        }
  }

  /// Occupies what lies between two occupied voxels of a row: the interior of a convex solid.
  void fill() {
    for (int z = 0; z < size[2]; ++z)
      for (int y = 0; y < size[1]; ++y) {
        const auto row = occupied.begin() + static_cast<std::ptrdiff_t>(index(0, y, z)), end = row + size[0];
        const auto first = std::find(row, end, 1);
        if (first == end) continue;
        const auto last = std::find(std::make_reverse_iterator(end), std::make_reverse_iterator(row), 1).base();
        std::fill(first, last, 1);
      }
  }
};

DistanceField::DistanceField(const PrimitiveBvh& primitives) : DistanceField(primitives, false, 0.0) {}
DistanceField::DistanceField(const PrimitiveBvh& surface, double outside) : DistanceField(surface, true, outside) {}

DistanceField::DistanceField(const PrimitiveBvh& primitives, bool solid, double outside) {
  Voxels voxels(primitives);
  if (solid) voxels.fill();
  const int ratio = voxels.occupied.size() > 300'000 ? 3 : voxels.occupied.size() > 50'000 ? 2 : 1;
  corner_ = voxels.corner;
  cell_ = ratio * voxels.edge;
  for (std::size_t i = 0; i < 3; ++i) size_[i] = (voxels.size[i] + ratio - 1) / ratio + 1;
  // Larger than what queries about any body need, and a whole number of voxels for the windows of measure().
  reach_ = voxels.edge * std::max(4.0, std::ceil(max_reach / voxels.edge));
  reach_ = std::min(reach_, 64 * voxels.edge);
  const bool tight = primitives.of_cubes() && voxels.edge == primitives.edge();
  error_bound_ = outside + (tight ? 0.0 : std::sqrt(3.0) * voxels.edge) + 2e-3 * reach_;
  measure(voxels);
}

DistanceField::Bounds DistanceField::distance(const Vector3d& point) const {
  const auto value = [&](int x, int y, int z) {
    return static_cast<double>(squared_[static_cast<std::size_t>((z * size_[1] + y) * size_[0] + x)]);
  };
  const Vector3d at = (point - corner_) / cell_;
  Vector3d inside, t;
  std::array<int, 3> cell{}, nearest{};
  double bend = 0;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    inside[i] = std::clamp(at[i], 0.0, size_[k] - 1.0);
    cell[k] = std::min(static_cast<int>(inside[i]), size_[k] - 2);
    nearest[k] = static_cast<int>(std::lround(inside[i]));
    t[i] = inside[i] - cell[k];
    bend += t[i] * (1 - t[i]);
  }
  double mixed = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
    const double weight = (x ? t[0] : 1 - t[0]) * (y ? t[1] : 1 - t[1]) * (z ? t[2] : 1 - t[2]);
    mixed += weight * value(cell[0] + x, cell[1] + y, cell[2] + z);
  }
  const double off = cell_ * (at - inside).norm();
  const double low = std::sqrt(std::max(0.0, mixed - cell_ * cell_ * bend) + off * off);
  const double v = std::sqrt(std::max(0.0, value(nearest[0], nearest[1], nearest[2])));
  if (v >= 0.99 * reach_) return {low, std::numeric_limits<double>::infinity()};
  const Vector3d grid_point = corner_ + cell_ * Vector3d(nearest[0], nearest[1], nearest[2]);
  return {low, v + error_bound_ + (point - grid_point).norm()};
}

namespace {

/// The squared distance from a grid point at `at` to the interval [cell, cell + 1].
float squared_gap(int at, int cell) {
  const auto d = static_cast<float>(std::max({cell - at, at - cell - 1, 0}));
  return d * d;
}

/// Of each grid point along a row of `size` voxels, the squared distance to the nearest occupied one, at most `far`,
/// the square of `window`. Grid points lie on every `ratio`-th corner of a voxel.
void measure_row(const char* row, int size, int ratio, int window, float far, std::vector<float>& squared) {
  int left = -window - 1, right = -1;  // the nearest occupied voxels on both sides of a grid point
  for (std::size_t i = 0; i < squared.size(); ++i) {
    const int at = ratio * static_cast<int>(i);
    for (int x = std::max(0, at - ratio); x < std::min(at, size); ++x)
      if (row[x]) left = x;
    if (right < at) {
      right = at;
      while (right < size && !row[right]) ++right;
    }
    squared[i] = std::min({far, squared_gap(at, left), right < size ? squared_gap(at, right) : far});
  }
}

/// One axis of the transform: `source` holds squared distances within the line or plane of voxels `cell`; `target` is a
/// sequence of lines or planes of grid points along the axis, each as large as the source, and becomes the minimum.
void relax(const std::vector<float>& source, int cell, int ratio, float far, std::vector<float>& target) {
  const std::size_t size = source.size();
  for (std::size_t k = 0; k < target.size() / size; ++k) {
    const float add = squared_gap(ratio * static_cast<int>(k), cell);
    if (add >= far) continue;
    float* out = target.data() + k * size;
    for (std::size_t i = 0; i < size; ++i) out[i] = std::min(out[i], source[i] + add);
  }
}

}  // namespace

/// Exact distances from the grid points to the occupied voxels, as far as the reach. As in Felzenszwalb and
/// Huttenlocher 2012, one axis after the other. Each axis takes the minimum over a window of voxels and not the lower
/// envelope of parabolas, since the reach is short, the distance is to voxels rather than to points, and there are
/// fewer grid points than voxels.
void DistanceField::measure(const Voxels& voxels) {
  const int ratio = static_cast<int>(std::lround(cell_ / voxels.edge));
  const int window = static_cast<int>(std::lround(reach_ / voxels.edge));
  const auto far = static_cast<float>(window) * static_cast<float>(window);  // in units of a voxel's edge
  const auto nx = static_cast<std::size_t>(size_[0]), ny = static_cast<std::size_t>(size_[1]),
             nz = static_cast<std::size_t>(size_[2]);
  std::vector<float> along_x(nx), along_y(ny * nx);
  squared_.assign(nx * ny * nz, far);
  for (int z = 0; z < voxels.size[2]; ++z) {
    interruption_point();
    std::fill(along_y.begin(), along_y.end(), far);
    bool any = false;
    for (int y = 0; y < voxels.size[1]; ++y) {
      const char* row = voxels.occupied.data() + voxels.index(0, y, z);
      if (std::find(row, row + voxels.size[0], 1) == row + voxels.size[0]) continue;
      any = true;
      measure_row(row, voxels.size[0], ratio, window, far, along_x);
      relax(along_x, y, ratio, far, along_y);
    }
    if (any) relax(along_y, z, ratio, far, squared_);
  }
  // Interpolating these in single precision loses less than this; error_bound() includes it.
  const double unit = voxels.edge * voxels.edge, rounding = 64 * 0x1p-24 * reach_ * reach_;
  for (float& value : squared_) value = static_cast<float>(value * unit - rounding);
}

namespace {

DistanceField solid_field(const TriangleSoup& surface, double outside) {
  const auto mesh = make_mesh_geometry(surface, MeshModel::surface);
  return DistanceField(*make_primitive_bvh(*mesh), outside);
}

TriangleSoup surface_of(const coal::Convex<coal::Triangle>& hull) {
  TriangleSoup surface{{hull.points->begin(), hull.points->end()}, {}};
  for (const coal::Triangle& t : *hull.polygons)
    surface.triangles.push_back({static_cast<int>(t[0]), static_cast<int>(t[1]), static_cast<int>(t[2])});
  return surface;
}

constexpr int cone_sides = 64;
/// A pyramid that contains the cone.
TriangleSoup surface_of(const coal::Cone& cone) {
  TriangleSoup surface{{{0, 0, cone.halfLength}, {0, 0, -cone.halfLength}}, {}};
  const double r = cone.radius / std::cos(std::numbers::pi / cone_sides);
  for (int i = 0; i < cone_sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / cone_sides;
    surface.vertices.emplace_back(r * std::cos(angle), r * std::sin(angle), -cone.halfLength);
    const int here = 2 + i, next = 2 + (i + 1) % cone_sides;
    surface.triangles.push_back({here, next, 0});
    surface.triangles.push_back({next, here, 1});
  }
  return surface;
}

}  // namespace

std::shared_ptr<const DistanceField> make_distance_field(const coal::CollisionGeometry& geometry,
                                                         const PrimitiveBvh* bvh) {
  if (bvh) return std::make_shared<const DistanceField>(*bvh);
  if (const auto* hull = dynamic_cast<const coal::Convex<coal::Triangle>*>(&geometry))
    return std::make_shared<const DistanceField>(solid_field(surface_of(*hull), 0.0));
  if (const auto* cone = dynamic_cast<const coal::Cone*>(&geometry))
    return std::make_shared<const DistanceField>(
        solid_field(surface_of(*cone), cone->radius * (1 / std::cos(std::numbers::pi / cone_sides) - 1)));
  return nullptr;
}

}  // namespace srmp
