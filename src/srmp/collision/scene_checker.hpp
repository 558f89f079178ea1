#pragma once

#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "srmp/collision/scene_model.hpp"

namespace srmp {

namespace detail {
class SceneWorkspace;
}

/// The library's own collision backend. Batches of spheres (BatchChecker) and tables of pairs of links decide most
/// checks; the pairs that they leave undecided go to Coal (CheckMode says which layers are used).
class SceneChecker final : public Checker {
 public:
  /// As make_checker.
  SceneChecker(const Scene& scene, const std::string& robot, const CheckerOptions& options = {});

  /// Follows objects that no robot holds and that were added to `scene`, removed, replaced or moved since this was
  /// made, while nothing else has changed: this is then as if made anew, in less time. Workspaces made before are not
  /// to be used any more. After an exception, neither is this.
  void follow_objects(const Scene& scene, const std::set<std::string>& names) { model_.follow_objects(scene, names); }

  /// Pairs of links that need not keep CheckerOptions::clearance (Bodies::close_links).
  const std::vector<std::string>& close_links() const { return model_.bodies.close_links; }

 private:
  WorkspacePtr do_make_workspace() const override;
  bool do_is_free(ConstVector q, Workspace& workspace) const override;
  bool do_is_motion_free(ConstVector a, ConstVector b, Workspace& workspace, const MotionQuery& query) const override;
  void do_are_free(ConstRows q, std::span<bool> free, Workspace& workspace, const StateQuery& query) const override;
  void do_find_colliding(ConstRows q, std::span<bool> colliding, Workspace& workspace) const override;
  MotionCertificate do_certify_motion(ConstVector a, ConstVector b, Workspace& workspace) const override;
  std::vector<Contact> do_contacts(ConstVector q, Workspace& workspace) const override;
  std::optional<Contact> do_nearest(ConstVector q, Workspace& workspace) const override;
  double do_clearance(ConstVector q, Workspace& workspace) const override;
  std::optional<Contact> do_nearest_fixed() const override;

  struct NearestPair;
  /// Of those apart at the workspace's configuration.
  NearestPair nearest_pair(detail::SceneWorkspace& workspace) const;

  detail::SceneModel model_;
};

}  // namespace srmp
