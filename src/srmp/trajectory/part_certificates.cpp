#include <algorithm>
#include <cmath>
#include <limits>

#include "srmp/trajectory/joint_torques.hpp"
#include "srmp/trajectory/limit_check.hpp"

namespace srmp {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

const std::vector<Joint>* joints_of(const Trajectory& t) { return t.robot ? &t.robot->model->joints() : nullptr; }

/// Without what belongs to the whole of a planned motion.
Certificate without_request(Certificate c) {
  c.goal_error = unknown;
  c.bound = std::numeric_limits<double>::infinity();
  c.bound_graph.clear();
  return c;
}

/// Proves the speeds of links and the torques anew; the robot is known.
void add_bounds_of_robot(const Trajectory& motion, Certificate& c, bool faults) {
  if (!need_robot(c.limits)) return;
  RobotBounds bounds;
  bounds.add(*motion.robot, c.limits);
  bounds.certify(c, motion, faults);
}

/// Finds the use of limits anew; that of the position limits where they are known.
void use_limits_of(const Trajectory& motion, Certificate& c) {
  if (motion.robot) c.position = {};
  c.velocity = c.acceleration = c.jerk = {};
  check_limits(motion, c.limits, {.joints = joints_of(motion), .limits = false, .at_rest = false}, c);
  if (motion.robot) add_bounds_of_robot(motion, c, false);
}

bool has_limits(const Trajectory& t) { return t.certificate && t.certificate->limits.size() == t.dof(); }
bool is_certified(const Trajectory& t) { return has_limits(t) && t.certificate->holds() && t.timed(); }

bool same(const MotionLimits& a, const MotionLimits& b) {
  return a.velocity == b.velocity && a.acceleration == b.acceleration && a.jerk == b.jerk &&
         a.continuous == b.continuous && a.link_speeds == b.link_speeds && a.torque == b.torque &&
         a.payload == b.payload;
}

void delay(Certificate& c, double by) {
  for (double* time : {&c.position.time, &c.velocity.time, &c.acceleration.time, &c.jerk.time, &c.torque.time,
                       &c.checked_from, &c.clearance_time, &c.deviation_time})
    *time += by;
  for (LinkSpeedUse& use : c.link_speeds) {
    use.speed_time += by;
    use.angular_speed_time += by;
  }
  for (SampledInterval& part : c.sampled) {
    part.from += by;
    part.to += by;
  }
  if (!c.clearance_kept) return;
  c.clearance_kept->from += by;
  c.clearance_kept->to += by;
  for (RelaxedClearance& pair : c.clearance_kept->relaxed) {
    pair.from += by;
    pair.to += by;
  }
  for (TimeInterval& stop : c.clearance_kept->at_stops) {
    stop.from += by;
    stop.to += by;
  }
}

bool rests(const Trajectory& t) { return (t.positions.rowwise() - t.positions.row(0)).isZero(0.0); }

/// What is said of the clearance of two motions, for the whole of them: `then` is that of the second, delayed. Nothing
/// is said of the clearance of a rest, which lies between two motions.
void join_clearance(std::optional<ClearanceKept>& kept, const std::optional<ClearanceKept>& then,
                    const Trajectory& first, const Trajectory& next) {
  if (!then && rests(next)) return;
  if (!kept && rests(first)) {
    kept = then;
    return;
  }
  if (!kept || !then || kept->required != then->required) return kept.reset();
  if (then->from > kept->to) kept->at_stops.push_back({kept->to, then->from});
  kept->at_stops.insert(kept->at_stops.end(), then->at_stops.begin(), then->at_stops.end());
  kept->to = then->to;
  kept->violation = std::max(kept->violation, then->violation);
  kept->relaxed.insert(kept->relaxed.end(), then->relaxed.begin(), then->relaxed.end());
  for (const std::string& pair : then->close_links)
    if (std::find(kept->close_links.begin(), kept->close_links.end(), pair) == kept->close_links.end())
      kept->close_links.push_back(pair);
}

/// What is said of the clearance of a whole, for the part of it between two times.
void cut_clearance(std::optional<ClearanceKept>& kept, double begin, double end) {
  if (!kept) return;
  kept->from = std::clamp(kept->from, begin, end);
  kept->to = std::clamp(kept->to, begin, end);
  std::erase_if(kept->relaxed, [&](const RelaxedClearance& pair) { return pair.to < begin || pair.from > end; });
  for (RelaxedClearance& pair : kept->relaxed) {
    pair.from = std::max(pair.from, begin);
    pair.to = std::min(pair.to, end);
  }
  std::erase_if(kept->at_stops, [&](const TimeInterval& stop) { return stop.to < begin || stop.from > end; });
  for (TimeInterval& stop : kept->at_stops) stop = {std::max(stop.from, begin), std::min(stop.to, end)};
}

void take_faster(LinkSpeedUse& use, const LinkSpeedUse& then) {
  if (then.speed > use.speed) use.speed = then.speed, use.speed_time = then.speed_time;
  if (then.angular_speed > use.angular_speed)
    use.angular_speed = then.angular_speed, use.angular_speed_time = then.angular_speed_time;
}

}  // namespace

