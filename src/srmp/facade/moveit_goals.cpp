#include "srmp/facade/moveit_goals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

using io::Frame;
using io::GoalAlternative;
using io::OrientationConstraint;
using io::PlacedShape;
using io::PositionConstraint;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNoDistance = 1e-9;  // [m]

/// Of a box that lies in the region, along the region's axes [m].
Eigen::Vector3d half_extents(const Shape& region) {
  if (const auto* box = std::get_if<Box>(&region)) return 0.5 * box->size;
  if (const auto* cylinder = std::get_if<Cylinder>(&region)) {
    const double side = cylinder->radius / std::numbers::sqrt2;
    return {side, side, 0.5 * cylinder->length};
  }
  return Eigen::Vector3d::Constant(std::get<Sphere>(region).radius / std::numbers::sqrt3);
}

/// The box that lies in the region when seen along `axes` (columns, in the region's frame).
Eigen::Vector3d box_along(const Shape& region, const Eigen::Matrix3d& axes) {
  return std::holds_alternative<Sphere>(region) ? half_extents(region) : inner_box(axes, half_extents(region));
}

class GoalReader {
 public:
  GoalReader(const Scene& scene, const io::FrameLookup& frames, const std::string& robot, const Eigen::VectorXd& start)
      : frames_(frames), instance_(scene.robot(robot)), robot_(*instance_.model), start_(start), name_(robot) {}

  /// What one alternative of the request stands for; any of the goals is enough.
  std::vector<GoalConstraint> goals(const GoalAlternative& goal) const {
    if (!goal.joints.empty() && !(goal.positions.empty() && goal.orientations.empty()))
      throw NotSupported("joint_constraints together with " +
                         std::string(goal.positions.empty() ? "orientation" : "position") +
                         "_constraints are not supported; give them as goals of their own");
    if (!goal.joints.empty()) return {joint_goal(goal)};
    if (goal.positions.size() > 1) throw NotSupported("several position_constraints in one goal are not supported");
    if (goal.orientations.size() > 1)
      throw NotSupported("several orientation_constraints in one goal are not supported");
    const OrientationConstraint* orientation = goal.orientations.empty() ? nullptr : &goal.orientations[0];
    if (orientation) require_link(orientation->link, "an orientation constraint");
    if (orientation && allows_all(*orientation)) orientation = nullptr;
    if (goal.positions.empty() && !orientation)
      throw InvalidArgument(
          "the tolerances leave every orientation free, and there is no position; nothing is asked for");
    if (goal.positions.empty()) return {pose_goal(nullptr, nullptr, *orientation)};
    std::vector<GoalConstraint> result;
    for (const PlacedShape& region : goal.positions[0].regions)
      result.push_back(orientation ? pose_goal(&goal.positions[0], &region, *orientation)
                                   : position_goal(goal.positions[0], region));
    return result;
  }

 private:
  GoalConstraint joint_goal(const GoalAlternative& goal) const {
    Eigen::VectorXd q = Eigen::VectorXd::Constant(start_.size(), std::numeric_limits<double>::quiet_NaN());
    for (const io::JointConstraint& constraint : goal.joints) {
      const std::vector<std::string>& names = robot_.joint_names();
      const auto it = std::find(names.begin(), names.end(), constraint.joint);
      if (it == names.end())
        require_met(constraint);
      else
        q[it - names.begin()] = target_of(robot_.joints()[static_cast<std::size_t>(it - names.begin())], constraint);
    }
    for (Eigen::Index i = 0; i < q.size(); ++i)
      if (std::isnan(q[i]))
        throw NotSupported("joint '" + robot_.joint_names()[static_cast<std::size_t>(i)] +
                           "' is left free; joint goals must give every planned joint");
    return GoalConstraint::joints(q);
  }

  /// The position, or the nearest within the joint's limits if the tolerances allow it. What remains outside of limits,
  /// plan reports.
  static double target_of(const Joint& joint, const io::JointConstraint& constraint) {
    const double position = constraint.position, target = std::clamp(position, joint.lower, joint.upper);
    const bool allowed =
        target <= position + constraint.tolerance_above && target >= position - constraint.tolerance_below;
    return allowed ? target : position;
  }

  /// A joint that is not planned stays where it is.
  void require_met(const io::JointConstraint& constraint) const {
    const std::vector<Joint>& others = robot_.other_joints();
    std::vector<std::string> known = robot_.joint_names();
    for (std::size_t i = 0; i < others.size(); ++i) {
      known.push_back(others[i].name);
      if (others[i].name != constraint.joint) continue;
      const double error = instance_.other_positions[static_cast<Eigen::Index>(i)] - constraint.position;
      if (error > constraint.tolerance_above + 1e-9 || error < -constraint.tolerance_below - 1e-9)
        throw InvalidArgument("joint '" + constraint.joint + "' is to be at " + to_text(constraint.position) +
                              ", but it is not planned and stands at " +
                              to_text(instance_.other_positions[static_cast<Eigen::Index>(i)]));
      return;
    }
    throw InvalidArgument("joint '" + constraint.joint + "' is not a movable joint of robot '" + name_ + "'" +
                          did_you_mean(constraint.joint, known));
  }

