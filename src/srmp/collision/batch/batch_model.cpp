#include "srmp/collision/batch/batch_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "srmp/collision/batch/batch_numbers.hpp"
#include "srmp/core/error.hpp"
#include "srmp/geometry/distance_field.hpp"

namespace srmp {

using batch::above;
using batch::below;
using batch::Part;
using batch::require;
using batch::require_index;
using batch::unit;

namespace {

constexpr std::size_t max_pairs = 4'000'000;

batch::KernelFunction kernel_of([[maybe_unused]] SimdBackend backend) {
#if defined(__x86_64__) && !defined(SRMP_PORTABLE_ONLY)
  if (backend == SimdBackend::avx512) return batch::run_avx512;
  if (backend == SimdBackend::avx2) return batch::run_avx2;
#endif
  return batch::run_portable;
}

batch::KernelField kernel_field(const DistanceField& field) {
  const auto& n = field.size();
  return {field.squared().data(),
          static_cast<float>(n[0]),
          static_cast<float>(n[0]) * static_cast<float>(n[1]),
          {static_cast<float>(n[0] - 1), static_cast<float>(n[1] - 1), static_cast<float>(n[2] - 1)},
          static_cast<float>(field.cell()),
          static_cast<float>(1 / field.cell()),
          above(field.error_bound()),
          below(0.99 * field.reach())};
}

double extent(const BatchObstacle& o) {
  switch (o.kind) {
    case BatchObstacle::Kind::sphere: return o.size[0];
    case BatchObstacle::Kind::box:
    case BatchObstacle::Kind::field: return o.size.norm() / 2;
    case BatchObstacle::Kind::cylinder: return std::hypot(o.size[0], o.size[1] / 2);
    case BatchObstacle::Kind::capsule: return o.size[0] + o.size[1] / 2;
  }
  return 0;
}

/// A lower bound of the diameter of a connected obstacle, padding left out; hardly more than 0 for others.
double diameter(const BatchObstacle& o) {
  if (!o.connected) return 1e-9;
  switch (o.kind) {
    case BatchObstacle::Kind::field: return o.size.maxCoeff();
    case BatchObstacle::Kind::sphere: return 2 * o.size[0];
    case BatchObstacle::Kind::box: return o.size.norm();
    case BatchObstacle::Kind::cylinder: return std::hypot(2 * o.size[0], o.size[1]);
    case BatchObstacle::Kind::capsule: return 2 * o.size[0] + o.size[1];
  }
  return 0;
}

void require_valid_obstacle(const BatchObstacle& o, const Part& part) {
  require(o.size.allFinite() && (o.size.array() >= 0).all() && o.pose.matrix().allFinite() &&
              std::isfinite(o.padding) && o.padding >= 0 && o.field_center.allFinite(),
          part, ": size, pose and padding must be finite and not negative");
  require((o.kind == BatchObstacle::Kind::field) == (o.field != nullptr), part,
          ": a field is needed where, and only where, the kind says so");
}

}  // namespace

BatchModel::BatchModel(std::shared_ptr<const BatchRobotModel> batch_robot, const BatchPairs& pairs, SimdBackend simd)
    : robot(std::move(batch_robot)), backend(simd), bodies(robot->bodies) {
  if (!is_available(backend)) throw InvalidArgument("batch checker: this CPU does not have " + to_string(backend));
  kernel = kernel_of(backend);
  require_valid(pairs);
  make_room(pairs);
  for (const BatchObstacle& obstacle : pairs.obstacles) add_obstacle(obstacle);
  add_all_pairs(pairs);
}

BatchModel::BatchModel(const BatchModel& before, const BatchPairs& pairs, std::span<const int> known)
    : robot(before.robot), backend(before.backend), kernel(before.kernel), bodies(robot->bodies) {
  make_room(pairs);
  for (std::size_t i = 0; i < pairs.obstacles.size(); ++i) {
    if (known[i] < 0) {
      require_valid_obstacle(pairs.obstacles[i], {"obstacle", i});
      add_obstacle(pairs.obstacles[i]);
      continue;
    }
    const auto number = static_cast<std::size_t>(known[i]);
    obstacles.push_back(before.obstacles[number]);
    nearest_.push_back(before.nearest_[number]);
    boxes_.push_back(before.boxes_[number]);
  }
  add_all_pairs(pairs);
}

void BatchModel::make_room(const BatchPairs& pairs) {
  obstacles.reserve(pairs.obstacles.size());
  nearest_.reserve(pairs.obstacles.size());
  boxes_.reserve(pairs.obstacles.size());
  self_pairs.reserve(pairs.self_pairs.size());
}

void BatchModel::add_all_pairs(const BatchPairs& pairs) {
  if (pairs.obstacle_pairs.size() + pairs.self_pairs.size() > max_pairs)
    throw InvalidArgument("batch checker: there are more than 4 million pairs");
  add_pairs(pairs);
  for (const BatchSelfPair& pair : pairs.self_pairs) add_self_pair(pair);
  if (pairs.deferred.empty()) return;
  not_deferred.assign(pair_obstacles.size() + self_pairs.size(), 1);
  for (const int pair : pairs.deferred) not_deferred[pair_obstacles.size() + static_cast<std::size_t>(pair)] = 0;
}

void BatchModel::require_valid(const BatchPairs& pairs) const {
  for (std::size_t i = 0; i < pairs.obstacles.size(); ++i) require_valid_obstacle(pairs.obstacles[i], {"obstacle", i});
  for (std::size_t i = 0; i < pairs.obstacle_pairs.size(); ++i) {
    const Part part{"pair", i};
    require_index(pairs.obstacle_pairs[i].first, bodies.size(), part, "body");
    require_index(pairs.obstacle_pairs[i].second, pairs.obstacles.size(), part, "obstacle");
  }
  for (std::size_t i = 0; i < pairs.self_pairs.size(); ++i) {
    const Part part{"self pair", i};
    require_index(pairs.self_pairs[i].a, bodies.size(), part, "first body");
    require_index(pairs.self_pairs[i].b, bodies.size(), part, "second body");
  }
  for (std::size_t i = 0; i < pairs.deferred.size(); ++i)
    require_index(pairs.deferred[i], pairs.self_pairs.size(), {"deferred pair", i}, "self pair");
}

void BatchModel::add_obstacle(const BatchObstacle& o) {
  batch::KernelObstacle kernel{};
  const Eigen::Isometry3d inverse = o.pose.inverse();
  batch::copy_rotation(inverse.linear(), kernel.rotation);
  kernel.aligned = inverse.linear().isIdentity(0.0);
  kernel.exact = o.exact;
  kernel.size = below(diameter(o));
  for (int i = 0; i < 3; ++i) kernel.offset[i] = static_cast<float>(inverse.translation()[i]);
  double rounding = 0;
  switch (o.kind) {
    case BatchObstacle::Kind::sphere: rounding = o.size[0]; break;
    case BatchObstacle::Kind::box:
      for (int i = 0; i < 3; ++i) kernel.half[i] = static_cast<float>(o.size[i] / 2);
      break;
    case BatchObstacle::Kind::cylinder:
      kernel.cylinder = 1;
      kernel.half[0] = static_cast<float>(o.size[0]);
      kernel.half[2] = static_cast<float>(o.size[1] / 2);
      break;
    case BatchObstacle::Kind::capsule:
      kernel.half[2] = static_cast<float>(o.size[1] / 2);
      rounding = o.size[0];
      break;
    case BatchObstacle::Kind::field:
      kernel.field = kernel_field(*o.field);
      for (int i = 0; i < 3; ++i)
        kernel.offset[i] = static_cast<float>(inverse.translation()[i] + o.field_center[i] - o.field->corner()[i]);
      break;
  }
  // Local coordinates err by some units of everything that went into them, comparisons by some of the threshold.
  const double here =
      robot->error_bound + 24 * unit * (robot->reach + o.pose.translation().norm() + extent(o) + o.padding + 1.0);
  kernel.radius = above(rounding + o.padding + here);
  kernel.inner_radius = below(rounding + o.padding - here);
  obstacles.push_back(kernel);
  add_box(o, kernel.radius + here + 1e-4);

  const Eigen::Vector3d p = inverse.translation();  // the base in the obstacle's frame
  double distance = p.norm() - extent(o);
  if (o.kind == BatchObstacle::Kind::box || o.kind == BatchObstacle::Kind::field)
    distance = (p.cwiseAbs() - o.size / 2).cwiseMax(0.0).norm();
  nearest_.push_back(distance - o.padding);
}

/// The box around the last obstacle (of a field: its grid) and the margin, which is larger than the kernel's errors.
void BatchModel::add_box(const BatchObstacle& o, double margin) {
  const batch::KernelObstacle& kernel = obstacles.back();
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Vector3d half(kernel.half[0], kernel.cylinder ? kernel.half[0] : kernel.half[1], kernel.half[2]);
  if (o.field) {
    for (int i = 0; i < 3; ++i) half[i] = o.field->cell() * (o.field->size()[i] - 1) / 2;
    center = o.field->corner() + half - o.field_center;
  }
  center = o.pose * center;
  half = o.pose.linear().cwiseAbs() * half;
  Box box;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    box[i] = below(center[axis] - half[axis] - margin);
    box[i + 3] = above(center[axis] + half[axis] + margin);
  }
  boxes_.push_back(box);
}

