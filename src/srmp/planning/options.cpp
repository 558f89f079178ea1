#include "srmp/planning/options.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <set>
#include <string_view>
#include <type_traits>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

struct Range {
  double low{-inf};
  double high{inf};
  bool open_low{false};  // low itself is not allowed
};
constexpr Range above_zero{0.0, inf, true};
constexpr Range from_zero{0.0, inf};
constexpr Range from_one{1.0, inf};
constexpr Range share{0.0, 1.0, true};
constexpr Range thread_count{0.0, 1024.0, true};

/// The field holds names of heuristics.
struct HeuristicName {};
const std::vector<std::string> directions{"auto", "forward", "backward"};
const std::vector<std::string> timings{"toppra", "ruckig", "none"};

// One list of fields for each planner: reading, checking, writing and suggesting all walk it.
template <class V>
void visit_fields(CommonOptions& o, V&& field) {
  field("time_limit", o.time_limit, above_zero);
  field("heuristic", o.heuristic, HeuristicName{});
  field("resolution", o.resolution, above_zero);
  field("prismatic_resolution", o.prismatic_resolution, above_zero);
  field("mprim_path", o.mprim_path, std::vector<std::string>{});
  field("direction", o.direction, directions);
  field("bfs_resolution", o.bfs_resolution, above_zero);
  field("bfs_radius", o.bfs_radius, from_zero);
  field("ik_solutions", o.ik_solutions, above_zero);
  field("ik_goal_connection", o.ik_goal_connection, Range{});
  field("recover_start", o.recover_start, Range{});
  field("shortcut", o.shortcut, Range{});
  field("sample_period", o.sample_period, above_zero);
  field("velocity_scaling", o.velocity_scaling, share);
  field("acceleration_scaling", o.acceleration_scaling, share);
  field("timing", o.timing, timings);
  field("blend_deviation", o.blend_deviation, from_zero);
  field("certify", o.certify, Range{});
}
template <class V>
void visit_fields(AStar& o, V&& field) {
  visit_fields(o.common, field);
}
template <class V>
void visit_fields(WAStar& o, V&& field) {
  visit_fields(o.common, field);
  field("weight", o.weight, from_one);
}
template <class V>
void visit_fields(ARAStar& o, V&& field) {
  visit_fields(o.common, field);
  field("weight", o.weight, from_one);
  field("weight_delta", o.weight_delta, above_zero);
  field("final_weight", o.final_weight, from_one);
}
template <class V>
void visit_fields(MHAStar& o, V&& field) {
  visit_fields(o.common, field);
  field("inadmissible_heuristics", o.inadmissible_heuristics, HeuristicName{});
  field("w1", o.w1, from_one);
  field("w2", o.w2, from_one);
}
template <class V>
void visit_fields(WPASE& o, V&& field) {
  visit_fields(o.common, field);
  field("weight", o.weight, from_one);
  field("num_threads", o.num_threads, thread_count);
  field("batch_size", o.batch_size, above_zero);
}
/// Of PA*SE's test whether states are independent, as others' dictionaries have it for wPASE. Here batches are fixed,
/// and nothing depends on it.
struct IndependenceTest {
  std::string i_heuristic;
  double i_weight{1.0};
};
template <class V>
void visit_fields(IndependenceTest& o, V&& field) {
  field("i_heuristic", o.i_heuristic, HeuristicName{});
  field("i_weight", o.i_weight, from_one);
}
template <class V>
void visit_fields(Auto& o, V&& field) {
  visit_fields(o.common, field);
  field("weight", o.weight, from_one);
  field("improve_rounds", o.improve_rounds, from_zero);
  field("improve_time", o.improve_time, from_zero);
  field("final_weight", o.final_weight, from_one);
  field("num_threads", o.num_threads, thread_count);
}
template <class V>
void visit_fields(CBS& o, V&& field) {
  visit_fields(o.common, field);
  field("num_threads", o.num_threads, thread_count);
}
template <class Options, class V>
void visit_conflict_fields(Options& o, V&& field) {
  visit_fields(o.common, field);
  field("weight_low_level_heuristic", o.weight_low_level_heuristic, from_one);
  field("high_level_focal_suboptimality", o.high_level_focal_suboptimality, from_one);
  field("low_level_focal_suboptimality", o.low_level_focal_suboptimality, from_one);
  field("num_threads", o.num_threads, thread_count);
}
template <class V>
void visit_fields(ECBS& o, V&& field) {
  visit_conflict_fields(o, field);
}
template <class V>
void visit_fields(XECBS& o, V&& field) {
  visit_conflict_fields(o, field);
  field("improve_rounds", o.improve_rounds, from_zero);
}
template <class V>
void visit_fields(Prioritised& o, V&& field) {
  visit_fields(o.common, field);
  field("weight_low_level_heuristic", o.weight_low_level_heuristic, from_one);
  field("num_threads", o.num_threads, thread_count);
}

