#include "planner_interface.hpp"

namespace srmp::python {

using Self = PyPlannerInterface;

void bind_files(PlannerClass& cls) {
  cls.def(
         "save",
         [](Self& self, const nb::object& path) { self.use([&](PlannerInterface& p) { p.save(to_path(path)); }); },
         nb::arg("path"), nb::sig("def save(self, path: str | os.PathLike[str]) -> None"),
         R"(Writes the whole problem: the scene with its robots, planners, motion limits that were set, and the request of the
last plan or plan_multi with its result, if nothing was changed since.

The file is JSON, by custom *.srmp.json, written completely or not at all; numbers read back bit for bit. Raises
FileError when it cannot be written, and InvalidArgument when a planner names a heuristic of add_heuristic.)")
      .def_static(
          "load",
          [](const nb::object& path, const std::vector<std::string>& package_dirs) {
            const auto file = to_path(path);
            const nb::gil_scoped_release no_gil;  // meshes take long to read, and other threads go on
            const InterruptionScope interruptible(raise_interrupt);
            return new Self(PlannerInterface::load(file, package_dirs));
          },
          nb::arg("path"), nb::arg("package_dirs") = std::vector<std::string>{}, nb::rv_policy::take_ownership,
          nb::sig("def load(path: str | os.PathLike[str], package_dirs: collections.abc.Sequence[str] = []) -> "
                  "PlannerInterface"),
          R"(Reads a problem that was saved: planning again gives the same trajectory, get_planning_stats and last_result are the
saved ones.

A scene file gives the scene alone. Only meshes of robots are other files: they are looked for where they were, and
in `package_dirs`. Raises FileError, with the line, for anything missing, misspelt or wrong, another format, and
newer versions.)")
      .def(
          "save_scene",
          [](Self& self, const nb::object& path) {
            self.use([&](PlannerInterface& p) { p.save_scene(to_path(path)); });
          },
          nb::arg("path"), nb::sig("def save_scene(self, path: str | os.PathLike[str]) -> None"),
          R"(Writes the scene alone: robots, objects, attachments, allowed collisions.

Raises FileError.)")
      .def(
          "load_scene",
          [](Self& self, const nb::object& path, const std::vector<std::string>& package_dirs) {
            self.use([&](PlannerInterface& p) { p.load_scene(to_path(path), package_dirs); });
          },
          nb::arg("path"), nb::arg("package_dirs") = std::vector<std::string>{},
          nb::sig("def load_scene(self, path: str | os.PathLike[str], package_dirs: collections.abc.Sequence[str] = "
                  "[]) -> None"),
          R"(Replaces this scene by that of a scene or problem file. Planners and motion limits of robots that both have stay;
limits only if the joints are the same.

Raises FileError, as load, and changes nothing.)")
      .def_prop_ro(
          "last_request", [](Self& self) { return self.use([](const auto& p) { return p.last_request(); }); },
          R"(The request of the last plan (a PlanRequest without options: those of make_planner apply) or plan_multi (a
MultiPlanRequest); None before the first, and once one of its robots or the scene was replaced.)")
      .def_prop_ro(
          "last_result", [](Self& self) { return self.use([](const auto& p) { return p.last_result(); }); },
          R"(The result of it: a PlanResult, or a MultiPlanResult of plan_multi; None before the first, and once scene or planner
were changed: then the same request may have another one.)");
}

}  // namespace srmp::python
