#pragma once

#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

// A struct below defines the type and the default of each option of a planner; the registry
// (src/srmp/planning/options/registry.cpp) adds its unit, its range and its meaning. The comments of these structs are
// generated from the registry by docs/generate_options.py.

namespace srmp {

/// Options that every planner has.
struct CommonOptions {
  /// All phases of a plan together take at most this time [s, > 0].
  double time_limit{5.0};
  /// This heuristic guides the search: joint_euclidean, joint_proximal, joint_distal, joint_sum, bfs, bfs(0.1) for
  /// cells of 0.1 m, or the name of a user's heuristic.
  std::string heuristic{"joint_euclidean"};
  /// A lattice has this step in revolute joints [degrees, > 0 and <= 360].
  double resolution{15.0};
  /// A lattice has this step in prismatic joints [m, > 0 and <= 1000].
  double prismatic_resolution{0.05};
  /// This YAML file defines the motion primitives; an empty path selects the built-in ones.
  std::string mprim_path{};
  /// The search begins at the start (forward), at the goals (backward), or at the end with less clearance (auto)
  /// [auto | forward | backward].
  std::string direction{"auto"};
  /// The grid of the bfs heuristic has cells of this size [m, > 0 and <= 1000].
  double bfs_resolution{0.05};
  /// The grid of the bfs heuristic inflates obstacles by this radius [m, >= 0 and <= 1000].
  double bfs_radius{0.05};
  /// Each target of a pose or position goal becomes at most this many valid configurations: of those that inverse
  /// kinematics finds, the nearest to the start [> 0].
  int ik_solutions{16};
  /// A search from the start may also end by inverse kinematics from a state near a pose or position target.
  bool ik_goal_connection{true};
  /// A start in collision is recovered first, by a motion on which no pair penetrates deeper and no other pair comes
  /// into contact.
  bool recover_start{false};
  /// The path is shortened before it is timed.
  bool shortcut{true};
  /// The returned trajectory has a sample after each such period [s, > 0].
  double sample_period{0.02};
  /// The returned trajectory has this many samples a second, at even times and nowhere else, in place of a
  /// `sample_period`; 0 leaves samples at the corners of the path too [Hz, >= 0].
  double sample_rate{0.0};
  /// The trajectory may use this fraction of the velocity limits [> 0 and <= 1].
  double velocity_scaling{1.0};
  /// The trajectory may use this fraction of the acceleration and jerk limits [> 0 and <= 1].
  double acceleration_scaling{1.0};
  /// The trajectory is time-optimal with rounded corners (toppra), jerk-limited with a stop at each corner (ruckig), or
  /// a path without times (none) [toppra | ruckig | none].
  std::string timing{"toppra"};
  /// No point of the robot leaves the checked path by more than this distance at a rounded corner
  /// [m, >= 0 and <= 1000].
  double blend_deviation{0.005};
  /// The path keeps this clearance from everything, and the robot's links from each other; a pair that is closer at the
  /// start or at the goal does not come closer on the way from or to there [m, >= 0 and <= 1000].
  double clearance{0.0};
  /// Shortening the path and rounding its corners give away no clearance below this that the searched path had
  /// [m, >= 0 and <= 1000].
  double preferred_clearance{0.0};
  /// Code that is independent of the planner verifies the trajectory and attaches a certificate.
  bool certify{true};
};

/// Options of one robot among many, which replace those of all robots. In a dictionary their keys end in the robot's
/// name: `heuristic_panda` and `mprim_path_panda` for the robot 'panda'.
struct RobotOptions {
  std::optional<std::string> heuristic{};
  std::optional<std::string> mprim_path{};
};
/// By robot name.
using RobotOptionMap = std::map<std::string, RobotOptions>;

/// A*: the shortest path in the lattice.
/// Literature: A*: Hart, Nilsson, Raphael 1968.
/// Guarantee: cost = optimum.
struct AStar {
  CommonOptions common{};
};

/// Weighted A*: a path of at most weight times the least cost, quickly.
/// Literature: weighted A*: Pohl 1970; lazy edges: Cohen, Phillips, Likhachev 2014.
/// Guarantee: cost <= `weight` * optimum.
struct WAStar {
  CommonOptions common{};
  /// This weight inflates the heuristic [>= 1].
  double weight{50.0};
  /// Lattices of 3, 1.5, 0.75 and 0.4 times `resolution`, from the start and from the goals, are searched side by side,
  /// and the bound holds for the one in which the path was found; otherwise one lattice is.
  bool multi_resolution{true};
};

/// ARA*: a first path quickly, then better ones until the time limit.
/// Literature: ARA*: Likhachev, Gordon, Thrun 2003.
/// Guarantee: anytime; cost <= last proven bound * optimum.
struct ARAStar {
  CommonOptions common{};
  /// The first round inflates the heuristic by this weight [>= 1].
  double weight{50.0};
  /// The weight decreases by this much after each round [> 0].
  double weight_delta{10.0};
  /// The search ends once this bound is proven [>= 1].
  double final_weight{1.0};
  /// Lattices of 3, 1.5, 0.75 and 0.4 times `resolution`, from the start and from the goals, are searched side by side,
  /// and the bound holds for the one in which the path was found; otherwise one lattice is.
  bool multi_resolution{true};
};

/// MHA*: several heuristics share one search.
/// Literature: MHA* with shared expansions: Aine, Swaminathan, Narayanan, Hwang, Likhachev 2016.
/// Guarantee: cost <= `w1` * `w2` * optimum.
struct MHAStar {
  CommonOptions common{};
  /// These heuristics guide searches beside the anchor search, which has the option `heuristic`.
  std::vector<std::string> inadmissible_heuristics{"joint_proximal", "joint_distal", "joint_sum"};
  /// This weight inflates every heuristic [>= 1].
  double w1{20.0};
  /// The keys of the inadmissible searches may exceed the anchor search's by this factor [>= 1].
  double w2{5.0};
  /// Lattices of 3, 1.5, 0.75 and 0.4 times `resolution`, from the start and from the goals, are searched side by side,
  /// and the bound holds for the one in which the path was found; otherwise one lattice is.
  bool multi_resolution{true};
};

/// Parallel weighted search; the same path for every number of threads.
/// Literature: ePA*SE: Mukherjee, Aine, Likhachev 2022; PA*SE: Phillips, Likhachev, Koenig 2014.
/// Guarantee: cost <= `weight` * optimum.
struct WPASE {
  CommonOptions common{};
  /// This weight inflates the heuristic [>= 1].
  double weight{50.0};
  /// This many threads evaluate edges; the path does not depend on it. More pay where a check takes much longer than
  /// waking a thread, some 50 us [> 0 and <= 1024].
  int num_threads{1};
  /// This many edges are evaluated together; another size may find another path [> 0].
  int batch_size{4};
  /// Lattices of 3, 1.5, 0.75 and 0.4 times `resolution`, from the start and from the goals, are searched side by side,
  /// and the bound holds for the one in which the path was found; otherwise one lattice is.
  bool multi_resolution{true};
};

/// AMRA*: several heuristics and resolutions share one search; better paths until the time limit.
/// Literature: AMRA*: Saxena, Kusnur, Likhachev 2022; MRA*: Du, Islam, Likhachev 2020.
/// Guarantee: anytime; first cost <= `w1` * `w2` * optimum of the finest lattice, then <= last proven bound * it.
struct AMRAStar {
  CommonOptions common{};
  /// In the first round, this weight inflates every heuristic [>= 1].
  double w1{20.0};
  /// In the first round, the keys of the inadmissible searches may exceed the anchor search's by this factor [>= 1].
  double w2{5.0};
  /// The search ends once this bound is proven [>= 1].
  double final_weight{1.0};
};

/// Two trees that grow towards each other, by the same samples every time: quick, not optimal.
/// Literature: RRT-Connect: Kuffner, LaValle 2000.
/// Guarantee: none; no path is shorter than the straight line, which bounds the cost.
struct RRTConnect {
  CommonOptions common{};
};

/// Many robots: the least sum of costs on their lattices.
/// Literature: CBS: Sharon, Stern, Felner, Sturtevant 2015.
/// Guarantee: sum of costs = optimum, without `independence_detection`.
struct CBS {
  CommonOptions common{};
  RobotOptionMap robots{};
  /// Each robot is planned by itself first, by weighted A*, and only robots whose paths conflict are planned jointly;
  /// otherwise all robots that can reach each other are.
  bool independence_detection{false};
  /// After `shortcut`, paths of robots that were planned jointly are rerouted, one robot at a time, while the others
  /// move as before.
  bool large_neighbourhood_search{true};
  /// At most this many threads plan parts for many robots at the same time; the result does not depend on it
  /// [> 0 and <= 1024].
  int num_threads{1};
};

/// Many robots: sum of costs within a bound.
/// Literature: ECBS: Barer, Sharon, Stern, Felner 2014.
/// Guarantee: sum of costs <= product of its three factors * optimum, without `independence_detection`.
struct ECBS {
  CommonOptions common{};
  RobotOptionMap robots{};
  /// This weight inflates the heuristic of each robot's low-level search [>= 1].
  double weight_low_level_heuristic{50.0};
  /// The focal list of the constraint tree holds the nodes within this factor of the lower bound [>= 1].
  double high_level_focal_suboptimality{1.3};
  /// The focal list of each robot's low-level search holds the states within this factor of its lower bound [>= 1].
  double low_level_focal_suboptimality{1.3};
  /// Each robot is planned by itself first, by weighted A*, and only robots whose paths conflict are planned jointly;
  /// otherwise all robots that can reach each other are.
  bool independence_detection{false};
  /// Lattices of 6, 3, 1.5 and 0.75 times `resolution` (at most 90 degrees) are searched in turn, with budgets that
  /// grow, and the bound holds for those in which the paths were found; otherwise lattices of `resolution` are.
  bool multi_resolution{true};
  /// After `shortcut`, paths of robots that were planned jointly are rerouted, one robot at a time, while the others
  /// move as before.
  bool large_neighbourhood_search{true};
  /// At most this many threads plan parts for many robots at the same time; the result does not depend on it
  /// [> 0 and <= 1024].
  int num_threads{1};
};

/// Many robots: ECBS that reuses its previous searches; quick.
/// Literature: xECBS: Shaoul, Mishani, Likhachev, Li 2024.
/// Guarantee: none beforehand; sum of costs <= `bound` of its statistics * optimum.
struct XECBS {
  CommonOptions common{};
  RobotOptionMap robots{};
  /// This weight inflates the heuristic of each robot's low-level search [>= 1].
  double weight_low_level_heuristic{50.0};
  /// The focal list of the constraint tree holds the nodes within this factor of the lower bound [>= 1].
  double high_level_focal_suboptimality{1.3};
  /// The focal list of each robot's low-level search holds the states within this factor of its lower bound [>= 1].
  double low_level_focal_suboptimality{1.3};
  /// Each robot is planned by itself first, by weighted A*, and only robots whose paths conflict are planned jointly;
  /// otherwise all robots that can reach each other are.
  bool independence_detection{true};
  /// After `shortcut`, paths of robots that were planned jointly are rerouted, one robot at a time, while the others
  /// move as before.
  bool large_neighbourhood_search{true};
  /// At most this many threads plan parts for many robots at the same time; the result does not depend on it
  /// [> 0 and <= 1024].
  int num_threads{1};
};

/// Many robots: robots of lower priority give way; quick, nothing is proven.
/// Literature: priority-based search: Ma, Harabor, Stuckey, Li, Koenig 2019.
/// Guarantee: none; it may find no path where there is one.
struct Prioritised {
  CommonOptions common{};
  RobotOptionMap robots{};
  /// This weight inflates the heuristic of each robot's low-level search [>= 1].
  double weight_low_level_heuristic{50.0};
  /// Each robot is planned by itself first, by weighted A*, and only robots whose paths conflict are planned jointly;
  /// otherwise all robots that can reach each other are.
  bool independence_detection{true};
  /// After `shortcut`, paths of robots that were planned jointly are rerouted, one robot at a time, while the others
  /// move as before.
  bool large_neighbourhood_search{true};
  /// At most this many threads plan parts for many robots at the same time; the result does not depend on it
  /// [> 0 and <= 1024].
  int num_threads{1};
};

/// The quickest: RRT-Connect and guided searches from both ends; anytime if requested.
/// Literature: RRT-Connect with a deterministic sequence: Kuffner, LaValle 2000; beside it a portfolio of searches with
/// several heuristics: Huberman, Lukose, Hogg 1997; Röger, Helmert 2010; Aine et al. 2016.
/// Guarantee: cost <= `weight` * optimum of the lattice in which the path was found, or <= `weight` * length of the
/// straight line; anytime if requested.
struct Auto {
  CommonOptions common{};
  RobotOptionMap robots{};
  /// The first path costs at most this factor times the optimum of its lattice, or the straight line [>= 1].
  double weight{50.0};
  /// After the first path, this many rounds search for better ones; the result is the same on every machine [>= 0].
  int improve_rounds{0};
  /// After the first path, the search for better ones takes this time within `time_limit`; 0 gives it the time that
  /// `improve_rounds` take [s, >= 0].
  double improve_time{0.0};
  /// The search for better paths ends early once this bound is proven; with 1 it uses all its rounds or time [>= 1].
  double final_weight{1.0};
  /// Without a first path after this many expanded states, the plan ends as timed_out, on every machine at the same
  /// place; 0 leaves that to `time_limit` [>= 0].
  int max_expansions{0};
  /// The same for each group of robots that are planned together, whose searches expand more [>= 0].
  int max_group_expansions{0};
  /// At most this many threads plan parts for many robots at the same time; the result does not depend on it
  /// [> 0 and <= 1024].
  int num_threads{1};
};

/// The options of one planner.
using PlannerOptions =
    std::variant<Auto, WAStar, AStar, ARAStar, MHAStar, WPASE, AMRAStar, XECBS, ECBS, CBS, Prioritised, RRTConnect>;

/// A value of a dictionary. A string may also hold a number or a truth value ("5", "true"), or names with commas or
/// spaces between them for an option that is a list of names.
using OptionValue = std::variant<bool, double, std::string, std::vector<std::string>>;
/// Options by name, as dictionaries and files bring them.
using OptionMap = std::map<std::string, OptionValue>;

/// Reads a dictionary: "planner_id" selects the planner (default: auto), every other key must be an option of it, and
/// options without a key have their defaults.
/// Throws InvalidArgument for an unknown planner or key (with the nearest known one), for a value of another type, and
/// for a value out of its range (with the range). The names of heuristics are not checked: see require_heuristics.
PlannerOptions parse_options(const OptionMap& options);
/// Throws InvalidArgument when a value is out of its range. The names of heuristics are not checked: see
/// require_heuristics.
void validate(const PlannerOptions& options);
/// Every option with its value, "planner_id" included: parse_options(to_map(o)) == o.
OptionMap to_map(const PlannerOptions& options);

/// The names of the built-in heuristics. Each estimates the cost from a configuration to the nearest goal:
/// joint_euclidean by the Euclidean distance in joint space, which is consistent; the others are inadmissible:
/// joint_proximal and joint_distal by the same distance with larger weights on the joints near the base, or near the
/// end effector; joint_sum by the sum of the joints' distances; bfs by the length of the end effector's path around the
/// objects, from a breadth-first search on a grid (Cohen, Chitta, Likhachev 2010) with cells of
/// CommonOptions::bfs_resolution or, as "bfs(0.1)", of 0.1 m.
const std::vector<std::string>& built_in_heuristics();
/// The size of the cells that a name such as "bfs(0.1)" gives [m]; nothing for other names. Throws InvalidArgument when
/// there is no number above 0 between the brackets.
std::optional<double> bfs_cell(const std::string& heuristic);
/// The names of all heuristics that the options refer to, those of single robots included.
std::vector<std::string> named_heuristics(const PlannerOptions& options);
#if __cplusplus >= 202002L  // MoveIt 1 is C++17
/// Throws InvalidArgument unless each heuristic that the options refer to is built in or one of `user_heuristics`.
void require_heuristics(const PlannerOptions& options, std::span<const std::string> user_heuristics);
#endif

/// The options that every planner has, with the values that hold for all robots.
const CommonOptions& common_options(const PlannerOptions& options);
/// The same with the values that hold for this robot (RobotOptions).
CommonOptions common_options(const PlannerOptions& options, const std::string& robot);
/// Throws InvalidArgument when there are options of single robots for a robot that is not one of `robots`, or when
/// `robots` holds one robot only.
void require_robots(const PlannerOptions& options, const std::vector<std::string>& robots);

/// How long a planner goes on after its first path.
struct Improvement {
  int rounds{0};     ///< 0 with a time: as many rounds as the time allows.
  double time{0.0};  ///< [s]; 0 with rounds: as long as the rounds take.
  double final_weight{1.0};

