#pragma once

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "srmp/trajectory/motion_limits.hpp"
#include "srmp/trajectory/path_constraint.hpp"

namespace srmp {

/// What can be wrong with a trajectory.
enum class FaultKind {
  joint_names,     ///< not those of the robot, or in another order
  shape,           ///< arrays that do not fit together, or none at all
  not_finite,      ///< NaN or infinity
  times,           ///< a time that does not increase
  position_limit,  ///< a joint outside its limits
  velocity_limit,
  acceleration_limit,
  jerk_limit,
  collision,         ///< two bodies touch, or come within their padding
  deviation,         ///< the motion leaves the path that was checked
  start,             ///< it does not begin at the given start
  goal,              ///< it does not end at the given goal
  not_at_rest,       ///< its velocity at the start or end is not 0, though it should be
  constraint,        ///< it breaks a path constraint, or is not proved to keep it
  clearance,         ///< it comes closer to something than the clearance that was asked for allows
  link_speed_limit,  ///< a link is faster than its limit, or is not proved to keep it
  torque_limit,      ///< a joint needs more torque than its limit, or is not proved to keep it
};
/// The name of a kind, such as "velocity_limit".
std::string to_string(FaultKind kind);

/// Something that is wrong, and where.
struct Fault {
  FaultKind kind{};         ///< what is wrong
  std::string text;         ///< a sentence
  double time{};            ///< [s] when it is worst; NaN: at no particular time
#if __cplusplus >= 202002L  // MoveIt 1 is C++17
  bool operator==(const Fault&) const = default;
#endif
};

/// The largest fraction of a limit that is used over the whole motion: from extrema of the polynomials, not of samples.
struct LimitUse {
  /// Of the limit; 1 = all of it. Positions: of the distance from the middle of the range to its end. Jerks: infinity
  /// where the acceleration jumps (from and to rest too), as with TOPP-RA: by more than 0.1 % of its limit, and by more
  /// than the jerk limit allows in 0.4 ms.
  double fraction{};
  std::string joint;        ///< by which joint; "" = nothing moves, or there is no limit
  double time{};            ///< [s]
#if __cplusplus >= 202002L  // MoveIt 1 is C++17
  bool operator==(const LimitUse&) const = default;
#endif
};

/// How fast a link moves, at most: proved over the whole motion, not at samples.
struct LinkSpeedUse {
  LinkSpeedLimit limit;         ///< that it was verified against, with the link's name
  double speed{};               ///< of its point [m/s]
  double speed_time{};          ///< [s] about when
  double angular_speed{};       ///< [rad/s]
  double angular_speed_time{};  ///< [s] about when

