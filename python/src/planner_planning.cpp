#include <cmath>

#include "planner_interface.hpp"

namespace srmp::python {

namespace {

using Self = PyPlannerInterface;

#define SRMP_START_IN_MOTION                               \
  "start_velocity: numpy.typing.ArrayLike | None = None, " \
  "start_acceleration: numpy.typing.ArrayLike | None = None"

/// Called while planning without the GIL; true after Ctrl-C.
bool python_interrupted() {
  const nb::gil_scoped_acquire gil;
  return PyErr_CheckSignals() != 0;
}

/// The same, or true while the planner's plans are to stop.
auto interrupted_or_stopped(const Self& self) {
  return [&self] { return self.stops_plans() || python_interrupted(); };
}

/// Runs `plan` without the GIL. A Ctrl-C that ended it is raised.
template <class Plan>
auto run_interruptible(Plan&& plan) {
  try {
    auto result = [&] {
      const InterruptionScope by_deadline({});  // which stops in an orderly way
      const nb::gil_scoped_release no_gil;
      return plan();
    }();
    if (PyErr_Occurred()) throw nb::python_error();
    return result;
  } catch (...) {
    if (PyErr_Occurred()) throw nb::python_error();  // Ctrl-C while it failed
    throw;
  }
}

/// The same; a PlanningError carries the planner's statistics.
template <class Plan>
auto run_plan(const PlannerInterface& planner, Plan&& plan) {
  try {
    return run_interruptible(plan);
  } catch (const PlanningError& error) {
    raise(error, to_dict(planner.get_planning_stats()));
  }
}

std::vector<PlanResult> plan_many(PlannerInterface& planner, const std::vector<PlanRequest>& requests,
                                  std::optional<int> threads, const std::optional<nb::callable>& progress) {
  PlannerInterface::Progress report;
  if (progress)
    report = [&progress](std::size_t done, std::size_t total) {
      const nb::gil_scoped_acquire gil;
      (*progress)(done, total);
    };
  return run_interruptible([&] { return planner.plan_many(requests, threads, python_interrupted, report); });
}

std::string only_robot(nb::handle robots) {
  const std::vector<std::string> names = to_names(robots, "robots");
  if (names.size() != 1)
    throw InvalidArgument("plan is for one robot, but " + std::to_string(names.size()) +
                          " were named; use plan_multi for many");
  return names[0];
}

/// The callback may keep its arguments, which are copies; only False stops the search.
OnSolution to_on_solution(const nb::object& callback) {
  if (callback.is_none()) return {};
  if (!PyCallable_Check(callback.ptr()))
    throw InvalidArgument("on_solution must be a function of a dict and an array, or None");
  return [&callback](const Solution& solution, ConstRows waypoints) {
    const nb::gil_scoped_acquire gil;
    const nb::object go_on = callback(to_dict(solution), to_numpy_rows(RowMatrix(waypoints)));
    return go_on.ptr() != Py_False;
  };
}

constexpr const char* plan_doc =
    R"(A timed, collision-free trajectory of one robot from `start` (dof,) [rad or m] to any one of the goals, by the planner
of make_planner, or by `auto`; other robots stand still. The name may be left out where there is one robot. The same
request gives the same result, bit for bit. The GIL is released; Ctrl-C stops the plan.

goal: a GoalConstraint; a Pose of the end effector, world frame; a configuration (dof,) [rad or m]; positions [rad or
m] by joint name, where joints not named stay as at the start; the name of a state of the SRDF (get_group_states);
Poses in the world frame by link name, which are reached at the same time; or a list of these.

on_solution(solution, waypoints) receives every path that is better than those before, while planners that improve
theirs run; when it returns False, that path is good enough. solution has time_s, cost_rad, bound and graph (see
get_planning_stats); waypoints are (n, dof) [rad or m], from the end of the start-state recovery on (option
recover_start: the path is not free before). It must not use this planner; what it raises ends the plan.

constraints: PathConstraints that hold at every instant of the motion, proved; Certificate.constraints has the proved
values. Configurations of the search are projected onto them (CBiRRT: Berenson et al. 2009; lattices likewise).

start_velocity: (dof,) [rad/s or m/s] with which the motion begins, straight ahead until it could stop; from there the
path is searched, and where the two meet the corner is rounded as others are. start_acceleration: (dof,) [rad/s^2 or
m/s^2] in its direction, for the timing `ruckig`, which limits the jerk. start_invalid when the robot cannot stop
straight ahead, with what is in the way.

Raises PlanningError when there is none: its status is timed_out, exhausted, start_invalid, goal_invalid or
cancelled, its text says why, its statistics are those of get_planning_stats. Raises InvalidArgument for an invalid
request: unknown robot, joint, state, link or frame, wrong size, NaN, a constraint that no planned joint changes.)";

/// The trajectory of one robot to any one of the goals.
Trajectory plan(PyPlannerInterface& self, const std::optional<std::string>& robot, const ArrayLike& start,
                nb::handle goal, const nb::object& on_solution, const std::vector<PathConstraint>& constraints,
                const std::optional<ArrayLike>& start_velocity, const std::optional<ArrayLike>& start_acceleration) {
  const OnSolution report = to_on_solution(on_solution);
  const std::vector<Goal> forms = to_goals(goal);
  return self.use([&](PlannerInterface& p) {
    const std::string name = robot ? *robot : p.only_robot();
    const Eigen::VectorXd q = start.vector("start of '" + name + "'");
    PlanRequest request{
        .robot = name,
        .start = q,
        .goals = {},
        .options = {},
        .constraints = constraints,
        .start_velocity = vector_or_none(start_velocity, "start_velocity of '" + name + "'"),
        .start_acceleration = vector_or_none(start_acceleration, "start_acceleration of '" + name + "'")};
    for (const Goal& form : forms) request.goals.push_back(p.goal(name, form, q));
    const auto interrupted = interrupted_or_stopped(self);
    return run_plan(p, [&] { return p.plan(request, interrupted, report); });
  });
}

constexpr const char* stop_doc =
    R"(The fastest certified stop on the path of a motion of the robot, from the instant t [s] of it on: it brakes as hard as
the velocity and acceleration limits allow at every instant, and stops at the earliest place of the path where it can.
With the timing `ruckig` the jerk limits are kept too; the path must be straight there, as such motions are. Times begin
at 0, with the position, velocity and, with `ruckig`, acceleration of the motion at t, or at its row that is within 1 µs
of t. The name may be left out where there is one robot. Timing, limits and time limit are those of make_planner. The
GIL is released.

Raises PlanningError, exhausted, when the stop touches what is in the scene now; and InvalidArgument for an unknown
robot, other joints, a motion without times or velocities, one that ends in motion before the robot can stop, and a t
outside it.)";