  /// Whether better paths are requested.
  bool requested() const { return rounds > 0 || time > 0.0; }
  /// Whether another round follows.
  bool goes_on_after(int round) const { return rounds > 0 ? round < rounds : time > 0.0; }
  /// The time for better paths [s], within the time limit; infinity: as long as that allows.
  double max_time() const { return time > 0.0 ? time : std::numeric_limits<double>::infinity(); }
};
/// Of ARA* and AMRA* nine tenths of the time limit; no rounds and no time for other planners without such options.
Improvement improvement(const PlannerOptions& options);

/// 1 for planners without that option.
int num_threads(const PlannerOptions& options);
/// True for planners without that option.
bool independence_detection(const PlannerOptions& options);
/// The same.
bool large_neighbourhood_search(const PlannerOptions& options);

/// PlannerInfo::id of the planner that these options are for.
std::string planner_id(const PlannerOptions& options);

enum class OptionType { boolean, integer, number, text, text_list };

/// What the registry knows of an option.
struct OptionInfo {
  std::string name;  ///< the key in a dictionary, and the field of the C++ struct and of the Python class
  OptionType type{};
  OptionValue default_value;
  std::string unit;                  ///< "s", "m", "degrees"; "" for a number without unit, and for other types
  std::string range;                 ///< of numbers, such as ">= 1" or "> 0 and <= 1"; "" otherwise
  std::vector<std::string> choices;  ///< all allowed words; empty when any text is allowed
  std::string description;           ///< one sentence
  bool common{};                     ///< a field of CommonOptions
  bool per_robot{};                  ///< may also be given for one robot among many (RobotOptions)
};

/// What the registry knows of a planner.
struct PlannerInfo {
  std::string id;                     ///< "planner_id" in a dictionary
  std::string class_name;             ///< of the C++ struct and of the Python class that hold its options
  std::string summary;                ///< one line
  std::string papers;                 ///< what the planner is called in the literature, and where
  std::string guarantee;              ///< on the cost of the path, relative to the optimum
  bool one_robot{};                   ///< serves plan
  bool many_robots{};                 ///< serves plan_multi
  std::vector<OptionInfo> options{};  ///< common options first
};
/// All planners; the first is the default.
const std::vector<PlannerInfo>& available_planners();
/// One of them by its id or one of its other spellings, such as "wA*". Throws InvalidArgument, with the nearest id.
const PlannerInfo& planner_info(const std::string& id);

}  // namespace srmp
