#include "srmp/collision/batch/batch_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "srmp/core/error.hpp"
#include "srmp/geometry/distance_field.hpp"

namespace srmp {

namespace {

constexpr double kUnit = 0x1p-24;  // half a unit in the last place of float32, relative

constexpr std::size_t kMaxPairs = 4'000'000;

batch::KernelFunction kernel_of([[maybe_unused]] SimdBackend backend) {
#if defined(__x86_64__) && !defined(SRMP_PORTABLE_ONLY)
  if (backend == SimdBackend::avx512) return batch::run_avx512;
  if (backend == SimdBackend::avx2) return batch::run_avx2;
#endif
  return batch::run_portable;
}

/// Conversions to float32 that round to the safe side.
float above(double x) {
  const auto f = static_cast<float>(x);
  return f >= x ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}
float below(double x) { return -above(-x); }

/// A part of the world, for messages; the text is made only for what is refused.
struct Part {
  const char* kind;
  std::size_t number;
  std::string name() const { return std::string("batch checker: ") + kind + " " + std::to_string(number); }
};

void require(bool fine, const Part& part, const char* what) {
  if (!fine) throw InvalidArgument(part.name() + what);
}

void require_index(int index, std::size_t size, const Part& part, const char* what) {
  if (index < 0 || static_cast<std::size_t>(index) >= size)
    throw InvalidArgument(part.name() + ": its " + what + " is " + std::to_string(index) + "; there are " +
                          std::to_string(size));
}

void require_spheres(std::span<const PlacedSphere> spheres, const Part& part) {
  for (const PlacedSphere& sphere : spheres)
    require(sphere.center.allFinite() && std::isfinite(sphere.radius) && sphere.radius >= 0, part,
            ": a sphere is not finite, or its radius is negative");
}

void copy_rotation(const Eigen::Matrix3d& rotation, float* out) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out[3 * r + c] = static_cast<float>(rotation(r, c));
}

batch::KernelSphere kernel_sphere(const PlacedSphere& sphere, bool inner = false) {
  return {static_cast<float>(sphere.center.x()),
          static_cast<float>(sphere.center.y()),
          static_cast<float>(sphere.center.z()),
          inner ? below(sphere.radius) : above(sphere.radius),
          0,
          0};
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

void require_valid_joint(const BatchWorld& world, std::size_t k) {
  const BatchActuatedJoint& joint = world.actuated_joints[k];
  const Part part{"actuated joint", k};
  require(joint.parent < static_cast<int>(k) && joint.parent >= -1, part, " comes before its parent");
  require_index(joint.joint, world.dof, part, "joint");
  require(joint.frame.matrix().allFinite(), part, ": its frame is not finite");
  require(std::isfinite(joint.ratio) && std::isfinite(joint.offset) && std::isfinite(joint.max_travel), part,
          ": ratio, offset and travel must be finite");
}

void require_valid_body(const BatchWorld& world, std::size_t i) {
  const BatchBody& body = world.bodies[i];
  const Part part{"body", i};
  if (body.actuated_joint != -1)
    require_index(body.actuated_joint, world.actuated_joints.size(), part, "actuated joint");
  require_spheres({&body.bound, 1}, part);
  require_spheres(body.coarse, part);
  require_spheres(body.fine, part);
  require_spheres(body.inner, part);
  require(!body.coarse.empty(), part, " has no spheres");
  require(std::isfinite(body.padding) && body.padding >= 0, part, ": its padding must be 0 or more");
  require(body.children.size() == (body.fine.empty() ? 0 : body.coarse.size()), part,
          ": children must be given for each coarse sphere when there are fine ones");
  for (const auto& list : body.children)
    for (const std::uint32_t child : list) require_index(static_cast<int>(child), body.fine.size(), part, "child");
}

void require_valid_obstacle(const BatchWorld& world, std::size_t i) {
  const BatchObstacle& o = world.obstacles[i];
  const Part part{"obstacle", i};
  require(o.size.allFinite() && (o.size.array() >= 0).all() && o.pose.matrix().allFinite() &&
              std::isfinite(o.padding) && o.padding >= 0 && o.field_center.allFinite(),
          part, ": size, pose and padding must be finite and not negative");
  require((o.kind == BatchObstacle::Kind::field) == (o.field != nullptr), part,
          ": a field is needed where, and only where, the kind says so");
}

}  // namespace

BatchModel::BatchModel(const BatchWorld& batch_world, SimdBackend simd) : world(batch_world), backend(simd) {
  if (!is_available(backend)) throw InvalidArgument("batch checker: this CPU does not have " + to_string(backend));
  kernel = kernel_of(backend);
  require_valid();
  add_nodes();
  add_bodies();
  add_obstacles();
  add_pairs();
  add_self_pairs();
  add_reach();
}

void BatchModel::require_valid() const {
  for (std::size_t k = 0; k < world.actuated_joints.size(); ++k) require_valid_joint(world, k);
  for (std::size_t i = 0; i < world.bodies.size(); ++i) require_valid_body(world, i);
  for (std::size_t i = 0; i < world.obstacles.size(); ++i) require_valid_obstacle(world, i);
  for (std::size_t i = 0; i < world.obstacle_pairs.size(); ++i) {
    const Part part{"pair", i};
    require_index(world.obstacle_pairs[i].first, world.bodies.size(), part, "body");
    require_index(world.obstacle_pairs[i].second, world.obstacles.size(), part, "obstacle");
  }
  for (std::size_t i = 0; i < world.self_pairs.size(); ++i) {
    const Part part{"self pair", i};
    require_index(world.self_pairs[i].a, world.bodies.size(), part, "first body");
    require_index(world.self_pairs[i].b, world.bodies.size(), part, "second body");
  }
  if (world.obstacle_pairs.size() + world.self_pairs.size() > kMaxPairs)
    throw InvalidArgument("batch checker: there are more than 4 million pairs");
}

void BatchModel::add_nodes() {
  nodes.push_back({-1, -1, 0, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}});
  rotation_error.push_back(0);
  position_error.push_back(0);
  node_reach.push_back(0);
  for (std::size_t k = 0; k < world.actuated_joints.size(); ++k) {
    const BatchActuatedJoint& actuated = world.actuated_joints[k];
    batch::KernelNode node{actuated.parent + 1, static_cast<int>(k), actuated.prismatic, {}, {}};
    copy_rotation(actuated.frame.linear(), node.rotation);
    for (int i = 0; i < 3; ++i) node.translation[i] = static_cast<float>(actuated.frame.translation()[i]);
    nodes.push_back(node);
    // Rounding of one joint: each entry of a product of rotations errs by at most 3 units, the constants by 1, the
    // joint's rotation by 3 more; sine and cosine by 2.5e-7; the angle (at most 2 pi) by 2 pi units. 9 entries: 3 times
    // that in norm, doubled for safety.
    const double step = actuated.frame.translation().norm() + actuated.max_travel;
    const double reach = node_reach[node.parent] + step;
    rotation_error.push_back(rotation_error[node.parent] + 80 * kUnit);
    position_error.push_back(position_error[node.parent] + rotation_error[node.parent] * step + 12 * kUnit * reach);
    node_reach.push_back(reach);
  }
}

