#include "srmp/heuristic/task_space_bfs.hpp"

#include <coal/collision.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

constexpr float unreached = std::numeric_limits<float>::infinity();
constexpr std::size_t most_cells = 50'000'000;

coal::Transform3s to_coal(const Pose& pose) { return {pose.q.toRotationMatrix(), pose.p}; }

/// Fills a grid piece by piece, since a large one takes long; false when time was up.
template <class T>
bool fill(std::vector<T>& cells, std::size_t count, T value, const Deadline& deadline) {
  constexpr std::size_t piece = 1 << 18;
  cells.reserve(count);
  while (cells.size() < count) {
    if (deadline.stop_requested()) return false;
    cells.resize(std::min(count, cells.size() + piece), value);
  }
  return true;
}

}  // namespace

TaskSpaceBfs::TaskSpaceBfs(const Scene& scene, const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                           std::span<const Eigen::Vector3d> goals, const Options& options, const Deadline& deadline)
    : resolution_(options.resolution), low_(low) {
  require_positive(options.resolution, "bfs_resolution");
  Eigen::Vector3d top = high;
  for (const Eigen::Vector3d& goal : goals) {
    low_ = low_.cwiseMin((goal.array() - 2 * resolution_).matrix());
    top = top.cwiseMax((goal.array() + 2 * resolution_).matrix());
  }
  double cells = 1.0;
  for (int i = 0; i < 3; ++i) {
    const double n = std::ceil((top[i] - low_[i]) / resolution_);
    cells *= std::max(1.0, n);
    size_[static_cast<std::size_t>(i)] = std::max(1, static_cast<int>(std::min(n, 1e6)));
  }
  if (cells > static_cast<double>(most_cells))
    throw InvalidArgument("bfs_resolution " + to_text(resolution_) +
                          " m makes a grid of more than 50 million cells; use a larger one");
  const auto count = static_cast<std::size_t>(cells);
  if (!fill<std::uint8_t>(occupied_, count, 0, deadline)) return;
  mark_obstacles(scene, options.radius, deadline);
  if (fill(distance_, count, unreached, deadline))
    flood(goals, deadline);
  else
    distance_.clear();
}

std::size_t TaskSpaceBfs::index(const Cell& c) const {
  return static_cast<std::size_t>((c[2] * static_cast<std::ptrdiff_t>(size_[1]) + c[1]) * size_[0] + c[0]);
}

TaskSpaceBfs::Cell TaskSpaceBfs::cell_of(const Eigen::Vector3d& point) const {
  Cell cell;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    cell[i] = std::clamp(static_cast<int>(std::floor((point[k] - low_[k]) / resolution_)), 0, size_[i] - 1);
  }
  return cell;
}

void TaskSpaceBfs::mark_obstacles(const Scene& scene, double radius, const Deadline& deadline) {
  const double reach = std::max(radius, 1e-6);
  const coal::Sphere ball(reach);
  coal::CollisionRequest request(coal::NO_REQUEST, 1);
  for (const auto& [name, object] : scene.objects()) {
    if (scene.attachments().contains(name)) continue;
    const coal::Transform3s object_pose = to_coal(object.pose);
    coal::ComputeCollision collide(&ball, object.geometry.get());
    // The object's box in the world, from the corners of its local box.
    Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    const coal::AABB& box = object.geometry->aabb_local;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d local((corner & 1) ? box.max_[0] : box.min_[0], (corner & 2) ? box.max_[1] : box.min_[1],
                                  (corner & 4) ? box.max_[2] : box.min_[2]);
      const Eigen::Vector3d world = object.pose * local;
      low = low.cwiseMin(world);
      high = high.cwiseMax(world);
    }
    const Cell from = cell_of((low.array() - reach - resolution_).matrix()),
               to = cell_of((high.array() + reach + resolution_).matrix());
    Cell c;
    for (c[2] = from[2]; c[2] <= to[2]; ++c[2])
      for (c[1] = from[1]; c[1] <= to[1]; ++c[1]) {
        if (deadline.stop_requested()) return;
        for (c[0] = from[0]; c[0] <= to[0]; ++c[0]) {
          if (occupied_[index(c)]) continue;
          const Eigen::Vector3d center = low_ + resolution_ * Eigen::Vector3d(c[0] + 0.5, c[1] + 0.5, c[2] + 0.5);
          coal::CollisionResult result;
          collide(coal::Transform3s(center), object_pose, request, result);
          if (result.isCollision()) occupied_[index(c)] = 1;
        }
      }
  }
}

void TaskSpaceBfs::flood(std::span<const Eigen::Vector3d> goals, const Deadline& deadline) {
  using Entry = std::pair<float, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (const Eigen::Vector3d& goal : goals) {
    const std::size_t i = index(cell_of(goal));
    distance_[i] = 0.0f;
    open.emplace(0.0f, i);
  }
  for (std::size_t steps = 0; !open.empty(); ++steps) {
    if (steps % 1024 == 0 && deadline.stop_requested()) return;
    const auto [d, i] = open.top();
    open.pop();
    if (d > distance_[i]) continue;
    const Cell c{static_cast<int>(i % static_cast<std::size_t>(size_[0])),
                 static_cast<int>(i / static_cast<std::size_t>(size_[0]) % static_cast<std::size_t>(size_[1])),
                 static_cast<int>(i / static_cast<std::size_t>(size_[0]) / static_cast<std::size_t>(size_[1]))};
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const Cell n{c[0] + dx, c[1] + dy, c[2] + dz};
          if (n[0] < 0 || n[1] < 0 || n[2] < 0 || n[0] >= size_[0] || n[1] >= size_[1] || n[2] >= size_[2]) continue;
          const std::size_t j = index(n);
          if (occupied_[j]) continue;
          const float candidate = d + static_cast<float>(resolution_ * std::sqrt(double(dx * dx + dy * dy + dz * dz)));
          if (candidate < distance_[j]) {
            distance_[j] = candidate;
            open.emplace(candidate, j);
          }
        }
  }
}

double TaskSpaceBfs::distance(const Eigen::Vector3d& point) const {
  if (distance_.empty()) return 0.0;
  const Cell c = cell_of(point);
  float least = distance_[index(c)];
  if (least < unreached) return least;
  for (int dz = -1; dz <= 1; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const Cell n{c[0] + dx, c[1] + dy, c[2] + dz};
        if (n[0] < 0 || n[1] < 0 || n[2] < 0 || n[0] >= size_[0] || n[1] >= size_[1] || n[2] >= size_[2]) continue;
        least = std::min(least, distance_[index(n)] + static_cast<float>(2 * resolution_));
      }
  return least;
}

}  // namespace srmp
