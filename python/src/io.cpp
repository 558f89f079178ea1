#include "bind.hpp"
#include "interrupt.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/core/write_file.hpp"
#include "srmp/io/moveit.hpp"

namespace srmp::python {

void bind_io(nb::module_& m) {
  nb::class_<io::RequestFile>(
      m, "MoveItRequest",
      R"(A MoveIt motion request as it is in its file; PlannerInterface.apply_moveit_request makes a problem of it.)")
      .def_ro("path", &io::RequestFile::path, "The file that it was read from.")
      .def_ro("group_name", &io::RequestFile::group_name, "The planning group that the request is for.")
      .def_ro("planner_id", &io::RequestFile::planner_id, "The planner id of the file; it is not used.")
      .def_prop_ro(
          "start_joints", [](const io::RequestFile& r) { return r.start_state.joints; },
          "The start state: joint name to position [rad or m].")
      .def_ro("allowed_planning_time", &io::RequestFile::allowed_planning_time,
              "The allowed planning time [s]; None if the file does not say it.")
      .def("__repr__", [](const io::RequestFile& request) {
        return "MoveItRequest('" + request.path + "', group '" + request.group_name + "')";
      });
  m.def("load_moveit_request", &io::read_moveit_request, nb::arg("path"),
        R"(Reads a MoveIt motion request (YAML), such as MotionBenchMaker's request*.yaml.

Raises FileError with the line, and NotSupported for what this version does not plan with (path constraints, say).)");
  m.def(
      "_write_file",
      [](const nb::object& path, const std::string& text) {
        const std::string name = to_path(path);
        const InterruptionScope interruptible(raise_interrupt);
        const nb::gil_scoped_release no_gil;
        write_file(name, text);
      },
      nb::arg("path"), nb::arg("text"), nb::sig("def _write_file(path: str | os.PathLike[str], text: str) -> None"),
      "Writes a file completely or not at all, as all files of the library. Raises FileError.");
}

}  // namespace srmp::python
