#include "bind.hpp"

namespace srmp::python {

void bind_options(nb::module_& m) {
  m.def(
      "planner_options", [](nb::dict options) { return to_dict(to_map(parse_options(to_option_map(options)))); },
      nb::arg("options"), nb::sig("def planner_options(options: dict) -> dict[str, typing.Any]"),
      "Every option of options['planner_id'] with its value: the given ones, checked, and defaults for the rest.\n\n"
      "Raises InvalidArgument for an unknown planner or option (with the nearest name) or a value out of range.");
  m.def(
      "available_planners",
      [] {
        nb::dict result;
        for (const PlannerInfo& info : available_planners()) result[info.id.c_str()] = info.summary;
        return result;
      },
      nb::sig("def available_planners() -> dict[str, str]"), "Planner ids and what each is for.");
}

}  // namespace srmp::python