/// None for planners of one robot.
template <class Options>
auto robots_of(Options& options)
    -> std::conditional_t<std::is_const_v<Options>, const RobotOptionMap*, RobotOptionMap*> {
  if constexpr (requires { options.robots; }) return &options.robots;
  return nullptr;
}

/// Those that are set, by the names that the dictionary has for them.
template <class V>
void visit_robot_fields(RobotOptionMap* robots, V&& field) {
  if (!robots) return;
  for (auto& [robot, own] : *robots) {
    const std::string of_robot = "_" + robot;
    if (own.heuristic) field("heuristic" + of_robot, *own.heuristic, HeuristicName{});
    if (own.mprim_path) field("mprim_path" + of_robot, *own.mprim_path, std::vector<std::string>{});
  }
}

/// Every option of a planner.
template <class Options, class V>
void visit_all_fields(Options& options, V&& field) {
  visit_fields(options, field);
  visit_robot_fields(robots_of(options), field);
}

std::string option(const std::string& key) { return "option '" + key + "'"; }

double as_number(const std::string& key, const OptionValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return *number;
  if (const auto* text = std::get_if<std::string>(&value)) {
    double number{};
    const char* end = text->data() + text->size();
    const auto [stop, error] = std::from_chars(text->data(), end, number);
    if (error == std::errc{} && stop == end) return number;
    throw InvalidArgument(option(key) + " is '" + *text + "'; it must be a number");
  }
  throw InvalidArgument(option(key) + " must be a number");
}

bool as_bool(const std::string& key, const OptionValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag;
  if (const auto* text = std::get_if<std::string>(&value)) {
    if (*text == "true" || *text == "True" || *text == "1") return true;
    if (*text == "false" || *text == "False" || *text == "0") return false;
  }
  if (const auto* number = std::get_if<double>(&value); number && (*number == 0.0 || *number == 1.0))
    return *number == 1.0;
  throw InvalidArgument(option(key) + " must be true or false");
}

std::vector<std::string> as_words(const std::string& key, const OptionValue& value) {
  if (const auto* words = std::get_if<std::vector<std::string>>(&value)) return *words;
  const auto* text = std::get_if<std::string>(&value);
  if (!text) throw InvalidArgument(option(key) + " must be a list of names");
  std::vector<std::string> words;
  std::string word;
  for (const char c : *text + ',') {
    if (c != ',' && c != ' ')
      word += c;
    else if (!word.empty())
      words.push_back(std::move(word)), word.clear();
  }
  return words;
}

void require_in(const std::string& key, double value, const Range& range) {
  const bool ok =
      std::isfinite(value) && (range.open_low ? value > range.low : value >= range.low) && value <= range.high;
  if (ok) return;
  std::string allowed = std::string("it must be ") + (range.open_low ? "above " : "at least ") + to_text(range.low);
  if (range.high < inf) allowed += " and at most " + to_text(range.high);
  throw InvalidArgument(option(key) + " is " + to_text(value) + "; " + allowed);
}

