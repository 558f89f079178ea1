#include "srmp/collision/checker.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <mutex>
#include <utility>

#include "srmp/collision/narrow_phase.hpp"
#include "srmp/collision/robot_group.hpp"
#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/core/lengths.hpp"

namespace srmp {

using detail::RobotGroup;

namespace {

constexpr int samples_per_deadline_check = 32;

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g mm", 1e3 * metres);
  return text;
}

const char* kind_text(BodyKind kind) {
  switch (kind) {
    case BodyKind::link: return "link '";
    case BodyKind::object: return "object '";
    case BodyKind::attached_object: return "attached object '";
  }
  return "'";
}

std::vector<std::string> with_other_robots(const std::string& robot, std::vector<std::string> names) {
  names.insert(names.begin(), robot);
  return names;
}

}  // namespace

std::string Contact::describe() const {
  const std::string pair = kind_text(kind_a) + body_a + "' and " + kind_text(kind_b) + body_b + "'";
  const double unpadded = distance + padding;
  if (padding == 0.0 && std::abs(unpadded) <= detail::NarrowPhase::contact_distance) return pair + " touch";
  if (unpadded <= 0.0) return pair + " overlap by " + millimetres(-unpadded);
  if (distance <= 0.0)
    return pair + " are " + millimetres(unpadded) + " apart, less than their padding of " + millimetres(padding);
  return pair + " are " + millimetres(unpadded) + " apart";
}

/// The kinematics of the planned robots, and the bounding spheres of what moves with them.
struct Checker::Robots {
  /// A link's geometry or an attached object.
  struct Part {
    std::size_t robot{};      // of the group
    std::uint64_t support{};  // actuated joints of the group that move it
    double padding{};
    Eigen::Vector3d center;  // of its bounding sphere, in the frame of the geometry or the object
    double radius{};
    std::size_t source{};                        // index of the geometry, or of the link that holds the object
    std::optional<Eigen::Isometry3d> in_link{};  // of an attached object
  };

  Robots(const Scene& scene, const std::vector<std::string>& names) : group(scene, names) {
    for (std::size_t i = 0; i < group.size(); ++i) add_links(i);
    for (const auto& [name, attachment] : scene.attachments()) add_attached(scene.object(name), attachment);
  }

  void add_links(std::size_t robot) {
    const RobotInstance& instance = group.instance(robot);
    const std::vector<LinkGeometry>& geometries = instance.model->geometries();
    for (std::size_t i = 0; i < geometries.size(); ++i)
      parts.push_back({robot, group.support(robot, geometries[i].support), instance.padding, geometries[i].center,
                       geometries[i].radius, i});
  }

  void add_attached(const Object& object, const Attachment& attachment) {
    for (std::size_t i = 0; i < group.size(); ++i) {
      const RobotModel& model = group.model(i);
      if (model.name() != attachment.robot) continue;
      const std::size_t link = model.link_index(attachment.link);
      const detail::Bounds bounds = detail::bounds_of(*object.geometry);
      parts.push_back({i, group.support(i, model.link_support(link)), object.padding, bounds.center, bounds.radius,
                       link, object.pose.isometry()});
    }
  }

  Eigen::Vector3d center(const Part& part, const RobotGroup::Data& data) const {
    if (part.in_link) return group.link_pose(data, part.robot, part.source) * *part.in_link * part.center;
    return group.geometry_pose(data, part.robot, part.source) * part.center;
  }

  /// How far a prismatic joint gets from where it is at 0.
  double travel(const ActuatedJoint& actuated) const {
    const Joint& joint = group.joints()[actuated.joint];
    return actuated.prismatic ? std::abs(actuated.ratio) * std::max(std::abs(joint.lower), std::abs(joint.upper)) : 0.0;
  }

