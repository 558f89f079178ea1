#include "srmp/collision/joint_cells.hpp"

#include <coal/collision.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "srmp/collision/gjk.hpp"
#include "srmp/core/interruption.hpp"

namespace srmp {

using detail::NarrowPhase;
using detail::Pair;
using detail::Placed;
using detail::SceneModel;
using detail::SceneWorkspace;

namespace {

/// The geometry less all that is within `depth` of its surface; null when it is of another kind or nothing is left.
std::unique_ptr<coal::CollisionGeometry> eroded(const coal::CollisionGeometry& geometry, double depth) {
  if (const auto* box = dynamic_cast<const coal::Box*>(&geometry)) {
    const coal::Vec3s half = box->halfSide.array() - depth;
    return half.minCoeff() > 0.0 ? std::make_unique<coal::Box>(2.0 * half) : nullptr;
  }
  if (const auto* sphere = dynamic_cast<const coal::Sphere*>(&geometry))
    return sphere->radius > depth ? std::make_unique<coal::Sphere>(sphere->radius - depth) : nullptr;
  if (const auto* capsule = dynamic_cast<const coal::Capsule*>(&geometry))
    return capsule->radius > depth ? std::make_unique<coal::Capsule>(capsule->radius - depth, 2.0 * capsule->halfLength)
                                   : nullptr;
  if (const auto* cylinder = dynamic_cast<const coal::Cylinder*>(&geometry))
    return std::min(cylinder->radius, cylinder->halfLength) > depth
               ? std::make_unique<coal::Cylinder>(cylinder->radius - depth, 2.0 * (cylinder->halfLength - depth))
               : nullptr;
  return nullptr;
}

bool can_be_eroded(const coal::CollisionGeometry& geometry) { return eroded(geometry, 0.0) != nullptr; }

bool touch(const coal::CollisionGeometry& a, const Placed& placed_a, const coal::CollisionGeometry& b,
           const Placed& placed_b) {
  coal::CollisionRequest request;
  coal::CollisionResult result;
  return coal::collide(&a, detail::coal_transform(placed_a.pose), &b, detail::coal_transform(placed_b.pose), request,
                       result) > 0;
}

std::vector<std::size_t> joints_of(const SceneModel& model, std::uint64_t support) {
  const std::vector<ActuatedJoint>& actuated_joints = model.group.actuated_joints();
  std::set<std::size_t> joints;
  for (std::size_t k = 0; k < actuated_joints.size(); ++k)
    if (support >> k & 1) joints.insert(actuated_joints[k].joint);
  return {joints.begin(), joints.end()};
}

/// Is the robot where it was after a whole turn of each continuous one? With mimic joints it need not be.
bool repeat_themselves(const SceneModel& model, const std::vector<std::size_t>& joints) {
  const std::vector<ActuatedJoint>& actuated_joints = model.group.actuated_joints();
  return std::none_of(actuated_joints.begin(), actuated_joints.end(), [&](const ActuatedJoint& actuated) {
    return model.group.continuous()[actuated.joint] &&
           (actuated.prismatic || actuated.ratio != std::round(actuated.ratio)) &&
           std::find(joints.begin(), joints.end(), actuated.joint) != joints.end();
  });
}

}  // namespace

std::vector<std::vector<std::size_t>> JointCells::sets_of_joints(std::size_t max_joints,
                                                                 Checker::Workspace& workspace) {
  auto* scene_workspace = dynamic_cast<SceneWorkspace*>(&workspace);
  if (!scene_workspace) return {};
  const SceneModel& model = scene_workspace->model();
  std::set<std::uint64_t> supports;
  for (const Pair& pair : model.bodies.pairs)
    if (can_be_eroded(*scene_workspace->body_a(pair).geometry) ||
        can_be_eroded(*scene_workspace->body_b(pair).geometry))
      supports.insert(pair.support());
  std::set<std::vector<std::size_t>> sets;
  for (const std::uint64_t support : supports) {
    std::vector<std::size_t> joints = joints_of(model, support);
    if (joints.size() > 1 && joints.size() <= max_joints && repeat_themselves(model, joints))
      sets.insert(std::move(joints));
  }
  std::vector<std::vector<std::size_t>> result(sets.begin(), sets.end());
  std::stable_sort(result.begin(), result.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return result;
}

JointCells::JointCells(std::vector<std::size_t> joints, ConstVector q, Checker::Workspace& workspace)
    : joints_(std::move(joints)), workspace_(dynamic_cast<SceneWorkspace&>(workspace)), here_(q) {
  const SceneModel& model = workspace_.model();
  support_ = model.group.actuated_by(joints_);
  change_.assign(static_cast<std::size_t>(q.size()), 0.0);
  still_ = change_;
  for (std::uint32_t i = 0; i < model.bodies.pairs.size(); ++i)
    if (model.bodies.pairs[i].depends_only_on(support_)) pairs_.push_back(i);
}

JointCells::Result JointCells::check(const Eigen::VectorXd& low, const Eigen::VectorXd& high, Pairs& pairs) {
  rare_interruption_point();
  for (std::size_t k = 0; k < joints_.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    here_[static_cast<Eigen::Index>(joints_[k])] = (low[i] + high[i]) / 2;
    change_[joints_[k]] = (high[i] - low[i]) / 2;
  }
  workspace_.start_any_motion(support_);
  workspace_.place_in_range(here_, change_, still_, change_);
  Pairs near;
  for (const std::uint32_t number : pairs) {
    const Pair& pair = workspace_.model().bodies.pairs[number];
    const double motion = workspace_.approach(pair), enough = pair.padding + motion + NarrowPhase::tolerance;
    if (workspace_.distance_bound(pair) > enough) continue;
    if (stays_in_contact(pair, motion)) return {CollisionStatus::colliding, number};
    if (workspace_.distance(pair, enough, enough) < detail::infinity) near.push_back(number);
  }
  pairs = std::move(near);
  return {pairs.empty() ? CollisionStatus::free : CollisionStatus::undecided};
}

bool JointCells::stays_in_contact(const Pair& pair, double motion) {
  const double depth = motion + NarrowPhase::tolerance;
  const Placed a = workspace_.placed(false, pair.a), b = workspace_.placed(pair.b_fixed, pair.b);
  if (const auto core = eroded(*a.geometry, depth); core && touch(*core, a, *b.geometry, b)) return true;
  const auto core = eroded(*b.geometry, depth);
  return core && touch(*a.geometry, a, *core, b);
}

Contact JointCells::contact(std::uint32_t pair) { return workspace_.contact(workspace_.model().bodies.pairs[pair]); }

}  // namespace srmp