constexpr const char* replan_doc =
    R"(A new motion to another goal (as for plan) that leaves a motion at its instant t [s] without a stop: it begins, at time
0, with the position, velocity and, with the timing `ruckig`, acceleration that the motion has there, as plan does with
start_velocity. Where the robot could not stop straight ahead, because something is in the way, the motion is left at
its next row at which it can. Path constraints hold from t on, and the motion must be left there. The name may be left
out where there is one robot. The GIL is released; Ctrl-C stops the plan.

Raises as plan, and InvalidArgument for other joints, a motion without times or velocities, and a t outside it.)";

constexpr const char* sequence_doc =
    R"(Motions, grasps and waits in a row, from `start` (dof,) [rad or m]: each segment begins where the one before ends, in
the scene as it is then. Where a later segment fails, earlier moves end elsewhere, at another target or another solution
of inverse kinematics, those near their starts first: a grasp takes a configuration from which the lift works. Moves with
a blend_radius are passed without a stop. Joints that are set are looked at in ten steps on their way for contacts;
attach an object before a gripper closes around it. The name may be left out where there is one robot.

The scene is as before afterwards, whether there is a sequence or not; last_request and last_result are None. Planner,
timing, limits and clearance are those of make_planner; the time limit is for each motion, and so many times as there are
segments for all. Every motion keeps the clearance, and may begin and end closer, as those of plan and follow do. The GIL
is released; Ctrl-C stops the plan.