  /// The larger one, as a fraction of its limit.
  double fraction() const { return std::fmax(speed / limit.speed, angular_speed / limit.angular_speed); }
#if __cplusplus >= 202002L  // MoveIt 1 is C++17
  bool operator==(const LinkSpeedUse&) const = default;
#endif
};

/// A part of a motion over which two bodies could not be proved to stay apart. They do not touch at the samples in it,
/// which are less than Checker::motion_floor of motion apart, unless the time limit ended the proof early.
struct SampledInterval {
  double from{}, to{};         ///< [s]
  std::string body_a, body_b;  ///< named as in Contact
#if __cplusplus >= 202002L     // MoveIt 1 is C++17
  bool operator==(const SampledInterval&) const = default;
#endif
};

/// How far a link may leave the poses that it is to follow.
struct CartesianTolerance {
  double position{1e-3};          ///< of the link's origin [m], > 0
  double rotation{M_PI / 360.0};  ///< [rad], > 0; half a degree
#if __cplusplus >= 202002L        // MoveIt 1 is C++17
  bool operator==(const CartesianTolerance&) const = default;
#endif
};

/// How far a link leaves the poses that it follows, at most: proved over the whole motion, not at samples.
struct CartesianDeviation {
  double position{};        ///< of the link's origin [m]
  double rotation{};        ///< [rad]
  double time{};            ///< [s] about when it is farthest away, as fractions of the tolerance
#if __cplusplus >= 202002L  // MoveIt 1 is C++17
  bool operator==(const CartesianDeviation&) const = default;
#endif
};

/// Two bodies that are closer to each other than the required clearance near an end of a motion, where they need not
/// keep it.
struct RelaxedClearance {
  std::string body_a, body_b;  ///< named as in Contact
  double clearance{};          ///< [m] at that end, less the padding: the least
  double from{}, to{};         ///< [s] the part of the motion over which they are closer, from the start or to the end
#if __cplusplus >= 202002L     // MoveIt 1 is C++17
  bool operator==(const RelaxedClearance&) const = default;
#endif
};

/// A part of a motion in time.
struct TimeInterval {
  double from{}, to{};      ///< [s]
#if __cplusplus >= 202002L  // MoveIt 1 is C++17
  bool operator==(const TimeInterval&) const = default;
#endif
};

/// How a motion keeps a required clearance (CommonOptions::clearance).
struct ClearanceKept {
  double required{};  ///< [m]
  /// [s] between these two no pair of bodies comes closer than `required`, also between samples: this is proved. The
  /// whole motion, if both ends keep it. Without what `at_stops` has.
  double from{}, to{};
  /// [m] the most by which a pair breaks the rule: between `from` and `to`, by which it is closer than `required`;
  /// before and after, at samples, by which a pair that is closer comes closer still on its way from the start or back
  /// from the end (beyond a tolerance of 0.02 mm), or is closer though it was not at the end. 0: the rule is kept.
  double violation{};
  std::vector<RelaxedClearance> relaxed;  ///< near the ends, those of the start first
  /// Pairs of the robot's links, "a and b", that only may not touch: they are built closer to each other than
  /// `required`, and are closer in at least half of the robot's configurations.
  std::vector<std::string> close_links;
  /// Of a motion made of several (Trajectory::followed_by, sequences): the parts between `from` and `to` where one of
  /// them ends and the next begins, and pairs may be closer, by the rule of the ends.
  std::vector<TimeInterval> at_stops;
#if __cplusplus >= 202002L  // MoveIt 1 is C++17
  bool operator==(const ClearanceKept&) const = default;
#endif
};

/// What is known of a trajectory, found by code that is independent of the code that made it.
struct Certificate {
  std::vector<Fault> faults;  ///< empty: every claim below holds

  MotionLimits limits;                              ///< that the motion was verified against
  LimitUse position, velocity, acceleration, jerk;  ///< use of the limits
  std::vector<LinkSpeedUse> link_speeds{};          ///< one for each of MotionLimits::link_speeds
  LimitUse torque{};                                ///< use of MotionLimits::torque, proved between samples too

  bool collisions_checked{};   ///< whether collisions were checked
  double checked_from{};       ///< [s]: what comes before is the recovery from a start in collision
  double clearance{};          ///< [m] the smallest that was found; infinity: there is nothing to collide with
  double clearance_time{};     ///< [s]
  std::string body_a, body_b;  ///< the pair there
  double clearance_proved{};   ///< [m] no two bodies come nearer than this, also between samples
  std::vector<SampledInterval> sampled;  ///< parts that are not proved free; empty: all of the motion is

  double deviation{};       ///< [m]: no point of the robot leaves its path along `waypoints` by more; NaN: not known
  double deviation_time{};  ///< [s]
  /// From the poses that were to be followed (PlannerInterface::follow); none: there were none.
  std::optional<CartesianDeviation> cartesian_deviation{};
  std::vector<ConstraintDeviation> constraints{};               ///< one for each path constraint of the request
  std::optional<ClearanceKept> clearance_kept{};                ///< none: no clearance was required
  double goal_error{std::numeric_limits<double>::quiet_NaN()};  ///< joints: rad or m, the worst joint; poses: m, rad
                                                                ///< over tolerance; NaN: no goal was given
  double bound{std::numeric_limits<double>::infinity()};        ///< PlanStatistics::bound of the search
  std::string bound_graph;                                      ///< PlanStatistics::bound_graph
  double time_s{};                                              ///< computing time [s]

  /// Whether there are no faults.
  bool holds() const { return faults.empty(); }
  /// Collisions were checked, there is none, and all of the motion is proved free, between samples too.
  bool proved_free() const;
  /// One line a claim.
  std::string report() const;
};

}  // namespace srmp