/// The end of a sentence that refuses a word.
std::string or_known(const std::string& word, const std::vector<std::string>& known) {
  const std::string hint = did_you_mean(word, known);
  return (hint.empty() ? "; known are " : hint + " Known are ") + quoted_list(known);
}

void require_word(const std::string& key, const std::string& word, const std::vector<std::string>& known) {
  if (known.empty() || std::find(known.begin(), known.end(), word) != known.end()) return;
  throw InvalidArgument(option(key) + " is '" + word + "'" + or_known(word, known));
}

struct Reader {
  const OptionMap& map;
  std::vector<std::string> known{"planner_id"};

  const OptionValue* find(const std::string& key) {
    known.push_back(key);
    const auto it = map.find(key);
    return it == map.end() ? nullptr : &it->second;
  }
  void operator()(const std::string& key, double& field, const Range&) {
    if (const auto* value = find(key)) field = as_number(key, *value);
  }
  void operator()(const std::string& key, int& field, const Range& range) {
    const auto* value = find(key);
    if (!value) return;
    const double number = as_number(key, *value);
    require_in(key, number, range);
    if (number != std::floor(number) || number > 1e9)
      throw InvalidArgument(option(key) + " is " + to_text(number) + "; it must be a whole number");
    field = static_cast<int>(number);
  }
  void operator()(const std::string& key, bool& field, const Range&) {
    if (const auto* value = find(key)) field = as_bool(key, *value);
  }
  template <class Allowed>
  void operator()(const std::string& key, std::string& field, const Allowed&) {
    const auto* value = find(key);
    if (!value) return;
    const auto* text = std::get_if<std::string>(value);
    if (!text) throw InvalidArgument(option(key) + " must be a word");
    field = *text;
  }
  void operator()(const std::string& key, std::vector<std::string>& field, const HeuristicName&) {
    if (const auto* value = find(key)) field = as_words(key, *value);
  }
};

struct Validator {
  void operator()(const std::string& key, double& field, const Range& range) { require_in(key, field, range); }
  void operator()(const std::string& key, int& field, const Range& range) { require_in(key, field, range); }
  void operator()(const std::string&, bool&, const Range&) {}
  void operator()(const std::string& key, std::string& field, const std::vector<std::string>& known) {
    require_word(key, field, known);
  }
  template <class Field>
  void operator()(const std::string&, Field&, const HeuristicName&) {}
};

struct HeuristicCheck {
  const std::vector<std::string>& known;

  template <class Field, class Allowed>
  void operator()(const std::string&, Field&, const Allowed&) {}
  void operator()(const std::string& key, std::string& name, const HeuristicName&) {
    if (!bfs_cell(name)) require_word(key, name, known);
  }
  void operator()(const std::string& key, std::vector<std::string>& names, const HeuristicName& allowed) {
    for (std::string& name : names) operator()(key, name, allowed);
  }
};

struct HeuristicNames {
  std::vector<std::string>& names;

  template <class Field, class Allowed>
  void operator()(const std::string&, Field&, const Allowed&) {}
  void operator()(const std::string&, std::string& name, const HeuristicName&) { names.push_back(name); }
  void operator()(const std::string&, std::vector<std::string>& more, const HeuristicName&) {
    names.insert(names.end(), more.begin(), more.end());
  }
};

struct Writer {
  OptionMap& map;
  template <class Field, class Allowed>
  void operator()(const std::string& key, Field& field, const Allowed&) {
    if constexpr (std::is_same_v<Field, int>)
      map[key] = static_cast<double>(field);
    else
      map[key] = field;
  }
};

const RobotOptionMap& single_robots(const PlannerOptions& options) {
  static const RobotOptionMap none;
  const RobotOptionMap* robots = std::visit([](const auto& typed) { return robots_of(typed); }, options);
  return robots ? *robots : none;
}

