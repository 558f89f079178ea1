#include "srmp/collision/batch/batch_robot.hpp"

#include <algorithm>
#include <numeric>
#include <span>

#include "srmp/collision/batch/batch_numbers.hpp"

namespace srmp {

using batch::above;
using batch::below;
using batch::Part;
using batch::require;
using batch::require_index;
using batch::unit;

namespace {

void require_spheres(std::span<const PlacedSphere> spheres, const Part& part) {
  for (const PlacedSphere& sphere : spheres)
    require(sphere.center.allFinite() && std::isfinite(sphere.radius) && sphere.radius >= 0, part,
            ": a sphere is not finite, or its radius is negative");
}

batch::KernelSphere kernel_sphere(const PlacedSphere& sphere, bool inner = false) {
  return {static_cast<float>(sphere.center.x()),
          static_cast<float>(sphere.center.y()),
          static_cast<float>(sphere.center.z()),
          inner ? below(sphere.radius) : above(sphere.radius),
          0,
          0,
          0};
}

/// Of each sphere the number of its cluster: spheres that overlap, directly or through others, are of one.
std::vector<int> clusters_of(const std::vector<PlacedSphere>& spheres) {
  constexpr double clearly = 1e-6;  // [m] by which spheres that count as overlapping overlap at least
  std::vector<int> cluster(spheres.size());
  std::iota(cluster.begin(), cluster.end(), 0);
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      if (cluster[j] == cluster[i]) continue;
      const double near = spheres[i].radius + spheres[j].radius - clearly;
      const int from = cluster[j], to = cluster[i];
      if (near > 0 && (spheres[i].center - spheres[j].center).squaredNorm() < near * near)
        std::ranges::replace(cluster, from, to);
    }
  return cluster;
}

void require_valid_joint(const BatchRobot& robot, std::size_t k) {
  const BatchActuatedJoint& joint = robot.actuated_joints[k];
  const Part part{"actuated joint", k};
  require(joint.parent < static_cast<int>(k) && joint.parent >= -1, part, " comes before its parent");
  require_index(joint.joint, robot.dof, part, "joint");
  require(joint.frame.matrix().allFinite(), part, ": its frame is not finite");
  require(std::isfinite(joint.ratio) && std::isfinite(joint.offset) && std::isfinite(joint.max_travel), part,
          ": ratio, offset and travel must be finite");
}

void require_valid_body(const BatchRobot& robot, std::size_t i) {
  const BatchBody& body = robot.bodies[i];
  const Part part{"body", i};
  if (body.actuated_joint != -1)
    require_index(body.actuated_joint, robot.actuated_joints.size(), part, "actuated joint");
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

/// Entries within 1e-9 of 0 and of 1 are taken for these: the float error of the rotation is larger.
void set_rotation(batch::KernelNode& node, const Eigen::Matrix3d& rotation) {
  const Eigen::Matrix3d whole = rotation.array().round();
  node.exchanges = (rotation - whole).cwiseAbs().maxCoeff() < 1e-9;
  batch::copy_rotation(node.exchanges ? whole : rotation, node.rotation);
  if (!node.exchanges) return;
  for (int c = 0; c < 3; ++c) {
    whole.col(c).cwiseAbs().maxCoeff(&node.axis[c]);
    node.direction[c] = static_cast<float>(whole(node.axis[c], c));
  }
}

/// Of a sphere around the centre of the body's: it contains the body, and the centres of all spheres that cover it.
double radius_around(const BatchBody& body) {
  double radius = body.bound.radius;
  for (const auto* spheres : {&body.coarse, &body.fine})
    for (const PlacedSphere& sphere : *spheres) radius = std::max(radius, (sphere.center - body.bound.center).norm());
  return radius;
}

/// The motion of a sphere is that of its center.
bool is_sphere(const BatchBody& body) {
  return body.exact && body.coarse.size() == 1 && body.coarse.front().center == body.bound.center;
}

}  // namespace

BatchRobotModel::BatchRobotModel(const BatchRobot& robot) : dof(robot.dof), actuated_joints(robot.actuated_joints) {
  for (std::size_t k = 0; k < robot.actuated_joints.size(); ++k) require_valid_joint(robot, k);
  for (std::size_t i = 0; i < robot.bodies.size(); ++i) require_valid_body(robot, i);
  add_nodes(robot);
  make_room(robot);
  actuated_reach.assign(actuated_joints.size(), 0.0);
  for (const BatchBody& body : robot.bodies) add_body(body);
  coarse_count = static_cast<int>(spheres.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) add_fine_and_inner_spheres(robot.bodies[i], bodies[i]);
}

void BatchRobotModel::make_room(const BatchRobot& robot) {
  std::size_t in_bodies = 0, in_spheres = 0;
  for (const BatchBody& body : robot.bodies) {
    in_bodies += body.coarse.size() + body.fine.size() + body.inner.size();
    for (const auto& list : body.children) in_spheres += list.size();
  }
  bodies.reserve(robot.bodies.size());
  spheres.reserve(in_bodies);
  children.reserve(in_spheres);
}

void BatchRobotModel::add_nodes(const BatchRobot& robot) {
  nodes.push_back({.parent = -1, .actuated_joint = -1});
  rotation_error_.push_back(0);
  position_error_.push_back(0);
  node_reach_.push_back(0);
  for (std::size_t k = 0; k < robot.actuated_joints.size(); ++k) {
    const BatchActuatedJoint& actuated = robot.actuated_joints[k];
    batch::KernelNode node{};
    node.parent = actuated.parent + 1;
    node.actuated_joint = static_cast<int>(k);
    node.prismatic = actuated.prismatic;
    set_rotation(node, actuated.frame.linear());
    for (int i = 0; i < 3; ++i) node.translation[i] = static_cast<float>(actuated.frame.translation()[i]);
    nodes.push_back(node);
    // Rounding of one joint: each entry of a product of rotations errs by at most 3 units, the constants by 1, the
    // joint's rotation by 3 more; sine and cosine by 2.5e-7; the angle (at most 2 pi) by 2 pi units. 9 entries: 3 times
    // that in norm, doubled for safety.
    const double step = actuated.frame.translation().norm() + actuated.max_travel;
    const double far = node_reach_[node.parent] + step;
    rotation_error_.push_back(rotation_error_[node.parent] + 80 * unit);
    position_error_.push_back(position_error_[node.parent] + rotation_error_[node.parent] * step + 12 * unit * far);
    node_reach_.push_back(far);
  }
}

void BatchRobotModel::add_reach(const BatchBody& body, double radius) {
  double beyond = body.bound.center.norm() + radius;
  const double far = node_reach_[body.actuated_joint + 1] + beyond;
  reach = std::max(reach, far);
  body_reach.push_back(far + body.padding);
  for (int k = body.actuated_joint; k >= 0; k = actuated_joints[k].parent) {
    actuated_reach[k] = std::max(actuated_reach[k], actuated_joints[k].prismatic ? 1.0 : beyond);
    nodes[k + 1].reach = above(1.0001 * actuated_reach[k] + 1e-3);
    beyond += actuated_joints[k].frame.translation().norm() + actuated_joints[k].max_travel;
  }
}

double BatchRobotModel::body_error(const BatchBody& body) const {
  const std::size_t node = static_cast<std::size_t>(body.actuated_joint + 1);
  double far = body.bound.center.norm() + body.bound.radius;
  for (const auto* list : {&body.coarse, &body.fine, &body.inner})
    for (const PlacedSphere& b : *list) far = std::max(far, b.center.norm());
  return position_error_[node] + rotation_error_[node] * far + 12 * unit * (node_reach_[node] + far);
}

void BatchRobotModel::add_body(const BatchBody& body) {
  batch::KernelBody kernel{};
  kernel.node = body.actuated_joint + 1;
  for (int n = kernel.node; n >= 0; n = nodes[n].parent) ++kernel.depth;
  kernel.first_stage = stage_count;
  stage_count += kernel.depth;
  const batch::KernelSphere bound = kernel_sphere(body.bound);
  const double error = body_error(body), radius = radius_around(body);
  kernel.x = bound.x, kernel.y = bound.y, kernel.z = bound.z, kernel.radius = bound.radius;
  kernel.reach_radius = above((is_sphere(body) ? 0.0 : radius) + 2 * error);
  kernel.rounding = above(4 * error);
  kernel.padding = above(body.padding);
  kernel.exact = body.exact;
  kernel.capacity = body.hollow ? above(2 * body.bound.radius + 1e-3) : 0.0f;
  kernel.first_sphere = static_cast<int>(spheres.size());
  kernel.spheres = static_cast<int>(body.coarse.size());
  for (const PlacedSphere& sphere : body.coarse) spheres.push_back(kernel_sphere(sphere));
  bodies.push_back(kernel);
  add_reach(body, radius);
  exact = exact && body.exact;
  error_bound = std::max(error_bound, error);
}

void BatchRobotModel::add_fine_and_inner_spheres(const BatchBody& body, batch::KernelBody& kernel) {
  const int first_fine = static_cast<int>(spheres.size());
  for (const PlacedSphere& sphere : body.fine) spheres.push_back(kernel_sphere(sphere));
  for (std::size_t c = 0; c < body.children.size(); ++c) {
    batch::KernelSphere& parent = spheres[kernel.first_sphere + c];
    parent.first_child = static_cast<int>(children.size());
    parent.children = static_cast<int>(body.children[c].size());
    max_children = std::max(max_children, parent.children);
    for (std::uint32_t child : body.children[c]) {
      const Eigen::Vector3f from_parent = (body.fine[child].center - body.coarse[c].center).cast<float>();
      const int sphere = first_fine + static_cast<int>(child);
      children.push_back({from_parent.x(), from_parent.y(), from_parent.z(), spheres[sphere].radius, sphere});
    }
  }
  kernel.first_inner = static_cast<int>(spheres.size());
  kernel.inners = static_cast<int>(body.inner.size());
  const std::vector<int> clusters = clusters_of(body.inner);
  for (std::size_t i = 0; i < body.inner.size(); ++i) {
    spheres.push_back(kernel_sphere(body.inner[i], true));
    spheres.back().cluster = clusters[i];
  }
}

BatchRobotStore::Ptr BatchRobotStore::get(Key key, const std::function<BatchRobot()>& make) {
  {
    const std::lock_guard lock(mutex_);
    if (changed_) {
      std::erase_if(known_, [&](const Known& known) { return known.asked_for < changes_; });
      ++changes_;
      changed_ = false;
    }
    if (Ptr robot = find(key)) return robot;
  }
  Ptr made = std::make_shared<const BatchRobotModel>(make());
  const std::lock_guard lock(mutex_);
  if (Ptr robot = find(key)) return robot;  // another thread was quicker
  known_.push_back({std::move(key), made, changes_});
  return made;
}

BatchRobotStore::Ptr BatchRobotStore::find(const Key& key) {
  const auto found = std::find_if(known_.begin(), known_.end(), [&](const Known& known) { return known.key == key; });
  if (found == known_.end()) return nullptr;
  found->asked_for = changes_;
  return found->robot;
}

void BatchRobotStore::scene_changed() {
  const std::lock_guard lock(mutex_);
  changed_ = true;
}

}  // namespace srmp