  RobotGroup::Data data_at_zero() const {
    RobotGroup::Data data = group.make_data();
    group.forward(data, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(group.joints().size())));
    return data;
  }

  /// The axes keep their distances as the joints turn, so a part is no farther from an axis than along the chain of
  /// axes to it, as it is at any one configuration, and what the prismatic joints between add. Calls
  /// at_axis(part, k, distance, axis) for every part and every actuated joint k that moves it, the distal ones first:
  /// no point of the part is ever farther than `distance` from the point `axis`, where the joint is.
  template <class AtAxis>
  void for_each_axis(const RobotGroup::Data& data, AtAxis&& at_axis) const {
    for (const Part& part : parts) {
      if (part.support == 0) continue;
      Eigen::Vector3d from = center(part, data);
      double distance = part.radius;
      for (int k = detail::deepest_actuated_joint(part.support); k >= 0;
           k = group.parent(static_cast<std::size_t>(k))) {
        const auto actuated = static_cast<std::size_t>(k);
        const Eigen::Vector3d axis = group.actuated_joint_axis(data, actuated).first;
        distance += (from - axis).norm();
        at_axis(part, actuated, distance, axis);
        distance += travel(group.actuated_joints()[actuated]);
        from = axis;
      }
    }
  }

  /// Checker::reach, which is computed once.
  const Eigen::VectorXd& reach() const {
    std::call_once(reach_known_, [this] { reach_ = farthest_points(); });
    return reach_;
  }

  RobotGroup group;
  std::vector<Part> parts;

 private:
  Eigen::VectorXd farthest_points() const {
    const std::vector<ActuatedJoint>& actuated_joints = group.actuated_joints();
    std::vector<double> farthest(actuated_joints.size(), 0.0);  // from the joint's axis
    for_each_axis(data_at_zero(), [&](const Part&, std::size_t k, double distance, const Eigen::Vector3d&) {
      farthest[k] = std::max(farthest[k], distance);
    });
    Eigen::VectorXd reach = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(group.joints().size()));
    for (std::size_t k = 0; k < actuated_joints.size(); ++k)
      reach[static_cast<Eigen::Index>(actuated_joints[k].joint)] +=
          std::abs(actuated_joints[k].ratio) * (actuated_joints[k].prismatic ? 1.0 : farthest[k]);
    return reach;
  }

  mutable std::once_flag reach_known_;
  mutable Eigen::VectorXd reach_;
};

// --- the public functions check

Checker::Checker(const Scene& scene, const std::string& robot, const CheckerOptions& options)
    : robots_(std::make_unique<const Robots>(scene, with_other_robots(robot, options.other_robots))),
      mode_(options.mode),
      clearance_(options.clearance) {
  if (!(options.clearance >= 0.0 && std::isfinite(options.clearance)))
    throw InvalidArgument("the clearance of a checker is " + to_text(options.clearance) + "; it must be 0 m or above");
}

Checker::~Checker() = default;

const RobotGroup& Checker::group() const { return robots_->group; }
const RobotModel& Checker::robot() const { return group().model(0); }
std::size_t Checker::dof() const { return group().joints().size(); }
const Pose& Checker::base() const { return group().instance(0).base; }
const Eigen::VectorXd& Checker::other_positions() const { return group().instance(0).other_positions; }

Checker::WorkspacePtr Checker::make_workspace() const {
  WorkspacePtr workspace = do_make_workspace();
  workspace->owner_ = this;
  return workspace;
}

void Checker::require_own(const Workspace& workspace) const {
  if (workspace.owner_ != this)
    throw InvalidArgument("this workspace was made by another checker; a checker needs one of its own make_workspace");
}

void Checker::require_motion(ConstVector a, ConstVector b, const Workspace& workspace) const {
  group().require_configuration(a, "start of the motion");
  group().require_configuration(b, "end of the motion");
  require_own(workspace);
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    const auto joint = static_cast<std::size_t>(i);
    if (std::abs(b[i] - a[i]) <= max_joint_travel || group().continuous()[joint]) continue;
    throw InvalidArgument("the motion takes joint '" + group().joints()[joint].name + "' from " + to_text(a[i]) +
                          " to " + to_text(b[i]) + "; a motion may take a joint as far as " +
                          to_text(max_joint_travel) + " rad or m");
  }
}

bool Checker::is_free(ConstVector q, Workspace& workspace) const {
  group().require_configuration(q, "configuration");
  require_own(workspace);
  ++workspace.statistics.states;
  return do_is_free(q, workspace);
}

bool Checker::is_motion_free(ConstVector a, ConstVector b, Workspace& workspace, const MotionQuery& query) const {
  require_motion(a, b, workspace);
  ++workspace.statistics.motions;
  return do_is_motion_free(a, b, workspace, query);
}

void Checker::require_rows(ConstRows q, std::size_t results, const char* function, const Workspace& workspace) const {
  if (results != static_cast<std::size_t>(q.rows()))
    throw InvalidArgument(function + (": there are " + std::to_string(q.rows()) + " configurations, but room for ") +
                          std::to_string(results) + " results");
  for (Eigen::Index i = 0; i < q.rows(); ++i)
    if (q.cols() != static_cast<Eigen::Index>(dof()) || !q.row(i).allFinite())
      group().require_configuration(q.row(i).transpose(), "configuration " + std::to_string(i));
  require_own(workspace);
}

void Checker::are_free(ConstRows q, std::span<bool> free, Workspace& workspace, const StateQuery& query) const {
  require_rows(q, free.size(), "are_free", workspace);
  workspace.statistics.states += free.size();
  do_are_free(q, free, workspace, query);
}

