#include "srmp/trajectory/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace srmp {

namespace {

std::string number(double value, double scale = 1.0) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value * scale);
  return text;
}

std::string line(const char* what, const LimitUse& use) {
  if (std::isinf(use.fraction))
    return std::string(what) + "unbounded (" + use.joint + " at " + number(use.time) + " s)";
  std::string text = std::string(what) + number(use.fraction, 100.0) + " % of the limit";
  return use.joint.empty() ? text : text + " (" + use.joint + " at " + number(use.time) + " s)";
}

std::string speed_text(const LinkSpeedUse& use) {
  std::string text = use.limit.link + ": ";
  if (std::isfinite(use.limit.speed))
    text += number(use.speed) + " m/s at most, " + number(use.speed / use.limit.speed, 100.0) + " % of the limit (at " +
            number(use.speed_time) + " s)";
  if (!std::isfinite(use.limit.angular_speed)) return text;
  if (std::isfinite(use.limit.speed)) text += "; ";
  return text + number(use.angular_speed) + " rad/s at most, " +
         number(use.angular_speed / use.limit.angular_speed, 100.0) + " % of the limit (at " +
         number(use.angular_speed_time) + " s)";
}

std::string clearance_text(const Certificate& c) {
  if (!c.collisions_checked) return "not checked";
  if (c.body_a.empty() && std::isfinite(c.clearance))
    return "at least " + number(c.clearance, 1e3) + " mm, as proved of the motion that this is a part of";
  if (c.body_a.empty()) return "nothing to collide with";
  return number(c.clearance, 1e3) + " mm, " + c.body_a + " and " + c.body_b + " at " + number(c.clearance_time) +
         " s; proved at least " + number(c.clearance_proved, 1e3) + " mm";
}

bool collides(const Certificate& c) {
  return std::any_of(c.faults.begin(), c.faults.end(),
                     [](const Fault& fault) { return fault.kind == FaultKind::collision; });
}

std::string kept_text(const ClearanceKept& kept) {
  std::string text = number(kept.required, 1e3) + " mm, " +
                     (kept.violation > 0.0 ? "broken by " + number(kept.violation, 1e3) + " mm" : "kept") + " from " +
                     number(kept.from) + " to " + number(kept.to) + " s";
  for (const RelaxedClearance& pair : kept.relaxed)
    text += "; " + pair.body_a + " and " + pair.body_b + " have " + number(pair.clearance, 1e3) + " mm at the " +
            (pair.from < kept.from ? "start"
             : pair.to > kept.to   ? "end"
                                   : "stop at " + number(pair.from) + " s");
  return text;
}

std::string free_text(const Certificate& c) {
  if (!c.collisions_checked) return "not checked";
  if (c.proved_free()) return "all of the motion, also between samples";
  if (collides(c)) return "no: it collides";
  return "all but " + std::to_string(c.sampled.size()) + " parts, which are free at samples";
}

}  // namespace

std::string to_string(FaultKind kind) {
  switch (kind) {
    case FaultKind::joint_names: return "joint_names";
    case FaultKind::shape: return "shape";
    case FaultKind::not_finite: return "not_finite";
    case FaultKind::times: return "times";
    case FaultKind::position_limit: return "position_limit";
    case FaultKind::velocity_limit: return "velocity_limit";
    case FaultKind::acceleration_limit: return "acceleration_limit";
    case FaultKind::jerk_limit: return "jerk_limit";
    case FaultKind::collision: return "collision";
    case FaultKind::deviation: return "deviation";
    case FaultKind::start: return "start";
    case FaultKind::goal: return "goal";
    case FaultKind::not_at_rest: return "not_at_rest";
    case FaultKind::constraint: return "constraint";
    case FaultKind::clearance: return "clearance";
    case FaultKind::link_speed_limit: return "link_speed_limit";
    case FaultKind::torque_limit: return "torque_limit";
  }
  return "unknown";
}

bool Certificate::proved_free() const { return collisions_checked && sampled.empty() && !collides(*this); }

std::string Certificate::report() const {
  std::string text;
  for (const Fault& fault : faults) text += "FAULT " + to_string(fault.kind) + ": " + fault.text + "\n";
  text += line("positions      ", position) + "\n";
  text += line("velocities     ", velocity) + "\n";
  text += line("accelerations  ", acceleration) + "\n";
  text += line("jerks          ", jerk) + "\n";
  for (const LinkSpeedUse& use : link_speeds) text += "link speed     " + speed_text(use) + "\n";
  if (limits.torque.size()) text += line("torques        ", torque) + "\n";
  text += "clearance      " + clearance_text(*this) + "\n";
  text += "proved free    " + free_text(*this) + "\n";
  text += "deviation      " +
          (std::isnan(deviation) ? "not known" : number(deviation, 1e3) + " mm from the checked path") + "\n";
  if (cartesian_deviation)
    text += "poses followed " + number(cartesian_deviation->position, 1e3) + " mm, " +
            number(cartesian_deviation->rotation, 180.0 / M_PI) + " degrees away at most\n";
  if (clearance_kept) text += "required       " + kept_text(*clearance_kept) + "\n";
  for (const ConstraintDeviation& kept : constraints)
    text += "constraint     " + kept.constraint + ": " + number(kept.deviation / kept.tolerance, 100.0) +
            " % of the tolerance at most\n";
  return text;
}

}  // namespace srmp
