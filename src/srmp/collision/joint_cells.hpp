#pragma once

#include <cstdint>
#include <vector>

#include "srmp/collision/batch/batch_checker.hpp"
#include "srmp/collision/checker.hpp"
#include "srmp/collision/scene_workspace.hpp"

namespace srmp {

/// Checks boxes of values of some joints whether two bodies whose relative pose depends on those joints alone are in
/// contact in all of the box: then nothing that the other joints do makes the robot free.
///
/// Contact over a box is proved by erosion. A convex body less all that is within some distance of its surface is in
/// contact with the other body; then the two stay in contact while neither moves farther than that. Boxes, spheres,
/// capsules and cylinders can be eroded.
class JointCells {
 public:
  /// Numbers of pairs of bodies.
  using Pairs = std::vector<std::uint32_t>;

  struct Result {
    CollisionStatus status{};  ///< free: no pair is in contact anywhere; colliding: one is everywhere
    std::uint32_t pair{};      ///< colliding: that one
  };

  /// The other joints are as in `q`, which does not matter. The workspace is that of a checker of the library's own.
  JointCells(std::vector<std::size_t> joints, ConstVector q, Checker::Workspace& workspace);

  /// Sets of at most `max_joints` joints, more than one, on which the relative pose of two bodies depends that may be
  /// in contact over a box; small sets first. None with a checker that is not the library's own. Sets with a continuous
  /// joint that another one follows so that a whole turn does not repeat the pose are left out.
  static std::vector<std::vector<std::size_t>> sets_of_joints(std::size_t max_joints, Checker::Workspace& workspace);

  const std::vector<std::size_t>& joints() const { return joints_; }
  /// All pairs whose relative pose depends on these joints alone.
  const Pairs& pairs() const { return pairs_; }
  /// Of the box from `low` to `high`, one entry per joint; `pairs` are those that may be in contact in it, those that
  /// cannot are removed. Throws MotionCheckStopped as Checker::stop_at says.
  Result check(const Eigen::VectorXd& low, const Eigen::VectorXd& high, Pairs& pairs);
  /// Of a pair that is in contact, in the middle of the box that was checked last.
  Contact contact(std::uint32_t pair);

 private:
  bool stays_in_contact(const detail::Pair& pair, double motion);

  std::vector<std::size_t> joints_;
  detail::SceneWorkspace& workspace_;
  Pairs pairs_;
  std::uint64_t support_{};  // actuated joints that these joints move
  Eigen::VectorXd here_;
  std::vector<double> change_, still_;
};

}  // namespace srmp
