// The forms of goals that plan accepts beside GoalConstraint, and what else PlannerInterface spares its users.
#include <algorithm>

#include "srmp/planner_interface.hpp"
#include "srmp/robot/joint_names.hpp"

namespace srmp {

namespace {

/// Positions by joint name; joints not named are at `rest`.
GoalConstraint by_name(const RobotModel& model, const std::map<std::string, double>& positions, Eigen::VectorXd rest) {
  const std::vector<std::string>& names = model.joint_names();
  const std::string goal = "goal of '" + model.name() + "'";
  if (positions.empty()) throw InvalidArgument(goal + " names no joint; planned are " + quoted_list(names));
  for (const auto& [joint, position] : positions) {
    const auto it = std::find(names.begin(), names.end(), joint);
    if (it != names.end()) {
      rest[it - names.begin()] = position;
      continue;
    }
    if (find_joint(model.other_joints(), joint))
      throw InvalidArgument(goal + ": joint '" + joint + "' is not planned; planned are " + quoted_list(names));
    const std::vector<std::string>& links = model.link_names();
    if (std::find(links.begin(), links.end(), joint) != links.end())
      throw InvalidArgument(goal + ": '" + joint + "' is a link, whose goal is a Pose; numbers are for joints");
    model.refuse_joint(joint);
  }
  require_finite({rest.data(), names.size()}, goal, names);
  return GoalConstraint::joints(rest);
}

/// Poses by link name.
GoalConstraint by_link(const RobotModel& model, const std::map<std::string, Pose>& poses) {
  const std::string goal = "goal of '" + model.name() + "'";
  if (poses.empty()) throw InvalidArgument(goal + " names no link; such as " + quoted_list(model.end_links()));
  const std::vector<std::string>& joints = model.joint_names();
  for (const auto& [link, pose] : poses)
    if (std::find(joints.begin(), joints.end(), link) != joints.end())
      throw InvalidArgument(goal + ": '" + link + "' is a joint, whose goal is a number; poses are for links");
  GoalConstraint constraint = GoalConstraint::poses(poses);
  for (const std::string& link : constraint.links) model.link_index(link);  // throws with the nearest name
  return constraint;
}

GoalConstraint by_state(const RobotModel& model, const std::string& state) {
  const auto it = model.group_states().find(state);
  if (it != model.group_states().end()) return GoalConstraint::joints(it->second);
  std::vector<std::string> known;
  for (const auto& [name, q] : model.group_states()) known.push_back(name);
  const std::string hint = did_you_mean(state, known);
  throw InvalidArgument("goal of '" + model.name() + "': there is no state '" + state +
                        "' of all its planned joints in the SRDF" +
                        (hint.empty() ? "; known are " + quoted_list(known) : hint));
}

}  // namespace

GoalConstraint PlannerInterface::goal(const std::string& robot, const Goal& goal,
                                      const std::optional<Eigen::VectorXd>& start) const {
  const RobotInstance& instance = scene().robot(robot);
  if (start) instance.model->require_configuration(*start, "start of '" + robot + "'");
  struct {
    const RobotModel& model;
    Eigen::VectorXd rest;
    GoalConstraint operator()(const GoalConstraint& constraint) const { return constraint; }
    GoalConstraint operator()(const Pose& pose) const { return GoalConstraint::pose(pose); }
    GoalConstraint operator()(const Eigen::VectorXd& q) const { return GoalConstraint::joints(q); }
    GoalConstraint operator()(const std::map<std::string, double>& positions) const {
      return by_name(model, positions, rest);
    }
    GoalConstraint operator()(const std::string& state) const { return by_state(model, state); }
    GoalConstraint operator()(const std::map<std::string, Pose>& poses) const { return by_link(model, poses); }
  } to_constraint{*instance.model, start.value_or(instance.q)};
  return std::visit(to_constraint, goal);
}

std::string PlannerInterface::only_robot() const {
  const std::vector<std::string> names = robot_names();
  if (names.size() == 1) return names[0];
  throw InvalidArgument("a plan without the name of its robot is for a scene with one robot; here " +
                        (names.empty() ? "is none, call add_articulation first" : "are " + quoted_list(names)));
}

Trajectory PlannerInterface::plan(const std::string& robot, ConstVector start, const Goal& goal,
                                  const Interrupt& interrupt, const OnSolution& on_solution) {
  return plan(robot, start, std::vector{this->goal(robot, goal, start)}, interrupt, on_solution);
}

Trajectory PlannerInterface::plan(ConstVector start, const Goal& goal, const Interrupt& interrupt,
                                  const OnSolution& on_solution) {
  return plan(only_robot(), start, goal, interrupt, on_solution);
}

const std::vector<std::string>& PlannerInterface::warnings(const std::string& robot) const {
  return this->robot(robot).warnings();
}

}  // namespace srmp
