#include <algorithm>
#include <numbers>

#include "srmp/core/error.hpp"
#include "srmp/facade/moveit_goals.hpp"

namespace srmp {

namespace {

constexpr double kMaxTilt = 1.5;  // [rad] of a cone that stands for two angles: they are within it up to pi/2

class PathConstraintReader {
 public:
  PathConstraintReader(const Scene& scene, const io::FrameLookup& frames, const std::string& robot)
      : frames_(frames), name_(robot), robot_(*scene.robot(robot).model) {}

  PathConstraint position(const io::PositionConstraint& constraint) const {
    const auto [link, in_link] = link_of(constraint.link, "a position constraint of the path");
    const auto [frame, in_frame] = frame_of(constraint.frame, "a position constraint of the path");
    const Pose region = in_frame * constraint.regions.front().pose;
    const Shape& shape = constraint.regions.front().shape;
    PathConstraint result = std::holds_alternative<Box>(shape)
                                ? PathConstraint::box(std::get<Box>(shape).size, region)
                                : PathConstraint::distance(region.p, 0.0, std::get<Sphere>(shape).radius);
    result.link = link;
    result.frame = frame;
    result.point = in_link * constraint.offset;
    return result;
  }

  PathConstraint orientation(const io::OrientationConstraint& constraint) const {
    const auto [link, in_link] = link_of(constraint.link, "an orientation constraint of the path");
    const auto [frame, in_frame] = frame_of(constraint.frame, "an orientation constraint of the path");
    const Eigen::Quaterniond required = in_frame.q * constraint.orientation;
    PathConstraint result = bound(constraint, in_link.q, required);
    result.link = link;
    result.frame = frame;
    return result;
  }

 private:
  /// `constrained`: the constrained frame in the link's; `required`: what is asked of it.
  static PathConstraint bound(const io::OrientationConstraint& constraint, const Eigen::Quaterniond& constrained,
                              const Eigen::Quaterniond& required) {
    // Of the angles of Rx(a) Ry(b) Rz(c), the turned z axis is tilted by acos(cos a cos b), whatever c is, and a and b
    // are no larger than that; likewise the x axis, and b and c.
    const auto axis_within = [&](Eigen::Index axis, double one, double other) {
      const auto allowed = [](double tolerance) { return tolerance == 0.0 ? least_rotation : tolerance; };
      const Eigen::Vector3d unit = Eigen::Vector3d::Unit(axis);
      return PathConstraint::cone(constrained * unit, required * unit,
                                  std::min({allowed(one), allowed(other), kMaxTilt}));
    };
    const Eigen::Vector3d& tolerance = constraint.tolerance;
    if (!constraint.rotation_vector && tolerance.z() >= std::numbers::pi)
      return axis_within(2, tolerance.x(), tolerance.y());
    if (!constraint.rotation_vector && tolerance.x() >= std::numbers::pi)
      return axis_within(0, tolerance.y(), tolerance.z());
    Eigen::Matrix3d to_constraint = constrained.toRotationMatrix().transpose();
    if (constraint.rotation_vector) to_constraint = constraint.orientation.toRotationMatrix() * to_constraint;
    return PathConstraint::orientation(required * constrained.conjugate(),
                                       rotation_tolerance(constraint, to_constraint, Eigen::Vector3d::Zero()));
  }

  /// A link of the robot, and a pose in its frame: of a link itself, an attached object or a subframe of one.
  std::pair<std::string, Pose> link_of(const std::string& name, const std::string& what) const {
    const auto found = frames_.find(name);
    if (!found || found->robot != name_)
      throw InvalidArgument(what + " is for '" + name + "', which is not a link of robot '" + name_ +
                            "' nor attached to one" + did_you_mean(name, robot_.link_names()));
    return {found->link, in_link(*found)};
  }

  /// A frame that stands still is given in the world (""), one that the planned joints move in its link.
  std::pair<std::string, Pose> frame_of(const std::string& name, const std::string& what) const {
    const io::Frame frame = frames_.require(name, what);
    if (frame.robot != name_ || !frames_.moves(frame)) return {"", frame.pose};
    return {frame.link, in_link(frame)};
  }

  Pose in_link(const io::Frame& frame) const {
    return frames_.link_pose(frame.robot, frame.link).inverse() * frame.pose;
  }

  const io::FrameLookup& frames_;
  const std::string& name_;
  const RobotModel& robot_;
};

}  // namespace

std::vector<PathConstraint> moveit_path_constraints(const io::RequestFile& request, const Scene& scene,
                                                    const io::FrameLookup& frames, const std::string& robot) {
  const PathConstraintReader reader(scene, frames, robot);
  std::vector<PathConstraint> constraints;
  try {
    for (const io::PositionConstraint& constraint : request.path_constraints.positions)
      constraints.push_back(reader.position(constraint));
    for (const io::OrientationConstraint& constraint : request.path_constraints.orientations)
      if (!allows_all(constraint)) constraints.push_back(reader.orientation(constraint));
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(request.path + ": " + error.what());
  }
  return constraints;
}

}  // namespace srmp
