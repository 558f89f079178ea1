#include "srmp/heuristic/task_space_bfs.hpp"

#include <coal/collision.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "srmp/core/error.hpp"
#include "srmp/geometry/distance_field.hpp"

namespace srmp {

namespace {

constexpr float unreached = std::numeric_limits<float>::infinity();
constexpr float occupied_cell = -1.0f;
constexpr std::size_t max_cells = 50'000'000;
constexpr int cells_per_deadline_check = 8;  // a test by Coal may take most of a millisecond

coal::Transform3s to_coal(const Pose& pose) { return {pose.q.toRotationMatrix(), pose.p}; }

/// Fills a grid in blocks, since a large one takes long; false when the deadline has passed.
template <class T>
bool fill(std::vector<T>& cells, std::size_t count, T value, const Deadline& deadline) {
  constexpr std::size_t block = 1 << 18;
  cells.reserve(count);
  while (cells.size() < count) {
    if (deadline.stop_requested()) return false;
    cells.resize(std::min(count, cells.size() + block), value);
  }
  return true;
}

/// From a solid shape to a point in its frame; nothing for shapes without a formula.
std::optional<double> distance(const Shape& shape, const Eigen::Vector3d& p) {
  const auto outside = [](double d) { return std::max(d, 0.0); };
  const double across = std::hypot(p.x(), p.y()), along = std::abs(p.z());
  if (const auto* box = std::get_if<Box>(&shape)) return (p.cwiseAbs() - box->size / 2).cwiseMax(0.0).norm();
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return outside(p.norm() - sphere->radius);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape))
    return std::hypot(outside(across - cylinder->radius), outside(along - cylinder->length / 2));
  if (const auto* capsule = std::get_if<Capsule>(&shape))
    return outside(std::hypot(across, outside(along - capsule->length / 2)) - capsule->radius);
  return std::nullopt;
}

/// Does a sphere collide with an object? By a formula, else by the object's distance field, and by Coal where its
/// bounds leave it open.
class SphereTest {
 public:
  SphereTest(const Object& object, double radius)
      : object_(object),
        radius_(radius),
        to_object_(object.pose.inverse()),
        sphere_(radius),
        pose_(to_coal(object.pose)),
        collide_(&sphere_, object.geometry.get()) {}

  bool operator()(const Eigen::Vector3d& center) const {
    const Eigen::Vector3d local = to_object_ * center;
    if (const auto d = distance(object_.shape, local)) return *d <= radius_;
    if (object_.field) {
      const DistanceField::Bounds bounds = object_.field->distance(local);
      if (bounds.low > radius_ + rounding) return false;
      if (bounds.high < radius_ - rounding) return true;
    }
    coal::CollisionResult result;
    return collide_(coal::Transform3s(center), pose_, coal::CollisionRequest(coal::NO_REQUEST, 1), result) > 0;
  }

 private:
  static constexpr double rounding = 1e-5;  // [m], of the field's and Coal's numbers

  const Object& object_;
  double radius_;
  Pose to_object_;
  coal::Sphere sphere_;
  coal::Transform3s pose_;
  coal::ComputeCollision collide_;
};

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
  if (cells > static_cast<double>(max_cells))
    throw InvalidArgument("bfs_resolution " + to_text(resolution_) +
                          " m makes a grid of more than 50 million cells; use a larger one");
  if (!fill(distance_, index(size_) + 1, unreached, deadline)) {
    distance_.clear();
    return;
  }
  add_border();
  for (const auto& [name, object] : scene.objects())
    if (!scene.attachments().contains(name)) mark(object, std::max(options.radius, 1e-6), deadline);
  flood(goals, deadline);
}

/// Of cells from -1 to size, the border included.
std::size_t TaskSpaceBfs::index(const Cell& c) const {
  return static_cast<std::size_t>(
      ((c[2] + 1) * (size_[1] + std::ptrdiff_t{2}) + c[1] + 1) * (size_[0] + std::ptrdiff_t{2}) + c[0] + 1);
}

