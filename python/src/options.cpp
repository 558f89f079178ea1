#include "bind.hpp"
#include "srmp/planning/options/other_vocabularies.hpp"

namespace srmp::python {

namespace {

/// As the type hints of the typed options have it.
const char* type_name(OptionType type) {
  switch (type) {
    case OptionType::boolean: return "bool";
    case OptionType::integer: return "int";
    case OptionType::number: return "float";
    case OptionType::text: return "str";
    case OptionType::text_list: break;
  }
  return "list[str]";
}

nb::object default_of(const OptionInfo& option) {
  const nb::object value = to_dict(OptionMap{{option.name, option.default_value}})[option.name.c_str()];
  return option.type == OptionType::integer ? nb::module_::import_("builtins").attr("int")(value) : value;
}

void bind_option_info(nb::module_& m) {
  nb::class_<OptionInfo>(m, "OptionInfo", "What is known of an option of a planner; see PlannerInfo.options.")
      .def_ro("name", &OptionInfo::name, "The key in a dictionary, and the field of the planner's class.")
      .def_prop_ro(
          "type", [](const OptionInfo& self) { return type_name(self.type); },
          "'bool', 'int', 'float', 'str' or 'list[str]'.")
      .def_prop_ro("default", &default_of, nb::sig("def default(self) -> bool | int | float | str | list[str]"),
                   "The value when it is not given.")
      .def_ro("unit", &OptionInfo::unit, "'s', 'm', 'degrees'; '' for a number without unit, and for other types.")
      .def_ro("range", &OptionInfo::range, "Of a number, such as '>= 1' or '> 0 and <= 1'; '' for other types.")
      .def_ro("choices", &OptionInfo::choices, "All allowed words; [] when any text is allowed.")
      .def_ro("description", &OptionInfo::description, "What the option does, in one sentence.")
      .def_ro("common", &OptionInfo::common, "Whether every planner has it.")
      .def_ro("per_robot", &OptionInfo::per_robot,
              "Whether it may also be given for one robot among many: `heuristic_panda`, for the robot 'panda'.")
      .def("__repr__", [](const OptionInfo& self) { return "<OptionInfo '" + self.name + "'>"; });
}

void bind_planner_info(nb::module_& m) {
  nb::class_<PlannerInfo>(m, "PlannerInfo", "What is known of a planner; see planner_info.")
      .def_ro("id", &PlannerInfo::id, "options['planner_id'] in a dictionary.")
      .def_ro("class_name", &PlannerInfo::class_name, "Of the class with its options: srmp.WAStar for 'WAStar'.")
      .def_ro("summary", &PlannerInfo::summary, "What the planner does, in one line.")
      .def_ro("papers", &PlannerInfo::papers, "What the planner is called in the literature, and where.")
      .def_ro("guarantee", &PlannerInfo::guarantee, "On the cost of the path, relative to the optimum.")
      .def_ro("one_robot", &PlannerInfo::one_robot, "Whether it serves plan.")
      .def_ro("many_robots", &PlannerInfo::many_robots, "Whether it serves plan_multi.")
      .def_ro("options", &PlannerInfo::options, "All its options (list of OptionInfo), those of every planner first.")
      .def("__repr__", [](const PlannerInfo& self) { return "<PlannerInfo '" + self.id + "'>"; });
}

}  // namespace

void bind_options(nb::module_& m) {
  bind_option_info(m);
  bind_planner_info(m);
  m.def(
      "planner_options", [](nb::dict options) { return to_dict(to_map(parse_options(to_option_map(options)))); },
      nb::arg("options"), nb::sig("def planner_options(options: dict) -> dict[str, typing.Any]"),
      "Every option of options['planner_id'] with its value: the given ones, checked, and defaults for the others.\n\n"
      "Raises InvalidArgument for an unknown planner or option (with the nearest name) or a value out of range.");
  m.def(
      "available_planners",
      [] {
        nb::dict result;
        for (const PlannerInfo& info : available_planners()) result[info.id.c_str()] = info.summary;
        return result;
      },
      nb::sig("def available_planners() -> dict[str, str]"), "Planner ids and what each is for.");
  m.def("planner_info", &planner_info, nb::arg("planner_id"), nb::rv_policy::reference,
        "A planner and its options, with units, ranges and meanings.\n\n"
        "Raises InvalidArgument for an unknown planner, with the nearest id.");
  m.def(
      "_did_you_mean",
      [](const std::string& name, const std::vector<std::string>& known) { return did_you_mean(name, known); },
      nb::arg("name"), nb::arg("known"),
      "\", did you mean 'x'?\" with the nearest known name; \"\" when none is near.");
  m.def("_option_of_other_planner", &option_of_other_planner, nb::arg("name"),
        "What an option of another planner is called here, as the end of a sentence; \"\" for words not known.");
}

}  // namespace srmp::python
