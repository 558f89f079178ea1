#include "srmp/cover/cover_solid.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

using Eigen::Vector3d;

constexpr int kLeafTriangles = 4;
constexpr int kFacets = 64;  // of a curved solid's polygonal stand-in

/// Ericson, Real-Time Collision Detection, 5.1.5.
Vector3d nearest_on_triangle(const Triangle& t, const Vector3d& p) {
  const Vector3d ab = t[1] - t[0], ac = t[2] - t[0], ap = p - t[0];
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return t[0];
  const Vector3d bp = p - t[1];
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return t[1];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return t[0] + ab * (d1 > d3 ? d1 / (d1 - d3) : 0.0);
  const Vector3d cp = p - t[2];
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return t[2];
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return t[0] + ac * (d2 > d6 ? d2 / (d2 - d6) : 0.0);
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double sum = (d4 - d3) + (d5 - d6);
    return t[1] + (t[2] - t[1]) * (sum > 0 ? (d4 - d3) / sum : 0.0);
  }
  const double scale = 1.0 / (va + vb + vc);
  return t[0] + ab * (vb * scale) + ac * (vc * scale);
}

bool ray_crosses(const Triangle& t, const Vector3d& origin, const Vector3d& direction) {
  const Vector3d e1 = t[1] - t[0], e2 = t[2] - t[0], p = direction.cross(e2);
  const double det = e1.dot(p);
  if (det == 0.0) return false;
  const Vector3d s = origin - t[0];
  const double u = s.dot(p) / det;
  if (u < 0 || u > 1) return false;
  const Vector3d q = s.cross(e1);
  const double v = direction.dot(q) / det;
  return v >= 0 && u + v <= 1 && e2.dot(q) / det > 0;
}

bool ray_meets(const Eigen::AlignedBox3d& box, const Vector3d& origin, const Vector3d& direction) {
  double near = 0.0, far = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {  // directions used here have no zero component
    const double a = (box.min()[k] - origin[k]) / direction[k], b = (box.max()[k] - origin[k]) / direction[k];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far * (1 + 1e-12);
}

}  // namespace

void split_triangle(const Triangle& t, double edge, const std::function<void(const Triangle&)>& emit) {
  const std::array<double, 3> length{(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()};
  const int k = static_cast<int>(std::max_element(length.begin(), length.end()) - length.begin());
  if (length[k] <= edge) return emit(t);
  const Vector3d &a = t[k], &b = t[(k + 1) % 3], &c = t[(k + 2) % 3];
  const Vector3d middle = 0.5 * (a + b);
  split_triangle({a, middle, c}, edge, emit);
  split_triangle({middle, b, c}, edge, emit);
}

// --- TriangleTree

TriangleTree::TriangleTree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  if (!triangles_.empty()) build(0, static_cast<int>(triangles_.size()));
}

int TriangleTree::build(int begin, int end) {
  const int id = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  Eigen::AlignedBox3d box, centers;
  for (int i = begin; i < end; ++i) {
    for (const Vector3d& v : triangles_[i]) box.extend(v);
    centers.extend(Vector3d(triangles_[i][0] + triangles_[i][1] + triangles_[i][2]));
  }
  nodes_[id].box = box;
  nodes_[id].begin = begin;
  nodes_[id].end = end;
  if (end - begin <= kLeafTriangles) return id;
  int axis;
  centers.sizes().maxCoeff(&axis);
  std::stable_sort(triangles_.begin() + begin, triangles_.begin() + end, [axis](const Triangle& a, const Triangle& b) {
    return a[0][axis] + a[1][axis] + a[2][axis] < b[0][axis] + b[1][axis] + b[2][axis];
  });
  const int middle = (begin + end) / 2;
  const int left = build(begin, middle), right = build(middle, end);
  nodes_[id].left = left;
  nodes_[id].right = right;
  return id;
}

TriangleTree::Nearest TriangleTree::nearest(const Vector3d& point, double limit) const {
  Nearest best;
  if (triangles_.empty()) return best;
  double least = limit * limit;
  std::array<std::pair<int, double>, 96> stack;
  int top = 0;
  stack[top++] = {0, nodes_[0].box.squaredExteriorDistance(point)};
  while (top > 0) {
    const auto [id, distance] = stack[--top];
    if (distance > least) continue;
    const Node& node = nodes_[id];
    if (node.left < 0) {
      for (int i = node.begin; i < node.end; ++i) {
        const Vector3d q = nearest_on_triangle(triangles_[i], point);
        const double d = (q - point).squaredNorm();
        if (d < least || (d == least && best.distance == std::numeric_limits<double>::infinity())) {
          least = d;
          best = {q, std::sqrt(d)};
        }
      }
      continue;
    }
    const double left = nodes_[node.left].box.squaredExteriorDistance(point);
    const double right = nodes_[node.right].box.squaredExteriorDistance(point);
    const bool left_first = left <= right;
    stack[top++] = left_first ? std::pair{node.right, right} : std::pair{node.left, left};
    stack[top++] = left_first ? std::pair{node.left, left} : std::pair{node.right, right};
  }
  return best;
}

