#pragma once

// Internal: trajectories as maps in files.

#include "srmp/io/json_archive.h"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp::io {

template <class Archive>
void describe(Archive& archive, Ref<Archive, LinkSpeedLimit> limit) {
  archive("link", limit.link);
  archive("speed", limit.speed);
  archive("angular_speed", limit.angular_speed);
  archive("point", limit.point);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, Payload> payload) {
  archive("mass", payload.mass);
  archive("center_of_mass", payload.center_of_mass);
  archive("inertia", payload.inertia);
  archive("link", payload.link);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, MotionLimits> limits) {
  archive("velocity", limits.velocity);
  archive("acceleration", limits.acceleration);
  archive("jerk", limits.jerk);
  archive("continuous", limits.continuous);
  describe_list(archive, "link_speeds", limits.link_speeds);
  describe_if(archive, "torque", limits.torque, limits.torque.size() > 0);
  archive("payload", limits.payload);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, Fault> fault) {
  archive("kind", fault.kind);
  archive("text", fault.text);
  archive("time", fault.time);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, LimitUse> use) {
  archive("fraction", use.fraction);
  archive("joint", use.joint);
  archive("time", use.time);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, LinkSpeedUse> use) {
  archive("limit", use.limit);
  archive("speed", use.speed);
  archive("speed_time", use.speed_time);
  archive("angular_speed", use.angular_speed);
  archive("angular_speed_time", use.angular_speed_time);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, SampledInterval> interval) {
  archive("from", interval.from);
  archive("to", interval.to);
  archive("body_a", interval.body_a);
  archive("body_b", interval.body_b);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, CartesianDeviation> deviation) {
  archive("position", deviation.position);
  archive("rotation", deviation.rotation);
  archive("time", deviation.time);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, ConstraintDeviation> kept) {
  archive("constraint", kept.constraint);
  archive("deviation", kept.deviation);
  archive("tolerance", kept.tolerance);
  archive("time", kept.time);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, RelaxedClearance> pair) {
  archive("body_a", pair.body_a);
  archive("body_b", pair.body_b);
  archive("clearance", pair.clearance);
  archive("from", pair.from);
  archive("to", pair.to);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, TimeInterval> interval) {
  archive("from", interval.from);
  archive("to", interval.to);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, ClearanceKept> kept) {
  archive("required", kept.required);
  archive("from", kept.from);
  archive("to", kept.to);
  archive("violation", kept.violation);
  archive("relaxed", kept.relaxed);
  archive("close_links", kept.close_links);
  describe_list(archive, "at_stops", kept.at_stops);
}

template <class Archive>
void describe(Archive& archive, Ref<Archive, Certificate> certificate) {
  archive("faults", certificate.faults);
  archive("limits", certificate.limits);
  archive("position", certificate.position);
  archive("velocity", certificate.velocity);
  archive("acceleration", certificate.acceleration);
  archive("jerk", certificate.jerk);
  describe_list(archive, "link_speeds", certificate.link_speeds);
  describe_if(archive, "torque", certificate.torque, certificate.limits.torque.size() > 0);
  archive("collisions_checked", certificate.collisions_checked);
  archive("checked_from", certificate.checked_from);
  archive("clearance", certificate.clearance);
  archive("clearance_time", certificate.clearance_time);
  archive("body_a", certificate.body_a);
  archive("body_b", certificate.body_b);
  archive("clearance_proved", certificate.clearance_proved);
  archive("sampled", certificate.sampled);
  archive("deviation", certificate.deviation);
  archive("deviation_time", certificate.deviation_time);
  archive("cartesian_deviation", certificate.cartesian_deviation);
  describe_list(archive, "constraints", certificate.constraints);
  archive("clearance_kept", certificate.clearance_kept);
  archive("goal_error", certificate.goal_error);
  archive("bound", certificate.bound);
  archive("bound_graph", certificate.bound_graph);
  archive("time_s", certificate.time_s);
}

/// "" when the arrays have matching sizes; otherwise an error message.
std::string misfit(const Trajectory& trajectory);
/// Empty arrays do not tell their columns in a file: gives them one per joint.
void give_columns(Trajectory& trajectory);

template <class Archive>
void describe(Archive& archive, Ref<Archive, Trajectory> trajectory) {
  archive("joint_names", trajectory.joint_names);
  archive("times", trajectory.times);
  archive("positions", trajectory.positions);
  archive("velocities", trajectory.velocities);
  archive("accelerations", trajectory.accelerations);
  archive("waypoints", trajectory.waypoints);
  archive("certificate", trajectory.certificate);
  if constexpr (Archive::reading) {
    give_columns(trajectory);
    if (const std::string text = misfit(trajectory); !text.empty()) archive.fail(text);
  }
}

}  // namespace srmp::io