void BatchModel::add_reach() {
  actuated_reach.assign(world.actuated_joints.size(), 0.0);
  for (const BatchBody& body : world.bodies) {
    double beyond = body.bound.center.norm() + body.bound.radius;
    for (int k = body.actuated_joint; k >= 0; k = world.actuated_joints[k].parent) {
      actuated_reach[k] = std::max(actuated_reach[k], world.actuated_joints[k].prismatic ? 1.0 : beyond);
      beyond += world.actuated_joints[k].frame.translation().norm() + world.actuated_joints[k].max_travel;
    }
  }
}

double BatchModel::body_error(const BatchBody& body) const {
  const std::size_t node = static_cast<std::size_t>(body.actuated_joint + 1);
  double far = body.bound.center.norm() + body.bound.radius;
  for (const auto* spheres : {&body.coarse, &body.fine, &body.inner})
    for (const PlacedSphere& b : *spheres) far = std::max(far, b.center.norm());
  return position_error[node] + rotation_error[node] * far + 12 * kUnit * (node_reach[node] + far);
}

/// The motion of a sphere is that of its center.
bool BatchModel::is_sphere(const BatchBody& body) {
  return body.exact && body.coarse.size() == 1 && body.coarse.front().center == body.bound.center;
}

void BatchModel::add_bodies() {
  for (const BatchBody& body : world.bodies) {
    batch::KernelBody kernel{};
    kernel.node = body.actuated_joint + 1;
    for (int n = kernel.node; n >= 0; n = nodes[n].parent) ++kernel.depth;
    kernel.first_stage = stage_count;
    stage_count += kernel.depth;
    const batch::KernelSphere bound = kernel_sphere(body.bound);
    kernel.x = bound.x, kernel.y = bound.y, kernel.z = bound.z, kernel.radius = bound.radius;
    kernel.reach_radius = above((is_sphere(body) ? 0.0 : body.bound.radius) + 2 * body_error(body));
    kernel.padding = above(body.padding);
    kernel.exact = body.exact;
    kernel.capacity = body.hollow ? above(2 * body.bound.radius + 1e-3) : 0.0f;
    kernel.first_sphere = static_cast<int>(spheres.size());
    kernel.spheres = static_cast<int>(body.coarse.size());
    for (const PlacedSphere& sphere : body.coarse) spheres.push_back(kernel_sphere(sphere));
    bodies.push_back(kernel);
    error_bound = std::max(error_bound, body_error(body));
    robot_reach = std::max(robot_reach, node_reach[kernel.node] + body.bound.center.norm() + body.bound.radius);
  }
  coarse_count = static_cast<int>(spheres.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) add_fine_and_inner_spheres(i);
}

