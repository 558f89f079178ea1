#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "srmp/collision/batch/batch_checker.hpp"
#include "srmp/collision/batch/batch_world.hpp"
#include "srmp/collision/bodies.hpp"
#include "srmp/collision/checker.hpp"
#include "srmp/collision/pair_groups.hpp"
#include "srmp/collision/pair_table.hpp"
#include "srmp/collision/robot_group.hpp"

namespace srmp::detail {

/// What a SceneChecker knows of the scene. Workspaces share it.
struct SceneModel {
  SceneModel(const Scene& scene, const RobotGroup& group, const CheckerOptions& options);

  /// As Bodies::follow_objects; workspaces made before are not to be used any more.
  void follow_objects(const Scene& scene, const std::set<std::string>& names);

  /// The pairs of bodies that an undecided pair of the batch stands for.
  std::span<const std::uint32_t> pairs_of(const UndecidedPair& pair) const {
    return (pair.self ? batch_scene.self_pairs : batch_scene.obstacle_pairs)[static_cast<std::size_t>(pair.pair)];
  }
  /// Do the spheres' bounds hold at q? They do for prismatic joints up to 1 m outside their limits
  /// (BatchActuatedJoint::max_travel).
  bool spheres_reach(ConstVector q) const;
  /// Of the bodies' pairs; found when they are first needed. Any thread may call it.
  const PairGroups& pair_groups() const;

  const RobotGroup& group;
  std::vector<std::shared_ptr<const PairTables>> tables;  // by robot of the group
  Bodies bodies;
  CheckMode mode;
  BatchScene batch_scene;
  std::optional<BatchChecker> batch;  // none in CheckMode::coal
  BatchChecker::MotionOptions batch_options;

 private:
  mutable std::mutex mutex_;                       // of what follows
  mutable std::optional<PairGroups> pair_groups_;  // none: not known yet
};

}  // namespace srmp::detail
