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
  if (name.empty() || name.find('\0') != std::string::npos)
    throw InvalidArgument("join_robots: the name of the joined robot is empty or has a zero byte");
  std::set<std::string> seen;
  for (const std::string& robot : robots) {
    scene.robot(robot);  // throws
    if (!seen.insert(robot).second) throw InvalidArgument("join_robots: robot '" + robot + "' is named twice");
  }
  for (const std::string& robot : robots)
    if (const double own = scene.robot(robot).padding, first = scene.robot(robots.front()).padding; own != first)
      throw InvalidArgument("join_robots: robot '" + robots.front() + "' has a padding of " + to_text(first) +
                            " m and robot '" + robot + "' one of " + to_text(own) +
                            " m, but one robot has one; give them the same by set_padding");
  if (scene.robots().contains(name) && !seen.contains(name))
    throw InvalidArgument("there is a robot '" + name + "' already; give another name");
}

/// A body of Scene::allowed_settings, and what it is called when the robots are one.
struct JoinedBody {
  std::string before, after;
  bool whole_robot{false};
};

/// Of a robot that is joined: each of its links.
std::vector<JoinedBody> joined_bodies(const Scene& scene, const std::string& name,
                                      const std::vector<std::string>& robots, const std::string& body) {
  if (scene.objects().contains(body)) return {{body, body}};
  const auto of_link = [&](const std::string& robot, const std::string& link) {
    return JoinedBody{robot + "/" + link, name + "/" + joined_name(robot, link)};
  };
  for (const std::string& robot : robots) {
    if (body.starts_with(robot + "/")) return {of_link(robot, body.substr(robot.size() + 1))};
    if (body != robot) continue;
    std::vector<JoinedBody> links;
    for (const std::string& link : scene.robot(robot).model->link_names()) links.push_back(of_link(robot, link));
    return links;
  }
  return {{body, body, scene.robots().contains(body)}};
}

/// Settings of whole robots become settings of their links. Of two that contradict each other one counts, as it did.
void allow_as_before(const Scene& before, const std::string& name, const std::vector<std::string>& robots,
                     Scene& joined) {
  for (const auto& [pair, allowed] : before.allowed_settings())
    for (const JoinedBody& a : joined_bodies(before, name, robots, pair.first))
      for (const JoinedBody& b : joined_bodies(before, name, robots, pair.second)) {
        if (a.before == b.before && !a.whole_robot) continue;
        const bool counts = a.whole_robot || b.whole_robot ? allowed : before.allowed_collision(a.before, b.before);
        joined.set_allowed_collision(a.after, b.after, counts);
      }
}

/// The scene with one robot in place of several, which stands as they did, holds what they held and may touch what
/// they might.
Scene with_joined(const Scene& scene, const std::string& name, const std::vector<std::string>& robots) {
  std::vector<RobotToJoin> parts;
  std::map<std::string, double> positions;
  Scene changed = scene;
  for (const std::string& robot : robots) {
    const RobotInstance& part = scene.robot(robot);
    parts.push_back({robot, *part.model, part.base, part.other_positions});
    for (std::size_t j = 0; j < part.model->dof(); ++j)
      positions[joined_name(robot, part.model->joint_names()[j])] = part.q[static_cast<Eigen::Index>(j)];
    changed.remove_robot(robot);
  }
  changed.add_robot(RobotModel::load(join_robots(name, parts)), {});
  changed.set_robot_padding(name, scene.robot(robots.front()).padding);
  changed.set_joint_positions(name, positions);
  for (const auto& [object, attachment] : scene.attachments()) {
    if (std::find(robots.begin(), robots.end(), attachment.robot) == robots.end()) continue;
    std::vector<std::string> touched;
    for (const std::string& link : attachment.touch_links) touched.push_back(joined_name(attachment.robot, link));
    changed.attach_object(object, name, joined_name(attachment.robot, attachment.link), touched,
                          scene.object(object).pose);
  }
  allow_as_before(scene, name, robots, changed);
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
  if (!limits.payload) return;
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
