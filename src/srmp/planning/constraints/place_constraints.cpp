#include "srmp/planning/constraints/place_constraints.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

class Placement {
 public:
  Placement(const Scene& scene, const std::string& robot, const std::vector<std::string>& moving)
      : scene_(scene), name_(robot), robot_(scene.robot(robot)), model_(*robot_.model), moving_(moving) {}

  PlacedConstraint place(const PathConstraint& constraint) const {
    constraint.validate();
    PlacedConstraint placed;
    placed.constraint = constraint;
    placed.constraint.axis.normalize();
    const auto [link, in_link] = body(constraint.link);
    placed.link = link;
    placed.body = in_link.isometry() * Eigen::Translation3d(constraint.point);
    set_frame(constraint, placed);
    const std::uint64_t of_frame = placed.frame ? model_.link_support(*placed.frame) : 0;
    placed.text = describe(constraint);
    if (model_.link_support(link) == of_frame)
      throw InvalidArgument("the path constraint '" + placed.text + "' cannot be planned for: no planned joint of '" +
                            name_ + "' changes it");
    return placed;
  }

 private:
  /// A link of the robot, and a pose in its frame.
  using Body = std::pair<std::size_t, Pose>;

  Body body(const std::string& name) const {
    if (name.empty()) return {model_.link_or_end_effector(name), {}};
    if (const auto held = held_object(name)) return *held;
    if (scene_.objects().contains(name))
      throw InvalidArgument("a path constraint is about the object '" + name + "', which '" + name_ +
                            "' does not hold");
    if (const std::string other = name.substr(0, name.find('/'));
        other != name && other != name_ && scene_.robots().contains(other))
      throw InvalidArgument("a path constraint of '" + name_ + "' is about '" + name +
                            "', a link of another robot; it can be about links of '" + name_ +
                            "' and objects that it holds");
    return {model_.link_index(own(name)), {}};  // throws with the nearest name
  }

  std::optional<Body> held_object(const std::string& name) const {
    const auto attachment = scene_.attachments().find(name);
    if (attachment == scene_.attachments().end() || attachment->second.robot != name_) return std::nullopt;
    return Body{model_.link_index(attachment->second.link), scene_.object(name).pose};
  }

  /// "link" of "robot/link"
  std::string own(const std::string& name) const {
    return name.starts_with(name_ + "/") ? name.substr(name_.size() + 1) : name;
  }

  void set_frame(const PathConstraint& constraint, PlacedConstraint& placed) const {
    const std::string& frame = constraint.frame;
    const Pose target{constraint.target.p, constraint.target.q.normalized()};
    const auto in_world = [&](const Pose& pose) { placed.target = (robot_.base.inverse() * pose * target).isometry(); };
    const auto& links = model_.link_names();
    if (frame.empty()) return in_world({});
    if (const auto held = held_object(frame)) {
      placed.frame = held->first;
      placed.target = (held->second * target).isometry();
    } else if (scene_.objects().contains(frame)) {
      const auto held_by = scene_.attachments().find(frame);
      if (held_by != scene_.attachments().end()) require_still(held_by->second.robot, frame);
      in_world(scene_.object_pose(frame));
    } else if (std::find(links.begin(), links.end(), own(frame)) != links.end()) {
      placed.frame = model_.link_index(own(frame));
      placed.target = target.isometry();
    } else {
      in_world(link_of_other_robot(frame));
    }
  }

  Pose link_of_other_robot(const std::string& frame) const {
    const std::size_t slash = frame.find('/');
    if (slash != std::string::npos) {
      require_still(frame.substr(0, slash), frame);
      return scene_.link_pose(frame.substr(0, slash), frame.substr(slash + 1));
    }
    std::vector<std::string> known = model_.link_names();
    for (const std::string& name : scene_.object_names()) known.push_back(name);
    throw InvalidArgument("a path constraint has the frame '" + frame + "', which is neither a link of '" + name_ +
                          "', nor an object, nor a link of another robot as 'robot/link'" + did_you_mean(frame, known));
  }

  void require_still(const std::string& robot, const std::string& frame) const {
    if (std::find(moving_.begin(), moving_.end(), robot) == moving_.end()) return;
    throw InvalidArgument("a path constraint of '" + name_ + "' has the frame '" + frame + "', which moves with '" +
                          robot + "' at the same time; frames can be the world, links of '" + name_ +
                          "', and links and objects that stand still");
  }

  /// "the z axis of 'hand' within 5 degrees of its direction in the world"
  std::string describe(const PathConstraint& c) const {
    const std::string link = "'" + (c.link.empty() ? model_.end_effector() : c.link) + "'";
    const std::string frame = c.frame.empty() ? "" : " in the frame of '" + c.frame + "'";
    const auto metres = [](double value) { return to_text(std::round(1e6 * value) / 1e6) + " m"; };
    switch (c.type) {
      case PathConstraintType::cone:
        return "an axis of " + link + " within " + to_text(std::round(c.tolerance * 18e5 / M_PI) / 1e4) + " degrees" +
               frame;
      case PathConstraintType::orientation: return "the orientation of " + link + frame;
      case PathConstraintType::pose: return "the pose of " + link + frame;
      case PathConstraintType::box: return link + " in a box" + frame;
      case PathConstraintType::plane: return link + " within " + metres(c.tolerance) + " of a plane" + frame;
      case PathConstraintType::line: return link + " within " + metres(c.tolerance) + " of a line" + frame;
      case PathConstraintType::distance:
        return link + " between " + metres(c.min_distance) + " and " + metres(c.max_distance) + " from a point" + frame;
    }
    return link;
  }

  const Scene& scene_;
  const std::string name_;
  const RobotInstance& robot_;
  const RobotModel& model_;
  const std::vector<std::string>& moving_;
};

}  // namespace

std::shared_ptr<const PlacedConstraints> place_constraints(const Scene& scene, const std::string& robot,
                                                           const std::vector<PathConstraint>& constraints,
                                                           const std::vector<std::string>& moving) {
  if (constraints.empty()) return nullptr;
  const Placement placement(scene, robot, moving);
  std::vector<PlacedConstraint> placed;
  for (const PathConstraint& constraint : constraints) placed.push_back(placement.place(constraint));
  const RobotInstance& instance = scene.robot(robot);
  return std::make_shared<const PlacedConstraints>(*instance.model, instance.other_positions, std::move(placed));
}

}  // namespace srmp
