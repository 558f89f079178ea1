#include "srmp/planning/endpoints/ik_goal_connection.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace srmp {

namespace {

struct ConnectionTarget {
  IkGoal goal;
  double max_distance;  // [m]
  int number;
};

class IkGoalConnection {
 public:
  IkGoalConnection(const PlacedRobot& robot, const Eigen::VectorXd& step)
      : robot_(*robot.model),
        step_(step),
        link_(robot_.link_index(robot_.end_effector())),
        data_(robot_.make_data(robot.other_positions).release(), RobotDataDeleter{}) {
    for (std::size_t j = 0; j < robot_.dof(); ++j) {
      const bool prismatic = robot_.joints()[j].kind == JointKind::prismatic;
      double& largest = prismatic ? slide_ : turn_;
      largest = std::max(largest, step[static_cast<Eigen::Index>(j)]);
    }
  }

  void add(IkGoal goal, int number) {
    goal.options.seeds = goal.options.max_solutions = 1;
    goal.options.max_iterations = 20;
    const double max_distance = turn_ * goal.in_base.p.norm() + slide_;
    targets_.push_back({std::move(goal), max_distance, number});
  }

  std::vector<ConnectedGoal> operator()(const Eigen::VectorXd& q) const {
    robot_.forward(*data_, q);
    const Eigen::Isometry3d end_effector = robot_.link_pose(*data_, link_);
    std::vector<ConnectedGoal> found;
    for (const ConnectionTarget& target : targets_) {
      if (!is_near(end_effector, target)) continue;
      for (const Eigen::VectorXd& there : inverse_kinematics(robot_, target.goal.in_base, q, target.goal.options))
        if ((robot_.difference(q, there).array().abs() <= 2.0 * step_.array()).all())
          found.push_back({there, target.number});
    }
    return found;
  }

 private:
  bool is_near(const Eigen::Isometry3d& end_effector, const ConnectionTarget& target) const {
    const Pose& goal_pose = target.goal.in_base;
    const IkOptions& options = target.goal.options;
    const Eigen::Vector3d offset = goal_pose.q.conjugate() * (end_effector.translation() - goal_pose.p);
    bool turned = false;  // orientations with free axes are left to inverse kinematics
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (!options.position_tolerance.is_free(axis) && std::abs(offset[axis]) > target.max_distance) return false;
      turned |= options.rotation_tolerance.is_free(axis);
    }
    return turned || goal_pose.q.angularDistance(Eigen::Quaterniond(end_effector.linear())) <= 2.0 * turn_;
  }

  const RobotModel& robot_;
  Eigen::VectorXd step_;
  std::size_t link_;
  std::shared_ptr<RobotData> data_;
  double turn_{0.0}, slide_{0.0};
  std::vector<ConnectionTarget> targets_;
};

}  // namespace

IkGoal ik_goal(const GoalConstraint& goal, const Eigen::VectorXd& target, const PlacedRobot& robot) {
  const bool position_only = goal.type == GoalType::position;
  const Pose world = position_only ? Pose{target, Eigen::Quaterniond::Identity()}
                                   : Pose::from_list({target.data(), static_cast<std::size_t>(target.size())});
  IkGoal result{robot.base.inverse() * world, {}};
  IkOptions& options = result.options;
  options.other_positions = robot.other_positions;
  options.position_tolerance = goal.position_tolerance.tightened(options.position_tolerance.axes[0]);
  options.rotation_tolerance = position_only ? AxisTolerance(search::infinity)
                                             : goal.rotation_tolerance.tightened(options.rotation_tolerance.axes[0]);
  return result;
}

GoalConnection make_ik_goal_connection(const PlacedRobot& robot, const std::vector<GoalConstraint>& goals,
                                       const Eigen::VectorXd& step) {
  const auto by_joints = [](const GoalConstraint& goal) { return goal.type == GoalType::joints; };
  if (std::all_of(goals.begin(), goals.end(), by_joints)) return {};
  IkGoalConnection connection(robot, step);
  int number = 0;
  for (const GoalConstraint& goal : goals)
    for (const Eigen::VectorXd& target : goal.targets) {
      if (!by_joints(goal)) connection.add(ik_goal(goal, target, robot), number);
      ++number;
    }
  return connection;
}

}  // namespace srmp
