#include "srmp/geometry/distance_field.hpp"

#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "srmp/geometry/mesh_file.hpp"

namespace srmp {

using Eigen::Vector3d;

namespace {

constexpr double max_sites = 4e6;
constexpr double sites_along = 64;      // the longest edge of a mesh
constexpr double largest_reach = 0.25;  // [m]

/// Lower corner and edges.
std::pair<Vector3d, Vector3d> box_around(const PrimitiveBvh& pieces) {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const PrimitiveBvh::Triangle& triangle : pieces.triangles())
    for (const Vector3d& v : triangle) low = low.cwiseMin(v), high = high.cwiseMax(v);
  for (const Vector3d& cube : pieces.cubes()) {
    low = low.cwiseMin((cube.array() - pieces.edge() / 2).matrix());
    high = high.cwiseMax((cube.array() + pieces.edge() / 2).matrix());
  }
  return {low, high - low};
}

/// Does the triangle meet the cube? Separating axes (Akenine-Moller 2001); the cube is a little larger than it is.
bool meets(const PrimitiveBvh::Triangle& triangle, const Vector3d& middle, double half) {
  const double h = half * (1 + 1e-6);
  const Vector3d a = triangle[0] - middle, b = triangle[1] - middle, c = triangle[2] - middle;
  const auto apart = [&](const Vector3d& axis) {
    const double x = axis.dot(a), y = axis.dot(b), z = axis.dot(c), r = h * axis.cwiseAbs().sum();
    return std::min({x, y, z}) > r || std::max({x, y, z}) < -r;
  };
  for (int i = 0; i < 3; ++i)
    if (apart(Vector3d::Unit(i))) return false;
  const std::array<Vector3d, 3> edges{b - a, c - b, a - c};
  if (apart(edges[0].cross(edges[1]))) return false;
  for (const Vector3d& edge : edges)
    for (int i = 0; i < 3; ++i)
      if (apart(Vector3d::Unit(i).cross(edge))) return false;
  return true;
}

}  // namespace

/// Small cubes that hold the geometry; each holds some of it.
struct DistanceField::Sites {
  double edge{};
  Vector3d corner;
  std::array<int, 3> size{};
  std::vector<char> taken;  // x runs fastest

  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[0]) +
           static_cast<std::size_t>(x);
  }

  explicit Sites(const PrimitiveBvh& pieces) {
    const auto [low, extent] = box_around(pieces);
    if (pieces.of_cubes()) {
      edge = pieces.edge();
      const auto count = [&] { return ((extent.array() / edge).ceil() + 1).prod(); };
      while (count() > max_sites) edge *= 2;
      corner = (low.array() / edge + 1e-6).floor() * edge;
    } else {
      edge = std::max(extent.maxCoeff() / sites_along, 1e-4);
      corner = low.array() - edge / 2;
    }
    for (int i = 0; i < 3; ++i)
      size[static_cast<std::size_t>(i)] =
          std::max(1, static_cast<int>(std::ceil((low[i] + extent[i] - corner[i]) / edge - 1e-6)));
    taken.assign(index(0, 0, size[2]), 0);
    if (pieces.of_cubes())
      for (const Vector3d& cube : pieces.cubes()) take(cube);
    else
      for (const PrimitiveBvh::Triangle& triangle : pieces.triangles()) take(triangle);
  }

  std::array<int, 3> cell_of(const Vector3d& p) const {
    std::array<int, 3> cell{};
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      cell[k] = std::clamp(static_cast<int>(std::floor((p[i] - corner[i]) / edge)), 0, size[k] - 1);
    }
    return cell;
  }

  void take(const Vector3d& cube) {
    const auto cell = cell_of(cube);
    taken[index(cell[0], cell[1], cell[2])] = 1;
  }

  void take(const PrimitiveBvh::Triangle& t) {
    const Vector3d slack = Vector3d::Constant(1e-6 * edge);
    const auto from = cell_of(t[0].cwiseMin(t[1]).cwiseMin(t[2]) - slack),
               to = cell_of(t[0].cwiseMax(t[1]).cwiseMax(t[2]) + slack);
    for (int z = from[2]; z <= to[2]; ++z)
      for (int y = from[1]; y <= to[1]; ++y)
        for (int x = from[0]; x <= to[0]; ++x) {
          char& cell = taken[index(x, y, z)];
          if (!cell) cell = meets(t, corner + edge * Vector3d(x + 0.5, y + 0.5, z + 0.5), edge / 2);
        }
  }

  /// What lies between two taken cells of a row, too: the inside of a convex solid.
  void fill() {
    for (int z = 0; z < size[2]; ++z)
      for (int y = 0; y < size[1]; ++y) {
        const auto row = taken.begin() + static_cast<std::ptrdiff_t>(index(0, y, z)), end = row + size[0];
        const auto first = std::find(row, end, 1);
        if (first == end) continue;
        const auto last = std::find(std::make_reverse_iterator(end), std::make_reverse_iterator(row), 1).base();
        std::fill(first, last, 1);
      }
  }
};

