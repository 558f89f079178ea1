#include "srmp/cover/enclosed_space.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "srmp/core/interruption.hpp"

namespace srmp {

using Eigen::Vector3d;

EnclosedSpace::EnclosedSpace(const std::vector<Triangle>& triangles, double voxel, double closing) : voxel_(voxel) {
  Eigen::AlignedBox3d box;
  for (const Triangle& t : triangles)
    for (const Vector3d& v : t) box.extend(v);
  const int margin = 2 + static_cast<int>(std::ceil(closing / voxel));
  origin_ = box.min() - Vector3d::Constant(margin * voxel);
  size_ = ((box.sizes().array() / voxel).ceil().cast<int>() + 2 * margin + 1).eval();
  state_.assign(static_cast<std::size_t>(size_.prod()), unknown);
  mark_surface(triangles);
  if (closing <= voxel)
    flood(std::vector<char>(state_.size(), 0));
  else
    roll_sphere(closing);
}

void EnclosedSpace::mark_surface(const std::vector<Triangle>& triangles) {
  for (const Triangle& triangle : triangles) {
    split_triangle(triangle, voxel_, [&](const Triangle& t) {
      interruption_point();
      const Eigen::Array3i low = index(t[0].cwiseMin(t[1]).cwiseMin(t[2]));
      const Eigen::Array3i high = index(t[0].cwiseMax(t[1]).cwiseMax(t[2]));
      for (int z = low[2]; z <= high[2]; ++z)
        for (int y = low[1]; y <= high[1]; ++y)
          for (int x = low[0]; x <= high[0]; ++x) state_[flat({x, y, z})] = surface;
    });
  }
}

/// Reaches what a sphere of radius `closing` reaches from outside. First its centre moves where no wall is nearer than
/// the radius; then everything within the radius and two voxels of a centre is reachable, so that voxels beside walls
/// are. The number of steps of the second flood is bounded, so that it does not pass through a hole and along the other
/// side of the wall.
void EnclosedSpace::roll_sphere(double closing) {
  const auto squared = [this](double radius) { return static_cast<float>(radius * radius / (voxel_ * voxel_)); };
  const std::vector<float> from_walls = squared_distance([&](std::size_t i) { return state_[i] == surface; });
  std::vector<char> barred(state_.size());
  for (std::size_t i = 0; i < barred.size(); ++i) barred[i] = from_walls[i] <= squared(closing);
  flood(barred);
  const std::vector<float> from_centers = squared_distance([&](std::size_t i) { return state_[i] == outside; });
  for (std::size_t i = 0; i < state_.size(); ++i) barred[i] = from_centers[i] > squared(closing + 2 * voxel_);
  std::vector<std::size_t> frontier;
  for (std::size_t i = 0; i < state_.size(); ++i)
    if (state_[i] == outside) frontier.push_back(i);
  spread(std::move(frontier), barred, static_cast<int>(std::ceil(std::sqrt(3.0) * (closing / voxel_ + 1))));
}

void EnclosedSpace::flood(const std::vector<char>& barred) {
  state_[0] = outside;
  spread({0}, barred, std::numeric_limits<int>::max());
}

/// Makes unknown voxels that are not barred and at most `steps` face-to-face steps from the frontier outside.
void EnclosedSpace::spread(std::vector<std::size_t> frontier, const std::vector<char>& barred, int steps) {
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(size_[0]),
                                          static_cast<std::size_t>(size_[0]) * size_[1]};
  std::vector<std::size_t> next;
  for (int step = 0; step < steps && !frontier.empty(); ++step) {
    rare_interruption_point();
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

/// Squared distance [voxels^2] between each voxel's centre and the nearest centre of a voxel that is `in`, exactly:
/// along each axis, the lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012).
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
        interruption_point();
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

}  // namespace srmp
