#include <algorithm>

#include "planner_interface.hpp"

namespace srmp::python {

namespace {

using Self = PyPlannerInterface;

bool is_number(nb::handle value) {
  if (nb::isinstance<nb::str>(value) || nb::isinstance<nb::bool_>(value)) return false;
  return nb::hasattr(value, "__float__") && nb::cast<int>(nb::module_::import_("numpy").attr("ndim")(value)) == 0;
}

/// Limits as users give them: None keeps what is, a number is for every joint, a dictionary for the joints it names.
Eigen::VectorXd to_limits(nb::handle value, const Eigen::VectorXd& now, const std::vector<std::string>& joints,
                          const std::string& what) {
  const auto text = [](nb::handle any) { return nb::cast<std::string>(nb::repr(any)); };
  const auto number = [](nb::handle any) { return nb::cast<double>(nb::float_(any)); };
  Eigen::VectorXd limits = now;
  if (value.is_none()) return limits;
  if (is_number(value)) return limits.setConstant(number(value));
  if (nb::isinstance<nb::str>(value) || nb::isinstance<nb::bool_>(value))
    throw InvalidArgument(what + " limits must be a number, one a joint, or a dictionary of joints, but are " +
                          text(value));
  if (!nb::hasattr(value, "keys")) return ArrayLike{nb::borrow<nb::object>(value)}.vector(what + " limits");
  for (const auto [key, item] : nb::cast<nb::dict>(nb::module_::import_("builtins").attr("dict")(value))) {
    const std::string name = nb::cast<std::string>(nb::str(key));
    const auto joint = std::find(joints.begin(), joints.end(), name);
    if (joint == joints.end()) {
      const std::string nearest = did_you_mean(name, joints);
      throw InvalidArgument(what + " limits name '" + name + "', which is no planned joint" +
                            (nearest.empty() ? "; these are " + quoted_list(joints) : nearest));
    }
    if (!is_number(item))
      throw InvalidArgument(name + ": the " + what + " limit is " + text(item) + "; it must be a number");
    limits[joint - joints.begin()] = number(item);
  }
  return limits;
}

double speed_of(nb::handle value, const std::string& link) {
  if (value.is_none()) return std::numeric_limits<double>::infinity();
  if (!is_number(value))
    throw InvalidArgument("the speed limit of link '" + link + "' is " + brief(value) +
                          "; it must be a number [m/s], or two: [m/s] and [rad/s], one of which may be None");
  return nb::cast<double>(nb::float_(value));
}

LinkSpeedLimit link_speed_of(const std::string& link, nb::handle value) {
  LinkSpeedLimit limit{.link = link};
  if (!nb::isinstance<nb::tuple>(value) && !nb::isinstance<nb::list>(value)) {
    limit.speed = speed_of(value, link);
  } else {
    if (nb::len(value) != 2) speed_of(nb::str("not two numbers"), link);
    limit.speed = speed_of(value[0], link);
    limit.angular_speed = speed_of(value[1], link);
  }
  return limit;
}

/// "urdf" is the URDF's effort limits, {} none; otherwise as other limits, infinite for what is not named.
Eigen::VectorXd to_torques(nb::handle value, const Eigen::VectorXd& now, const RobotModel& robot) {
  if (nb::isinstance<nb::str>(value)) {
    if (nb::cast<std::string>(value) == "urdf") return effort_limits(robot);
    throw InvalidArgument("torque limits are " + brief(value) +
                          "; as a text, only 'urdf' is known: the effort limits of the URDF");
  }
  if (nb::hasattr(value, "keys") && nb::len(value) == 0) return {};
  const auto dof = static_cast<Eigen::Index>(robot.dof());
  const Eigen::VectorXd none = Eigen::VectorXd::Constant(dof, std::numeric_limits<double>::infinity());
  return to_limits(value, now.size() ? now : none, robot.joint_names(), "torque");
}

/// 0 or False removes it.
std::optional<Payload> to_payload(nb::handle value) {
  if (nb::isinstance<Payload>(value)) return nb::cast<Payload>(value);
  if (is_number(value)) {
    const double mass = nb::cast<double>(nb::float_(value));
    return mass == 0.0 ? std::nullopt : std::optional(Payload{.mass = mass});
  }
  throw InvalidArgument("payload must be a Payload or a mass [kg], but is " + brief(value));
}

void set_motion_limits(PlannerInterface& planner, const std::string& robot, nb::handle velocity,
                       nb::handle acceleration, nb::handle jerk, nb::handle link_speeds, nb::handle torque,
                       nb::handle payload) {
  const std::vector<std::string> joints = planner.get_joint_names(robot);
  MotionLimits limits = planner.motion_limits(robot);
  limits.velocity = to_limits(velocity, limits.velocity, joints, "velocity");
  limits.acceleration = to_limits(acceleration, limits.acceleration, joints, "acceleration");
  limits.jerk = to_limits(jerk, limits.jerk, joints, "jerk");
  if (!link_speeds.is_none()) limits.link_speeds = to_link_speeds(link_speeds);
  if (!torque.is_none()) limits.torque = to_torques(torque, limits.torque, planner.robot(robot));
  if (!payload.is_none()) limits.payload = to_payload(payload);
  planner.set_motion_limits(robot, limits);
}

}  // namespace

std::vector<LinkSpeedLimit> to_link_speeds(nb::handle value) {
  std::vector<LinkSpeedLimit> limits;
  if (value.is_none()) return limits;
  if (nb::hasattr(value, "keys")) {
    for (const auto [link, item] : nb::cast<nb::dict>(nb::module_::import_("builtins").attr("dict")(value)))
      limits.push_back(link_speed_of(nb::cast<std::string>(nb::str(link)), item));
    return limits;
  }
  if (nb::isinstance<nb::str>(value) || !nb::hasattr(value, "__iter__"))
    throw InvalidArgument(
        "link_speeds must be a dictionary from links to speeds [m/s], or a list of LinkSpeedLimit, "
        "but is " +
        brief(value));
  for (nb::handle item : nb::iter(value)) {
    if (!nb::isinstance<LinkSpeedLimit>(item))
      throw InvalidArgument(
          "link_speeds must be a dictionary from links to speeds [m/s], or a list of "
          "LinkSpeedLimit, but holds " +
          brief(item));
    limits.push_back(nb::cast<LinkSpeedLimit>(item));
  }
  return limits;
}

void bind_verification(PlannerClass& cls) {
  cls.def(
         "motion_limits",
         [](Self& self, const std::string& robot) {
           return self.use([&](const PlannerInterface& p) { return p.motion_limits(robot); });
         },
         nb::arg("robot"),
         R"(The limits of the robot's joints, as MotionLimits: velocities of the URDF, and default_limits for the others, until
set_motion_limits.)")
      .def(
          "set_motion_limits",
          [](Self& self, const std::string& robot, nb::handle velocity, nb::handle acceleration, nb::handle jerk,
             nb::handle link_speeds, nb::handle torque, nb::handle payload) {
            self.use([&](PlannerInterface& p) {
              set_motion_limits(p, robot, velocity, acceleration, jerk, link_speeds, torque, payload);
            });
          },
          nb::arg("robot"), nb::arg("velocity") = nb::none(), nb::arg("acceleration") = nb::none(),
          nb::arg("jerk") = nb::none(), nb::arg("link_speeds") = nb::none(), nb::arg("torque") = nb::none(),
          nb::arg("payload") = nb::none(),
          nb::sig("def set_motion_limits(self, robot: str, "
                  "velocity: numpy.typing.ArrayLike | collections.abc.Mapping[str, float] | None = None, "
                  "acceleration: numpy.typing.ArrayLike | collections.abc.Mapping[str, float] | None = None, "
                  "jerk: numpy.typing.ArrayLike | collections.abc.Mapping[str, float] | None = None, "
                  "link_speeds: " SRMP_LINK_SPEEDS " | None = None, "
                  "torque: numpy.typing.ArrayLike | collections.abc.Mapping[str, float] | "
                  "typing.Literal['urdf'] | None = None, payload: Payload | float | None = None) -> None"),
          R"(Sets the limits of all plans that follow, dof entries each: velocity [rad/s or m/s], acceleration [rad/s^2 or
m/s^2], jerk [rad/s^3 or m/s^3].

Each is a number for all joints, (dof,) numbers, or a dictionary {joint name: number}; what is not named stays.

link_speeds replaces the limits of links: {link: speed [m/s]}, {link: (speed, angular speed [rad/s])} with None for one
that is not limited, or a list of LinkSpeedLimit, for points of links. {} removes them; the link '' is the end effector.
They are limits in the world at every instant, which velocity_scaling does not change; Certificate.link_speeds has the
proved speeds.

torque [N m, prismatic joints N]: of the torques that the motion needs in gravity, by the masses of the URDF and the
payload, at every instant; 'urdf' is the URDF's effort limits, inf not limited, {} removes all. payload: a Payload, or a
mass [kg] at the origin of the end effector; 0 removes it. Certificate.torque has what is proved.

Raises InvalidArgument for an unknown robot, joint or link (with the nearest name), a wrong size, a link that no planned
joint moves, torques of a robot without masses, and limits that are not above 0 and finite.)")
      .def(
          "load_joint_limits",
          [](Self& self, const std::string& robot, const nb::object& path) {
            return self.use([&](PlannerInterface& p) { return p.load_joint_limits(robot, to_path(path)); });
          },
          nb::arg("robot"), nb::arg("path"),
          nb::sig("def load_joint_limits(self, robot: str, path: str | os.PathLike[str]) -> list[str]"),
          R"(Replaces the limits that were set by those of a MoveIt joint_limits.yaml (rad, m, s).

Read are max_velocity, max_acceleration and max_jerk where has_…_limits is not false;
default_velocity_scaling_factor and default_acceleration_scaling_factor multiply those of all joints, the latter
jerks too. What the file does not say is as in default_limits. Returns the joints in it that are not planned ones:
they were not used.

Raises FileError, with the line, for a missing file, unknown keys (with the nearest), and values out of range;
NotSupported for position limits narrower than the URDF's, limits of deceleration or effort, and soft limits.)")
      .def(
          "verify",
          [](Self& self, const std::string& robot, const Trajectory& trajectory, const std::optional<ArrayLike>& start,
             nb::handle goals, const std::optional<MotionLimits>& limits, bool jerk,
             std::optional<double> max_deviation, double gap_tolerance, bool at_rest,
             const std::optional<ArrayLike>& start_velocity, const std::optional<ArrayLike>& start_acceleration,
             const std::vector<PathConstraint>& constraints, double clearance) {
            VerifyOptions options{
                .limits = limits,
                .jerk = jerk,
                .at_rest = at_rest,
                .start_velocity = vector_or_none(start_velocity, "start_velocity of '" + robot + "'"),
                .start_acceleration = vector_or_none(start_acceleration, "start_acceleration of '" + robot + "'"),
                .max_deviation = max_deviation,
                .gap_tolerance = gap_tolerance,
                .constraints = constraints,
                .clearance = clearance};
            if (start) options.start = start->vector("start of '" + robot + "'");
            const std::vector<Goal> forms = goals.is_none() ? std::vector<Goal>{} : to_goals(goals);
            return self.use([&](const PlannerInterface& p) {
              for (const Goal& goal : forms) options.goals.push_back(p.goal(robot, goal, options.start));
              const nb::gil_scoped_release no_gil;
              return p.verify(robot, trajectory, options);
            });
          },
          nb::arg("robot"), nb::arg("trajectory"), nb::arg("start") = nb::none(), nb::arg("goals") = nb::none(),
          nb::arg("limits") = nb::none(), nb::kw_only(), nb::arg("jerk") = false, nb::arg("max_deviation") = nb::none(),
          nb::arg("gap_tolerance") = 0.5, nb::arg("at_rest") = true, nb::arg("start_velocity") = nb::none(),
          nb::arg("start_acceleration") = nb::none(), nb::arg("constraints") = std::vector<PathConstraint>(),
          nb::arg("clearance") = 0.0,
          nb::sig("def verify(self, robot: str, trajectory: Trajectory, start: numpy.typing.ArrayLike | None = None, "
                  "goals: " SRMP_GOALS " | None = None, "
                  "limits: MotionLimits | None = None, *, jerk: bool = False, max_deviation: float | None = None, "
                  "gap_tolerance: float = 0.5, at_rest: bool = True, "
                  "start_velocity: numpy.typing.ArrayLike | None = None, "
                  "start_acceleration: numpy.typing.ArrayLike | None = None, "
                  "constraints: collections.abc.Sequence[PathConstraint] = (), clearance: float = 0.0) -> Certificate"),
          R"(A certificate of any trajectory of the robot, whoever planned it, in the scene as it is, made by code that plans
nothing: limits at every instant, collisions between rows too, whether it is at rest at both ends, start and goals.
Faults are reported, not raised.

start: (dof,) [rad or m] where it should begin. goals: it should reach one of them. limits: default
motion_limits(robot). jerk: verify the jerk limits too. max_deviation: [m] that it may leave its waypoints by.
gap_tolerance: in (0, 1), how well the clearance is to be known: it is proved until (clearance - clearance_proved) /
clearance is no more than this, within some hundred distances; what is proved free does not depend on it. at_rest: a
velocity at the first or last row is a fault; False for a slice of a motion. start_velocity: (dof,) [rad/s or m/s] with
which it should begin. start_acceleration: (dof,) [rad/s^2 or m/s^2] before the motion, for its jerk (default: 0).
constraints: PathConstraints that it should keep at every instant; Certificate.constraints has the proved deviations.
clearance: [m] that it should keep from everything, except near ends that are closer, as the option of make_planner
says; Certificate.clearance_kept. The GIL is released.

Raises InvalidArgument for an unknown robot, constraints that plan would refuse, and options out of range.)")
      .def(
          "verify_multi",
          [](Self& self, nb::handle trajectory, nb::handle starts, nb::handle goals, nb::handle obstacles, bool jerk,
             std::optional<double> max_deviation, double gap_tolerance, bool at_rest, double clearance,
             nb::handle constraints) {
            const MultiTrajectory motions{to_trajectories(trajectory, "the trajectories")};
            const nb::dict none;
            const auto given = [&](nb::handle mapping) { return mapping.is_none() ? nb::handle(none) : mapping; };
            return self.use([&](const PlannerInterface& p) {
              MultiPlanRequest r =
                  to_multi_request(given(starts), given(goals), obstacles, constraints, constraints_of(p));
              const MultiVerifyOptions options{.starts = std::move(r.starts),
                                               .goals = std::move(r.goals),
                                               .obstacles = std::move(r.obstacles),
                                               .jerk = jerk,
                                               .at_rest = at_rest,
                                               .max_deviation = max_deviation,
                                               .gap_tolerance = gap_tolerance,
                                               .clearance = clearance,
                                               .constraints = std::move(r.constraints)};
              const nb::gil_scoped_release no_gil;
              return p.verify_multi(motions, options);
            });
          },
          nb::arg("trajectory").none(), nb::arg("starts") = nb::none(), nb::arg("goals") = nb::none(),
          nb::arg("obstacles") = nb::none(), nb::kw_only(), nb::arg("jerk") = false,
          nb::arg("max_deviation") = nb::none(), nb::arg("gap_tolerance") = 0.5, nb::arg("at_rest") = true,
          nb::arg("clearance") = 0.0, nb::arg("constraints") = nb::none(),
          nb::sig("def verify_multi(self, trajectory: MultiTrajectory | collections.abc.Mapping[str, Trajectory], "
                  "starts: collections.abc.Mapping[str, numpy.typing.ArrayLike] | None = None, "
                  "goals: collections.abc.Mapping[str, " SRMP_GOAL "] | None = None, "
                  "obstacles: collections.abc.Mapping[str, Trajectory] | None = None, *, jerk: bool = False, "
                  "max_deviation: float | None = None, gap_tolerance: float = 0.5, at_rest: bool = True, "
                  "clearance: float = 0.0, constraints: collections.abc.Mapping[str, "
                  "collections.abc.Sequence[PathConstraint]] | None = None"
                  ") -> dict[str, Certificate]"),
          R"(verify for many robots that move on one clock, by name: a certificate of each, verified against the others too,
which rest where their motions end. Robots not named stand still.

starts: by robot name, (dof,) [rad or m]: where they should begin. goals: by robot name: what they should reach; a
robot with a goal of type HOLD should end where it should begin, or where it does begin if that is not given.
obstacles: by robot name: motions that are not verified themselves. clearance: [m] as in verify; from each other the
robots keep it at their ends too. constraints: PathConstraints by robot name, as those of plan_multi, with frames of
robots whose trajectories stay in one place. The other arguments are those of verify. The GIL is released.

Raises InvalidArgument for an unknown robot, starts, goals and constraints of robots without a trajectory, constraints
that plan_multi would refuse, and options out of range.)");
}

}  // namespace srmp::python