int TriangleTree::crossings(const Vector3d& point, const Vector3d& direction) const {
  if (triangles_.empty()) return 0;
  int count = 0, top = 0;
  std::array<int, 96> stack;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (!ray_meets(node.box, point, direction)) continue;
    if (node.left < 0) {
      for (int i = node.begin; i < node.end; ++i) count += ray_crosses(triangles_[i], point, direction);
      continue;
    }
    stack[top++] = node.right;
    stack[top++] = node.left;
  }
  return count;
}

// --- EnclosedSpace

EnclosedSpace::EnclosedSpace(const std::vector<Triangle>& triangles, double voxel, double closing) : voxel_(voxel) {
  Eigen::AlignedBox3d box;
  for (const Triangle& t : triangles)
    for (const Vector3d& v : t) box.extend(v);
  const int margin = 2 + static_cast<int>(std::ceil(closing / voxel));
  origin_ = box.min() - Vector3d::Constant(margin * voxel);
  size_ = ((box.sizes().array() / voxel).ceil().cast<int>() + 2 * margin + 1).eval();
  state_.assign(static_cast<std::size_t>(size_.prod()), unknown);
  for (const Triangle& triangle : triangles) {
    split_triangle(triangle, voxel, [&](const Triangle& t) {
      const Eigen::Array3i low = index(t[0].cwiseMin(t[1]).cwiseMin(t[2]));
      const Eigen::Array3i high = index(t[0].cwiseMax(t[1]).cwiseMax(t[2]));
      for (int z = low[2]; z <= high[2]; ++z)
        for (int y = low[1]; y <= high[1]; ++y)
          for (int x = low[0]; x <= high[0]; ++x) state_[flat({x, y, z})] = surface;
    });
  }
  if (closing <= voxel) {
    flood(std::vector<char>(state_.size(), 0));
    return;
  }
  // Where the sphere's centre gets to; then what lies around that, within the sphere's radius and a little, for voxels
  // beside walls are to be reached, but not by way of a hole, along the wall's other side: so in so many steps.
  const auto squared = [voxel](double radius) { return static_cast<float>(radius * radius / (voxel * voxel)); };
  const std::vector<float> from_walls = squared_distance([&](std::size_t i) { return state_[i] == surface; });
  std::vector<char> barred(state_.size());
  for (std::size_t i = 0; i < barred.size(); ++i) barred[i] = from_walls[i] <= squared(closing);
  flood(barred);
  const std::vector<float> from_centers = squared_distance([&](std::size_t i) { return state_[i] == outside; });
  for (std::size_t i = 0; i < state_.size(); ++i) barred[i] = from_centers[i] > squared(closing + 2 * voxel);
  std::vector<std::size_t> frontier;
  for (std::size_t i = 0; i < state_.size(); ++i)
    if (state_[i] == outside) frontier.push_back(i);
  spread(std::move(frontier), barred, static_cast<int>(std::ceil(std::sqrt(3.0) * (closing / voxel + 1))));
}

void EnclosedSpace::flood(const std::vector<char>& barred) {
  state_[0] = outside;
  spread({0}, barred, std::numeric_limits<int>::max());
}

/// Unknown voxels not barred, at most so many steps from the frontier, become outside.
void EnclosedSpace::spread(std::vector<std::size_t> frontier, const std::vector<char>& barred, int steps) {
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(size_[0]),
                                          static_cast<std::size_t>(size_[0]) * size_[1]};
  std::vector<std::size_t> next;
  for (int step = 0; step < steps && !frontier.empty(); ++step) {
    for (const std::size_t i : frontier)
      for (int k = 0; k < 3; ++k) {
        const std::size_t place = i / stride[k] % static_cast<std::size_t>(size_[k]);
        for (const bool up : {false, true}) {
          if (up ? place + 1 == static_cast<std::size_t>(size_[k]) : place == 0) continue;
          const std::size_t j = up ? i + stride[k] : i - stride[k];
          if (state_[j] != unknown || barred[j]) continue;
          state_[j] = outside;
          next.push_back(j);
        }
      }
    frontier.swap(next);
    next.clear();
  }
}