struct Planner {
  PlannerInfo info;
  PlannerOptions defaults;
  std::vector<std::string> spellings;  // compared without case and without '-', '_', ' '
};

const std::vector<Planner>& registry() {
  static const std::vector<Planner> planners{
      {{"auto", "the quickest: two trees and guided searches from both ends; anytime if asked", true, true},
       Auto{},
       {}},
      {{"Astar", "A*: the shortest path on the lattice", true, false}, AStar{}, {"a*"}},
      {{"wAstar", "weighted A*: cost at most weight times the shortest; quick", true, false},
       WAStar{},
       {"wa*", "weightedastar"}},
      {{"ARAstar", "ARA*: a first path quickly, then better ones until the time limit", true, false},
       ARAStar{},
       {"ara*"}},
      {{"MHAstar", "MHA*: several heuristics share one search", true, false}, MHAStar{}, {"mha*"}},
      {{"wPASE", "parallel weighted search; the same path for every number of threads", true, false},
       WPASE{},
       {"wpa*se", "wpastarse", "epa*se", "epase"}},
      {{"CBS", "many robots: the least sum of costs on their lattices", false, true}, CBS{}, {}},
      {{"ECBS", "many robots: sum of costs within a bound", false, true}, ECBS{}, {}},
      {{"xECBS", "many robots: ECBS that learns from its own searches; quick", false, true}, XECBS{}, {}},
      {{"prioritised", "many robots: one gives way to another; quick, nothing is proved", false, true},
       Prioritised{},
       {"prioritized", "pbs", "pp"}},
  };
  return planners;
}

std::string folded(const std::string& id) {
  std::string result;
  for (const char c : id)
    if (c != '-' && c != '_' && c != ' ') result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

const Planner& find_planner(const std::string& id) {
  std::vector<std::string> known;
  for (const Planner& planner : registry()) {
    known.push_back(planner.info.id);
    std::vector<std::string> names = planner.spellings;
    names.push_back(folded(planner.info.id));
    if (std::find(names.begin(), names.end(), folded(id)) != names.end()) return planner;
  }
  throw InvalidArgument("there is no planner '" + id + "'" + or_known(id, known));
}

/// Makes room for the options of single robots that the dictionary has.
void make_room(RobotOptionMap* robots, const OptionMap& map) {
  if (!robots) return;
  for (const auto& [key, value] : map)
    for (const std::string_view option : {"heuristic_", "mprim_path_"})
      if (key.starts_with(option) && key.size() > option.size()) {
        RobotOptions& own = (*robots)[key.substr(option.size())];
        (option == "heuristic_" ? own.heuristic : own.mprim_path).emplace();
      }
}

void require_known_keys(const OptionMap& map, const std::vector<std::string>& known, const std::string& id) {
  for (const auto& [key, value] : map)
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      const std::string hint = did_you_mean(key, known);
      throw InvalidArgument("planner '" + id + "' has no option '" + key + "'" +
                            (hint.empty() ? "; it knows " + quoted_list(known) : hint));
    }
}

}  // namespace

PlannerOptions parse_options(const OptionMap& map) {
  const auto id = map.find("planner_id");
  const auto* name = id == map.end() ? nullptr : std::get_if<std::string>(&id->second);
  if (id != map.end() && !name) throw InvalidArgument("option 'planner_id' must be a word, such as 'auto'");
  const Planner& planner = name ? find_planner(*name) : registry().front();
  PlannerOptions options = planner.defaults;
  std::visit(
      [&](auto& typed) {
        Reader reader{map};
        make_room(robots_of(typed), map);
        visit_all_fields(typed, reader);
        if constexpr (std::is_same_v<decltype(typed), WPASE&>) {
          IndependenceTest unused;
          visit_fields(unused, reader);
          visit_fields(unused, Validator{});
        }
        require_known_keys(map, reader.known, planner.info.id);
      },
      options);
  validate(options);
  return options;
}

