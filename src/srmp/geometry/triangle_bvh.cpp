#include "srmp/geometry/triangle_bvh.hpp"

#include <algorithm>
#include <cmath>

namespace srmp {

namespace {

using Eigen::Vector3d;

constexpr int kLeafTriangles = 4;

/// The nearest point of a triangle: Ericson, Real-Time Collision Detection, 5.1.5.
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

/// Moeller and Trumbore 1997.
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

bool ray_hits(const Eigen::AlignedBox3d& box, const Vector3d& origin, const Vector3d& direction) {
  double near = 0.0, far = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {  // the caller's directions have no zero component
    const double a = (box.min()[k] - origin[k]) / direction[k], b = (box.max()[k] - origin[k]) / direction[k];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far * (1 + 1e-12);
}

}  // namespace

TriangleBvh::TriangleBvh(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  if (!triangles_.empty()) build(0, static_cast<int>(triangles_.size()));
}

int TriangleBvh::build(int begin, int end) {
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

TriangleBvh::Nearest TriangleBvh::nearest(const Vector3d& point, double limit) const {
  Nearest best;
  if (triangles_.empty()) return best;
  double min_squared = limit * limit;
  std::array<std::pair<int, double>, 96> stack;
  int top = 0;
  stack[top++] = {0, nodes_[0].box.squaredExteriorDistance(point)};
  while (top > 0) {
    const auto [id, distance] = stack[--top];
    if (distance > min_squared) continue;
    const Node& node = nodes_[id];
    if (node.left < 0) {
      for (int i = node.begin; i < node.end; ++i) {
        const Vector3d q = nearest_on_triangle(triangles_[i], point);
        const double d = (q - point).squaredNorm();
        if (d < min_squared || (d == min_squared && best.distance == std::numeric_limits<double>::infinity())) {
          min_squared = d;
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

int TriangleBvh::crossings(const Vector3d& point, const Vector3d& direction) const {
  if (triangles_.empty()) return 0;
  int count = 0, top = 0;
  std::array<int, 96> stack;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (!ray_hits(node.box, point, direction)) continue;
    if (node.left < 0) {
      for (int i = node.begin; i < node.end; ++i) count += ray_crosses(triangles_[i], point, direction);
      continue;
    }
    stack[top++] = node.right;
    stack[top++] = node.left;
  }
  return count;
}

void split_triangle(const Triangle& t, double edge, const std::function<void(const Triangle&)>& emit) {
  const std::array<double, 3> length{(t[1] - t[0]).norm(), (t[2] - t[1]).norm(), (t[0] - t[2]).norm()};
  const int k = static_cast<int>(std::max_element(length.begin(), length.end()) - length.begin());
  if (length[k] <= edge) return emit(t);
  const Vector3d &a = t[k], &b = t[(k + 1) % 3], &c = t[(k + 2) % 3];
  const Vector3d middle = 0.5 * (a + b);
  split_triangle({a, middle, c}, edge, emit);
  split_triangle({middle, b, c}, edge, emit);
}

}  // namespace srmp
