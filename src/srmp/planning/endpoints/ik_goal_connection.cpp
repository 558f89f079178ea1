#include "srmp/planning/endpoints/ik_goal_connection.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace srmp {

namespace {

struct ConnectionTarget {
  IkGoal goal;
  std::size_t link;
  double max_distance;  // [m]
  int number;
};

class IkGoalConnection {
 public:
  IkGoalConnection(const PlacedRobot& robot, const Eigen::VectorXd& step)
      : robot_(*robot.model),
        step_(step),
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
    const std::size_t link = robot_.link_or_end_effector(goal.link);
    targets_.push_back({std::move(goal), link, max_distance, number});
  }

  std::vector<ConnectedGoal> operator()(const Eigen::VectorXd& q) const {
    robot_.forward(*data_, q);
    std::vector<ConnectedGoal> found;
    for (const ConnectionTarget& target : targets_) {
      const IkGoal& goal = target.goal;
      if (!is_near(robot_.link_pose(*data_, target.link), target)) continue;
      for (const Eigen::VectorXd& there : inverse_kinematics(robot_, goal.in_base, q, goal.options, goal.link))
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
  std::shared_ptr<RobotData> data_;
  double turn_{0.0}, slide_{0.0};
  std::vector<ConnectionTarget> targets_;
};

}  // namespace

std::vector<IkGoal> ik_goals(const GoalConstraint& goal, const Eigen::VectorXd& target, const PlacedRobot& robot) {
  const bool position_only = goal.type == GoalType::position;
  IkOptions options;
  options.other_positions = robot.other_positions;
  options.position_tolerance = goal.position_tolerance.tightened(options.position_tolerance.axes[0]);
  options.rotation_tolerance = position_only ? AxisTolerance(search::infinity)
                                             : goal.rotation_tolerance.tightened(options.rotation_tolerance.axes[0]);
  const std::size_t links = std::max<std::size_t>(1, goal.links.size());
  const std::size_t each = static_cast<std::size_t>(target.size()) / links;
  std::vector<IkGoal> result;
  for (std::size_t i = 0; i < links; ++i) {
    const std::span<const double> numbers(target.data() + i * each, each);
    const Pose world = position_only ? Pose{Eigen::Vector3d(numbers.data()), Eigen::Quaterniond::Identity()}
                                     : Pose::from_list(numbers);
    result.push_back({goal.links.empty() ? "" : goal.links[i], robot.base.inverse() * world, options});
  }
  return result;
}

std::vector<Eigen::VectorXd> all_solutions(const RobotModel& robot, const IkGoal& target,
                                           const Eigen::VectorXd& reference, const Deadline& deadline) {
  IkOptions options = target.options;
  options.max_solutions = options.seeds;
  return inverse_kinematics(robot, target.in_base, reference, options, target.link, deadline);
}

GoalConnection make_ik_goal_connection(const PlacedRobot& robot, const std::vector<GoalConstraint>& goals,
                                       const Eigen::VectorXd& step) {
  const auto is_left_out = [](const GoalConstraint& g) { return g.type == GoalType::joints || g.links.size() > 1; };
  if (std::all_of(goals.begin(), goals.end(), is_left_out)) return {};
  IkGoalConnection connection(robot, step);
  int number = 0;
  for (const GoalConstraint& goal : goals)
    for (const Eigen::VectorXd& target : goal.targets) {
      if (!is_left_out(goal)) connection.add(ik_goals(goal, target, robot).front(), number);
      ++number;
    }
  return connection;
}

}  // namespace srmp
