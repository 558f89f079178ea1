#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <string_view>

#include "srmp/core/pose.hpp"
#include "srmp/robot/inverse_kinematics.hpp"

namespace srmp {

/// The kind of a path constraint: what it bounds.
enum class PathConstraintType {
  cone,         ///< the angle between an axis of the link and a direction
  orientation,  ///< the rotation from an orientation, about each axis
  pose,         ///< position and rotation from a pose, along and about each axis
  box,          ///< a point of the link stays in a box
  plane,        ///< a point of the link stays near a plane
  line,         ///< a point of the link stays near a line
  distance,     ///< a point of the link keeps a distance from a point
};

/// The name in files and messages: "cone", "orientation", "pose", "box", "plane", "line" or "distance".
std::string_view to_string(PathConstraintType type);

/// What has to hold at every instant of a motion. It is about a link of the robot or an object that it holds (`link`),
/// in the frame of the world, of a link of the same robot, which may move, or of anything that stands still: an object,
/// or a link of another robot as "robot/link" (`frame`). Make one with the functions below, then set `link`, `frame`
/// and `point`.
struct PathConstraint {
  PathConstraintType type{PathConstraintType::cone};  ///< what it bounds
  std::string link{};   ///< a link of the robot, or an object that it holds; "" = the end effector
  std::string frame{};  ///< in whose frame `target` is; "" = the world
  /// cone, plane, line: z is the direction, the normal or the line. box, distance: its centre. orientation, pose: what
  /// is to be kept.
  Pose target{};
  Eigen::Vector3d axis{0.0, 0.0, 1.0};   ///< of a cone: in the link's frame, of length 1
  Eigen::Vector3d point{0.0, 0.0, 0.0};  ///< in the link's frame [m]: what positions are about
  /// [m] box, pose: along the axes of the target; infinity: that axis is free.
  AxisTolerance position_tolerance{std::numeric_limits<double>::infinity()};
  /// [rad] orientation, pose: of the rotation vector's components along the axes of the target; infinity: free.
  AxisTolerance rotation_tolerance{std::numeric_limits<double>::infinity()};
  double tolerance{};     ///< cone: [rad], below pi; plane, line: [m]; > 0
  double min_distance{};  ///< of a distance [m], >= 0
  double max_distance{};  ///< of a distance [m], above min_distance

  /// `axis` of the link stays within `tolerance` [rad] of `direction`, both (3,) of any length.
  static PathConstraint cone(const Eigen::Vector3d& axis, const Eigen::Vector3d& direction, double tolerance);
  /// The link's orientation differs from `target` by a rotation vector whose components, along the axes of `target`,
  /// are within the tolerance [rad].
  static PathConstraint orientation(const Eigen::Quaterniond& target, const AxisTolerance& tolerance);
  /// The link stays at a pose, to the tolerances [m, rad]: with `frame`, the relative pose of two links.
  static PathConstraint pose(const Pose& target, const AxisTolerance& position_tolerance,
                             const AxisTolerance& rotation_tolerance);
  /// The link's origin stays in a box with full edge lengths `size` (3,) [m], infinity: unbounded, centred at `pose`.
  static PathConstraint box(const Eigen::Vector3d& size, const Pose& pose);
  /// The link's origin stays within `tolerance` [m] of the plane through `point` with this normal.
  static PathConstraint plane(const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double tolerance);
  /// The link's origin stays within `tolerance` [m] of the line through `point` along `direction`.
  static PathConstraint line(const Eigen::Vector3d& point, const Eigen::Vector3d& direction, double tolerance);
  /// The link's origin keeps a distance of min_distance to max_distance [m] from `centre`.
  static PathConstraint distance(const Eigen::Vector3d& centre, double min_distance, double max_distance);

  /// Throws InvalidArgument for NaN, directions and quaternions of length 0, tolerances that are not above 0, and
  /// constraints that leave everything free. Names are not looked up.
  void validate() const;
};

/// How far a motion goes from the middle of what a path constraint allows, at most: proved, not sampled.
struct ConstraintDeviation {
  std::string constraint{};  ///< "the z axis of 'hand' within 5 degrees of [0, 0, 1]"
  double deviation{};        ///< [rad or m]: of a distance, from the middle of its range
  double tolerance{};        ///< [rad or m] that is allowed
  double time{};             ///< [s] about when it is worst
#if __cplusplus >= 202002L   // MoveIt 1 is C++17
  bool operator==(const ConstraintDeviation&) const = default;
#endif
};

}  // namespace srmp