void validate(const PlannerOptions& options) {
  PlannerOptions copy = options;
  std::visit([](auto& typed) { visit_all_fields(typed, Validator{}); }, copy);
}

const std::vector<std::string>& built_in_heuristics() {
  static const std::vector<std::string> names{"joint_euclidean", "joint_base", "joint_hand", "joint_sum", "bfs"};
  return names;
}

std::optional<double> bfs_cell(const std::string& heuristic) {
  if (!heuristic.starts_with("bfs(")) return std::nullopt;
  double cell{};
  const char* end = heuristic.data() + heuristic.size();
  const auto [stop, error] = std::from_chars(heuristic.data() + 4, end, cell);
  if (error == std::errc{} && stop + 1 == end && *stop == ')' && cell > 0.0 && cell < inf) return cell;
  throw InvalidArgument("heuristic '" + heuristic +
                        "': between the brackets must be the cell of the grid [m], above 0");
}

std::vector<std::string> named_heuristics(const PlannerOptions& options) {
  std::vector<std::string> names;
  PlannerOptions copy = options;
  std::visit([&](auto& typed) { visit_all_fields(typed, HeuristicNames{names}); }, copy);
  return names;
}

void require_heuristics(const PlannerOptions& options, std::span<const std::string> users) {
  std::vector<std::string> known = built_in_heuristics();
  known.insert(known.end(), users.begin(), users.end());
  PlannerOptions copy = options;
  std::visit([&](auto& typed) { visit_all_fields(typed, HeuristicCheck{known}); }, copy);
}

OptionMap to_map(const PlannerOptions& options) {
  PlannerOptions copy = options;
  OptionMap map{{"planner_id", planner_id(options)}};
  std::visit([&](auto& typed) { visit_all_fields(typed, Writer{map}); }, copy);
  return map;
}

Improvement improvement(const PlannerOptions& options) {
  if (const auto* any = std::get_if<Auto>(&options)) return {any->improve_rounds, any->improve_time, any->final_weight};
  if (const auto* xecbs = std::get_if<XECBS>(&options)) return {.rounds = xecbs->improve_rounds};
  return {};
}

int num_threads(const PlannerOptions& options) {
  return std::visit(
      [](const auto& typed) {
        if constexpr (requires { typed.num_threads; }) return typed.num_threads;
        return 1;
      },
      options);
}

const CommonOptions& common_options(const PlannerOptions& options) {
  return std::visit([](const auto& typed) -> const CommonOptions& { return typed.common; }, options);
}

CommonOptions common_options(const PlannerOptions& options, const std::string& robot) {
  CommonOptions common = common_options(options);
  const RobotOptionMap& robots = single_robots(options);
  if (const auto own = robots.find(robot); own != robots.end()) {
    if (own->second.heuristic) common.heuristic = *own->second.heuristic;
    if (own->second.mprim_path) common.mprim_path = *own->second.mprim_path;
  }
  return common;
}

void require_robots(const PlannerOptions& options, const std::vector<std::string>& robots) {
  for (const auto& [name, own] : single_robots(options)) {
    if (std::find(robots.begin(), robots.end(), name) == robots.end())
      throw InvalidArgument("there are options for robot '" + name +
                            "' alone, which is none of the robots of this planner" + or_known(name, robots));
    if (robots.size() == 1)
      throw InvalidArgument("there are options for robot '" + name + "' alone, such as 'heuristic_" + name +
                            "', but it is the only one; name them without it");
  }
}

std::string planner_id(const PlannerOptions& options) {
  for (const Planner& planner : registry())
    if (planner.defaults.index() == options.index()) return planner.info.id;
  return {};
}

const std::vector<PlannerInfo>& available_planners() {
  static const std::vector<PlannerInfo> infos = [] {
    std::vector<PlannerInfo> list;
    for (const Planner& planner : registry()) list.push_back(planner.info);
    return list;
  }();
  return infos;
}

}  // namespace srmp
