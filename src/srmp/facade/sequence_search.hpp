#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/planner_interface.hpp"

namespace srmp {

struct SequenceSearchOptions {
  int max_attempts{200};     ///< > 0 motions that are planned, with all alternatives: more find more, and take longer
  double distinct{0.05};     ///< [rad or m] between ends that count as different: less tries more ends that are alike
  int gripper_samples{10};   ///< > 0 steps of joints that are set, where contacts that can be named are searched
  double max_duration{1e6};  ///< [s] of a segment that waits: what is longer is a mistake in the input
};

/// Plans a sequence segment by segment (PlannerInterface::plan_sequence). Where a later one fails, an earlier motion
/// ends elsewhere: at another target, or at another solution of inverse kinematics. The planner's scene is what it is
/// then; its owner restores it.
class SequenceSearch {
 public:
  using SetScene = std::function<void(const Scene&)>;

  /// All arguments must outlive it. `time_limit` [s] is for each segment.
  SequenceSearch(PlannerInterface& planner, const std::string& robot, const std::vector<Segment>& segments,
                 const SetScene& set_scene, double time_limit, const PlannerInterface::Interrupt& interrupt,
                 const SequenceSearchOptions& options = {});

  /// Throws InvalidArgument for segments that cannot be, before anything is planned.
  void require_segments(const Eigen::VectorXd& start);
  /// Throws PlanningError where there is no sequence.
  void run(const Eigen::VectorXd& start);

  /// The motion of each segment; no rows: none.
  const std::vector<Trajectory>& motions() const { return motions_; }
  /// In which each segment begins.
  const std::vector<Scene>& scenes() const { return scenes_; }

 private:
  bool solve(std::size_t i, const Eigen::VectorXd& q);
  bool solve_move(std::size_t i, const Eigen::VectorXd& q);
  std::vector<Eigen::VectorXd> ends(const std::vector<GoalConstraint>& goals, const Eigen::VectorXd& q) const;
  Trajectory along_poses(const Segment& segment, const Eigen::VectorXd& q);
  bool attempt(std::size_t i, const std::function<Trajectory()>& plan);
  bool act(std::size_t i, const Eigen::VectorXd& q);
  bool set_joints(std::size_t i, const Eigen::VectorXd& q);
  void change_scene(const Segment& segment, const Eigen::VectorXd& q);
  void require_not_planned(std::size_t i) const;
  void require_poses(const Segment& segment, const Eigen::VectorXd& start) const;
  void fail(std::size_t i, Status status, const std::string& reason);
  Eigen::VectorXd end_of(std::size_t i) const { return motions_[i].positions.bottomRows(1).transpose(); }

  PlannerInterface& planner_;
  const std::string& robot_;
  const std::vector<Segment>& segments_;
  const SetScene& set_scene_;
  const SequenceSearchOptions options_;
  const Deadline deadline_;
  const PlannerInterface::Interrupt& interrupt_;
  std::vector<Trajectory> motions_;
  std::vector<Scene> scenes_;
  std::map<std::vector<std::string>, std::shared_ptr<const RobotModel>> models_;  // by joints that are set
  int attempts_{}, alternatives_{};
  bool failed_{};
  std::size_t deepest_{};  // segment that was reached
  Status status_{Status::exhausted};
  std::string reason_;  // of what failed there
};

}  // namespace srmp
