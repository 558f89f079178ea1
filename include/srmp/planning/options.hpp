#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace srmp {

/// Options that every planner has.
struct CommonOptions {
  double time_limit{5.0};                    ///< [s] over all phases of a plan, > 0
  std::string heuristic{"joint_euclidean"};  ///< one of built_in_heuristics(), or the user's
  double resolution{15.0};                   ///< lattice step of revolute joints [degrees], > 0
  double prismatic_resolution{0.05};         ///< lattice step of prismatic joints [m], > 0
  std::string mprim_path{};  ///< motion primitives (YAML); "" = default_primitives, for Auto rich_primitives
  std::string direction{
      "auto"};  ///< search from: forward = the start | backward = the goals | auto = the end with less clearance
  double bfs_resolution{0.05};  ///< cell of the bfs heuristic's grid [m], > 0
  double bfs_radius{0.05};      ///< obstacles are inflated by this in that grid [m], >= 0
  int ik_solutions{16};         ///< configurations tried for a pose or position goal, > 0
  bool ik_goal_connection{
      true};  ///< a search from the start may also end by inverse kinematics from a state near a pose target
  bool recover_start{false};         ///< leave a start in collision, if no pair gets deeper on the way (escape.hpp)
  bool shortcut{true};               ///< shorten the path before timing it
  double sample_period{0.02};        ///< of the returned trajectory [s], > 0
  double velocity_scaling{1.0};      ///< share of the velocity limits that may be used, in (0, 1]
  double acceleration_scaling{1.0};  ///< share of the acceleration and jerk limits, in (0, 1]
  /// toppra: time-optimal with rounded corners | ruckig: jerk-limited with a stop at each corner | none: a path
  /// without times.
  std::string timing{"toppra"};
  double blend_deviation{0.005};  ///< no point of the robot leaves the checked path by more at a corner [m], >= 0
  bool certify{true};             ///< prove the trajectory by other code (Trajectory::certificate)
};

/// A* (Hart, Nilsson, Raphael 1968): cost <= optimal on the lattice.
struct AStar {
  CommonOptions common{};
};

/// Weighted A* with lazy edges (Pohl 1970; Cohen, Phillips, Likhachev 2014): cost <= weight * optimal.
struct WAStar {
  CommonOptions common{};
  double weight{50.0};  ///< >= 1
};

/// ARA* (Likhachev, Gordon, Thrun 2003): anytime, from weight down to final_weight in steps of weight_delta.
struct ARAStar {
  CommonOptions common{};
  double weight{50.0};        ///< first weight, >= 1
  double weight_delta{10.0};  ///< taken off after every round, > 0
  double final_weight{1.0};   ///< stop at this bound, >= 1
};

/// MHA* (Aine et al. 2016) with shared expansions: cost <= w1 * w2 * optimal.
struct MHAStar {
  CommonOptions common{};
  /// Beside the anchor (common.heuristic).
  std::vector<std::string> inadmissible_heuristics{"bfs", "joint_base", "joint_hand", "joint_sum"};
  double w1{20.0};  ///< inflation of every heuristic, >= 1
  double w2{5.0};   ///< how far the others may run ahead of the anchor, >= 1
};

/// Parallel weighted search on edges (ePA*SE; Mukherjee, Aine, Likhachev 2022): cost <= weight * optimal; the same path
/// for every num_threads.
struct WPASE {
  CommonOptions common{};
  double weight{50.0};  ///< >= 1
  int num_threads{4};   ///< 1 to 1024
  int batch_size{16};   ///< edges evaluated together, > 0; part of the question: another batch may find another path
};

/// Options of one robot among many that stand in place of those for all: in the paper's dictionary `heuristic_panda`
/// and `mprim_path_panda`, for the robot 'panda'.
struct RobotOptions {
  std::optional<std::string> heuristic{};
  std::optional<std::string> mprim_path{};
};
using RobotOptionMap = std::map<std::string, RobotOptions>;

/// CBS (Sharon, Stern, Felner, Sturtevant 2015), many robots: sum of costs optimal on their lattices in discrete time.
struct CBS {
  CommonOptions common{};
  RobotOptionMap robots{};
  int num_threads{1};  ///< of parts that are planned at the same time, 1 to 1024; the same answer for every number
};

/// ECBS (Barer, Sharon, Stern, Felner 2014), many robots: sum of costs <= the product of its three factors * optimal.
struct ECBS {
  CommonOptions common{};
  RobotOptionMap robots{};
  double weight_low_level_heuristic{50.0};     ///< >= 1
  double high_level_focal_suboptimality{1.3};  ///< >= 1
  double low_level_focal_suboptimality{1.3};   ///< >= 1
  int num_threads{1};                          ///< as CBS::num_threads
};

