#include "srmp/moveit_request.hpp"

#include <algorithm>
#include <set>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

std::string where(const io::RequestFile& request) { return request.path + ": "; }

GoalConstraint joint_goal(const RobotModel& robot, const io::RequestFile& request, const io::GoalAlternative& goal) {
  const std::vector<std::string>& names = robot.joint_names();
  Eigen::VectorXd q(static_cast<Eigen::Index>(names.size()));
  std::set<std::string> missing(names.begin(), names.end());
  for (const io::JointConstraint& constraint : goal.joints) {
    const auto it = std::find(names.begin(), names.end(), constraint.joint);
    if (it == names.end())
      throw InvalidArgument(where(request) + "the goal names joint '" + constraint.joint +
                            "', which is not a planned joint of '" + robot.name() + "'" +
                            did_you_mean(constraint.joint, names));
    q[it - names.begin()] = constraint.position;
    missing.erase(constraint.joint);
  }
  if (!missing.empty())
    throw NotSupported(where(request) + "the goal leaves joint '" + *missing.begin() +
                       "' free; joint goals must give every planned joint");
  return GoalConstraint::joints(q);
}

GoalConstraint pose_goal(const RobotModel& robot, const io::RequestFile& request, const io::GoalAlternative& goal) {
  if (goal.positions.size() != 1 || goal.orientations.size() > 1)
    throw NotSupported(where(request) +
                       "a pose goal needs one position constraint and at most one orientation constraint");
  const io::PositionConstraint& position = goal.positions[0];
  if (position.link != robot.end_effector())
    throw InvalidArgument(where(request) + "the goal is for link '" + position.link + "', but goals of '" +
                          robot.name() + "' are for its end effector '" + robot.end_effector() + "'");
  GoalConstraint result = GoalConstraint::position(position.pose.p);
  if (!goal.orientations.empty()) {
    result = GoalConstraint::pose({position.pose.p, goal.orientations[0].orientation});
    Eigen::Vector3d tolerance = goal.orientations[0].tolerance.cwiseMax(1e-4);
    for (double& axis : tolerance)
      if (axis >= M_PI) axis = INFINITY;  // any angle
    result.rotation_tolerance = tolerance;
  }
  if (const auto* sphere = std::get_if<Sphere>(&position.region)) result.position_tolerance = sphere->radius;
  if (const auto* box = std::get_if<Box>(&position.region)) result.position_tolerance = 0.5 * box->size.minCoeff();
  return result;
}

}  // namespace

MoveItProblem apply_moveit_request(PlannerInterface& planner, const std::string& robot,
                                   const io::RequestFile& request) {
  const RobotModel& model = planner.robot(robot);
  MoveItProblem problem{planner.scene().robot(robot).q, {}, {}};
  for (const io::GoalAlternative& goal : request.goals)
    problem.goals.push_back(goal.joints.empty() ? pose_goal(model, request, goal) : joint_goal(model, request, goal));
  std::map<std::string, double> others;
  for (const auto& [name, position] : request.start_state.joints) {
    const auto planned = std::find(model.joint_names().begin(), model.joint_names().end(), name);
    const bool other = std::any_of(model.other_joints().begin(), model.other_joints().end(),
                                   [&](const Joint& joint) { return joint.name == name; });
    if (planned != model.joint_names().end())
      problem.start[planned - model.joint_names().begin()] = position;
    else if (other)
      others[name] = position;
    else
      problem.ignored_joints.push_back(name);
  }
  if (!others.empty()) planner.set_joint_positions(robot, others);
  if (!request.start_state.attached.empty()) planner.attach_moveit_objects(request);
  return problem;
}

}  // namespace srmp
