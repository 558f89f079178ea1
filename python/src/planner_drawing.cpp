#include "planner_interface.hpp"

namespace srmp::python {

using Self = PyPlannerInterface;

namespace {

/// A function of srmp/viewer, which draws.
nb::object in_viewer(const char* function) { return nb::module_::import_("srmp.viewer").attr(function); }

std::string counted(std::size_t count, const char* what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string repr(Self& self) {
  try {
    return self.use([](const PlannerInterface& p) {
      return "PlannerInterface(" + counted(p.scene().robot_names().size(), "robot") + ", " +
             counted(p.scene().objects().size(), "object") + ")";
    });
  } catch (const Error&) {  // another thread plans with it
    return "PlannerInterface(planning)";
  }
}

}  // namespace

void bind_drawing(PlannerClass& cls) {
  cls.def(
         "show",
         [](nb::handle self, nb::handle trajectory, nb::handle kinds, nb::handle host, nb::handle port,
            bool open_browser) {
           return in_viewer("show")(self, trajectory, nb::arg("kinds") = kinds, nb::arg("host") = host,
                                    nb::arg("port") = port, nb::arg("open_browser") = open_browser);
         },
         nb::arg("trajectory") = nb::none(), nb::kw_only(), nb::arg("kinds") = nb::none(),
         nb::arg("host").none() = "127.0.0.1", nb::arg("port").none() = 8080, nb::arg("open_browser") = true,
         nb::sig("def show(self, trajectory: Trajectory | MultiTrajectory | collections.abc.Mapping[str, Trajectory] | "
                 "None = None, *, kinds: collections.abc.Sequence[str] | None = None, host: str = '127.0.0.1', "
                 "port: int = 8080, open_browser: bool = True) -> typing.Any"),
         R"(Opens a viewer of this scene in the browser, and returns it (a srmp.viewer.Viewer); docs/viewer.md describes it.

The viewer has a copy of the scene and follows changes of this one; what is done in the browser changes nothing
here. trajectory: what it plays first, default the result of the last plan. kinds: how robots can be seen: "visual",
"collision", "spheres"; default the first of these that each has. host, port: where the page is served; port 0: any
that is free, and another than `port` where that is taken.

Raises NotSupported where viser is not installed, and InvalidArgument for a trajectory that is none of the robots',
an unknown kind, and a port out of range.)")
      .def(
          "to_html",
          [](nb::handle self, nb::handle path, nb::handle trajectory, nb::handle title, nb::handle kinds) {
            return in_viewer("to_html")(self, path, trajectory, nb::arg("title") = title, nb::arg("kinds") = kinds);
          },
          nb::arg("path") = nb::none(), nb::arg("trajectory") = nb::none(), nb::kw_only(), nb::arg("title").none() = "",
          nb::arg("kinds") = nb::none(),
          nb::sig("def to_html(self, path: str | os.PathLike[str] | None = None, trajectory: Trajectory | "
                  "MultiTrajectory | collections.abc.Mapping[str, Trajectory] | None = None, *, title: str = '', "
                  "kinds: collections.abc.Sequence[str] | None = None) -> str | None"),
          R"(Writes the scene and a motion as one HTML file that plays in any browser, without a server and without other files.

trajectory: default the result of the last plan; where that failed, what is at fault is drawn. kinds: as in show.
Without a path, the text is returned.

Raises FileError when the file cannot be written, and InvalidArgument as show.)")
      .def(
          "plot",
          [](nb::handle self, nb::handle path, nb::handle trajectory, nb::handle title, nb::handle kinds) {
            return in_viewer("plot")(self, path, trajectory, nb::arg("title") = title, nb::arg("kinds") = kinds);
          },
          nb::arg("path") = nb::none(), nb::arg("trajectory") = nb::none(), nb::kw_only(), nb::arg("title").none() = "",
          nb::arg("kinds") = nb::none(),
          nb::sig("def plot(self, path: str | os.PathLike[str] | None = None, trajectory: Trajectory | "
                  "MultiTrajectory | collections.abc.Mapping[str, Trajectory] | None = None, *, title: str = '', "
                  "kinds: collections.abc.Sequence[str] | None = None) -> typing.Any"),
          R"(Draws the scene and a motion, early robots dark, late ones bright, as a matplotlib Figure, which is returned.

path: writes it too (PNG, PDF or SVG, by the suffix). The other arguments are those of to_html.

Raises FileError when it cannot be written, InvalidArgument as show and for a suffix of no figure format, and
ModuleNotFoundError where matplotlib is not installed.)")
      .def("__repr__", &repr);
  make_html(cls);
}

}  // namespace srmp::python
