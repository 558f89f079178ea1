#include <algorithm>
#include <string_view>

#include "srmp/core/error.hpp"
#include "srmp/planning/options/other_vocabularies.hpp"
#include "srmp/planning/options/registry.hpp"

namespace srmp {

namespace {

/// Looks keys up, and remembers which keys there may be.
class Dictionary {
 public:
  explicit Dictionary(const OptionMap& map) : map_(map) {}

  const OptionValue* find(const std::string& key) {
    known_.push_back(key);
    const auto it = map_.find(key);
    return it == map_.end() ? nullptr : &it->second;
  }
  /// Throws InvalidArgument for keys that nobody has looked up.
  void require_no_other_key(const std::string& id) const {
    for (const auto& [key, value] : map_)
      if (std::find(known_.begin(), known_.end(), key) == known_.end()) {
        const std::string theirs = option_of_other_planner(key), hint = did_you_mean(key, known_);
        throw InvalidArgument("planner '" + id + "' has no option '" + key + "'" +
                              (!theirs.empty() ? "; " + theirs
                               : hint.empty()  ? "; it knows " + quoted_list(known_)
                                               : hint));
      }
  }
  /// The robots whose names stand after `prefix` in a key.
  std::vector<std::string> robots_after(std::string_view prefix) const {
    std::vector<std::string> robots;
    for (const auto& [key, value] : map_)
      if (key.starts_with(prefix) && key.size() > prefix.size()) robots.push_back(key.substr(prefix.size()));
    return robots;
  }

 private:
  const OptionMap& map_;
  std::vector<std::string> known_{"planner_id"};
};

void read_robot_options(Dictionary& dictionary, RobotOptionMap& robots) {
  for (const RobotOptionSpec& spec : robot_option_specs())
    for (const std::string& robot : dictionary.robots_after(spec.name + "_")) (robots[robot].*spec.member).emplace();
  for (auto& [robot, own] : robots)
    for (const RobotOptionSpec& spec : robot_option_specs()) {
      if (!(own.*spec.member)) continue;
      const std::string key = spec.name + "_" + robot;
      own.*spec.member = as_text(key, *dictionary.find(key));
    }
}

/// Calls `visit(key, spec, value)` for each option of single robots that is set.
template <class Visit>
void for_each_robot_option(const PlannerOptions& options, Visit visit) {
  for (const auto& [robot, own] : single_robots(options))
    for (const RobotOptionSpec& spec : robot_option_specs())
      if (const auto& value = own.*spec.member) visit(spec.name + "_" + robot, spec, *value);
}

/// Calls `visit(key, name)` for each heuristic that the options refer to.
template <class Visit>
void for_each_heuristic(const PlannerOptions& options, Visit visit) {
  for (const OptionSpec& spec : registered_planner(options).options) {
    if (!spec.allowed.names_heuristics) continue;
    const FieldValue value = spec.get(options);
    if (const auto* name = std::get_if<std::string>(&value)) visit(spec.info.name, *name);
    if (const auto* names = std::get_if<std::vector<std::string>>(&value))
      for (const std::string& name : *names) visit(spec.info.name, name);
  }
  for_each_robot_option(options, [&](const std::string& key, const RobotOptionSpec& spec, const std::string& name) {
    if (spec.names_heuristics) visit(key, name);
  });
}

}  // namespace

PlannerOptions parse_options(const OptionMap& map) {
  const auto id = map.find("planner_id");
  const RegisteredPlanner& planner =
      id == map.end() ? registry().front() : registered_planner(as_text(id->first, id->second));
  PlannerOptions options = planner.defaults;
  Dictionary dictionary(map);
  for (const OptionSpec& spec : planner.options)
    if (const OptionValue* value = dictionary.find(spec.info.name))
      spec.set(options, read_value(spec.info.name, spec, *value));
  if (planner.robots) read_robot_options(dictionary, *planner.robots(options));
  for (const OptionSpec& spec : planner.ignored)
    if (const OptionValue* value = dictionary.find(spec.info.name))
      require_allowed(spec.info.name, read_value(spec.info.name, spec, *value), spec.allowed);
  dictionary.require_no_other_key(planner.info.id);
  validate(options);
  return options;
}

void validate(const PlannerOptions& options) {
  for (const OptionSpec& spec : registered_planner(options).options)
    require_allowed(spec.info.name, spec.get(options), spec.allowed);
  const CommonOptions& common = common_options(options);
  if (common.sample_rate == 0.0) return;
  if (common.sample_period != CommonOptions{}.sample_period)
    throw InvalidArgument("options 'sample_period' and 'sample_rate' are both given; leave one of them out");
  if (common.timing == "none")
    throw InvalidArgument("option 'timing' is 'none', and a path without times has no 'sample_rate'; leave it out");
}

OptionMap to_map(const PlannerOptions& options) {
  const RegisteredPlanner& planner = registered_planner(options);
  OptionMap map{{"planner_id", planner.info.id}};
  for (const OptionSpec& spec : planner.options) map[spec.info.name] = to_option_value(spec.get(options));
  for_each_robot_option(
      options, [&](const std::string& key, const RobotOptionSpec&, const std::string& value) { map[key] = value; });
  return map;
}

std::vector<std::string> named_heuristics(const PlannerOptions& options) {
  std::vector<std::string> names;
  for_each_heuristic(options, [&](const std::string&, const std::string& name) { names.push_back(name); });
  return names;
}

void require_heuristics(const PlannerOptions& options, std::span<const std::string> user_heuristics) {
  std::vector<std::string> known = built_in_heuristics();
  known.insert(known.end(), user_heuristics.begin(), user_heuristics.end());
  for_each_heuristic(options, [&](const std::string& key, const std::string& name) {
    if (!bfs_cell(name)) require_choice(key, name, known);
  });
}

}  // namespace srmp
