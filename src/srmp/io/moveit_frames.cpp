#include "srmp/io/moveit_frames.h"

#include <algorithm>

#include "srmp/core/error.hpp"

namespace srmp::io {

namespace {

bool has_link(const RobotInstance& robot, const std::string& link) {
  const std::vector<std::string>& links = robot.model->link_names();
  return std::find(links.begin(), links.end(), link) != links.end();
}

bool agree(const Pose& a, const Pose& b) {
  constexpr double tolerance = 1e-6;  // [m, rad]: files hold rounded numbers
  return (a.p - b.p).norm() <= tolerance && a.q.angularDistance(b.q) <= tolerance;
}

}  // namespace

FrameLookup::FrameLookup(const Scene& scene, const Pose& planning_frame, std::string robot)
    : scene_(scene), planning_frame_(planning_frame), robot_(std::move(robot)) {}

void FrameLookup::set_configuration(const std::string& robot, const Eigen::VectorXd& q) {
  configurations_.insert_or_assign(robot, q);
}

void FrameLookup::define(const std::vector<FixedFrame>& frames) {
  // MoveIt always writes one from the planning frame to itself, which tells the name of the planning frame.
  for (const FixedFrame& fixed : frames)
    if (fixed.frame == fixed.child && !find(fixed.frame) && agree(fixed.pose, {}))
      fixed_.emplace(fixed.frame, planning_frame_);
  for (const FixedFrame& fixed : frames) define(fixed);
}

void FrameLookup::define(const FixedFrame& fixed) {
  const auto frame = find(fixed.frame), child = find(fixed.child);
  if (!frame && !child)
    throw InvalidArgument("a fixed frame is between '" + fixed.frame + "' and '" + fixed.child +
                          "', which are both unknown" + did_you_mean(fixed.child, known_names()));
  if (child && !frame)
    fixed_.emplace(fixed.frame, child->pose * fixed.pose);
  else if (frame && !child)
    fixed_.emplace(fixed.child, frame->pose * fixed.pose);
  else if (!agree(frame->pose, child->pose * fixed.pose) && !agree(child->pose, frame->pose * fixed.pose))
    throw InvalidArgument("a fixed frame is between '" + fixed.frame + "' and '" + fixed.child +
                          "', which are both known and stand differently");
}

bool FrameLookup::is_planning_frame(const std::string& name) const {
  return name.empty() || name == "world" ||
         std::any_of(scene_.robots().begin(), scene_.robots().end(), [&](const auto& entry) {
           const auto& joint = entry.second.model->virtual_joint();
           return joint && joint->parent_frame == name;
         });
}

std::optional<Frame> FrameLookup::find(const std::string& name) const {
  if (name.starts_with('/')) return find(name.substr(1));
  if (const auto link = find_link(name)) return link;
  if (const auto in_objects = find_in_objects(name)) return in_objects;
  if (const auto fixed = fixed_.find(name); fixed != fixed_.end()) return Frame{fixed->second, "", ""};
  if (is_planning_frame(name)) return Frame{planning_frame_, "", ""};
  return std::nullopt;
}

std::optional<Frame> FrameLookup::find_link(const std::string& name) const {
  std::vector<Frame> found;
  for (const auto& [robot, instance] : scene_.robots()) {
    const bool full = name.starts_with(robot + "/");
    const std::string link = full ? name.substr(robot.size() + 1) : name;
    if (!has_link(instance, link)) continue;
    Frame frame{link_pose(robot, link), robot, link};
    if (full || robot == robot_) return frame;
    found.push_back(std::move(frame));
  }
  if (found.size() > 1)
    throw InvalidArgument("link '" + name + "' is in the robots '" + found[0].robot + "' and '" + found[1].robot +
                          "'; write '" + found[0].robot + "/" + name + "'");
  return found.empty() ? std::nullopt : std::optional(found[0]);
}

std::optional<Frame> FrameLookup::find_in_objects(const std::string& name) const {
  for (const auto& [id, group] : scene_.groups()) {
    if (name == id) return of_object(group.objects.front(), group.frame);
    if (!name.starts_with(id + "/")) continue;
    const auto subframe = group.subframes.find(name.substr(id.size() + 1));
    if (subframe != group.subframes.end()) return of_object(group.objects.front(), group.frame * subframe->second);
  }
  if (scene_.objects().contains(name)) return of_object(name, {});
  return std::nullopt;
}

Frame FrameLookup::of_object(const std::string& object, const Pose& in_object) const {
  const auto attached = scene_.attachments().find(object);
  Frame frame{object_pose(object) * in_object, "", ""};
  if (attached != scene_.attachments().end()) {
    frame.robot = attached->second.robot;
    frame.link = attached->second.link;
  }
  return frame;
}

Frame FrameLookup::require(const std::string& name, const std::string& what) const {
  if (const auto frame = find(name)) return *frame;
  throw InvalidArgument(what + " is in the unknown frame '" + name + "'" + did_you_mean(name, known_names()));
}

bool FrameLookup::moves(const Frame& frame) const {
  if (frame.robot.empty()) return false;
  const RobotModel& model = *scene_.robot(frame.robot).model;
  return model.link_support(model.link_index(frame.link)) != 0;
}

std::string FrameLookup::robot_of(const std::string& link, const std::string& what) const {
  if (const auto frame = find_link(link)) return frame->robot;
  std::vector<std::string> links;
  for (const auto& [name, robot] : scene_.robots())
    links.insert(links.end(), robot.model->link_names().begin(), robot.model->link_names().end());
  throw InvalidArgument(what + " the unknown link '" + link + "'" + did_you_mean(link, links));
}

Pose FrameLookup::link_pose(const std::string& robot, const std::string& link) const {
  const auto configuration = configurations_.find(robot);
  if (configuration == configurations_.end()) return scene_.link_pose(robot, link);
  const RobotInstance& instance = scene_.robot(robot);
  return instance.base * instance.model->compute_fk(configuration->second, link, instance.other_positions);
}

Pose FrameLookup::object_pose(const std::string& object) const {
  const auto attached = scene_.attachments().find(object);
  if (attached == scene_.attachments().end()) return scene_.object_pose(object);
  return link_pose(attached->second.robot, attached->second.link) * scene_.object(object).pose;
}

std::vector<std::string> FrameLookup::known_names() const {
  std::vector<std::string> names = scene_.object_names();
  for (const auto& [name, robot] : scene_.robots()) {
    names.insert(names.end(), robot.model->link_names().begin(), robot.model->link_names().end());
    if (const auto& joint = robot.model->virtual_joint()) names.push_back(joint->parent_frame);
  }
  for (const auto& [id, group] : scene_.groups()) {
    names.push_back(id);
    for (const auto& [subframe, pose] : group.subframes) names.push_back(id + "/" + subframe);
  }
  for (const auto& [name, pose] : fixed_) names.push_back(name);
  names.emplace_back("world");
  return names;
}

}  // namespace srmp::io
