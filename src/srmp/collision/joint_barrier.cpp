#include "srmp/collision/joint_barrier.hpp"

#include <algorithm>

#include "srmp/collision/scene_workspace.hpp"
#include "srmp/core/interruption.hpp"

namespace srmp {

using detail::NarrowPhase;
using detail::Pair;
using detail::SceneModel;
using detail::SceneWorkspace;

namespace {

constexpr int max_placements = 1'000;  // of a pair: where it slides along the other it is not followed any further

/// Conservative advancement of one pair at a time along one joint, of those that come near each other there.
class BarrierSearch {
 public:
  BarrierSearch(const SceneModel& model, ConstVector from, ConstVector to, SceneWorkspace& workspace)
      : model_(model), from_(from), to_(to), workspace_(workspace) {}

  std::optional<JointBarrier> run() {
    const std::vector<char>& continuous = model_.group.continuous();
    for (std::size_t joint = 0; joint < continuous.size(); ++joint) {
      const auto j = static_cast<Eigen::Index>(joint);
      if (continuous[joint] || from_[j] == to_[j]) continue;
      begin(joint);
      for (const Pair* pair : pairs_near())
        if (const auto position = contact_on_the_way(*pair))
          return JointBarrier{joint, *position, workspace_.contact(*pair)};
    }
    return std::nullopt;
  }

 private:
  /// Values of the joint.
  struct Interval {
    double low, high;
    double middle() const { return (low + high) / 2; }
  };

  void begin(std::size_t joint) {
    joint_ = joint;
    support_ = model_.group.actuated_by({&joint, 1});
    workspace_.start_any_motion(support_);
    here_ = from_;
    change_.assign(static_cast<std::size_t>(from_.size()), 0.0);
    still_ = change_;
    const auto [low, high] =
        std::minmax(from_[static_cast<Eigen::Index>(joint)], to_[static_cast<Eigen::Index>(joint)]);
    whole_ = {low, high};
  }

  void place(const Interval& interval) {
    here_[static_cast<Eigen::Index>(joint_)] = interval.middle();
    change_[joint_] = (interval.high - interval.low) / 2;
    workspace_.place_in_range(here_, change_, still_, change_);
  }

  /// Two that are farther apart do not touch while they approach each other by `motion`.
  static double margin(const Pair& pair, double motion) { return pair.padding + motion + NarrowPhase::tolerance; }

  /// Pairs whose relative pose depends on the joint alone, and that may touch on its way.
  std::vector<const Pair*> pairs_near() {
    place(whole_);
    std::vector<const Pair*> near;
    for (const Pair& pair : model_.bodies.pairs) {
      if (pair.depends_only_on(support_) && workspace_.distance_bound(pair) <= margin(pair, workspace_.approach(pair)))
        near.push_back(&pair);
    }
    return near;
  }

  std::optional<double> contact_on_the_way(const Pair& pair) {
    std::vector<Interval> open{whole_};
    for (int placements = 0; !open.empty() && placements < max_placements; ++placements) {
      rare_interruption_point();
      const Interval interval = open.back();
      const double middle = interval.middle();
      open.pop_back();
      place(interval);
      if (workspace_.in_contact(pair, {.use_tables = false})) return middle;
      const double motion = workspace_.approach(pair), enough = margin(pair, motion);
      if (motion < Checker::motion_floor || workspace_.distance_bound(pair) > enough) continue;
      if (workspace_.distance(pair, enough, enough) == detail::infinity) continue;
      open.push_back({middle, interval.high});
      open.push_back({interval.low, middle});
    }
    return std::nullopt;
  }

  const SceneModel& model_;
  const Eigen::VectorXd from_, to_;
  SceneWorkspace& workspace_;
  std::size_t joint_{};
  std::uint64_t support_{};  // actuated joints that the joint moves
  Interval whole_{};
  Eigen::VectorXd here_;
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
