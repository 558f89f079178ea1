#pragma once

#include <vector>

#include "srmp/planning/world_paths.hpp"

namespace srmp {

/// Robots as one robot with all their joints: where it begins, where it may end, and which of its motions are free.
/// Robots whose goal is anywhere end where they start.
class CompositeSpace {
 public:
  /// Another robot, which stands still.
  struct Standing {
    std::size_t robot{};
    Eigen::VectorXd q;
  };
  using Others = std::vector<Standing>;
  /// The world outlives this.
  CompositeSpace(MultiRobotWorld& world, std::vector<std::size_t> robots, Others others = {});
  /// From and to where the robots are collision-free, whatever their tasks: a start and a goal of each.
  CompositeSpace(MultiRobotWorld& world, std::vector<std::size_t> robots, const std::vector<Eigen::VectorXd>& starts,
                 const std::vector<Eigen::VectorXd>& goals, Others others);

  std::size_t size() const { return robots_.size(); }
  const MultiRobotWorld& world() const { return world_; }
  const std::vector<Joint>& joints() const { return joints_; }
  const RobotModel& model(std::size_t i) const { return world_.model(robots_[i]); }
  const WorldTask& task(std::size_t i) const { return world_.task(robots_[i]); }
  Eigen::Index first(std::size_t i) const { return first_[i]; }  ///< joint of robot i; first(size()): of all
  const Eigen::VectorXd& start() const { return start_; }
  const std::vector<Eigen::VectorXd>& targets() const { return targets_; }  ///< goals of all robots, collision-free

  Eigen::VectorBlock<Eigen::VectorXd> part(Eigen::VectorXd& q, std::size_t i) const {
    return q.segment(first_[i], first_[i + 1] - first_[i]);
  }
  Eigen::VectorXd part(const Eigen::VectorXd& q, std::size_t i) const {
    return q.segment(first_[i], first_[i + 1] - first_[i]);
  }

  /// `a` is free. By exact geometry: robots often have to pass each other closely.
  bool is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;

  /// Is the configuration free of collisions with the others, which stand still?
  bool is_free_of_others(const Eigen::VectorXd& q) const;

  JointPath path(const std::vector<Eigen::VectorXd>& rows) const;
  /// Configurations along a path of these robots, and maybe others: its rows and some between.
  std::vector<Eigen::VectorXd> configurations(const JointPath& path) const;

 private:
  void add_joints();
  void add_targets(std::size_t i, Eigen::VectorXd q);

  MultiRobotWorld& world_;
  std::vector<std::size_t> robots_;
  Others others_;
  std::vector<Joint> joints_;
  std::vector<Eigen::Index> first_;
  Eigen::VectorXd start_;
  std::vector<Eigen::VectorXd> targets_;
};

}  // namespace srmp