void BatchModel::add_fine_and_inner_spheres(std::size_t i) {
  const BatchBody& body = world.bodies[i];
  const int first_fine = static_cast<int>(spheres.size());
  for (const PlacedSphere& sphere : body.fine) spheres.push_back(kernel_sphere(sphere));
  for (std::size_t c = 0; c < body.children.size(); ++c) {
    batch::KernelSphere& parent = spheres[bodies[i].first_sphere + c];
    parent.first_child = static_cast<int>(children.size());
    parent.children = static_cast<int>(body.children[c].size());
    max_children = std::max(max_children, parent.children);
    for (std::uint32_t child : body.children[c]) children.push_back(first_fine + static_cast<int>(child));
  }
  bodies[i].first_inner = static_cast<int>(spheres.size());
  bodies[i].inners = static_cast<int>(body.inner.size());
  for (const PlacedSphere& sphere : body.inner) spheres.push_back(kernel_sphere(sphere, true));
}

void BatchModel::add_obstacles() {
  for (const BatchObstacle& o : world.obstacles) {
    batch::KernelObstacle kernel{};
    const Eigen::Isometry3d inverse = o.pose.inverse();
    copy_rotation(inverse.linear(), kernel.rotation);
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
        error_bound + 24 * kUnit * (robot_reach + o.pose.translation().norm() + extent(o) + o.padding + 1.0);
    kernel.radius = above(rounding + o.padding + here);
    kernel.inner_radius = below(rounding + o.padding - here);
    obstacles.push_back(kernel);
  }
}

bool BatchModel::reachable(const BatchBody& body, const BatchObstacle& o) const {
  const double reach =
      node_reach[body.actuated_joint + 1] + body.bound.center.norm() + body.bound.radius + body.padding;
  const Eigen::Vector3d p = o.pose.inverse().translation();  // the base in the obstacle's frame
  double distance = p.norm() - extent(o);
  if (o.kind == BatchObstacle::Kind::box || o.kind == BatchObstacle::Kind::field)
    distance = (p.cwiseAbs() - o.size / 2).cwiseMax(0.0).norm();
  return distance - o.padding <= reach * 1.0001 + 1e-3;
}

void BatchModel::add_pairs() {
  std::vector<std::array<int, 3>> pairs;  // body, obstacle, index
  for (const auto& [body, obstacle] : world.obstacle_pairs)
    pairs.push_back({body, obstacle, static_cast<int>(pairs.size())});
  std::sort(pairs.begin(), pairs.end());
  for (std::size_t i = 0, k = 0; i < bodies.size(); ++i) {
    bodies[i].first_pair = static_cast<int>(pair_obstacles.size());
    for (; k < pairs.size() && pairs[k][0] == static_cast<int>(i); ++k) {
      if (!reachable(world.bodies[i], world.obstacles[pairs[k][1]])) continue;
      pair_obstacles.push_back(pairs[k][1]);
      pair_ids.push_back(pairs[k][2]);
    }
    bodies[i].pairs = static_cast<int>(pair_obstacles.size()) - bodies[i].first_pair;
  }
}

void BatchModel::add_self_pairs() {
  for (const BatchSelfPair& pair : world.self_pairs) {
    const auto chain = [&](int body) {
      std::vector<int> result;
      for (int n = bodies[body].node; n >= 0; n = nodes[n].parent) result.push_back(n);
      return result;
    };
    const std::vector<int> a = chain(pair.a), b = chain(pair.b);
    int up_a = 0, up_b = 0;  // steps to the last common node: only what is beyond moves one against the other
    while (a[up_a] != b[up_b]) ++(a[up_a] > b[up_b] ? up_a : up_b);
    const double here = 2 * error_bound + 24 * kUnit * (robot_reach + 1.0);
    self_pairs.push_back({pair.a, pair.b, pair.exact, bodies[pair.a].first_stage + up_a,
                          bodies[pair.b].first_stage + up_b, above(pair.padding), above(here)});
  }
}

}  // namespace srmp