Raises PlanningError with the segment that was reached and why it failed, and InvalidArgument, with the number of the
segment, for segments that cannot be: unknown objects, links and joints, goals as plan, poses as follow, no segments,
negative times and radii.)";

SequenceResult plan_sequence(PyPlannerInterface& self, const std::optional<std::string>& robot, const ArrayLike& start,
                             const std::vector<Segment>& segments) {
  return self.use([&](PlannerInterface& p) {
    const std::string name = robot ? *robot : p.only_robot();
    const Eigen::VectorXd q = start.vector("start of '" + name + "'");
    const auto interrupted = interrupted_or_stopped(self);
    return run_plan(p, [&] { return p.plan_sequence(name, q, segments, interrupted); });
  });
}

Trajectory stop(PyPlannerInterface& self, const std::optional<std::string>& robot, const Trajectory& trajectory,
                double t) {
  return self.use([&](const PlannerInterface& p) {
    const std::string name = robot ? *robot : p.only_robot();
    return run_plan(p, [&] { return p.stop(name, trajectory, t, python_interrupted); });
  });
}

Trajectory replan(PyPlannerInterface& self, const std::optional<std::string>& robot, const Trajectory& trajectory,
                  double t, nb::handle goal, const std::vector<PathConstraint>& constraints) {
  const std::vector<Goal> forms = to_goals(goal);
  return self.use([&](PlannerInterface& p) {
    PlanRequest request{
        .robot = robot ? *robot : p.only_robot(), .start = {}, .goals = {}, .options = {}, .constraints = constraints};
    const std::optional<Eigen::VectorXd> here =
        trajectory.timed() && std::isfinite(t) ? std::optional(trajectory.sample(t)) : std::nullopt;
    for (const Goal& form : forms) request.goals.push_back(p.goal(request.robot, form, here));
    const auto interrupted = interrupted_or_stopped(self);
    return run_plan(p, [&] { return p.replan(trajectory, t, request, interrupted); });
  });
}

/// The trajectory of one robot along poses.
Trajectory follow(PyPlannerInterface& self, const std::optional<std::string>& robot, const ArrayLike& start,
                  const std::vector<Pose>& poses, const CartesianOptions& options) {
  return self.use([&](PlannerInterface& p) {
    const std::string name = robot ? *robot : p.only_robot();
    const Eigen::VectorXd q = start.vector("start of '" + name + "'");
    return run_plan(p, [&] { return p.follow(name, q, poses, options, python_interrupted); });
  });
}

constexpr const char* follow_doc =
    R"(A timed, collision-free trajectory on which a link (default: the end effector) passes `poses` (world frame, at least
one) in order, straight from each to the next and turning evenly (slerp), beginning where it is at `start` (dof,) [rad
or m]; other robots stand still. The robot's name may be left out where there is one robot.

The joints that are not needed for this avoid obstacles and limits: configurations along the path are searched by
weighted A* (Pohl 1970) in a graph of poses times redundancy, from the configuration at the start on, without jumps.
The link leaves the path by no more than max_deviation [m] and max_rotation [rad], at every instant of the timed
motion; this is proved, and Certificate.cartesian_deviation has the proved values. Where the path has a corner, the
motion slows down, or stops if the tolerance is too small to round it. The GIL is released; Ctrl-C stops the plan.

constraints: PathConstraints that hold at every instant of the motion besides, proved, as those of plan:
Certificate.constraints has the proved values. A start that breaks one is start_invalid; a last pose at which all
configurations that are found break one is goal_invalid.

