#include "srmp/collision/joint_barrier.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/collision/scene_workspace.hpp"
#include "srmp/core/interruption.hpp"

namespace srmp {

using detail::NarrowPhase;
using detail::Pair;
using detail::SceneModel;
using detail::SceneWorkspace;

namespace {

constexpr int max_placements = 1'000;  // of a pair: where it slides along the other it is not followed any further

/// Conservative advancement of one pair at a time along one joint.
class BarrierSearch {
 public:
  BarrierSearch(const SceneModel& model, ConstVector from, ConstVector to, SceneWorkspace& workspace)
      : model_(model), from_(from), to_(to), here_(from), workspace_(workspace), change_(dof(), 0.0) {}

  std::optional<JointBarrier> run() {
    for (const Pair& pair : model_.bodies.pairs)
      if (const auto joint = only_joint_of(pair))
        if (const auto position = contact_on_the_way(pair, *joint))
          return JointBarrier{*joint, *position, contact_of(pair)};
    return std::nullopt;
  }

 private:
  std::size_t dof() const { return static_cast<std::size_t>(from_.size()); }

  /// The joint on which alone the relative pose of the two depends, if it is one of those that are to be looked at.
  std::optional<std::size_t> only_joint_of(const Pair& pair) const {
    std::optional<std::size_t> only;
    const std::uint64_t support = pair.support_a | pair.support_b;
    for (std::size_t k = 0; k < model_.group.actuated_joints().size(); ++k) {
      if (!(support >> k & 1)) continue;
      const std::size_t joint = model_.group.actuated_joints()[k].joint;
      if (only && *only != joint) return std::nullopt;
      only = joint;
    }
    if (!only || model_.group.continuous()[*only]) return std::nullopt;
    const auto j = static_cast<Eigen::Index>(*only);
    return from_[j] == to_[j] ? std::nullopt : only;
  }

  void place(std::size_t joint, double position, double half_width) {
    here_[static_cast<Eigen::Index>(joint)] = position;
    change_[joint] = half_width;
    workspace_.place_in_range(here_, change_, still_, change_);
  }

  std::optional<double> contact_on_the_way(const Pair& pair, std::size_t joint) {
    const auto j = static_cast<Eigen::Index>(joint);
    here_ = from_;
    change_.assign(dof(), 0.0);
    still_.assign(dof(), 0.0);
    workspace_.start_any_motion(pair.support_a | pair.support_b);
    struct Interval {
      double low, high;
    };
    std::vector<Interval> open{{std::min(from_[j], to_[j]), std::max(from_[j], to_[j])}};
    for (int placements = 0; !open.empty() && placements < max_placements; ++placements) {
      rare_interruption_point();
      const auto [low, high] = open.back();
      open.pop_back();
      const double middle = (low + high) / 2;
      place(joint, middle, (high - low) / 2);
      if (workspace_.in_contact(pair, {.use_tables = false})) return middle;
      const double motion = workspace_.approach(pair), margin = pair.padding + motion + NarrowPhase::tolerance;
      if (motion < Checker::motion_floor || workspace_.distance_bound(pair) > margin) continue;
      if (workspace_.distance(pair, margin, margin) == detail::infinity) continue;
      open.push_back({middle, high});
      open.push_back({low, middle});
    }
    return std::nullopt;
  }

  Contact contact_of(const Pair& pair) const {
    const auto found = NarrowPhase::deepest(workspace_.placed(false, pair.a), workspace_.placed(pair.b_fixed, pair.b),
                                            pair.padding + NarrowPhase::contact_distance);
    return workspace_.contact(workspace_.body_a(pair), workspace_.body_b(pair), found, pair.padding);
  }

  const SceneModel& model_;
  const Eigen::VectorXd from_, to_;
  Eigen::VectorXd here_;
  SceneWorkspace& workspace_;
  std::vector<double> change_, still_;
};

}  // namespace

std::optional<JointBarrier> find_joint_barrier(const Checker& checker, ConstVector from, ConstVector to,
                                               Checker::Workspace& workspace) {
  checker.require_own(workspace);
  auto* scene_workspace = dynamic_cast<SceneWorkspace*>(&workspace);
  if (!scene_workspace) return std::nullopt;
  return BarrierSearch(scene_workspace->model(), from, to, *scene_workspace).run();
}

}  // namespace srmp