std::shared_ptr<const Certificate> certificate_of_part(const Trajectory& whole, const Trajectory& part) {
  if (!is_certified(whole)) return nullptr;
  Certificate c = without_request(*whole.certificate);
  const double begin = part.times[0], end = part.times[part.times.size() - 1];
  use_limits_of(part, c);
  c.collisions_checked = c.collisions_checked && c.checked_from < end;
  c.checked_from = std::max(c.checked_from, begin);
  if (!(c.clearance_time >= begin && c.clearance_time <= end) && !c.body_a.empty()) {
    c.clearance = c.clearance_proved;
    c.clearance_time = unknown;
    c.body_a.clear();
    c.body_b.clear();
  }
  std::erase_if(c.sampled, [&](const SampledInterval& s) { return s.to < begin || s.from > end; });
  for (SampledInterval& s : c.sampled) {
    s.from = std::max(s.from, begin);
    s.to = std::min(s.to, end);
  }
  cut_clearance(c.clearance_kept, begin, end);
  c.deviation = c.deviation_time = unknown;  // from the path of the whole, which the part has not
  return std::make_shared<const Certificate>(std::move(c));
}

std::shared_ptr<const Certificate> certificate_of_join(const Trajectory& first, const Trajectory& next,
                                                       const Trajectory& whole) {
  if (!is_certified(first) || !is_certified(next) || !same(first.certificate->limits, next.certificate->limits))
    return nullptr;
  Certificate c = without_request(*first.certificate), then = *next.certificate;
  const double seam = first.times[first.times.size() - 1];
  if (then.checked_from > next.times[0]) c.checked_from = then.checked_from + seam - next.times[0];
  delay(then, seam - next.times[0]);
  if (then.position.fraction > c.position.fraction) c.position = then.position;
  for (std::size_t i = 0; i < std::min(c.link_speeds.size(), then.link_speeds.size()); ++i)
    take_faster(c.link_speeds[i], then.link_speeds[i]);
  if (then.torque.fraction > c.torque.fraction) c.torque = then.torque;
  use_limits_of(whole, c);
  c.collisions_checked = c.collisions_checked && then.collisions_checked;
  if (then.clearance < c.clearance) {
    c.clearance = then.clearance;
    c.clearance_time = then.clearance_time;
    c.body_a = then.body_a;
    c.body_b = then.body_b;
  }
  c.clearance_proved = std::min(c.clearance_proved, then.clearance_proved);
  c.sampled.insert(c.sampled.end(), then.sampled.begin(), then.sampled.end());
  if (!(then.deviation <= c.deviation)) {  // NaN too
    c.deviation = std::isnan(c.deviation) ? c.deviation : then.deviation;
    c.deviation_time = std::isnan(c.deviation) ? unknown : then.deviation_time;
  }
  join_clearance(c.clearance_kept, then.clearance_kept, first, next);
  c.cartesian_deviation.reset();
  c.constraints.clear();  // the two may have had others
  c.goal_error = then.goal_error;
  c.time_s += then.time_s;
  return std::make_shared<const Certificate>(std::move(c));
}

std::shared_ptr<const Certificate> certificate_of_limits(const Trajectory& of, const Trajectory& motion) {
  if (!has_limits(of)) return nullptr;
  Certificate c;
  c.limits = of.certificate->limits;
  check_limits(motion, c.limits, {.joints = joints_of(motion)}, c);
  if (motion.robot) add_bounds_of_robot(motion, c, true);
  c.deviation = c.deviation_time = unknown;
  return std::make_shared<const Certificate>(std::move(c));
}

}  // namespace srmp
