#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

/// Two bodies in contact, or the nearest two.
struct Contact {
  std::string body_a;            ///< "link" of the planned robot (or attached object)
  std::string body_b;            ///< object, link of the same robot, or "robot/link" of another
  double distance{};             ///< [m]; negative: penetration depth
  Eigen::Vector3d point_a;       ///< on body_a, world frame [m]
  Eigen::Vector3d point_b;       ///< on body_b, world frame [m]

  /// "link 'panda_link5' and object 'shelf' overlap by 12.3 mm".
  std::string describe() const;
};

/// What a thread's checks did so far.
struct CheckStatistics {
  std::uint64_t configurations{};    ///< kinematics computed
  std::uint64_t states{};            ///< is_free calls
  std::uint64_t motions{};           ///< is_motion_free calls
  std::uint64_t narrow_phase{};      ///< pairs that Coal decided
};

/// Exact collision checking of one robot of a scene with Coal. Built once per snapshot; const, shared by threads, each
/// with a Workspace of its own. Other robots stand where set_qpos put them.
///
/// A motion is the straight line in joint space (continuous joints by the short way). It is called free only when it
/// is *proved* free, between samples too: at a sample every pair must be farther apart than the two can move before
/// the next proved sample (conservative advancement; motion bounds from the kinematic tree). A pair that can be neither
/// proved free nor shown in contact above 20 µm of motion counts as not free.
class Checker {
 public:
  class Workspace;
  struct WorkspaceDeleter {
    void operator()(Workspace*) const;
  };
  using WorkspacePtr = std::unique_ptr<Workspace, WorkspaceDeleter>;

  Checker(const Scene& scene, const std::string& robot);
  ~Checker();

  const RobotModel& robot() const;
  const Pose& base() const;
  WorkspacePtr make_workspace() const;

  bool is_free(ConstVector q, Workspace& workspace) const;
  bool is_motion_free(ConstVector a, ConstVector b, Workspace& workspace) const;

  /// Every pair in contact at q, deepest first; empty when free.
  std::vector<Contact> contacts(ConstVector q, Workspace& workspace) const;
  /// The nearest pair (padding counts as part of a body); nullopt when the robot has nothing to collide with.
  std::optional<Contact> nearest(ConstVector q, Workspace& workspace) const;

  const CheckStatistics& statistics(const Workspace& workspace) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace srmp
