#include "srmp/trajectory/multi_trajectory.hpp"

#include "bind.hpp"

namespace srmp::python {

namespace {

const Trajectory* found(const MultiTrajectory& self, nb::handle robot) {
  if (!nb::isinstance<nb::str>(robot)) return nullptr;
  const auto at = self.robots.find(nb::cast<std::string>(robot));
  return at == self.robots.end() ? nullptr : &at->second;
}

Trajectory at(const MultiTrajectory& self, nb::handle robot) {
  if (const Trajectory* trajectory = found(self, robot)) return *trajectory;
  if (!nb::isinstance<nb::str>(robot))
    raise_unknown_robot("a robot's name is a string, not " + nb::cast<std::string>(nb::repr(robot)));
  try {
    return self.at(nb::cast<std::string>(robot));
  } catch (const InvalidArgument& error) {
    raise_unknown_robot(error.what());
  }
}

}  // namespace

void bind_multi_trajectory(nb::module_& m) {
  nb::class_<MultiTrajectory> cls(m, "MultiTrajectory",
                                  R"(Motions of many robots on one clock, by robot name: a mapping.

All begin at time 0, and a robot whose own motion is over rests where it ended.)");
  cls.def(
         "__init__",
         [](MultiTrajectory* self, nb::handle robots) {
           new (self) MultiTrajectory{to_trajectories(robots, "the trajectories")};
         },
         nb::arg("robots").none(),
         nb::sig("def __init__(self, robots: collections.abc.Mapping[str, Trajectory]) -> None"),
         R"(Motions from trajectories by robot name.

Raises InvalidArgument for anything else.)")
      .def("__getitem__", &at, nb::arg("robot").none(), nb::sig("def __getitem__(self, robot: str) -> Trajectory"),
           R"(The trajectory of a robot.

Raises UnknownRobot with the nearest name.)")
      .def(
          "get",
          [](const MultiTrajectory& self, nb::handle robot, nb::object otherwise) {
            const Trajectory* trajectory = found(self, robot);
            return trajectory ? nb::cast(*trajectory) : otherwise;
          },
          nb::arg("robot").none(), nb::arg("default") = nb::none(),
          nb::sig("def get(self, robot: str, default: typing.Any = None) -> typing.Any"),
          "The trajectory of a robot, or `default`.")
      .def("__len__", [](const MultiTrajectory& self) { return self.robots.size(); })
      .def(
          "__contains__", [](const MultiTrajectory& self, nb::handle robot) { return found(self, robot) != nullptr; },
          nb::arg().none(), nb::sig("def __contains__(self, arg: object, /) -> bool"))
      .def(
          "__iter__", [](const MultiTrajectory& self) { return nb::iter(nb::cast(self.robots).attr("keys")()); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[str]"))
      .def(
          "keys",
          [](const MultiTrajectory& self) {
            std::vector<std::string> names;
            for (const auto& [name, trajectory] : self.robots) names.push_back(name);
            return names;
          },
          "The robots' names, sorted.")
      .def(
          "values",
          [](const MultiTrajectory& self) {
            std::vector<Trajectory> values;
            for (const auto& [name, trajectory] : self.robots) values.push_back(trajectory);
            return values;
          },
          "The trajectories, in the order of the names.")
      .def(
          "items",
          [](const MultiTrajectory& self) {
            return std::vector<std::pair<std::string, Trajectory>>(self.robots.begin(), self.robots.end());
          },
          "The pairs (name, trajectory) of all robots, in the order of the names.")
      .def_prop_ro("duration", &MultiTrajectory::duration, "Duration of the longest motion [s].")
      .def(
          "merged", &MultiTrajectory::merged,
          R"(All robots as one Trajectory: joints 'robot/joint', in the order of the names; rows where any robot has one.

The motion is that of the robots; there is no certificate. Raises InvalidArgument when some have times (or
velocities) and others have not.)")
      .def(
          "plot",
          [](nb::handle_t<MultiTrajectory> self, nb::handle path, const std::string& title) {
            return nb::module_::import_("srmp._trajectory").attr("plot_many")(self, path, title);
          },
          nb::arg("path") = nb::none(), nb::arg("title") = "",
          nb::sig("def plot(self, path: str | os.PathLike[str] | None = None, title: str = '') -> typing.Any"),
          R"(Draws Trajectory.plot's figure of all robots on one clock: joints 'robot/joint'. Dashed: the limits of the
certificates.

Raises InvalidArgument without robots and as Trajectory.plot does.)")
      .def("__repr__", [](const MultiTrajectory& self) {
        return "MultiTrajectory(" + std::to_string(self.robots.size()) + " robots, " + brief_seconds(self.duration()) +
               ")";
      });
  make_html(cls);
  make_value(
      cls, [](const MultiTrajectory& self) { return nb::make_tuple(self.robots); },
      [](const State& state) { return MultiTrajectory{nb::cast<std::map<std::string, Trajectory>>(state[0])}; });
  nb::module_::import_("collections.abc").attr("Mapping").attr("register")(cls);
}

}  // namespace srmp::python