/// xECBS (Shaoul, Mishani, Likhachev, Li 2024): ECBS whose searches begin with what still holds of the last one, with
/// further branches in which one robot gives way to another (multi::ConflictSearchOptions). The same bound.
struct XECBS {
  CommonOptions common{};
  RobotOptionMap robots{};
  double weight_low_level_heuristic{50.0};     ///< >= 1
  double high_level_focal_suboptimality{1.3};  ///< >= 1
  double low_level_focal_suboptimality{1.3};   ///< >= 1
  int improve_rounds{0};                       ///< of better paths after the first, >= 0
  int num_threads{1};                          ///< as CBS::num_threads
};

/// Priority-based search (Ma, Harabor, Stuckey, Li, Koenig 2019), many robots: fast; incomplete, and nothing is proved.
struct Prioritised {
  CommonOptions common{};
  RobotOptionMap robots{};
  double weight_low_level_heuristic{50.0};  ///< >= 1
  int num_threads{1};                       ///< as CBS::num_threads
};

/// Two trees that grow towards each other (robot_trees.hpp) and, beside them, eight greedy searches in turns (a
/// portfolio: Huberman, Lukose, Hogg 1997): from the start and from the goals, at 3, 1.5, 0.75 and 0.4 times
/// `resolution`, each guided by several heuristics. cost <= weight * optimal on the lattice of the one that finishes
/// first, or weight * the straight line; then anytime, for as long as asked. No trees where `heuristic`, `direction` or
/// `mprim_path` asks for another search.
struct Auto {
  CommonOptions common{};
  RobotOptionMap robots{};   ///< for many robots
  double weight{50.0};       ///< of the first path, >= 1
  int improve_rounds{0};     ///< of better paths after the first, >= 0: the same answer on every machine
  double improve_time{0.0};  ///< [s] for better paths, within the time limit; 0 = as long as the rounds take
  double final_weight{1.0};  ///< stop improving once this bound is proven, >= 1; 1 = go on as long as asked
  int num_threads{1};        ///< for many robots, as CBS::num_threads; one robot takes one thread
};

using PlannerOptions = std::variant<Auto, WAStar, AStar, ARAStar, MHAStar, WPASE, XECBS, ECBS, CBS, Prioritised>;

/// A value as dictionaries bring it; strings hold numbers too ("5", "true").
using OptionValue = std::variant<bool, double, std::string, std::vector<std::string>>;
using OptionMap = std::map<std::string, OptionValue>;

/// Reads the paper's dictionary: "planner_id" chooses (default: auto), every other key must be an option of that
/// planner. Throws InvalidArgument with the nearest known id, key or the allowed range.
PlannerOptions parse_options(const OptionMap& options);
/// Throws InvalidArgument when a value is out of its range. Names of heuristics may be any: see require_heuristics.
void validate(const PlannerOptions& options);

/// joint_euclidean: straight joint-space distance, consistent. joint_base, joint_hand: the same with the joints near
/// the base, or near the hand, counting for more; joint_sum: the sum over the joints; bfs: way of the end effector on a
/// grid, round the objects, in cells of bfs_resolution, or, as "bfs(0.1)", of 0.1 m; all of these inadmissible.
const std::vector<std::string>& built_in_heuristics();
/// The cell of "bfs(0.1)" [m]; nothing for other names. Throws InvalidArgument for what is no number above 0.
std::optional<double> bfs_cell(const std::string& heuristic);
/// Names of all heuristics that the options ask for.
std::vector<std::string> named_heuristics(const PlannerOptions& options);
/// Throws InvalidArgument unless each heuristic named is built in or one of the `users`.
void require_heuristics(const PlannerOptions& options, std::span<const std::string> users);
/// Every option with its value, "planner_id" included: parse_options(to_map(o)) == o.
OptionMap to_map(const PlannerOptions& options);

const CommonOptions& common_options(const PlannerOptions& options);
/// Those of one robot of many.
CommonOptions common_options(const PlannerOptions& options, const std::string& robot);
/// Throws InvalidArgument for options of single robots that are none of `robots`, or the only one.
void require_robots(const PlannerOptions& options, const std::vector<std::string>& robots);

/// What is asked for after the first path.
struct Improvement {
  int rounds{0};     ///< 0, with a time: as many as it allows
  double time{0.0};  ///< [s]; 0, with rounds: what they take
  double final_weight{1.0};

  bool wanted() const { return rounds > 0 || time > 0.0; }
  bool goes_on_after(int round) const { return rounds > 0 ? round < rounds : time > 0.0; }
  double time_of(double remaining) const { return time > 0.0 ? std::min(time, remaining) : remaining; }
};
Improvement improvement(const PlannerOptions& options);

/// 1 for planners without that option.
int num_threads(const PlannerOptions& options);

std::string planner_id(const PlannerOptions& options);

struct PlannerInfo {
  std::string id;
  std::string summary;
  bool one_robot{};
  bool many_robots{};
};
/// What make_planner knows.
const std::vector<PlannerInfo>& available_planners();

}  // namespace srmp