DistanceField::DistanceField(const PrimitiveBvh& pieces) : DistanceField(pieces, false, 0.0) {}
DistanceField::DistanceField(const PrimitiveBvh& surface, double outside) : DistanceField(surface, true, outside) {}

DistanceField::DistanceField(const PrimitiveBvh& pieces, bool solid, double outside) {
  Sites sites(pieces);
  if (solid) sites.fill();
  const int ratio = sites.taken.size() > 300'000 ? 3 : sites.taken.size() > 50'000 ? 2 : 1;
  corner_ = sites.corner;
  cell_ = ratio * sites.edge;
  for (std::size_t i = 0; i < 3; ++i) size_[i] = (sites.size[i] + ratio - 1) / ratio + 1;
  // Longer than any body that is asked about needs; whole cells, for the passes' windows.
  reach_ = sites.edge * std::max(4.0, std::ceil(largest_reach / sites.edge));
  reach_ = std::min(reach_, 64 * sites.edge);
  const bool tight = pieces.of_cubes() && sites.edge == pieces.edge();
  excess_ = outside + (tight ? 0.0 : std::sqrt(3.0) * sites.edge) + 2e-3 * reach_;
  measure(sites);
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
  return {low, v + excess_ + (point - grid_point).norm()};
}

/// Exact distances to the cubes, one axis after the other (Felzenszwalb and Huttenlocher 2012), within the reach.
void DistanceField::measure(const Sites& sites) {
  const int ratio = static_cast<int>(std::lround(cell_ / sites.edge));
  const int window = static_cast<int>(std::lround(reach_ / sites.edge));
  const auto far = static_cast<float>(window) * static_cast<float>(window);  // in units of the sites' edge
  const auto nx = static_cast<std::size_t>(size_[0]), ny = static_cast<std::size_t>(size_[1]),
             nz = static_cast<std::size_t>(size_[2]);
  // Square of the distance from a grid point at `at` to the interval [cell, cell + 1].
  const auto apart = [](int at, int cell) {
    const auto d = static_cast<float>(std::max({cell - at, at - cell - 1, 0}));
    return d * d;
  };
  std::vector<float> along_x(nx), along_y(ny * nx);
  squared_.assign(nx * ny * nz, far);
  for (int z = 0; z < sites.size[2]; ++z) {
    std::fill(along_y.begin(), along_y.end(), far);
    bool any = false;
    for (int y = 0; y < sites.size[1]; ++y) {
      const char* row = sites.taken.data() + sites.index(0, y, z);
      if (std::find(row, row + sites.size[0], 1) == row + sites.size[0]) continue;
      any = true;
      int left = -window - 1, right = -1;  // the nearest taken cells on both sides of a grid point
      for (std::size_t i = 0; i < nx; ++i) {
        const int at = ratio * static_cast<int>(i);
        for (int x = std::max(0, at - ratio); x < std::min(at, sites.size[0]); ++x)
          if (row[x]) left = x;
        if (right < at) {
          right = at;
          while (right < sites.size[0] && !row[right]) ++right;
        }
        along_x[i] = std::min({far, apart(at, left), right < sites.size[0] ? apart(at, right) : far});
      }
      for (std::size_t j = 0; j < ny; ++j) {
        const float add = apart(ratio * static_cast<int>(j), y);
        if (add >= far) continue;
        float* out = along_y.data() + j * nx;
        for (std::size_t i = 0; i < nx; ++i) out[i] = std::min(out[i], along_x[i] + add);
      }
    }
    if (!any) continue;
    for (std::size_t k = 0; k < nz; ++k) {
      const float add = apart(ratio * static_cast<int>(k), z);
      if (add >= far) continue;
      float* out = squared_.data() + k * ny * nx;
      for (std::size_t i = 0; i < ny * nx; ++i) out[i] = std::min(out[i], along_y[i] + add);
    }
  }
  // Single precision, in what interpolates these, loses less than this; excess() makes up for it.
  const double unit = sites.edge * sites.edge, slack = 64 * 0x1p-24 * reach_ * reach_;
  for (float& value : squared_) value = static_cast<float>(value * unit - slack);
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
/// A pyramid around the cone.
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
                                                         const PrimitiveBvh* pieces) {
  if (pieces) return std::make_shared<const DistanceField>(*pieces);
  if (const auto* hull = dynamic_cast<const coal::Convex<coal::Triangle>*>(&geometry))
    return std::make_shared<const DistanceField>(solid_field(surface_of(*hull), 0.0));
  if (const auto* cone = dynamic_cast<const coal::Cone*>(&geometry))
    return std::make_shared<const DistanceField>(
        solid_field(surface_of(*cone), cone->radius * (1 / std::cos(std::numbers::pi / cone_sides) - 1)));
  return nullptr;
}

}  // namespace srmp
