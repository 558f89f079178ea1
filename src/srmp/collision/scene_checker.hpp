#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "srmp/collision/batch/batch_world.hpp"
#include "srmp/collision/bodies.hpp"
#include "srmp/collision/checker.hpp"
#include "srmp/collision/pair_table.hpp"
#include "srmp/collision/robot_group.hpp"

namespace srmp {

namespace detail {

class SceneWorkspace;

/// What a SceneChecker knows of the scene. Const; workspaces share it.
struct SceneModel {
  SceneModel(const Scene& scene, const RobotGroup& group, const CheckerOptions& options);

  /// The pairs of bodies that an undecided pair of the batch stands for.
  std::span<const std::uint32_t> pairs_of(const UndecidedPair& pair) const {
    return (pair.self ? batch_scene.self_pairs : batch_scene.obstacle_pairs)[static_cast<std::size_t>(pair.pair)];
  }
  /// Do the spheres' bounds hold at q? They do for prismatic joints up to 1 m outside their limits
  /// (BatchActuatedJoint::max_travel).
  bool spheres_reach(ConstVector q) const;
  bool has_tables() const;

  const RobotGroup& group;
  std::vector<std::shared_ptr<const PairTables>> tables;  // by robot of the group
  Bodies bodies;
  CheckMode mode;
  BatchScene batch_scene;
  std::optional<BatchChecker> batch;  // none in CheckMode::coal
  BatchChecker::MotionOptions batch_options;
};

}  // namespace detail

/// The library's own collision backend. Batches of spheres (BatchChecker) and tables of pairs of links decide most
/// checks; the pairs that they leave undecided go to Coal (CheckMode says which layers are used).
class SceneChecker final : public Checker {
 public:
  /// As make_checker.
  SceneChecker(const Scene& scene, const std::string& robot, const CheckerOptions& options = {});

  const detail::SceneModel& model() const { return model_; }
  /// The workspace as what it is. Throws InvalidArgument unless this checker made it.
  detail::SceneWorkspace& own(Workspace& workspace) const;

 private:
  WorkspacePtr do_make_workspace() const override;
  bool do_is_free(ConstVector q, Workspace& workspace) const override;
  bool do_is_motion_free(ConstVector a, ConstVector b, Workspace& workspace, const MotionQuery& query) const override;
  void do_are_free(ConstRows q, std::span<bool> free, Workspace& workspace, const StateQuery& query) const override;
  MotionCertificate do_certify_motion(ConstVector a, ConstVector b, Workspace& workspace) const override;
  std::vector<Contact> do_contacts(ConstVector q, Workspace& workspace) const override;
  std::optional<Contact> do_nearest(ConstVector q, Workspace& workspace) const override;

  detail::SceneModel model_;
};

}  // namespace srmp
