#include "bind.hpp"
#include "srmp/planning/statistics_fields.hpp"

namespace srmp::python {

namespace {

// Fields of PlanStatistics to Python objects and back.
template <class T>
nb::object to_python(const T& value) {
  return nb::cast(value);
}
nb::object to_python(const std::vector<Solution>& solutions) {
  nb::list list;
  for (const Solution& solution : solutions) list.append(to_dict(solution));
  return list;
}
template <class T>
void from_python(nb::handle value, T& field) {
  field = nb::cast<T>(value);
}
void from_python(nb::handle value, std::vector<Solution>& solutions) {
  for (nb::handle item : nb::cast<nb::list>(value)) {
    const auto d = nb::cast<nb::dict>(item);
    solutions.push_back({nb::cast<double>(d["time_s"]), nb::cast<double>(d["cost_rad"]), nb::cast<double>(d["bound"]),
                         nb::cast<std::string>(d["graph"])});
  }
}

PlanStatistics to_statistics(const nb::dict& d) {
  PlanStatistics statistics;
  const auto take = [&](const char* name, auto& field) { from_python(d[name], field); };
  for_each_field(statistics, take);
  if (d.contains("robot_cost_rad")) for_each_multi_field(statistics, take);
  return statistics;
}

nb::object own_options(const PlanRequest& request) {
  return request.options ? nb::object(to_dict(to_map(*request.options))) : nb::object(nb::none());
}

template <class Motion>
void bind_result(nb::module_& m, const char* name, const char* what, const char* trajectory) {
  using Result = ResultOf<Motion>;
  nb::class_<Result> result(m, name, what);
  result.def_prop_ro("solved", &Result::solved, "Whether there is a trajectory.")
      .def_prop_ro("status", &Result::status, "How the plan ended.")
      .def_prop_ro("reason", &Result::reason, "Why there is no trajectory; '' when solved.")
      .def_prop_ro(
          "statistics", [](const Result& r) { return to_dict(r.statistics()); },
          nb::sig("def statistics(self) -> dict[str, typing.Any]"),
          "What the plan did, solved or not: see PlannerInterface.get_planning_stats.")
      .def_prop_ro(
          "trajectory",
          [](const Result& r) -> const Motion& {
            if (!r.solved()) raise({r.status(), r.reason()}, to_dict(r.statistics()));
            return r.trajectory();
          },
          nb::rv_policy::reference_internal, trajectory)
      .def("__repr__", [name = std::string(name)](const Result& r) {
        return name + (r.solved() ? "(solved)" : "(" + std::string(to_string(r.status())) + ": " + r.reason() + ")");
      });
  make_html(result);
  make_value(
      result,
      [](const Result& r) {
        return nb::make_tuple(to_dict(r.statistics()), r.solved() ? nb::cast(r.trajectory()) : nb::none());
      },
      [](const State& state) {
        std::optional<Motion> motion;
        if (!state[1].is_none()) motion = nb::cast<const Motion&>(state[1]);
        return Result(to_statistics(nb::cast<nb::dict>(state[0])), std::move(motion));
      });
}

}  // namespace

nb::dict to_dict(const Solution& s) {
  nb::dict d;
  d["time_s"] = s.time_s;
  d["cost_rad"] = s.cost_rad;
  d["bound"] = s.bound;
  d["graph"] = s.graph;
  return d;
}

nb::dict to_dict(const PlanStatistics& statistics) {
  nb::dict d;
  const auto give = [&](const char* name, const auto& field) { d[name] = to_python(field); };
  for_each_field(statistics, give);
  if (!statistics.robot_cost_rad.empty()) for_each_multi_field(statistics, give);
  return d;
}

namespace {

std::vector<double> to_list(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

Eigen::VectorXd to_vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

void bind_plan_request(nb::module_& m) {
  nb::class_<PlanRequest> request(m, "PlanRequest", "A request to PlannerInterface.plan or plan_many.");
  request
      .def(
          "__init__",
          [](PlanRequest* self, const std::string& robot, const ArrayLike& start, nb::handle goals, nb::handle options,
             const std::vector<PathConstraint>& constraints, const std::optional<ArrayLike>& start_velocity,
             const std::optional<ArrayLike>& start_acceleration) {
            PlanRequest request{.robot = robot,
                                .start = start.vector("start of '" + robot + "'"),
                                .goals = {},
                                .options = {},
                                .constraints = constraints,
                                .start_velocity = vector_or_none(start_velocity, "start_velocity"),
                                .start_acceleration = vector_or_none(start_acceleration, "start_acceleration")};
            for (const Goal& goal : to_goals(goals)) request.goals.push_back(constraint_without_scene(robot, goal));
            if (!options.is_none()) request.options = parse_options(to_option_map(options));
            new (self) PlanRequest(std::move(request));
          },
          nb::arg("robot"), nb::arg("start"), nb::arg("goals"), nb::arg("options") = nb::none(),
          nb::arg("constraints") = std::vector<PathConstraint>(), nb::arg("start_velocity") = nb::none(),
          nb::arg("start_acceleration") = nb::none(),
          nb::sig("def __init__(self, robot: str, start: numpy.typing.ArrayLike, "
                  "goals: GoalConstraint | Pose | numpy.typing.ArrayLike | "
                  "collections.abc.Sequence[GoalConstraint | Pose | numpy.typing.ArrayLike], "
                  "options: dict | object | None = None, "
                  "constraints: collections.abc.Sequence[PathConstraint] = (), "
                  "start_velocity: numpy.typing.ArrayLike | None = None, "
                  "start_acceleration: numpy.typing.ArrayLike | None = None) -> None"),
          R"(A request for a plan of one robot.

robot: its name. start: (dof,) [rad or m]. goals: one, or several of which any one is enough: a GoalConstraint, a Pose
or a configuration (PlannerInterface.goal makes a GoalConstraint of names of joints and states). options: a planner of
its own, as for make_planner (default: that of make_planner, or `auto`). constraints: PathConstraints that hold at
every instant of the motion. start_velocity, start_acceleration: (dof,) of a start in motion, as for plan.

Raises InvalidArgument for what is not numbers, goals or planner options.)")
      .def_ro("robot", &PlanRequest::robot, "Name of the robot that is planned.")
      .def_prop_ro(
          "start", [](const PlanRequest& r) { return to_numpy(r.start); }, "The start configuration (dof,) [rad or m].")
      .def_ro("goals", &PlanRequest::goals, "The goals; any one of them is enough.")
      .def_prop_ro("options", &own_options, nb::sig("def options(self) -> dict[str, typing.Any] | None"),
                   "Options of its own planner, as srmp.planner_options gives them; None: those of make_planner.")
      .def_ro("constraints", &PlanRequest::constraints, "PathConstraints that hold at every instant of the motion.")
      .def_prop_ro(
          "start_velocity", [](const PlanRequest& r) { return to_numpy(r.start_velocity); },
          "The velocity at the start (dof,) [rad/s or m/s]; empty: at rest.")
      .def_prop_ro(
          "start_acceleration", [](const PlanRequest& r) { return to_numpy(r.start_acceleration); },
          "The acceleration at the start (dof,) [rad/s^2 or m/s^2]; empty: 0.")
      .def("__repr__", [](const PlanRequest& r) {
        return "PlanRequest('" + r.robot + "', " + std::to_string(r.goals.size()) +
               (r.goals.size() == 1 ? " goal)" : " goals)");
      });
  make_html(request);
  make_value(
      request,
      [](const PlanRequest& r) {
        return nb::make_tuple(r.robot, std::vector<double>(r.start.begin(), r.start.end()), r.goals, own_options(r),
                              r.constraints, to_list(r.start_velocity), to_list(r.start_acceleration));
      },
      [](const State& state) {
        const ArrayLike start{nb::borrow<nb::object>(state[1])};
        PlanRequest r{nb::cast<std::string>(state[0]), start.vector("start"),
                      nb::cast<std::vector<GoalConstraint>>(state[2])};
        if (!state[3].is_none()) r.options = parse_options(to_option_map(state[3]));
        r.constraints = nb::cast<std::vector<PathConstraint>>(state[4]);
        r.start_velocity = to_vector(nb::cast<std::vector<double>>(state[5]));
        r.start_acceleration = to_vector(nb::cast<std::vector<double>>(state[6]));
        return r;
      });
}

void bind_multi_plan_request(nb::module_& m) {
  nb::class_<MultiPlanRequest> multi(m, "MultiPlanRequest", "A request to PlannerInterface.plan_multi: its arguments.");
  multi
      .def(
          "__init__",
          [](MultiPlanRequest* self, nb::handle starts, nb::handle goals, nb::handle obstacles,
             nb::handle constraints) {
            new (self) MultiPlanRequest(to_multi_request(starts, goals, obstacles, constraints));
          },
          nb::arg("starts").none(), nb::arg("goals").none(), nb::arg("obstacles") = nb::none(),
          nb::arg("constraints") = nb::none(),
          nb::sig("def __init__(self, starts: collections.abc.Mapping[str, numpy.typing.ArrayLike], "
                  "goals: collections.abc.Mapping[str, GoalConstraint | Pose | numpy.typing.ArrayLike], "
                  "obstacles: collections.abc.Mapping[str, Trajectory] | None = None, "
                  "constraints: collections.abc.Mapping[str, collections.abc.Sequence[PathConstraint]] | None = None"
                  ") -> None"),
          "A request with the arguments of plan_multi.\n\nRaises InvalidArgument for what is not numbers, goals, "
          "trajectories or path constraints.")
      .def_prop_ro(
          "starts",
          [](const MultiPlanRequest& r) {
            std::map<std::string, NumpyArray> starts;
            for (const auto& [name, start] : r.starts) starts.emplace(name, to_numpy(start));
            return starts;
          },
          "The starts by robot name, (dof,) [rad or m].")
      .def_prop_ro(
          "goals", [](const MultiPlanRequest& r) { return r.goals; },
          "The goals by robot name; a robot with a start and no goal holds still.")
      .def_prop_ro(
          "obstacles", [](const MultiPlanRequest& r) { return r.obstacles; },
          "Motions that other robots are committed to, by robot name.")
      .def_prop_ro(
          "constraints", [](const MultiPlanRequest& r) { return r.constraints; },
          "PathConstraints that hold at every instant of the motions, by robot name.")
      .def("__repr__", [](const MultiPlanRequest& r) {
        return "MultiPlanRequest(" + std::to_string(r.starts.size()) + (r.starts.size() == 1 ? " robot" : " robots") +
               (r.obstacles.empty() ? ")" : " among " + std::to_string(r.obstacles.size()) + " that are committed)");
      });
  make_html(multi);
  make_value(
      multi,
      [](const MultiPlanRequest& r) {
        std::map<std::string, std::vector<double>> starts;
        for (const auto& [name, start] : r.starts)
          starts.emplace(name, std::vector<double>(start.begin(), start.end()));
        return nb::make_tuple(starts, r.goals, r.obstacles, r.constraints);
      },
      [](const State& state) { return to_multi_request(state[0], state[1], state[2], state[3]); });
}

}  // namespace

void bind_plan_many(nb::module_& m) {
  bind_plan_request(m);
  bind_multi_plan_request(m);
  bind_result<Trajectory>(m, "PlanResult", "The result of PlannerInterface.plan, and of one request of plan_many.",
                          "The trajectory.\n\nRaises PlanningError with status and reason unless solved.");
  bind_result<MultiTrajectory>(
      m, "MultiPlanResult", "The result of PlannerInterface.plan_multi.",
      "The trajectories of all robots.\n\nRaises PlanningError with status and reason unless solved.");
}

}  // namespace srmp::python