/// Felzenszwalb and Huttenlocher 2012: along each axis, the lower envelope of parabolas.
std::vector<float> EnclosedSpace::squared_distance(const std::function<bool(std::size_t)>& in) const {
  constexpr float far = 1e12F;
  std::vector<float> field(state_.size());
  for (std::size_t i = 0; i < field.size(); ++i) field[i] = in(i) ? 0 : far;
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(size_[0]),
                                          static_cast<std::size_t>(size_[0]) * size_[1]};
  std::vector<float> line(size_.maxCoeff()), starts(line.size() + 1);
  std::vector<int> tops(line.size());
  for (int k = 0; k < 3; ++k) {
    const int n = size_[k], a = (k + 1) % 3, b = (k + 2) % 3;
    for (int u = 0; u < size_[a]; ++u)
      for (int v = 0; v < size_[b]; ++v) {
        float* first = field.data() + u * stride[a] + v * stride[b];
        int top = -1;
        for (int i = 0; i < n; ++i) {
          line[i] = first[i * stride[k]];
          if (line[i] >= far) continue;
          float start = -far;
          for (; top >= 0; --top) {
            const int j = tops[top];
            start = ((line[i] + float(i) * i) - (line[j] + float(j) * j)) / (2.0F * (i - j));
            if (start > starts[top]) break;
          }
          ++top;
          starts[top] = top == 0 ? -far : start;
          tops[top] = i;
        }
        if (top < 0) continue;
        for (int i = 0, p = 0; i < n; ++i) {
          while (p < top && starts[p + 1] < i) ++p;
          first[i * stride[k]] = line[tops[p]] + float(i - tops[p]) * (i - tops[p]);
        }
      }
  }
  return field;
}

std::vector<Triangle> EnclosedSpace::plugs() const {
  std::vector<Triangle> faces;
  for (int z = 1; z + 1 < size_[2]; ++z)
    for (int y = 1; y + 1 < size_[1]; ++y)
      for (int x = 1; x + 1 < size_[0]; ++x) {
        const Eigen::Array3i i(x, y, z);
        if (at(i) != unknown) continue;
        for (int k = 0; k < 3; ++k)
          for (int step : {-1, 1}) {
            Eigen::Array3i j = i;
            j[k] += step;
            if (at(j) != outside) continue;
            const Vector3d low = origin_ + voxel_ * i.cast<double>().matrix();
            const Vector3d corner = low + Vector3d::Unit(k) * (step > 0 ? voxel_ : 0.0);
            const Vector3d u = voxel_ * Vector3d::Unit((k + 1) % 3), v = voxel_ * Vector3d::Unit((k + 2) % 3);
            faces.push_back({corner, corner + u, corner + v});
            faces.push_back({corner + u + v, corner + u, corner + v});
          }
      }
  return faces;
}

Eigen::Array3i EnclosedSpace::index(const Vector3d& point) const {
  return ((point - origin_).array() / voxel_).floor().cast<int>();
}

char EnclosedSpace::at(const Eigen::Array3i& i) const {
  if ((i < 0).any() || (i >= size_).any()) return outside;
  return state_[flat(i)];
}

bool EnclosedSpace::encloses(const Vector3d& point) const { return !state_.empty() && at(index(point)) == unknown; }

bool EnclosedSpace::cut(const Vector3d& point) const { return at(index(point)) == surface; }

bool EnclosedSpace::reachable_near(const Triangle& t) const {
  const Eigen::Array3i low = index(t[0].cwiseMin(t[1]).cwiseMin(t[2])) - 1;
  const Eigen::Array3i high = index(t[0].cwiseMax(t[1]).cwiseMax(t[2])) + 1;
  for (int z = low[2]; z <= high[2]; ++z)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int x = low[0]; x <= high[0]; ++x)
        if (at({x, y, z}) == outside) return true;
  return false;
}

// --- Depth

bool CoverSolid::Impl::is_odd(const Vector3d& p) const {
  const Vector3d direction(0.4371, 0.7213, 0.5373);  // no mesh is aligned with it
  return closed && all.crossings(p, direction) % 2 == 1 && all.crossings(p, -direction) % 2 == 1;
}

double CoverSolid::Impl::depth(const Vector3d& p) const {
  if (curved_depth) return curved_depth(p);
  if (convex) return (offsets - normals * p).minCoeff();
  const double distance = outer.nearest(p).distance;
  // In a voxel that triangles cut: those of an inner wall are far from the outer surface; else a closed mesh can tell.
  const bool inside = filled.encloses(p) || (filled.cut(p) && distance > 3 * filled.voxel()) || is_odd(p);
  return inside ? distance : -distance;
}