void Checker::find_colliding(ConstRows q, std::span<bool> colliding, Workspace& workspace) const {
  require_rows(q, colliding.size(), "find_colliding", workspace);
  std::ranges::fill(colliding, false);
  do_find_colliding(q, colliding, workspace);
}

MotionCertificate Checker::certify_motion(ConstVector a, ConstVector b, Workspace& workspace) const {
  require_motion(a, b, workspace);
  ++workspace.statistics.motions;
  return do_certify_motion(a, b, workspace);
}

std::vector<Contact> Checker::contacts(ConstVector q, Workspace& workspace) const {
  group().require_configuration(q, "configuration");
  require_own(workspace);
  return do_contacts(q, workspace);
}

std::optional<Contact> Checker::nearest(ConstVector q, Workspace& workspace) const {
  group().require_configuration(q, "configuration");
  require_own(workspace);
  return do_nearest(q, workspace);
}

double Checker::clearance(ConstVector q, Workspace& workspace) const {
  group().require_configuration(q, "configuration");
  require_own(workspace);
  return do_clearance(q, workspace);
}

void Checker::stop_at(const Deadline& deadline, Workspace& workspace) const {
  require_own(workspace);
  workspace.deadline = &deadline;
}

// --- what a backend need not override

double Checker::do_clearance(ConstVector q, Workspace& workspace) const {
  const std::optional<Contact> pair = do_nearest(q, workspace);
  return pair ? pair->distance : std::numeric_limits<double>::infinity();
}

std::optional<Contact> Checker::do_nearest_fixed() const { return std::nullopt; }

void Checker::do_find_colliding(ConstRows, std::span<bool>, Workspace&) const {}

Checker::WorkspacePtr Checker::do_make_workspace() const { return std::make_unique<Workspace>(); }

void Checker::do_are_free(ConstRows q, std::span<bool> free, Workspace& workspace, const StateQuery&) const {
  for (std::size_t i = 0; i < free.size(); ++i)
    free[i] = do_is_free(q.row(static_cast<Eigen::Index>(i)).transpose(), workspace);
}

bool Checker::do_is_motion_free(ConstVector a, ConstVector b, Workspace& workspace, const MotionQuery&) const {
  return do_certify_motion(a, b, workspace).proved;
}

MotionCertificate Checker::do_certify_motion(ConstVector a, ConstVector b, Workspace& workspace) const {
  const Eigen::VectorXd difference = group().difference(a, b);
  // Either body of a pair may move, so the two approach each other by up to twice this over the whole motion.
  const double travel = do_reach().dot(difference.cwiseAbs());
  struct Interval {
    double from, to;
  };
  std::vector<Interval> open{{0.0, 1.0}};  // a stack, so that the first part that cannot be proved is found first
  for (int samples = 1; !open.empty(); ++samples) {
    rare_interruption_point();
    if (workspace.deadline && samples % samples_per_deadline_check == 0 && workspace.deadline->expired())
      throw MotionCheckStopped();
    const auto [from, to] = open.back();
    open.pop_back();
    const double middle = (from + to) / 2.0, motion = travel * (to - from);
    const std::optional<Contact> pair = do_nearest(a + middle * difference, workspace);
    if (!pair || pair->distance > motion) continue;
    if (pair->distance <= 0.0) return {false, middle, middle, pair->body_a, pair->body_b};
    if (motion < motion_floor) return {false, from, to, pair->body_a, pair->body_b};
    open.push_back({middle, to});
    open.push_back({from, middle});
  }
  return {true, 0.0, 0.0, "", ""};
}

Eigen::VectorXd Checker::do_reach() const { return robots_->reach(); }

/// The sphere is centred on the first axis that never moves.
PlacedSphere Checker::do_range() const {
  const RobotGroup::Data data = robots_->data_at_zero();
  PlacedSphere sphere;
  bool centered = false;
  const auto include = [&](const Eigen::Vector3d& point, double radius) {
    if (!std::exchange(centered, true)) sphere.center = point;
    sphere.radius = std::max(sphere.radius, (point - sphere.center).norm() + radius);
  };
  robots_->for_each_axis(data,
                         [&](const Robots::Part& part, std::size_t k, double distance, const Eigen::Vector3d& axis) {
                           if (part.robot == 0 && group().parent(k) < 0)
                             include(axis, distance + robots_->travel(group().actuated_joints()[k]) + part.padding);
                         });
  for (const Robots::Part& part : robots_->parts)
    if (part.robot == 0 && part.support == 0) include(robots_->center(part, data), part.radius + part.padding);
  sphere.center = base() * sphere.center;
  sphere.radius += clearance_;
  return sphere;
}

}  // namespace srmp
