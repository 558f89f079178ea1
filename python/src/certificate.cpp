#include "srmp/trajectory/certificate.hpp"

#include <cmath>
#include <limits>

#include "bind.hpp"
#include "srmp/io/trajectory_file.hpp"

namespace srmp::python {

namespace {

/// NaN stands for "none" in a certificate; as None it is equal to itself.
nb::object plain(double value) { return std::isnan(value) ? nb::none() : nb::object(nb::float_(value)); }
double number(nb::handle value) {
  return value.is_none() ? std::numeric_limits<double>::quiet_NaN() : nb::cast<double>(value);
}

std::vector<double> to_list(const Eigen::VectorXd& v) { return {v.begin(), v.end()}; }
Eigen::VectorXd to_vector(nb::handle list) {
  const auto values = nb::cast<std::vector<double>>(list);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

MotionLimits make_limits(const ArrayLike& velocity, const ArrayLike& acceleration, const ArrayLike& jerk,
                         const std::vector<bool>& continuous, nb::handle link_speeds,
                         const std::optional<ArrayLike>& torque, const std::optional<Payload>& payload) {
  MotionLimits limits{.velocity = velocity.vector("velocity limits"),
                      .acceleration = acceleration.vector("acceleration limits"),
                      .jerk = jerk.vector("jerk limits"),
                      .continuous = continuous,
                      .link_speeds = to_link_speeds(link_speeds),
                      .torque = torque ? torque->vector("torque limits") : Eigen::VectorXd(),
                      .payload = payload};
  std::vector<std::string> names;
  for (std::size_t j = 0; j < limits.size(); ++j) names.push_back("joint " + std::to_string(j));
  require_limits(limits, names);
  if (!continuous.empty() && continuous.size() != limits.size())
    throw InvalidArgument("continuous: got " + std::to_string(continuous.size()) + " flags, but there are " +
                          std::to_string(limits.size()) + " joints");
  return limits;
}

std::array<double, 3> to_array(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

LinkSpeedLimit make_link_limit(const std::string& link, std::optional<double> speed,
                               std::optional<double> angular_speed, const std::optional<ArrayLike>& point) {
  LinkSpeedLimit limit{.link = link};
  if (speed) limit.speed = *speed;
  if (angular_speed) limit.angular_speed = *angular_speed;
  if (point) limit.point = point->vector3("point_in_link");
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
  require_limits({one, one, one, {}, {limit}}, {"joint"});
  return limit;
}

std::string text_of(const LinkSpeedLimit& limit) {
  std::string text = "LinkSpeedLimit('" + limit.link + "'";
  if (std::isfinite(limit.speed)) text += ", " + to_text(limit.speed) + " m/s";
  if (std::isfinite(limit.angular_speed)) text += ", " + to_text(limit.angular_speed) + " rad/s";
  return text + ")";
}

void bind_link_speeds(nb::module_& m) {
  nb::class_<LinkSpeedLimit> limit(m, "LinkSpeedLimit",
                                   "A limit of how fast a link of the robot moves, at every instant.");
  limit
      .def(
          "__init__",
          [](LinkSpeedLimit* self, const std::string& link, std::optional<double> speed,
             std::optional<double> angular_speed, const std::optional<ArrayLike>& point) {
            new (self) LinkSpeedLimit(make_link_limit(link, speed, angular_speed, point));
          },
          nb::arg("link") = "", nb::arg("speed") = nb::none(), nb::arg("angular_speed") = nb::none(), nb::kw_only(),
          nb::arg("point_in_link") = nb::none(),
          "link: '' = the end effector. speed [m/s]: of the point (3,) of the link [m], default its origin. "
          "angular_speed\n"
          "[rad/s]. One of the two may be None: not limited.\n\n"
          "Raises InvalidArgument unless one of them is given, both are above 0, and the point is finite.")
      .def_ro("link", &LinkSpeedLimit::link, "The link; '' = the end effector.")
      .def_ro("speed", &LinkSpeedLimit::speed, "[m/s]; inf: not limited.")
      .def_ro("angular_speed", &LinkSpeedLimit::angular_speed, "[rad/s]; inf: not limited.")
      .def_prop_ro(
          "point_in_link", [](const LinkSpeedLimit& l) { return to_numpy(l.point); },
          "Whose speed it is (3,), in the link's frame [m].")
      .def("__repr__", [](const LinkSpeedLimit& l) { return text_of(l); });
  make_value(
      limit,
      [](const LinkSpeedLimit& l) { return nb::make_tuple(l.link, l.speed, l.angular_speed, to_array(l.point)); },
      [](const State& s) {
        const auto p = nb::cast<std::array<double, 3>>(s[3]);
        return LinkSpeedLimit{nb::cast<std::string>(s[0]), number(s[1]), number(s[2]), {p[0], p[1], p[2]}};
      });

  nb::class_<LinkSpeedUse> use(m, "LinkSpeedUse",
                               "How fast a link moves, at most: proved over the whole motion, not at samples.");
  use.def_ro("limit", &LinkSpeedUse::limit, "LinkSpeedLimit that it was verified against, with the link's name.")
      .def_ro("speed", &LinkSpeedUse::speed, "Of its point [m/s]; 0 where it is not limited.")
      .def_ro("speed_time", &LinkSpeedUse::speed_time, "About when it is fastest [s].")
      .def_ro("angular_speed", &LinkSpeedUse::angular_speed, "[rad/s]; 0 where it is not limited.")
      .def_ro("angular_speed_time", &LinkSpeedUse::angular_speed_time, "About when it turns fastest [s].")
      .def_prop_ro("fraction", &LinkSpeedUse::fraction, "The larger one, as a fraction of its limit.")
      .def("__repr__", [](const LinkSpeedUse& u) {
        return "LinkSpeedUse('" + u.limit.link + "', " + to_text(u.fraction()) + " of the limit)";
      });
  make_value(
      use,
      [](const LinkSpeedUse& u) {
        return nb::make_tuple(u.limit, plain(u.speed), plain(u.speed_time), plain(u.angular_speed),
                              plain(u.angular_speed_time));
      },
      [](const State& s) {
        return LinkSpeedUse{nb::cast<LinkSpeedLimit>(s[0]), number(s[1]), number(s[2]), number(s[3]), number(s[4])};
      });
}

Payload make_payload(double mass, const std::optional<ArrayLike>& center_of_mass,
                     const std::optional<ArrayLike>& inertia, const std::string& link) {
  Payload payload{.mass = mass, .link = link};
  if (center_of_mass) payload.center_of_mass = center_of_mass->vector3("center_of_mass");
  if (inertia) payload.inertia = inertia->vector3("inertia");
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(1);
  require_limits({.velocity = one, .acceleration = one, .jerk = one, .continuous = {}, .payload = payload}, {"joint"});
  return payload;
}

void bind_payload(nb::module_& m) {
  nb::class_<Payload> payload(m, "Payload", "What a link carries, for the torques of the joints.");
  payload
      .def(
          "__init__",
          [](Payload* self, double mass, const std::optional<ArrayLike>& center_of_mass,
             const std::optional<ArrayLike>& inertia,
             const std::string& link) { new (self) Payload(make_payload(mass, center_of_mass, inertia, link)); },
          nb::arg("mass"), nb::kw_only(), nb::arg("center_of_mass") = nb::none(), nb::arg("inertia") = nb::none(),
          nb::arg("link") = "",
          "mass [kg]; center_of_mass (3,) in the link's frame [m], default its origin; inertia (3,) about it, for the\n"
          "link's axes [kg m^2], default 0; link: '' = the end effector.\n\n"
          "Raises InvalidArgument unless the mass is above 0 and all numbers are finite.")
      .def_ro("mass", &Payload::mass, "Its mass [kg].")
      .def_prop_ro(
          "center_of_mass", [](const Payload& p) { return to_numpy(p.center_of_mass); },
          "(3,), in the link's frame [m].")
      .def_prop_ro(
          "inertia", [](const Payload& p) { return to_numpy(p.inertia); },
          "(3,) about the centre of mass, for the link's axes [kg m^2].")
      .def_ro("link", &Payload::link, "The link; '' = the end effector.")
      .def("__repr__", [](const Payload& p) {
        return "Payload(" + to_text(p.mass) + (p.link.empty() ? " kg)" : " kg on '" + p.link + "')");
      });
  make_value(
      payload,
      [](const Payload& p) { return nb::make_tuple(p.mass, to_array(p.center_of_mass), to_array(p.inertia), p.link); },
      [](const State& s) {
        const auto c = nb::cast<std::array<double, 3>>(s[1]), i = nb::cast<std::array<double, 3>>(s[2]);
        return Payload{number(s[0]), {c[0], c[1], c[2]}, {i[0], i[1], i[2]}, nb::cast<std::string>(s[3])};
      });
}

void bind_limits(nb::module_& m) {
  nb::class_<MotionLimits> limits(m, "MotionLimits",
                                  "Limits of each joint's motion, one entry a joint, in the order of the joint names.");
  limits
      .def(
          "__init__",
          [](MotionLimits* self, const ArrayLike& velocity, const ArrayLike& acceleration, const ArrayLike& jerk,
             const std::vector<bool>& continuous, nb::handle link_speeds, const std::optional<ArrayLike>& torque,
             const std::optional<Payload>& payload) {
            new (self)
                MotionLimits(make_limits(velocity, acceleration, jerk, continuous, link_speeds, torque, payload));
          },
          nb::arg("velocity"), nb::arg("acceleration"), nb::arg("jerk"), nb::arg("continuous") = std::vector<bool>{},
          nb::kw_only(), nb::arg("link_speeds") = nb::none(), nb::arg("torque") = nb::none(),
          nb::arg("payload") = nb::none(),
          nb::sig("def __init__(self, velocity: numpy.typing.ArrayLike, acceleration: numpy.typing.ArrayLike, "
                  "jerk: numpy.typing.ArrayLike, continuous: collections.abc.Sequence[bool] = [], *, "
                  "link_speeds: " SRMP_LINK_SPEEDS " | None = None, torque: numpy.typing.ArrayLike | None = None, "
                  "payload: Payload | None = None) -> None"),
          "(dof,) each: velocity [rad/s or m/s], acceleration [rad/s^2 or m/s^2], jerk [rad/s^3 or m/s^3]; continuous: "
          "a flag a joint,\n"
          "empty = none is. link_speeds: limits of links, as PlannerInterface.set_motion_limits takes them. torque: "
          "(dof,)\n"
          "[N m, prismatic joints N], inf = not limited; None: none is. payload: what the robot carries.\n\n"
          "Raises InvalidArgument unless all have one entry a joint, above 0 and finite.")
      .def_prop_ro(
          "velocity", [](const MotionLimits& l) { return to_numpy(l.velocity); },
          "Velocity limits (dof,) [rad/s or m/s].")
      .def_prop_ro(
          "acceleration", [](const MotionLimits& l) { return to_numpy(l.acceleration); },
          "Acceleration limits (dof,) [rad/s^2 or m/s^2].")
      .def_prop_ro(
          "jerk", [](const MotionLimits& l) { return to_numpy(l.jerk); }, "Jerk limits (dof,) [rad/s^3 or m/s^3].")
      .def_ro("continuous", &MotionLimits::continuous,
              "Joints whose waypoints must follow by the short way round; empty = none.")
      .def_ro("link_speeds", &MotionLimits::link_speeds, "Limits of links, as LinkSpeedLimit; any number of a link.")
      .def_prop_ro(
          "torque",
          [](const MotionLimits& l) { return l.torque.size() ? std::optional(to_numpy(l.torque)) : std::nullopt; },
          nb::sig("def torque(self) -> numpy.typing.NDArray[numpy.float64] | None"),
          "Torque limits (dof,) [N m, prismatic joints N], inf: not limited; None: none is.")
      .def_ro("payload", &MotionLimits::payload, "What the robot carries, for the torques; None: nothing.")
      .def("__repr__", [](const MotionLimits& l) { return "MotionLimits(" + std::to_string(l.size()) + " joints)"; });
  make_value(
      limits,
      [](const MotionLimits& l) {
        return nb::make_tuple(to_list(l.velocity), to_list(l.acceleration), to_list(l.jerk), l.continuous,
                              l.link_speeds, to_list(l.torque), l.payload);
      },
      [](const State& s) {
        return MotionLimits{to_vector(s[0]),
                            to_vector(s[1]),
                            to_vector(s[2]),
                            nb::cast<std::vector<bool>>(s[3]),
                            nb::cast<std::vector<LinkSpeedLimit>>(s[4]),
                            to_vector(s[5]),
                            nb::cast<std::optional<Payload>>(s[6])};
      });
}

void bind_default_limits(nb::module_& m) {
  m.def(
      "default_limits", [](const ArrayLike& velocity) { return default_limits(velocity.vector("velocity limits")); },
      nb::arg("velocity"),
      "MotionLimits for robots of which only velocity limits are known, (dof,) [rad/s or m/s]: acceleration = 2/s * "
      "velocity, full "
      "speed in half a\n"
      "second, and jerk = 10/s * acceleration. A velocity of 0, infinite, or above 1e6 means that there is no limit "
      "and "
      "becomes 1.\n\n"
      "Raises InvalidArgument when one is negative or NaN.");
}

void bind_faults(nb::module_& m) {
  nb::enum_<FaultKind>(m, "FaultKind", "What can be wrong with a trajectory.")
      .value("joint_names", FaultKind::joint_names, "Not those of the robot, or in another order.")
      .value("shape", FaultKind::shape, "Arrays that do not fit together, or none at all.")
      .value("not_finite", FaultKind::not_finite, "NaN or infinity.")
      .value("times", FaultKind::times, "A time that does not increase.")
      .value("position_limit", FaultKind::position_limit, "A joint outside its limits.")
      .value("velocity_limit", FaultKind::velocity_limit, "A joint faster than its limit.")
      .value("acceleration_limit", FaultKind::acceleration_limit, "A joint that accelerates beyond its limit.")
      .value("jerk_limit", FaultKind::jerk_limit, "A joint with more jerk than its limit.")
      .value("collision", FaultKind::collision, "Two bodies touch, or come within their padding.")
      .value("deviation", FaultKind::deviation, "The motion leaves the path that was checked.")
      .value("start", FaultKind::start, "It does not begin at the given start.")
      .value("goal", FaultKind::goal, "It does not end at the given goal.")
      .value("not_at_rest", FaultKind::not_at_rest, "Its velocity at the start or end is not 0, though it should be.")
      .value("constraint", FaultKind::constraint, "It breaks a path constraint, or is not proved to keep it.")
      .value("clearance", FaultKind::clearance,
             "It comes closer to something than the clearance that was asked for allows.")
      .value("torque_limit", FaultKind::torque_limit,
             "A joint that needs more torque than its limit, or is not proved to keep it.")
      .value("link_speed_limit", FaultKind::link_speed_limit,
             "A link is faster than its limit, or is not proved to keep it.");

  nb::class_<Fault> fault(m, "Fault", "Something that is wrong, and where.");
  fault.def_ro("kind", &Fault::kind, "The kind of the fault.")
      .def_ro("text", &Fault::text, "What is wrong, as a sentence.")
      .def_ro("time", &Fault::time, "[s] when it is worst; NaN: at no particular time.")
      .def("__repr__", [](const Fault& f) { return "Fault(" + to_string(f.kind) + ": " + f.text + ")"; });
  make_value(
      fault, [](const Fault& f) { return nb::make_tuple(f.kind, f.text, plain(f.time)); },
      [](const State& s) { return Fault{nb::cast<FaultKind>(s[0]), nb::cast<std::string>(s[1]), number(s[2])}; });
}

void bind_parts(nb::module_& m) {
  nb::class_<LimitUse> use(m, "LimitUse", "The largest fraction of a limit that is used over the whole motion.");
  use.def_ro(
         "fraction", &LimitUse::fraction,
         "Of the limit; 1 = all of it. Positions: of the distance from the middle of the range to its end. Jerks: inf\n"
         "where the acceleration jumps (from and to rest too), as with TOPP-RA.")
      .def_ro("joint", &LimitUse::joint, "By which joint; '' = nothing moves, or there is no limit.")
      .def_ro("time", &LimitUse::time, "The time of it [s].")
      .def("__repr__", [](const LimitUse& u) {
        return "LimitUse(" + to_text(u.fraction) + (u.joint.empty() ? "" : ", " + u.joint) + ")";
      });
  make_value(
      use, [](const LimitUse& u) { return nb::make_tuple(plain(u.fraction), u.joint, plain(u.time)); },
      [](const State& s) { return LimitUse{number(s[0]), nb::cast<std::string>(s[1]), number(s[2])}; });

  nb::class_<CartesianDeviation> deviation(m, "CartesianDeviation",
                                           "How far a link leaves the poses that it follows, at most: proved over the "
                                           "whole motion, not at samples.");
  deviation.def_ro("position", &CartesianDeviation::position, "Of the link's origin [m].")
      .def_ro("rotation", &CartesianDeviation::rotation, "Of its rotation [rad].")
      .def_ro("time", &CartesianDeviation::time, "About when it is farthest away, as fractions of the tolerance [s].")
      .def("__repr__", [](const CartesianDeviation& d) {
        return "CartesianDeviation(" + to_text(d.position) + " m, " + to_text(d.rotation) + " rad)";
      });
  make_value(
      deviation,
      [](const CartesianDeviation& d) { return nb::make_tuple(plain(d.position), plain(d.rotation), plain(d.time)); },
      [](const State& s) { return CartesianDeviation{number(s[0]), number(s[1]), number(s[2])}; });

  nb::class_<ConstraintDeviation> kept(m, "ConstraintDeviation",
                                       "How far a motion goes from the middle of what a path constraint allows, at "
                                       "most: proved, not sampled.");
  kept.def_ro("constraint", &ConstraintDeviation::constraint, "The constraint in words.")
      .def_ro("deviation", &ConstraintDeviation::deviation,
              "[rad or m]: of a distance, from the middle of its range; with a tolerance for each axis, the largest\n"
              "fraction of these times `tolerance`.")
      .def_ro("tolerance", &ConstraintDeviation::tolerance, "[rad or m] that is allowed: of several, the smallest.")
      .def_ro("time", &ConstraintDeviation::time, "About when it is worst [s].")
      .def("__repr__", [](const ConstraintDeviation& d) {
        return "ConstraintDeviation(" + d.constraint + ": " + to_text(d.deviation) + " of " + to_text(d.tolerance) +
               ")";
      });
  make_value(
      kept,
      [](const ConstraintDeviation& d) {
        return nb::make_tuple(d.constraint, plain(d.deviation), plain(d.tolerance), plain(d.time));
      },
      [](const State& s) {
        return ConstraintDeviation{nb::cast<std::string>(s[0]), number(s[1]), number(s[2]), number(s[3])};
      });

  nb::class_<SampledInterval> sampled(m, "SampledInterval",
                                      "A part of a motion over which two bodies could not be proved to stay apart; "
                                      "they are apart at every sample in it.");
  sampled.def_ro("from_time", &SampledInterval::from, "Begin of the interval [s].")
      .def_ro("to_time", &SampledInterval::to, "End of the interval [s].")
      .def_ro("body_a", &SampledInterval::body_a, "Link (or attached object) of the robot.")
      .def_ro("body_b", &SampledInterval::body_b, "Object, link of the same robot, or 'robot/link' of another.")
      .def("__repr__", [](const SampledInterval& i) {
        return "SampledInterval(" + to_text(i.from) + " s to " + to_text(i.to) + " s, " + i.body_a + " and " +
               i.body_b + ")";
      });
  make_value(
      sampled, [](const SampledInterval& i) { return nb::make_tuple(plain(i.from), plain(i.to), i.body_a, i.body_b); },
      [](const State& s) {
        return SampledInterval{number(s[0]), number(s[1]), nb::cast<std::string>(s[2]), nb::cast<std::string>(s[3])};
      });
}

using Stops = std::vector<std::pair<double, double>>;

Stops at_stops(const ClearanceKept& kept) {
  Stops stops;
  for (const TimeInterval& stop : kept.at_stops) stops.emplace_back(stop.from, stop.to);
  return stops;
}

std::vector<TimeInterval> intervals(const Stops& stops) {
  std::vector<TimeInterval> result;
  for (const auto& [from, to] : stops) result.push_back({from, to});
  return result;
}

void bind_clearance(nb::module_& m) {
  nb::class_<RelaxedClearance> relaxed(m, "RelaxedClearance",
                                       "Two bodies that are closer to each other than the required clearance near an "
                                       "end of a motion, where they need not\nkeep it.");
  relaxed.def_ro("body_a", &RelaxedClearance::body_a, "Link (or attached object) of the robot.")
      .def_ro("body_b", &RelaxedClearance::body_b, "Object, link of the same robot, or 'robot/link' of another.")
      .def_ro("clearance", &RelaxedClearance::clearance, "At that end, less the padding: the least [m].")
      .def_ro("from_time", &RelaxedClearance::from, "Begin of the part over which they are closer [s].")
      .def_ro("to_time", &RelaxedClearance::to, "End of that part [s].")
      .def("__repr__", [](const RelaxedClearance& r) {
        return "RelaxedClearance(" + r.body_a + " and " + r.body_b + ": " + to_text(r.clearance) + " m)";
      });
  make_value(
      relaxed,
      [](const RelaxedClearance& r) {
        return nb::make_tuple(r.body_a, r.body_b, plain(r.clearance), plain(r.from), plain(r.to));
      },
      [](const State& s) {
        return RelaxedClearance{nb::cast<std::string>(s[0]), nb::cast<std::string>(s[1]), number(s[2]), number(s[3]),
                                number(s[4])};
      });

  nb::class_<ClearanceKept> kept(m, "ClearanceKept", "How a motion keeps the clearance that was required of it.");
  kept.def_ro("required", &ClearanceKept::required, "The option `clearance` [m].")
      .def_ro("from_time", &ClearanceKept::from,
              "[s]: from here to `to_time` no pair of bodies comes closer than `required`, also between samples: this "
              "is proved.\nThe whole motion, if both ends keep it. Without what `at_stops` has.")
      .def_ro("to_time", &ClearanceKept::to, "The end of that part [s].")
      .def_ro("violation", &ClearanceKept::violation,
              "[m] the most by which a pair breaks the rule: between `from_time` and `to_time`, by which it is closer "
              "than\n`required`; before and after, at samples, by which a pair that is closer comes closer still on "
              "its way from the\nstart or back from the end (beyond a tolerance of 0.02 mm), or is closer though it "
              "was not at the end. 0: the rule\nis kept.")
      .def_ro("relaxed", &ClearanceKept::relaxed, "RelaxedClearances near the ends, those of the start first.")
      .def_ro(
          "close_links", &ClearanceKept::close_links,
          "Pairs of the robot's links, 'a and b', that only may not touch: they are built closer to each other than "
          "`required`,\nand are closer in at least half of the robot's configurations.")
      .def_prop_ro(
          "at_stops", at_stops,
          "(from, to) [s] of a motion made of several (`Trajectory.followed_by`, sequences): the parts between "
          "`from_time` and\n`to_time` where one of them ends and the next begins, and pairs may be closer, by the rule "
          "of the ends.")
      .def("__repr__", [](const ClearanceKept& k) {
        return "ClearanceKept(" + to_text(k.required) + " m, violation " + to_text(k.violation) + " m)";
      });
  make_value(
      kept,
      [](const ClearanceKept& k) {
        return nb::make_tuple(plain(k.required), plain(k.from), plain(k.to), plain(k.violation), k.relaxed,
                              k.close_links, at_stops(k));
      },
      [](const State& s) {
        return ClearanceKept{number(s[0]),
                             number(s[1]),
                             number(s[2]),
                             number(s[3]),
                             nb::cast<std::vector<RelaxedClearance>>(s[4]),
                             nb::cast<std::vector<std::string>>(s[5]),
                             intervals(nb::cast<Stops>(s[6]))};
      });
}

std::string repr(const Certificate& c) {
  if (!c.holds())
    return "Certificate(" + std::to_string(c.faults.size()) + (c.faults.size() == 1 ? " fault: " : " faults, first: ") +
           c.faults.front().text + ")";
  if (!c.collisions_checked) return "Certificate(holds, collisions not checked)";
  return c.proved_free() ? "Certificate(holds, proved free)"
                         : "Certificate(holds, free; " + std::to_string(c.sampled.size()) + " parts at samples)";
}

nb::tuple state(const Certificate& c) {
  return nb::make_tuple(c.faults, c.limits, c.position, c.velocity, c.acceleration, c.jerk, c.collisions_checked,
                        plain(c.checked_from), plain(c.clearance), plain(c.clearance_time), c.body_a, c.body_b,
                        plain(c.clearance_proved), c.sampled, plain(c.deviation), plain(c.deviation_time),
                        plain(c.goal_error), plain(c.bound), c.bound_graph, plain(c.time_s), c.cartesian_deviation,
                        c.constraints, c.clearance_kept, c.link_speeds, c.torque);
}

Certificate from_state(const State& s) {
  const auto text = [&](std::size_t i) { return nb::cast<std::string>(s[i]); };
  const auto use = [&](std::size_t i) { return nb::cast<LimitUse>(s[i]); };
  return {.faults = nb::cast<std::vector<Fault>>(s[0]),
          .limits = nb::cast<MotionLimits>(s[1]),
          .position = use(2),
          .velocity = use(3),
          .acceleration = use(4),
          .jerk = use(5),
          .link_speeds = nb::cast<std::vector<LinkSpeedUse>>(s[23]),
          .torque = use(24),
          .collisions_checked = nb::cast<bool>(s[6]),
          .checked_from = number(s[7]),
          .clearance = number(s[8]),
          .clearance_time = number(s[9]),
          .body_a = text(10),
          .body_b = text(11),
          .clearance_proved = number(s[12]),
          .sampled = nb::cast<std::vector<SampledInterval>>(s[13]),
          .deviation = number(s[14]),
          .deviation_time = number(s[15]),
          .cartesian_deviation = nb::cast<std::optional<CartesianDeviation>>(s[20]),
          .constraints = nb::cast<std::vector<ConstraintDeviation>>(s[21]),
          .clearance_kept = nb::cast<std::optional<ClearanceKept>>(s[22]),
          .goal_error = number(s[16]),
          .bound = number(s[17]),
          .bound_graph = text(18),
          .time_s = number(s[19])};
}

}  // namespace

void bind_certificate(nb::module_& m) {
  bind_link_speeds(m);
  bind_payload(m);
  bind_limits(m);
  bind_default_limits(m);
  bind_faults(m);
  bind_parts(m);
  bind_clearance(m);
  nb::class_<Certificate> cls(m, "Certificate",
                              "What is known of a trajectory, found by code that is independent of the code that made "
                              "it. All of it is about the\n"
                              "polynomials between the rows, at every instant, not about samples.");
  cls.def_prop_ro("holds", &Certificate::holds, "There are no faults.")
      .def_prop_ro("proved_free", &Certificate::proved_free,
                   "Collisions were checked, there is none, and all of the motion is proved free, between samples too.")
      .def("report", &Certificate::report, "A text with one line for each claim.")
      .def(
          "to_dict",
          [](const Certificate& c) {
            const nb::module_ json = nb::module_::import_("json");
            return json.attr("loads")(io::to_json(c),
                                      nb::arg("parse_int") = nb::borrow(reinterpret_cast<PyObject*>(&PyFloat_Type)));
          },
          nb::sig("def to_dict(self) -> dict[str, typing.Any]"),
          "All fields as names, numbers and lists, as in files; infinity and NaN are the texts 'inf', '-inf' and "
          "'nan'. There is no key 'cartesian_deviation' where no poses were to be followed, no key\n"
          "'constraints' where there were no path constraints, no key 'clearance_kept' where no clearance was "
          "required, no key 'link_speeds' where no link's speed was limited, and no key 'torque' where no torque was.")
      .def_ro("faults", &Certificate::faults, "Faults; empty: every claim below holds.")
      .def_ro("limits", &Certificate::limits, "MotionLimits that the motion was verified against.")
      .def_ro("position", &Certificate::position, "LimitUse of the position limits.")
      .def_ro("velocity", &Certificate::velocity, "LimitUse of the velocity limits.")
      .def_ro("acceleration", &Certificate::acceleration, "LimitUse of the acceleration limits.")
      .def_ro("jerk", &Certificate::jerk, "LimitUse of the jerk limits.")
      .def_ro("link_speeds", &Certificate::link_speeds,
              "LinkSpeedUse of each of MotionLimits.link_speeds: how fast links move, at most.")
      .def_ro("torque", &Certificate::torque,
              "LimitUse of the torque limits, proved between samples too; 0 where there are none.")
      .def_ro("collisions_checked", &Certificate::collisions_checked, "Whether collisions were checked.")
      .def_ro("checked_from", &Certificate::checked_from,
              "[s]: what comes before is the recovery from a start in collision.")
      .def_ro("clearance", &Certificate::clearance,
              "[m] the smallest that was found; inf: there is nothing to collide with.")
      .def_ro("clearance_time", &Certificate::clearance_time, "The time of the smallest clearance [s].")
      .def_ro("body_a", &Certificate::body_a, "Of the pair there: link (or attached object) of the robot.")
      .def_ro("body_b", &Certificate::body_b, "Object, link of the same robot, or 'robot/link' of another.")
      .def_ro("clearance_proved", &Certificate::clearance_proved,
              "[m]: no two bodies come nearer than this, also between samples.")
      .def_ro("sampled", &Certificate::sampled,
              "SampledIntervals: parts that are not proved free; empty: all of the motion is.")
      .def_ro("deviation", &Certificate::deviation,
              "[m]: no point of the robot leaves its path along the waypoints by more; NaN: not known.")
      .def_ro("deviation_time", &Certificate::deviation_time, "The time of the largest deviation [s].")
      .def_ro("cartesian_deviation", &Certificate::cartesian_deviation,
              "CartesianDeviation from the poses that were to be followed; None: there were none.")
      .def_ro("constraints", &Certificate::constraints,
              "A ConstraintDeviation for each path constraint of the request.")
      .def_ro("clearance_kept", &Certificate::clearance_kept,
              "ClearanceKept: how the motion keeps the option `clearance`; None: no clearance was required.")
      .def_ro("goal_error", &Certificate::goal_error,
              "Joint goals: of the worst joint [rad or m]; poses: over tolerance [m, rad]; NaN: no goal was given.")
      .def_ro("bound", &Certificate::bound,
              "The path costs at most this times the optimum of bound_graph; inf: nothing is proven.")
      .def_ro("bound_graph", &Certificate::bound_graph, "The graph that the bound is about.")
      .def_ro("time_s", &Certificate::time_s, "Computing time [s].")
      .def("__repr__", &repr);
  make_html(cls);
  make_value(cls, &state, &from_state);
}

}  // namespace srmp::python