double CoverSolid::Impl::inner_depth(const Vector3d& p) const {
  if (curved_depth) return curved_depth(p);
  if (convex) return (inner_offsets - normals * p).minCoeff();
  if (!is_odd(p)) return -std::numeric_limits<double>::infinity();
  return all.nearest(p).distance;
}

// --- Solids

namespace {

using Impl = CoverSolid::Impl;

void set_corners(Impl& impl) {
  for (const Triangle& t : impl.triangles) impl.vertices.insert(impl.vertices.end(), t.begin(), t.end());
  for (const Vector3d& v : impl.vertices) impl.box.extend(v);
}

/// Faces' planes and a few more directions, each moved outward until it holds every vertex.
void set_planes(Impl& impl, const CoverSolid::Vertices& vertices) {
  std::vector<Vector3d> normals;
  std::vector<double> inner;
  for (const Triangle& t : impl.triangles) {
    const Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]);
    const double area = n.norm();
    if (area < 1e-12) continue;
    Vector3d unit = n / area;
    if (unit.dot(t[0] - impl.box.center()) < 0) unit = -unit;
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
  impl.normals.resize(count, 3);
  impl.offsets.resize(count);
  impl.inner_offsets.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    double support = -std::numeric_limits<double>::infinity();
    for (const Vector3d& v : vertices) support = std::max(support, normals[i].dot(v));
    impl.normals.row(i) = normals[i];
    impl.offsets[i] = support;
    impl.inner_offsets[i] = std::min(inner[i], support) - 1e-9;
  }
  impl.convex = true;
}

std::vector<Triangle> gather(const CoverSolid::Vertices& vertices, const CoverSolid::Triangles& triangles) {
  std::vector<Triangle> result;
  for (std::size_t k = 0; k < vertices.size(); ++k)
    if (!vertices[k].allFinite()) throw InvalidArgument("mesh: vertex " + std::to_string(k) + " is not finite");
  for (const auto& t : triangles) {
    for (int i : t)
      if (i < 0 || i >= static_cast<int>(vertices.size()))
        throw InvalidArgument("mesh: a triangle names vertex " + std::to_string(i) + ", there are " +
                              std::to_string(vertices.size()));
    result.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
  }
  if (result.empty()) throw InvalidArgument("mesh: there are no triangles to cover");
  return result;
}

/// Does every edge belong to an even number of triangles, equal vertices taken as one?
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