Time limit, timing, limits, clearance and certificate are those of make_planner; its search options do not apply. A
start or an end may be closer to something than the clearance: on the way from there, no pair that is closer comes
closer still. Raises PlanningError: start_invalid, goal_invalid, timed_out, cancelled, or exhausted, with how far the
link came and what stopped it (a contact, the clearance, a constraint, the joint limits, a singularity). Raises
InvalidArgument for an unknown robot, link or frame (with the nearest name), a link that no planned joint moves, a
constraint that no planned joint changes, a wrong size, NaN, no poses, poses or a path beyond 1000 m, and tolerances
that are not above 0 and at most 0.1 m and 0.5 rad. last_request and last_result are None afterwards.)";

constexpr const char* linear_doc =
    R"(A timed, collision-free trajectory on which a link (default: the end effector) moves in a straight line from where it
is at `start` (dof,) [rad or m] to `goal`, a pose in the world frame, turning evenly (slerp). The same as `follow` with
one pose: see there for arguments, and for what is raised.)";

}  // namespace

void bind_planning(PlannerClass& cls) {
  cls.def(
         "make_planner",
         [](Self& self, nb::handle robots, nb::handle options) {
           const auto names = to_names(robots, "robots");
           const OptionMap map = to_option_map(options);
           self.use([&](auto& p) { p.make_planner(names, map); });
         },
         nb::arg("names"), nb::arg("options"),
         nb::sig("def make_planner(self, names: str | collections.abc.Sequence[str], options: dict | object) -> None"),
         R"(Chooses the planner of these robots, from a dictionary ("planner_id", "time_limit", …; numbers may be strings) or
typed options such as srmp.WAStar(weight=10). Options left out have their defaults.

Astar        A* (Hart, Nilsson, Raphael 1968)
wAstar       weighted A* (Pohl 1970) with lazy edges (Cohen, Phillips, Likhachev 2014)
ARAstar      ARA* (Likhachev, Gordon, Thrun 2003), anytime
MHAstar      MHA* (Aine et al. 2016), several heuristics
wPASE        ePA*SE (Mukherjee, Aine, Likhachev 2022), parallel
auto         RRT-Connect and a portfolio of heuristic searches from both ends; the default
CBS          conflict-based search (Sharon et al. 2015), many robots: optimal on their lattices
ECBS         (Barer et al. 2014), many robots: within a bound
xECBS        (Shaoul, Mishani, Likhachev, Li 2024), many robots: ECBS with experience; quick
prioritised  priority-based search (Ma et al. 2019), many robots: quick, without a bound

Raises InvalidArgument for an unknown robot, planner or option (with the nearest name) or a value out of range.)")
      .def(
          "add_heuristic",
          [](Self& self, const std::string& name, const nb::callable& function, bool consistent) {
            self.add_heuristic(name, function, consistent);
          },
          nb::arg("name"), nb::arg("function"), nb::kw_only(), nb::arg("consistent") = false,
          nb::sig("def add_heuristic(self, name: str, function: collections.abc.Callable[[numpy.typing.NDArray"
                  "[numpy.float64], numpy.typing.NDArray[numpy.float64]], numpy.typing.ArrayLike], "
                  "*, consistent: bool = False) -> None"),
          R"(Registers a heuristic: from now on `name` may stand where options name one, for any robot.

function(configurations, goals): (n, dof) and (m, dof) [rad or m] to (n,) estimates of the joint-space path length
to the nearest goal, each finite and >= 0; it is not called for the goals themselves, which are 0. A search from the
goals leads to the start: `goals` is the start then. The same arguments must give the same values. It must not use
this PlannerInterface, which is planning when it is called; what it raises ends the plan and is raised there.

consistent: you declare that h(a) <= |b - a| + h(b) for all configurations; without it no bound counts as proven
(but that of `auto`).

Raises InvalidArgument for a name in use, empty, or with spaces, commas or brackets; plan raises it for values that
are not finite and >= 0, with the value and the configuration.)")
      .def(
          "remove_heuristic", [](Self& self, const std::string& name) { self.remove_heuristic(name); }, nb::arg("name"),
          R"(Removes a heuristic of add_heuristic; planners that name it refuse to plan.

Raises InvalidArgument for an unknown name.)")
      .def_prop_ro(
          "heuristic_names",
          [](Self& self) { return self.use([](const PlannerInterface& p) { return p.heuristic_names(); }); },
          "Names of the heuristics of add_heuristic, sorted.")
      .def(
          "goal",
          [](Self& self, const std::string& robot, nb::handle goal, const std::optional<ArrayLike>& start) {
            const std::vector<Goal> forms = to_goals(goal);
            if (forms.size() != 1) throw InvalidArgument("the goal of '" + robot + "' must be one, but is a list");
            std::optional<Eigen::VectorXd> q;
            if (start) q = start->vector("start of '" + robot + "'");
            return self.use([&](const PlannerInterface& p) { return p.goal(robot, forms[0], q); });
          },
          nb::arg("robot"), nb::arg("goal"), nb::arg("start") = nb::none(),
          nb::sig("def goal(self, robot: str, goal: " SRMP_GOAL
                  ", start: numpy.typing.ArrayLike | None = None) -> GoalConstraint"),
          R"(A goal in any form that plan accepts, as a GoalConstraint for this robot.

Joints that a goal by joint names leaves out are as in `start` (dof,) [rad or m] (default: set_qpos).

Raises InvalidArgument for an unknown robot, joint or state, with the nearest name.)")
      .def(
          "plan",
          [](Self& self, nb::handle robot, const ArrayLike& start, nb::handle goal, const nb::object& on_solution,
             const std::vector<PathConstraint>& constraints, const std::optional<ArrayLike>& start_velocity,
             const std::optional<ArrayLike>& start_acceleration) {
            return plan(self, only_robot(robot), start, goal, on_solution, constraints, start_velocity,
                        start_acceleration);
          },
          nb::arg("name"), nb::arg("start"), nb::arg("goal"), nb::arg("on_solution") = nb::none(), nb::kw_only(),
          nb::arg("constraints") = std::vector<PathConstraint>(), nb::arg("start_velocity") = nb::none(),
          nb::arg("start_acceleration") = nb::none(),
          nb::sig("def plan(self, name: str | collections.abc.Sequence[str], start: numpy.typing.ArrayLike, "
                  "goal: " SRMP_GOALS ", "
                  "on_solution: collections.abc.Callable[[dict[str, typing.Any], "
                  "numpy.typing.NDArray[numpy.float64]], bool | None] | None = None, *, "
                  "constraints: collections.abc.Sequence[PathConstraint] = (), " SRMP_START_IN_MOTION
                  ") -> Trajectory"),
          plan_doc)
      .def(
          "plan",
          [](Self& self, const ArrayLike& start, nb::handle goal, const nb::object& on_solution,
             const std::vector<PathConstraint>& constraints, const std::optional<ArrayLike>& start_velocity,
             const std::optional<ArrayLike>& start_acceleration) {
            return plan(self, std::nullopt, start, goal, on_solution, constraints, start_velocity, start_acceleration);
          },
          nb::arg("start"), nb::arg("goal"), nb::kw_only(), nb::arg("on_solution") = nb::none(),
          nb::arg("constraints") = std::vector<PathConstraint>(), nb::arg("start_velocity") = nb::none(),
          nb::arg("start_acceleration") = nb::none(),
          nb::sig("def plan(self, start: numpy.typing.ArrayLike, goal: " SRMP_GOALS ", *, "
                  "on_solution: collections.abc.Callable[[dict[str, typing.Any], "
                  "numpy.typing.NDArray[numpy.float64]], bool | None] | None = None, "
                  "constraints: collections.abc.Sequence[PathConstraint] = (), " SRMP_START_IN_MOTION
                  ") -> Trajectory"),
          plan_doc)
      .def(
          "plan_sequence",
          [](Self& self, const std::string& robot, const ArrayLike& start, const std::vector<Segment>& segments) {
            return plan_sequence(self, robot, start, segments);
          },
          nb::arg("name"), nb::arg("start"), nb::arg("segments"), sequence_doc)
      .def(
          "plan_sequence",
          [](Self& self, const ArrayLike& start, const std::vector<Segment>& segments) {
            return plan_sequence(self, std::nullopt, start, segments);
          },
          nb::arg("start"), nb::arg("segments"), sequence_doc)
      .def(
          "stop",
          [](Self& self, const std::string& robot, const Trajectory& trajectory, double t) {
            return stop(self, robot, trajectory, t);
          },
          nb::arg("name"), nb::arg("trajectory"), nb::arg("t"), stop_doc)
      .def(
          "stop",
          [](Self& self, const Trajectory& trajectory, double t) { return stop(self, std::nullopt, trajectory, t); },
          nb::arg("trajectory"), nb::arg("t"), stop_doc)
      .def(
          "replan",
          [](Self& self, const std::string& robot, const Trajectory& trajectory, double t, nb::handle goal,
             const std::vector<PathConstraint>& constraints) {
            return replan(self, robot, trajectory, t, goal, constraints);
          },
          nb::arg("name"), nb::arg("trajectory"), nb::arg("t"), nb::arg("goal"), nb::kw_only(),
          nb::arg("constraints") = std::vector<PathConstraint>(),
          nb::sig("def replan(self, name: str, trajectory: Trajectory, t: float, goal: " SRMP_GOALS ", *, "
                  "constraints: collections.abc.Sequence[PathConstraint] = ()) -> Trajectory"),
          replan_doc)
      .def(
          "replan",
          [](Self& self, const Trajectory& trajectory, double t, nb::handle goal,
             const std::vector<PathConstraint>& constraints) {
            return replan(self, std::nullopt, trajectory, t, goal, constraints);
          },
          nb::arg("trajectory"), nb::arg("t"), nb::arg("goal"), nb::kw_only(),
          nb::arg("constraints") = std::vector<PathConstraint>(),
          nb::sig("def replan(self, trajectory: Trajectory, t: float, goal: " SRMP_GOALS ", *, "
                  "constraints: collections.abc.Sequence[PathConstraint] = ()) -> Trajectory"),
          replan_doc)
      .def(
          "plan_linear",
          [](Self& self, const std::string& robot, const ArrayLike& start, const Pose& goal, const std::string& link,
             double max_deviation, double max_rotation, const std::vector<PathConstraint>& constraints) {
            return follow(self, robot, start, {goal}, {link, max_deviation, max_rotation, constraints});
          },
          nb::arg("name"), nb::arg("start"), nb::arg("goal"), nb::kw_only(), SRMP_CARTESIAN,
          nb::sig("def plan_linear(self, name: str, start: numpy.typing.ArrayLike, goal: Pose, *, " SRMP_CARTESIAN_SIG
                  ") -> Trajectory"),
          linear_doc)
      .def(
          "plan_linear",
          [](Self& self, const ArrayLike& start, const Pose& goal, const std::string& link, double max_deviation,
             double max_rotation, const std::vector<PathConstraint>& constraints) {
            return follow(self, std::nullopt, start, {goal}, {link, max_deviation, max_rotation, constraints});
          },
          nb::arg("start"), nb::arg("goal"), nb::kw_only(), SRMP_CARTESIAN,
          nb::sig("def plan_linear(self, start: numpy.typing.ArrayLike, goal: Pose, *, " SRMP_CARTESIAN_SIG
                  ") -> Trajectory"),
          linear_doc)
      .def(
          "follow",
          [](Self& self, const std::string& robot, const ArrayLike& start, const std::vector<Pose>& poses,
             const std::string& link, double max_deviation, double max_rotation,
             const std::vector<PathConstraint>& constraints) {
            return follow(self, robot, start, poses, {link, max_deviation, max_rotation, constraints});
          },
          nb::arg("name"), nb::arg("start"), nb::arg("poses"), nb::kw_only(), SRMP_CARTESIAN,
          nb::sig("def follow(self, name: str, start: numpy.typing.ArrayLike, poses: "
                  "collections.abc.Sequence[Pose], *, " SRMP_CARTESIAN_SIG ") -> Trajectory"),
          follow_doc)
      .def(
          "follow",
          [](Self& self, const ArrayLike& start, const std::vector<Pose>& poses, const std::string& link,
             double max_deviation, double max_rotation, const std::vector<PathConstraint>& constraints) {
            return follow(self, std::nullopt, start, poses, {link, max_deviation, max_rotation, constraints});
          },
          nb::arg("start"), nb::arg("poses"), nb::kw_only(), SRMP_CARTESIAN,
          nb::sig("def follow(self, start: numpy.typing.ArrayLike, poses: collections.abc.Sequence[Pose], "
                  "*, " SRMP_CARTESIAN_SIG ") -> Trajectory"),
          follow_doc)
      .def(
          "prepare",
          [](Self& self, const std::optional<nb::callable>& progress) {
            self.use([&](PlannerInterface& p) {
              const nb::gil_scoped_release no_gil;
              p.prepare(report_to_python(progress));
            });
          },
          nb::arg("progress") = nb::none(),
          nb::sig("def prepare(self, progress: collections.abc.Callable[[int, int], object] | None = None) -> None"),
          R"(Computes now, on all cores, what makes collision checks of the scene's robots faster: sphere covers, and tables of
pairs of links. It takes seconds to minutes for a robot seen for the first time; later it comes from the cache
directory (`cover_directory()`). Without this call it happens in the background, from the first plan on. No result
depends on it, only the time that plans take. `progress` is called often, with the number of steps done and of all.
The GIL is released; Ctrl-C, or an exception of `progress`, ends the call within 0.1 s and is raised.)")
      .def(
          "plan_many",
          [](Self& self, const std::vector<PlanRequest>& requests, std::optional<int> threads,
             const std::optional<nb::callable>& progress) {
            return self.use([&](PlannerInterface& p) { return plan_many(p, requests, threads, progress); });
          },
          nb::arg("requests"), nb::arg("threads") = nb::none(), nb::arg("progress") = nb::none(),
          nb::sig("def plan_many(self, requests: collections.abc.Sequence[PlanRequest], threads: int | None = None, "
                  "progress: collections.abc.Callable[[int, int], object] | None = None) -> list[PlanResult]"),
          R"(Plans many requests in the scene as it is, independently of each other, on `threads` threads (> 0; default: one for
each core).

Results are in the order of the requests, and each is what plan alone would have found, bit for bit, for any number
of threads. A request that has no trajectory does not disturb the others: its PlanResult says why. Every request has
its own time limit, which begins with its own plan; only a limit that stops a plan can make a difference, and it
does so earlier the more threads share a core. `progress` is called with the number of requests done and of all. The
GIL is released; Ctrl-C, or an exception of `progress`, stops all plans and is raised. get_planning_stats stays as
it was.

Raises InvalidArgument for an invalid request, as plan does, with its number; before anything is planned where it
can.)")
      .def("_stop_plans", &Self::stop_plans, nb::arg("stop"),
           "Of BatchPlanner and Viewer: plans in other threads end as cancelled, for as long as it is true.")
      .def(
          "plan_multi",
          [](Self& self, nb::handle starts, nb::handle goals, nb::handle obstacles, nb::handle constraints) {
            return self.use([&](PlannerInterface& p) {
              const MultiPlanRequest r = to_multi_request(starts, goals, obstacles, constraints, constraints_of(p));
              const auto interrupted = interrupted_or_stopped(self);
              return run_plan(p, [&] { return p.plan_multi(r, interrupted); });
            });
          },
          nb::arg("starts").none(), nb::arg("goals").none(), nb::arg("obstacles") = nb::none(),
          nb::arg("constraints") = nb::none(),
          nb::sig("def plan_multi(self, starts: collections.abc.Mapping[str, numpy.typing.ArrayLike], "
                  "goals: collections.abc.Mapping[str, " SRMP_GOAL "], "
                  "obstacles: collections.abc.Mapping[str, Trajectory] | None = None, "
                  "constraints: collections.abc.Mapping[str, collections.abc.Sequence[PathConstraint]] | None = None"
                  ") -> MultiTrajectory"),
          R"(Motions of many robots together, on one clock, collision-free among each other too, from `starts` (dof,) [rad or m]
to `goals` in any form (see plan), both by robot name.

A robot with a start and no goal holds still, as with GoalConstraint.hold(); one with GoalConstraint.any() may move
out of the others' way; robots without a start stand where set_qpos put them. Every trajectory has a certificate
that covers the others, those of robots that hold too. Planned by the planner that make_planner chose for the robots
of `starts`, or by `auto`. The GIL is released; Ctrl-C stops it.

obstacles: timed trajectories by robot name, that other robots of the scene are committed to. They begin at time 0
too, and the robots rest where they end and are not planned for. The planned motions begin together, as early as
they pass the obstacles, in steps of 0.1 s, at rest at the starts until then; or, where that fails or begins late,
each robot moves and waits as suits the others (not complete). Certificates cover the obstacles.

constraints: PathConstraints by robot name, which hold at every instant, proved, as those of plan; each is about links
of its robot or objects that it holds. Frames are the world, links of the robot, and what stands still: objects and,
as "robot/link", links of robots that do not move in this request. A start or goal that breaks one is start_invalid or
goal_invalid. Raises InvalidArgument for constraints of a robot without a start and for frames that move, and
NotSupported for constraints together with obstacles.

Raises PlanningError, with a status and a reason, when there are none: a start where an obstacle begins is
start_invalid (one where it ends too, unless the robot can leave before), a goal where one ends is goal_invalid;
exhausted names links and time when no motions are found. Raises InvalidArgument for a goal without a start, wrong
sizes and NaN, when no robot is to move, and for an obstacle that has a start, has no times, does not begin at time
0, leaves the joint limits or does not have the robot's joints.)")
      .def(
          "get_planning_stats",
          [](Self& self) { return self.use([](auto& p) { return to_dict(p.get_planning_stats()); }); },
          nb::sig("def get_planning_stats(self) -> dict[str, typing.Any]"),
          R"(Statistics of the last plan, solved or not; status `exhausted` with zeros before the first.

status, reason, note; plan_time_s (until the path is ready), total_time_s, and of these ik_time_s, heuristic_time_s,
search_time_s, shortcut_time_s, timing_time_s, verification_time_s [s]; expansions, generated, states, edge_checks,
edges_free_by_spheres, edges_colliding_by_spheres, edges_free_by_coal, edges_colliding_by_coal (their sum is
edge_checks), configurations, narrow_phase (counts); memory_bytes; recovery_waypoints (the path is free from this
waypoint on: above 0, it began in collision, see recover_start) and recovery_cost_rad, its length up to there, which
no other cost counts; search_cost_rad and path_cost_rad, before and after the shortcut [rad, prismatic joints m];
bound (path_cost_rad is at most this times the optimum of bound_graph; inf: none proven); solutions (a list: the
time_s, cost_rad, bound and graph of every path that was better than those before); goal_index (which target was
reached, counted over all goals; -1: none).

After plan_multi also robot_cost_rad (by robot; path_cost_rad is their sum), tree_nodes (of the constraint tree),
independence_detection (robots that did not conflict kept the paths found for each alone), large_neighbourhood_search
(paths planned jointly were rerouted, one robot at a time), makespan_s and flow_time_s (sum of the robots' times of
arrival) [s].)")
      .def(
          "print_available_planners",
          [](Self&) {
            nb::object print = nb::module_::import_("builtins").attr("print");
            for (const PlannerInfo& info : available_planners())
              print((info.id + std::string(13 - info.id.size(), ' ') + info.summary).c_str());
          },
          "Prints the planner ids and what each is for.");
}

}  // namespace srmp::python