/// Starts a new block with boxes that nothing is near to where the last one is full.
void BatchModel::add_pair_box(std::size_t in_body, const Box& box) {
  const std::size_t lane = in_body % batch::kLanes;
  if (lane == 0) pair_boxes.resize(pair_boxes.size() + 6 * batch::kLanes, std::numeric_limits<float>::infinity());
  float* block = pair_boxes.data() + pair_boxes.size() - 6 * batch::kLanes;
  for (std::size_t i = 0; i < 6; ++i) block[i * batch::kLanes + lane] = box[i];
}

/// Sorted; without those of obstacles that the body cannot reach.
void BatchModel::add_pairs(const BatchPairs& pairs) {
  const std::vector<std::pair<int, int>>& all = pairs.obstacle_pairs;
  std::vector<int> order(all.size());
  std::iota(order.begin(), order.end(), 0);
  if (!std::is_sorted(all.begin(), all.end()))
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return all[a] < all[b]; });
  pair_obstacles.reserve(all.size());
  pair_ids.reserve(all.size());
  auto next = order.begin();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double reach = robot->body_reach[i] * 1.0001 + 1e-3;
    bodies[i].first_pair = static_cast<int>(pair_obstacles.size());
    bodies[i].first_box = static_cast<int>(pair_boxes.size());
    for (; next != order.end() && all[*next].first == static_cast<int>(i); ++next) {
      const int obstacle = all[*next].second;
      if (nearest_[obstacle] > reach) continue;
      add_pair_box(pair_obstacles.size() - static_cast<std::size_t>(bodies[i].first_pair), boxes_[obstacle]);
      pair_obstacles.push_back(obstacle);
      pair_ids.push_back(*next);
    }
    bodies[i].pairs = static_cast<int>(pair_obstacles.size()) - bodies[i].first_pair;
  }
}

void BatchModel::add_self_pair(const BatchSelfPair& pair) {
  // Steps to the last common node, parents having lower numbers: only what is beyond moves one against the other.
  int a = bodies[pair.a].node, b = bodies[pair.b].node, up_a = 0, up_b = 0;
  while (a != b) {
    const bool from_a = a > b;
    int& node = from_a ? a : b;
    node = robot->nodes[node].parent;
    ++(from_a ? up_a : up_b);
  }
  const double here = 2 * robot->error_bound + 24 * unit * (robot->reach + 1.0);
  const float padding = above(pair.padding), error = above(here);
  self_pairs.push_back({pair.a, pair.b, pair.exact, bodies[pair.a].first_stage + up_a,
                        bodies[pair.b].first_stage + up_b, padding, error, padding + error,
                        bodies[pair.a].radius + bodies[pair.b].radius});
}

}  // namespace srmp
