#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "srmp/facade/planner_impl.hpp"
#include "srmp/planner_interface.hpp"
#include "srmp/robot/joined_robots.hpp"
#include "srmp/trajectory/joint_torques.hpp"

namespace srmp {

namespace {

void require_to_join(const Scene& scene, const std::string& name, const std::vector<std::string>& robots) {
  if (robots.size() < 2)
    throw InvalidArgument("join_robots: " + std::to_string(robots.size()) + " robots are given; it takes two or more");
  std::set<std::string> seen;
  for (const std::string& robot : robots) {
    scene.robot(robot);  // throws
    if (!seen.insert(robot).second) throw InvalidArgument("join_robots: robot '" + robot + "' is named twice");
  }
  if (scene.robots().contains(name) && !seen.contains(name))
    throw InvalidArgument("there is a robot '" + name + "' already; give another name");
}

/// What a body of the scene is called when the robots are one: entries of Scene::allowed_settings.
std::vector<std::string> joined_bodies(const Scene& scene, const std::string& name,
                                       const std::vector<std::string>& robots, const std::string& body) {
  if (scene.objects().contains(body)) return {body};
  for (const std::string& robot : robots) {
    if (body.starts_with(robot + "/")) return {name + "/" + joined_name(robot, body.substr(robot.size() + 1))};
    if (body != robot) continue;
    std::vector<std::string> links;
    for (const std::string& link : scene.robot(robot).model->link_names())
      links.push_back(name + "/" + joined_name(robot, link));
    return links;
  }
  return {body};
}

/// The scene with one robot in place of several, which stands as they did, holds what they held and may touch what
/// they might.
Scene with_joined(const Scene& scene, const std::string& name, const std::vector<std::string>& robots) {
  std::vector<RobotToJoin> parts;
  double padding = 0.0;
  std::map<std::string, double> positions;
  Scene changed = scene;
  for (const std::string& robot : robots) {
    const RobotInstance& part = scene.robot(robot);
    parts.push_back({robot, *part.model, part.base, part.other_positions});
    padding = std::max(padding, part.padding);
    for (std::size_t j = 0; j < part.model->dof(); ++j)
      positions[joined_name(robot, part.model->joint_names()[j])] = part.q[static_cast<Eigen::Index>(j)];
    changed.remove_robot(robot);
  }
  changed.add_robot(RobotModel::load(join_robots(name, parts)), {});
  changed.set_robot_padding(name, padding);
  changed.set_joint_positions(name, positions);
  for (const auto& [object, attachment] : scene.attachments()) {
    if (std::find(robots.begin(), robots.end(), attachment.robot) == robots.end()) continue;
    std::vector<std::string> touched;
    for (const std::string& link : attachment.touch_links) touched.push_back(joined_name(attachment.robot, link));
    changed.attach_object(object, name, joined_name(attachment.robot, attachment.link), touched,
                          scene.object(object).pose);
  }
  for (const auto& [pair, allowed] : scene.allowed_settings())
    for (const std::string& a : joined_bodies(scene, name, robots, pair.first))
      for (const std::string& b : joined_bodies(scene, name, robots, pair.second))
        if (a != b) changed.set_allowed_collision(a, b, allowed);
  return changed;
}

void append(Eigen::VectorXd& values, const Eigen::VectorXd& more) {
  const Eigen::Index size = values.size();
  values.conservativeResize(size + more.size());
  values.tail(more.size()) = more;
}

/// Appends the limits of one robot's joints and links.
void append(MotionLimits& joined, const MotionLimits& limits, const std::string& robot, const RobotModel& model) {
  append(joined.velocity, limits.velocity);
  append(joined.acceleration, limits.acceleration);
  append(joined.jerk, limits.jerk);
  append(joined.torque, limits.torque.size() > 0 ? limits.torque
                                                 : Eigen::VectorXd::Constant(limits.velocity.size(),
                                                                             std::numeric_limits<double>::infinity()));
  for (const Joint& joint : model.joints()) joined.continuous.push_back(joint.kind == JointKind::continuous);
  for (LinkSpeedLimit limit : limits.link_speeds) {
    limit.link = joined_name(robot, limit.link.empty() ? model.end_effector() : limit.link);
    joined.link_speeds.push_back(std::move(limit));
  }
  if (!limits.payload || limits.torque.size() == 0) return;
  if (joined.payload)
    throw InvalidArgument(
        "join_robots: more than one of the robots has a payload for its torques; set one of them to " +
        std::string("carry nothing, and give the joined robot the payload of both"));
  joined.payload = limits.payload;
  joined.payload->link = joined_name(robot, limits.payload->link.empty() ? model.end_effector() : limits.payload->link);
}

}  // namespace

void PlannerInterface::join_robots(const std::string& name, const std::vector<std::string>& robots) {
  const std::string joined_robot = name;  // the caller's strings may live in what is removed
  const std::vector<std::string> parts = robots;
  require_to_join(impl_->scene, joined_robot, parts);
  const auto is_part = [&](const std::string& robot) {
    return std::find(parts.begin(), parts.end(), robot) != parts.end();
  };
  std::optional<MotionLimits> limits;
  if (std::any_of(parts.begin(), parts.end(),
                  [&](const auto& robot) { return impl_->motion_limits.contains(robot); })) {
    limits.emplace();
    for (const std::string& robot : parts) append(*limits, impl_->limits_of(robot), robot, impl_->model(robot));
    if (!(limits->torque.array() < std::numeric_limits<double>::infinity()).any()) limits->torque.resize(0);
  }
  Scene joined = with_joined(impl_->scene, joined_robot, parts);
  if (limits) require_bounds_of_robot(*limits, *joined.robot(joined_robot).model);
  impl_->change([&](Scene& scene) { scene = std::move(joined); });
  impl_->forget(is_part);
  if (limits) impl_->motion_limits.insert_or_assign(joined_robot, std::move(*limits));
}

}  // namespace srmp