/// Is the mesh its own convex hull, but for rounding? Looks how deep its surface lies under the hull's planes.
bool is_nearly_convex(const Impl& mesh, const CoverSolid::Vertices& vertices) {
  if (!mesh.closed || mesh.triangles.size() > 4000) return false;
  const double size = mesh.box.diagonal().norm();
  for (const Triangle& t : mesh.triangles) {  // the cheap no
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
  Impl hull;
  hull.triangles = mesh.triangles;
  hull.box = mesh.box;
  set_planes(hull, vertices);
  bool near = true;
  for (const Triangle& t : mesh.triangles)
    split_triangle(t, size / 40, [&](const Triangle& piece) {
      if (near) near = hull.depth((piece[0] + piece[1] + piece[2]) / 3) <= 1.5e-3 * size;
    });
  return near;
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

/// Planes that touch the curved solid: `sides` around (unit normals tilted by `slope` = dr/dz) and the two caps.
void set_planes_around(Impl& impl, double normal_r, double normal_z, double side_offset, double low, double high) {
  impl.normals.resize(kFacets + 2, 3);
  impl.offsets.resize(kFacets + 2);
  for (int k = 0; k < kFacets; ++k) {
    const double angle = 2 * std::numbers::pi * k / kFacets;
    impl.normals.row(k) << normal_r * std::cos(angle), normal_r * std::sin(angle), normal_z;
    impl.offsets[k] = side_offset;
  }
  impl.normals.row(kFacets) << 0, 0, 1;
  impl.normals.row(kFacets + 1) << 0, 0, -1;
  impl.offsets[kFacets] = high;
  impl.offsets[kFacets + 1] = -low;
  impl.inner_offsets = impl.offsets;
  impl.convex = true;
  set_corners(impl);
}

}  // namespace

CoverSolid CoverSolid::sphere(double radius) {
  require_positive(radius, "sphere radius");
  auto impl = std::make_shared<Impl>();
  impl->kind = Impl::Kind::sphere;
  impl->radius = radius;
  impl->convex = true;
  impl->curved_depth = [radius](const Vector3d& p) { return radius - p.norm(); };
  impl->box = Eigen::AlignedBox3d(Vector3d::Constant(-radius), Vector3d::Constant(radius));
  return CoverSolid(impl);
}

CoverSolid CoverSolid::capsule(double radius, double length) {
  require_positive(radius, "capsule radius");
  require_positive(length, "capsule length");
  auto impl = std::make_shared<Impl>();
  impl->kind = Impl::Kind::capsule;
  impl->radius = radius;
  impl->length = length;
  impl->convex = true;
  impl->curved_depth = [radius, half = length / 2](const Vector3d& p) {
    return radius - (p - Vector3d(0, 0, std::clamp(p.z(), -half, half))).norm();
  };
  const Vector3d corner(radius, radius, length / 2 + radius);
  impl->box = Eigen::AlignedBox3d(-corner, corner);
  return CoverSolid(impl);
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
  auto impl = std::make_shared<Impl>();
  const double half = length / 2;
  impl->triangles = revolve({{radius, -half}, {radius, half}});
  impl->curved_depth = [radius, half](const Vector3d& p) {
    return std::min(radius - p.head<2>().norm(), half - std::abs(p.z()));
  };
  set_planes_around(*impl, 1, 0, radius, -half, half);
  return CoverSolid(impl);
}

CoverSolid CoverSolid::cone(double radius, double length) {
  require_positive(radius, "cone radius");
  require_positive(length, "cone length");
  auto impl = std::make_shared<Impl>();
  const double half = length / 2, slant = std::hypot(radius, length);
  const double nr = length / slant, nz = radius / slant, offset = nz * half;
  impl->triangles = revolve({{radius, -half}, {0, half}});
  impl->curved_depth = [=](const Vector3d& p) {
    return std::min(offset - (nr * p.head<2>().norm() + nz * p.z()), p.z() + half);
  };
  set_planes_around(*impl, nr, nz, offset, -half, half);
  return CoverSolid(impl);
}

CoverSolid CoverSolid::convex(const Vertices& vertices, const Triangles& triangles) {
  auto impl = std::make_shared<Impl>();
  impl->triangles = gather(vertices, triangles);
  impl->vertices = vertices;
  set_corners(*impl);
  set_planes(*impl, vertices);
  return CoverSolid(impl);
}

CoverSolid CoverSolid::mesh(const Vertices& vertices, const Triangles& triangles, double closing) {
  auto impl = std::make_shared<Impl>();
  impl->triangles = gather(vertices, triangles);
  set_corners(*impl);
  impl->closed = every_edge_is_shared(impl->triangles);
  if (is_nearly_convex(*impl, vertices)) {
    set_planes(*impl, vertices);
    return CoverSolid(impl);
  }
  impl->all = TriangleTree(impl->triangles);
  const double voxel = std::max(impl->box.sizes().maxCoeff() / 128, 2.5e-4);
  impl->enclosed = EnclosedSpace(impl->triangles, voxel);
  impl->filled = closing > voxel ? EnclosedSpace(impl->triangles, voxel, closing) : impl->enclosed;
  std::vector<Triangle> outer = impl->filled.plugs();
  for (const Triangle& t : impl->triangles) {
    bool reachable = false;
    split_triangle(t, voxel, [&](const Triangle& piece) {
      if (!reachable) reachable = impl->filled.reachable_near(piece);
    });
    if (reachable) outer.push_back(t);
  }
  impl->outer = TriangleTree(outer);
  return CoverSolid(impl);
}

bool CoverSolid::is_convex() const { return impl_->convex; }

bool CoverSolid::is_closed() const { return impl_->convex || impl_->closed; }

double CoverSolid::depth(const Vector3d& point) const { return impl_->depth(point); }

PlacedSphere CoverSolid::bounding_sphere() const {
  const Impl& impl = *impl_;
  if (impl.kind == Impl::Kind::sphere) return {Vector3d::Zero(), impl.radius};
  if (impl.kind == Impl::Kind::capsule) return {Vector3d::Zero(), impl.radius + impl.length / 2};
  // Badoiu and Clarkson 2003: step towards the farthest point, ever less.
  PlacedSphere sphere{impl.box.center(), 0};
  const auto farthest = [&](const Vector3d& c) {
    Vector3d far = c;
    for (const Vector3d& v : impl.vertices)
      if ((v - c).squaredNorm() > (far - c).squaredNorm()) far = v;
    return far;
  };
  for (int i = 1; i <= 60; ++i) sphere.center += (farthest(sphere.center) - sphere.center) / (i + 1);
  if (impl.curved_depth) sphere.center.head<2>().setZero();  // by symmetry; then the ring of vertices tells the radius
  sphere.radius = (farthest(sphere.center) - sphere.center).norm() * (1 + 1e-12);
  return sphere;
}

}  // namespace srmp
