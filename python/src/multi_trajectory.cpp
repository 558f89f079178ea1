#include "srmp/trajectory/multi_trajectory.hpp"

#include "bind.hpp"

namespace srmp::python {

void bind_multi_trajectory(nb::module_& m) {
  nb::class_<MultiTrajectory> cls(m, "MultiTrajectory",
                                  "Motions of many robots on one clock, by robot name: a mapping. All begin at time 0, "
                                  "and a robot whose own motion "
                                  "is over rests\n"
                                  "where it ended.");
  cls.def(
         "__init__",
         [](MultiTrajectory* self, std::map<std::string, Trajectory> robots) {
           new (self) MultiTrajectory{std::move(robots)};
         },
         nb::arg("robots"), "From trajectories by robot name.")
      .def(
          "__getitem__", [](const MultiTrajectory& self, const std::string& robot) { return self.at(robot); },
          nb::arg("robot"), "The trajectory of a robot; raises InvalidArgument with the nearest name.")
      .def("__len__", [](const MultiTrajectory& self) { return self.robots.size(); })
      .def("__contains__",
           [](const MultiTrajectory& self, const std::string& robot) { return self.robots.contains(robot); })
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
          "Their trajectories, in the order of the names.")
      .def(
          "items",
          [](const MultiTrajectory& self) {
            return std::vector<std::pair<std::string, Trajectory>>(self.robots.begin(), self.robots.end());
          },
          "(name, trajectory) of every robot.")
      .def_prop_ro("duration", &MultiTrajectory::duration, "Of the longest [s].")
      .def("merged", &MultiTrajectory::merged,
           "All robots as one Trajectory: joints 'robot/joint', in the order of the names; rows where any robot has "
           "one. The motion is\n"
           "that of the robots; there is no certificate.\n\n"
           "Raises InvalidArgument when some have times (or velocities) and others have not.")
      .def("__repr__", [](const MultiTrajectory& self) {
        return "MultiTrajectory(" + std::to_string(self.robots.size()) + " robots, " + to_text(self.duration()) + " s)";
      });
  make_value(
      cls, [](const MultiTrajectory& self) { return nb::make_tuple(self.robots); },
      [](const nb::tuple& state) { return MultiTrajectory{nb::cast<std::map<std::string, Trajectory>>(state[0])}; });
}

}  // namespace srmp::python