void TaskSpaceBfs::add_border() {
  for (int z = -1; z <= size_[2]; ++z)
    for (int y = -1; y <= size_[1]; ++y) {
      const bool outside = z < 0 || z == size_[2] || y < 0 || y == size_[1];
      if (outside)
        std::fill_n(distance_.begin() + static_cast<std::ptrdiff_t>(index({-1, y, z})), size_[0] + 2, occupied_cell);
      distance_[index({-1, y, z})] = distance_[index({size_[0], y, z})] = occupied_cell;
    }
}

TaskSpaceBfs::Cell TaskSpaceBfs::cell_of(const Eigen::Vector3d& point) const {
  Cell cell;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    cell[i] = std::clamp(static_cast<int>(std::floor((point[k] - low_[k]) / resolution_)), 0, size_[i] - 1);
  }
  return cell;
}

void TaskSpaceBfs::mark(const Object& object, double radius, const Deadline& deadline) {
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
  const Cell from = cell_of((low.array() - radius - resolution_).matrix()),
             to = cell_of((high.array() + radius + resolution_).matrix());
  const SphereTest hits(object, radius);
  Cell c;
  for (c[2] = from[2]; c[2] <= to[2]; ++c[2])
    for (c[1] = from[1]; c[1] <= to[1]; ++c[1])
      for (c[0] = from[0]; c[0] <= to[0]; ++c[0]) {
        if ((c[0] - from[0]) % cells_per_deadline_check == 0 && deadline.stop_requested()) return;
        float& cell = distance_[index(c)];
        if (cell != occupied_cell && hits(low_ + resolution_ * Eigen::Vector3d(c[0] + 0.5, c[1] + 0.5, c[2] + 0.5)))
          cell = occupied_cell;
      }
}

/// Dijkstra's algorithm with one bucket for each `resolution` of distance (Denardo, Fox 1979): no step is shorter, so
/// distances in the lowest bucket are final and need no order.
void TaskSpaceBfs::flood(std::span<const Eigen::Vector3d> goals, const Deadline& deadline) {
  struct Step {
    std::ptrdiff_t offset;
    float length;
  };
  std::vector<Step> steps;
  const auto middle = static_cast<std::ptrdiff_t>(index({0, 0, 0}));
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        if (x || y || z)
          steps.push_back({static_cast<std::ptrdiff_t>(index({x, y, z})) - middle,
                           static_cast<float>(resolution_ * std::sqrt(double(x * x + y * y + z * z)))});
  using Entry = std::pair<float, std::ptrdiff_t>;
  std::array<std::vector<Entry>, 4> buckets;  // at most three are in use: no step is two resolutions long
  const auto reach = [&](std::ptrdiff_t cell, float d) {
    distance_[static_cast<std::size_t>(cell)] = d;
    buckets[static_cast<std::size_t>(d / static_cast<float>(resolution_)) % buckets.size()].emplace_back(d, cell);
  };
  for (const Eigen::Vector3d& goal : goals) reach(static_cast<std::ptrdiff_t>(index(cell_of(goal))), 0.0f);
  std::size_t polled = 0, empty = 0;
  for (std::size_t lowest = 0; empty < buckets.size(); ++lowest) {
    std::vector<Entry>& bucket = buckets[lowest % buckets.size()];
    empty = bucket.empty() ? empty + 1 : 0;
    while (!bucket.empty()) {
      if (polled++ % 1024 == 0 && deadline.stop_requested()) return;
      const auto [d, cell] = bucket.back();
      bucket.pop_back();
      if (d > distance_[static_cast<std::size_t>(cell)]) continue;
      for (const Step& step : steps)
        if (d + step.length < distance_[static_cast<std::size_t>(cell + step.offset)])
          reach(cell + step.offset, d + step.length);
    }
  }
}

bool TaskSpaceBfs::occupied(const Eigen::Vector3d& point) const {
  return !distance_.empty() && distance_[index(cell_of(point))] < 0.0f;
}

double TaskSpaceBfs::distance(const Eigen::Vector3d& point) const {
  if (distance_.empty()) return 0.0;
  const Cell c = cell_of(point);
  const float here = distance_[index(c)];
  if (here >= 0.0f && here < unreached) return here;
  float least = unreached;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        if (const float next = distance_[index({c[0] + x, c[1] + y, c[2] + z})]; next >= 0.0f)
          least = std::min(least, next + static_cast<float>(2 * resolution_));
  return least;
}

}  // namespace srmp