  GoalConstraint position_goal(const PositionConstraint& constraint, const PlacedShape& region) const {
    const Eigen::Vector3d point = point_in_end_effector(constraint);
    if (point.norm() > kNoDistance)
      throw NotSupported("a position constraint is for a point that is " + to_text(point.norm()) +
                         " m from the origin of end effector '" + robot_.end_effector() +
                         "'; without an orientation constraint only the origin is supported");
    const Pose pose = frame_of(constraint.frame, "a position constraint") * region.pose;
    GoalConstraint goal = GoalConstraint::position(pose.p);
    goal.position_tolerance = box_along(region.shape, pose.q.toRotationMatrix().transpose());
    return goal;
  }

  /// Without a position, the end effector may go anywhere.
  GoalConstraint pose_goal(const PositionConstraint* position, const PlacedShape* region,
                           const OrientationConstraint& orientation) const {
    const std::string what = "an orientation constraint";
    const Eigen::Quaterniond constrained = in_end_effector(orientation.link, what).q;
    const Eigen::Quaterniond required = frame_of(orientation.frame, what).q * orientation.orientation;
    Pose target{robot_base_to_world(robot_.compute_fk(start_, "", instance_.other_positions)).p,
                required * constrained.conjugate()};
    const Eigen::Vector3d point = position ? point_in_end_effector(*position) : Eigen::Vector3d::Zero();
    Eigen::Matrix3d to_constraint = constrained.toRotationMatrix().transpose();
    if (orientation.rotation_vector) to_constraint = orientation.orientation.toRotationMatrix() * to_constraint;
    Eigen::Vector3d rotation = rotation_tolerance(orientation, to_constraint, point);
    Eigen::Vector3d box = Eigen::Vector3d::Constant(kInfinity);
    if (position) {
      const Pose pose = frame_of(position->frame, "a position constraint") * region->pose;
      target.p = pose.p - target.q * point;
      const Eigen::Matrix3d axes = pose.q.toRotationMatrix().transpose() * target.q.toRotationMatrix();
      box = leave_room(box_along(region->shape, axes), point.norm(), rotation);
    }
    GoalConstraint goal = GoalConstraint::pose(target);
    goal.position_tolerance = box;
    goal.rotation_tolerance = rotation;
    return goal;
  }

  /// The box without the distance by which rotations within the tolerance, if need be made smaller, move a point that
  /// is so far from the end effector's origin.
  static Eigen::Vector3d leave_room(const Eigen::Vector3d& box, double distance, Eigen::Vector3d& rotation) {
    if (distance <= kNoDistance) return box;
    const auto turned = [&] { return rotation.unaryExpr([](double a) { return std::isinf(a) ? 0.0 : a; }).norm(); };
    const double room = 0.5 * box.minCoeff();
    if (distance * turned() > room) rotation *= room / (distance * turned());
    return box.array() - distance * turned();
  }

  Pose robot_base_to_world(const Pose& in_base) const { return instance_.base * in_base; }

  Eigen::Vector3d point_in_end_effector(const PositionConstraint& constraint) const {
    return in_end_effector(constraint.link, "a position constraint") * constraint.offset;
  }

  /// A link, or a frame of an attached object, that is rigidly joined to the end effector.
  Frame require_link(const std::string& name, const std::string& what) const {
    const auto frame = frames_.find(name);
    if (!frame || frame->robot != name_)
      throw InvalidArgument(what + " is for '" + name + "', which is not a link of robot '" + name_ +
                            "' nor attached to one" + did_you_mean(name, robot_.link_names()));
    const auto support = [&](const std::string& link) { return robot_.link_support(robot_.link_index(link)); };
    if (support(frame->link) != support(robot_.end_effector()))
      throw NotSupported(what + " is for '" + name + "', which is not rigidly joined to the end effector '" +
                         robot_.end_effector() + "'; goals are for the end effector");
    return *frame;
  }

  Pose in_end_effector(const std::string& name, const std::string& what) const {
    const Frame frame = require_link(name, what);
    if (name == robot_.end_effector()) return {};
    return frames_.link_pose(name_, robot_.end_effector()).inverse() * frame.pose;
  }

  Pose frame_of(const std::string& name, const std::string& what) const {
    const Frame frame = frames_.require(name, what);
    if (frame.robot == name_ && frames_.moves(frame))
      throw NotSupported(what + " is in frame '" + name +
                         "', which the planned joints move; use one that stands still");
    return frame.pose;
  }

  const io::FrameLookup& frames_;
  const RobotInstance& instance_;
  const RobotModel& robot_;
  const Eigen::VectorXd& start_;
  const std::string& name_;
};

/// "goal 2 ('folded'): ".
std::string label(std::size_t index, const GoalAlternative& goal) {
  return "goal " + std::to_string(index + 1) + (goal.name.empty() ? "" : " ('" + goal.name + "')") + ": ";
}

}  // namespace

std::vector<GoalConstraint> moveit_goals(const io::RequestFile& request, const Scene& scene,
                                         const io::FrameLookup& frames, const std::string& robot,
                                         const Eigen::VectorXd& start) {
  const GoalReader reader(scene, frames, robot, start);
  std::vector<GoalConstraint> goals;
  for (std::size_t i = 0; i < request.goals.size(); ++i) {
    const std::string where = request.path + ": " + label(i, request.goals[i]);
    try {
      for (GoalConstraint& goal : reader.goals(request.goals[i])) goals.push_back(std::move(goal));
    } catch (const InvalidArgument& error) {
      throw InvalidArgument(where + error.what());
    } catch (const NotSupported& error) {
      throw NotSupported(where + error.what());
    }
  }
  return goals;
}

}  // namespace srmp
