#pragma once

#include <optional>
#include <string>
#include <vector>

#include "srmp/planning/options.hpp"
#include "srmp/planning/options/option_spec.hpp"

namespace srmp {

/// One planner: what users are told about it, and how its options are read, checked and written.
struct RegisteredPlanner {
  PlannerInfo info;  ///< info.options repeats those of `options`
  PlannerOptions defaults;
  std::vector<OptionSpec> options{};  ///< common options first
  std::vector<OptionSpec> ignored{};  ///< accepted and checked for the sake of other planners' dictionaries; no fields
  std::vector<std::string> other_names{};        ///< in lower case, without '-', '_' and ' ', none of which count
  RobotOptionMap* (*robots)(PlannerOptions&){};  ///< null for planners of one robot
};

/// All planners; the first is the default. This is the one place that lists planners and their options.
const std::vector<RegisteredPlanner>& registry();
/// Throws InvalidArgument, with the nearest id.
const RegisteredPlanner& registered_planner(const std::string& id);
/// The planner whose options have this type.
const RegisteredPlanner& registered_planner(const PlannerOptions& options);

/// An option of a single robot: in a dictionary its key is `name`, '_' and the robot's name.
struct RobotOptionSpec {
  std::string name;
  std::optional<std::string> RobotOptions::* member{};
  bool names_heuristics{};
};
const std::vector<RobotOptionSpec>& robot_option_specs();
/// The options of single robots; empty for planners of one robot.
const RobotOptionMap& single_robots(const PlannerOptions& options);

}  // namespace srmp
