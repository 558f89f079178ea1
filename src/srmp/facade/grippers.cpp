#include "srmp/facade/grippers.hpp"

#include <algorithm>

#include "srmp/collision/checker.hpp"
#include "srmp/core/error.hpp"

namespace srmp {

namespace {

const EndEffector& end_effector_of(const RobotModel& robot, const std::string& name) {
  std::vector<std::string> known;
  for (const EndEffector& each : robot.end_effectors()) {
    if (each.name == name || (name.empty() && robot.end_effectors().size() == 1)) return each;
    known.push_back(each.name);
  }
  const std::string of = "robot '" + robot.name() + "'";
  if (known.empty()) throw InvalidArgument(of + " has no end effector in its SRDF; set joints by name instead");
  if (name.empty()) throw InvalidArgument(of + " has several end effectors; name one of " + quoted_list(known));
  const std::string hint = did_you_mean(name, known);
  throw InvalidArgument(of + " has no end effector '" + name + "' in its SRDF" +
                        (hint.empty() ? "; known are " + quoted_list(known) : hint));
}

std::vector<std::string> states_of(const EndEffector& effector) {
  std::vector<std::string> known;
  for (const auto& [state, positions] : effector.states) known.push_back(state);
  for (const char* state : {"close", "open"})
    if (effector.opening && !effector.states.contains(state)) known.emplace_back(state);
  return known;
}

std::map<std::string, double> at_width(const EndEffector& effector, double width) {
  const std::string of = "end effector '" + effector.name + "'";
  if (!effector.opening)
    throw InvalidArgument(of + " has no opening width, because it has no two fingers that slide against each other; " +
                          "name a state" +
                          (effector.states.empty() ? "" : " instead: " + quoted_list(states_of(effector))));
  const GripperOpening& opening = *effector.opening;
  if (!(width >= 0.0 && width <= opening.max_width))
    throw InvalidArgument("width of " + of + " is " + to_text(width) + " m; allowed is 0 to " +
                          to_text(opening.max_width));
  std::map<std::string, double> positions;
  for (const auto& [joint, closed] : opening.closed)
    positions[joint] = closed + width / opening.max_width * (opening.opened.at(joint) - closed);
  return positions;
}

}  // namespace

std::map<std::string, double> gripper_positions(const RobotModel& robot, const Segment& segment) {
  const EndEffector& effector = end_effector_of(robot, segment.end_effector);
  if (segment.width && !segment.state.empty()) throw InvalidArgument("a gripper is given either a state or a width");
  if (segment.width) return at_width(effector, *segment.width);
  const auto state = effector.states.find(segment.state);
  if (state != effector.states.end()) return state->second;
  if (effector.opening && segment.state == "open") return effector.opening->opened;
  if (effector.opening && segment.state == "close") return effector.opening->closed;
  const std::vector<std::string> known = states_of(effector);
  const std::string hint = did_you_mean(segment.state, known);
  throw InvalidArgument("end effector '" + effector.name + "' has no state '" + segment.state + "' in the SRDF" +
                        (!hint.empty()   ? hint
                         : known.empty() ? ""
                                         : "; known are " + quoted_list(known)));
}

std::shared_ptr<const RobotModel> with_planned_joints(const RobotModel& robot, const std::vector<std::string>& joints) {
  RobotDescription description = robot.self_contained_description();
  description.group.clear();
  description.end_effector.clear();
  description.joint_names = joints;
  description.strict = false;  // what the files lack was accepted for the robot
  for (const std::string& joint : joints) description.fixed_joints.erase(joint);
  return RobotModel::load(description);
}

namespace {

std::map<std::string, double> joint_positions(const RobotInstance& robot) {
  std::map<std::string, double> positions;
  for (std::size_t j = 0; j < robot.model->dof(); ++j)
    positions[robot.model->joint_names()[j]] = robot.q[static_cast<Eigen::Index>(j)];
  const std::vector<Joint>& others = robot.model->other_joints();
  for (std::size_t j = 0; j < others.size(); ++j)
    positions[others[j].name] = robot.other_positions[static_cast<Eigen::Index>(j)];
  return positions;
}

/// The scene with another model of a robot, which stands as it did, holds what it held and may touch what it might.
Scene with_model(const Scene& scene, const std::string& name, std::shared_ptr<const RobotModel> model) {
  const RobotInstance& before = scene.robot(name);
  Scene changed = scene;
  changed.remove_robot(name);
  changed.add_robot(std::move(model), before.base);
  changed.set_robot_padding(name, before.padding);
  changed.set_joint_positions(name, joint_positions(before));
  for (const auto& [object, attachment] : scene.attachments())
    if (attachment.robot == name)
      changed.attach_object(object, name, attachment.link,
                            {attachment.touch_links.begin(), attachment.touch_links.end()}, scene.object(object).pose);
  // The contacts that each model samples for want of an SRDF differ: those of the robot itself count.
  const std::vector<std::pair<std::string, std::string>> sampled = changed.robot(name).model->always_colliding();
  for (const auto& pairs : {sampled, before.model->always_colliding()})
    for (const auto& [a, b] : pairs)
      changed.set_allowed_collision(name + "/" + a, name + "/" + b, before.model->allowed(a, b));
  for (const auto& [pair, allowed] : scene.allowed_settings())
    changed.set_allowed_collision(pair.first, pair.second, allowed);
  return changed;
}

}  // namespace

bool is_finger_motion_free(const Scene& scene, const std::string& robot, std::shared_ptr<const RobotModel> model,
                           const std::map<std::string, double>& positions) {
  const Scene changed = with_model(scene, robot, std::move(model));
  const RobotInstance& fingers = changed.robot(robot);
  Eigen::VectorXd to = fingers.q;
  for (Eigen::Index j = 0; j < to.size(); ++j)
    to[j] = positions.at(fingers.model->joint_names()[static_cast<std::size_t>(j)]);
  const auto checker = make_checker(changed, robot, {.mode = CheckMode::coal});
  const auto workspace = checker->make_workspace();
  return checker->is_motion_free(fingers.q, to, *workspace);
}

}  // namespace srmp
