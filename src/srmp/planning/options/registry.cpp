#include "srmp/planning/options/registry.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>

#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"
#include "srmp/planning/options/other_vocabularies.hpp"

namespace srmp {

namespace {

std::vector<OptionSpec> common_option_specs() {
  using C = CommonOptions;
  return {
      common_option("time_limit", &C::time_limit, above(0.0, "s"),
                    "All phases of a plan together take at most this time."),
      common_option("heuristic", &C::heuristic, heuristic_names(),
                    "This heuristic guides the search: joint_euclidean, joint_proximal, joint_distal, joint_sum, bfs, "
                    "bfs(0.1) for cells of 0.1 m, or the name of a user's heuristic."),
      common_option("resolution", &C::resolution, above_up_to(0.0, 360.0, "degrees"),
                    "A lattice has this step in revolute joints."),
      common_option("prismatic_resolution", &C::prismatic_resolution, above_up_to(0.0, max_length, "m"),
                    "A lattice has this step in prismatic joints."),
      common_option("mprim_path", &C::mprim_path, anything(),
                    "This YAML file defines the motion primitives; an empty path selects the built-in ones."),
      common_option("direction", &C::direction, one_of({"auto", "forward", "backward"}),
                    "The search begins at the start (forward), at the goals (backward), or at the end with less "
                    "clearance (auto)."),
      common_option("bfs_resolution", &C::bfs_resolution, above_up_to(0.0, max_length, "m"),
                    "The grid of the bfs heuristic has cells of this size."),
      common_option("bfs_radius", &C::bfs_radius, between(0.0, max_length, "m"),
                    "The grid of the bfs heuristic inflates obstacles by this radius."),
      common_option(
          "ik_solutions", &C::ik_solutions, above(0.0),
          "Each target of a pose or position goal becomes at most this many valid configurations: of those that "
          "inverse kinematics finds, the nearest to the start."),
      common_option("ik_goal_connection", &C::ik_goal_connection, anything(),
                    "A search from the start may also end by inverse kinematics from a state near a pose or position "
                    "target."),
      common_option(
          "recover_start", &C::recover_start, anything(),
          "A start in collision is recovered first, by a motion on which no pair penetrates deeper and no other "
          "pair comes into contact."),
      common_option("shortcut", &C::shortcut, anything(), "The path is shortened before it is timed."),
      common_option("sample_period", &C::sample_period, above(0.0, "s"),
                    "The returned trajectory has a sample after each such period."),
      common_option("sample_rate", &C::sample_rate, at_least(0.0, "Hz"),
                    "The returned trajectory has this many samples a second, at even times and nowhere else, in place "
                    "of a `sample_period`; 0 leaves samples at the corners of the path too."),
      common_option("velocity_scaling", &C::velocity_scaling, above_up_to(0.0, 1.0),
                    "The trajectory may use this fraction of the velocity limits."),
      common_option("acceleration_scaling", &C::acceleration_scaling, above_up_to(0.0, 1.0),
                    "The trajectory may use this fraction of the acceleration and jerk limits."),
      common_option("timing", &C::timing, one_of({"toppra", "ruckig", "none"}),
                    "The trajectory is time-optimal with rounded corners (toppra), jerk-limited with a stop at each "
                    "corner (ruckig), or a path without times (none)."),
      common_option("blend_deviation", &C::blend_deviation, between(0.0, max_length, "m"),
                    "No point of the robot leaves the checked path by more than this distance at a rounded corner."),
      common_option("clearance", &C::clearance, between(0.0, max_length, "m"),
                    "The path keeps this clearance from everything, and the robot's links from each other; a pair that "
                    "is closer at the start or at the goal does not come closer on the way from or to there."),
      common_option("preferred_clearance", &C::preferred_clearance, between(0.0, max_length, "m"),
                    "Shortening the path and rounding its corners give away no clearance below this that the searched "
                    "path had."),
      common_option("certify", &C::certify, anything(),
                    "Code that is independent of the planner verifies the trajectory and attaches a certificate."),
  };
}

// --- options that several planners have ------------------------------------------------------------------------------

Allowed thread_count() { return above_up_to(0.0, 1024.0); }

template <class Planner>
OptionSpec robot_threads() {
  return option("num_threads", &Planner::num_threads, thread_count(),
                "At most this many threads plan parts for many robots at the same time; the result does not depend on "
                "it.");
}

template <class Planner>
OptionSpec search_weight() {
  return option("weight", &Planner::weight, at_least(1.0), "This weight inflates the heuristic.");
}

template <class Planner>
OptionSpec multi_resolution() {
  return option("multi_resolution", &Planner::multi_resolution, anything(),
                "Lattices of 3, 1.5, 0.75 and 0.4 times `resolution`, from the start and from the goals, are searched "
                "side by side, and the bound holds for the one in which the path was found; otherwise one lattice is.");
}

template <class Planner>
OptionSpec low_level_weight() {
  return option("weight_low_level_heuristic", &Planner::weight_low_level_heuristic, at_least(1.0),
                "This weight inflates the heuristic of each robot's low-level search.");
}

template <class Planner>
OptionSpec independence_detection() {
  return option("independence_detection", &Planner::independence_detection, anything(),
                "Each robot is planned by itself first, by weighted A*, and only robots whose paths conflict are "
                "planned jointly; otherwise all robots that can reach each other are.");
}

template <class Planner>
OptionSpec large_neighbourhood_search() {
  return option("large_neighbourhood_search", &Planner::large_neighbourhood_search, anything(),
                "After `shortcut`, paths of robots that were planned jointly are rerouted, one robot at a time, while "
                "the others move as before.");
}

template <class Planner>
std::vector<OptionSpec> conflict_options() {
  std::vector<OptionSpec> options{
      low_level_weight<Planner>(),
      option("high_level_focal_suboptimality", &Planner::high_level_focal_suboptimality, at_least(1.0),
             "The focal list of the constraint tree holds the nodes within this factor of the lower bound."),
      option("low_level_focal_suboptimality", &Planner::low_level_focal_suboptimality, at_least(1.0),
             "The focal list of each robot's low-level search holds the states within this factor of its lower bound."),
      independence_detection<Planner>(),
      large_neighbourhood_search<Planner>(),
      robot_threads<Planner>(),
  };
  if constexpr (requires { &Planner::multi_resolution; })
    options.insert(options.end() - 2, option("multi_resolution", &Planner::multi_resolution, anything(),
                                             "Lattices of 6, 3, 1.5 and 0.75 times `resolution` (at most 90 degrees) "
                                             "are searched in turn, with budgets that grow, and the bound holds for "
                                             "those in which the paths were found; otherwise lattices of `resolution` "
                                             "are."));
  return options;
}

// --- planners --------------------------------------------------------------------------------------------------------

/// `own` are the options beside the common ones.
template <class Options>
RegisteredPlanner planner(PlannerInfo info, std::vector<OptionSpec> own, std::vector<std::string> other_names = {}) {
  RegisteredPlanner result{.info = std::move(info),
                           .defaults = Options{},
                           .options = common_option_specs(),
                           .other_names = std::move(other_names)};
  std::move(own.begin(), own.end(), std::back_inserter(result.options));
  if constexpr (requires(Options options) { options.robots; }) {
    result.robots = [](PlannerOptions& options) { return &std::get<Options>(options).robots; };
    for (OptionSpec& spec : result.options)
      for (const RobotOptionSpec& of_robot : robot_option_specs())
        if (spec.info.name == of_robot.name) spec.info.per_robot = true;
  }
  for (const OptionSpec& spec : result.options) result.info.options.push_back(spec.info);
  return result;
}

RegisteredPlanner automatic() {
  return planner<Auto>(
      {.id = "auto",
       .class_name = "Auto",
       .summary = "the quickest: RRT-Connect and guided searches from both ends; anytime if requested",
       .papers = "RRT-Connect with a deterministic sequence: Kuffner, LaValle 2000; beside it a portfolio of searches "
                 "with several heuristics: Huberman, Lukose, Hogg 1997; Röger, Helmert 2010; Aine et al. 2016",
       .guarantee = "cost <= `weight` * optimum of the lattice in which the path was found, or <= `weight` * length of "
                    "the straight line; anytime if requested",
       .one_robot = true,
       .many_robots = true},
      {option("weight", &Auto::weight, at_least(1.0),
              "The first path costs at most this factor times the optimum of its lattice, or the straight line."),
       option("improve_rounds", &Auto::improve_rounds, at_least(0.0),
              "After the first path, this many rounds search for better ones; the result is the same on every "
              "machine."),
       option("improve_time", &Auto::improve_time, at_least(0.0, "s"),
              "After the first path, the search for better ones takes this time within `time_limit`; 0 gives it the "
              "time that `improve_rounds` take."),
       option(
           "final_weight", &Auto::final_weight, at_least(1.0),
           "The search for better paths ends early once this bound is proven; with 1 it uses all its rounds or time."),
       option(
           "max_expansions", &Auto::max_expansions, at_least(0.0),
           "Without a first path after this many expanded states, the plan ends as timed_out, on every machine at the "
           "same place; 0 leaves that to `time_limit`."),
       option("max_group_expansions", &Auto::max_group_expansions, at_least(0.0),
              "The same for each group of robots that are planned together, whose searches expand more."),
       robot_threads<Auto>()});
}

RegisteredPlanner astar() {
  return planner<AStar>({.id = "Astar",
                         .class_name = "AStar",
                         .summary = "A*: the shortest path in the lattice",
                         .papers = "A*: Hart, Nilsson, Raphael 1968",
                         .guarantee = "cost = optimum",
                         .one_robot = true},
                        {}, {"a*"});
}

RegisteredPlanner rrt_connect() {
  return planner<RRTConnect>(
      {.id = "RRTConnect",
       .class_name = "RRTConnect",
       .summary = "two trees that grow towards each other, by the same samples every time: quick, not optimal",
       .papers = "RRT-Connect: Kuffner, LaValle 2000",
       .guarantee = "none; no path is shorter than the straight line, which bounds the cost",
       .one_robot = true,
       .many_robots = true},
      {}, {"rrtconnect", "rrt"});
}

RegisteredPlanner weighted_astar() {
  return planner<WAStar>({.id = "wAstar",
                          .class_name = "WAStar",
                          .summary = "weighted A*: a path of at most weight times the least cost, quickly",
                          .papers = "weighted A*: Pohl 1970; lazy edges: Cohen, Phillips, Likhachev 2014",
                          .guarantee = "cost <= `weight` * optimum",
                          .one_robot = true},
                         {search_weight<WAStar>(), multi_resolution<WAStar>()}, {"wa*", "weightedastar"});
}

RegisteredPlanner ara_star() {
  return planner<ARAStar>(
      {.id = "ARAstar",
       .class_name = "ARAStar",
       .summary = "ARA*: a first path quickly, then better ones until the time limit",
       .papers = "ARA*: Likhachev, Gordon, Thrun 2003",
       .guarantee = "anytime; cost <= last proven bound * optimum",
       .one_robot = true},
      {option("weight", &ARAStar::weight, at_least(1.0), "The first round inflates the heuristic by this weight."),
       option("weight_delta", &ARAStar::weight_delta, above(0.0),
              "The weight decreases by this much after each round."),
       option("final_weight", &ARAStar::final_weight, at_least(1.0), "The search ends once this bound is proven."),
       multi_resolution<ARAStar>()},
      {"ara*"});
}

RegisteredPlanner mha_star() {
  return planner<MHAStar>(
      {.id = "MHAstar",
       .class_name = "MHAStar",
       .summary = "MHA*: several heuristics share one search",
       .papers = "MHA* with shared expansions: Aine, Swaminathan, Narayanan, Hwang, Likhachev 2016",
       .guarantee = "cost <= `w1` * `w2` * optimum",
       .one_robot = true},
      {option("inadmissible_heuristics", &MHAStar::inadmissible_heuristics, heuristic_names(),
              "These heuristics guide searches beside the anchor search, which has the option `heuristic`."),
       option("w1", &MHAStar::w1, at_least(1.0), "This weight inflates every heuristic."),
       option("w2", &MHAStar::w2, at_least(1.0),
              "The keys of the inadmissible searches may exceed the anchor search's by this factor."),
       multi_resolution<MHAStar>()},
      {"mha*"});
}

RegisteredPlanner amra_star() {
  return planner<AMRAStar>(
      {.id = "AMRAstar",
       .class_name = "AMRAStar",
       .summary = "AMRA*: several heuristics and resolutions share one search; better paths until the time limit",
       .papers = "AMRA*: Saxena, Kusnur, Likhachev 2022; MRA*: Du, Islam, Likhachev 2020",
       .guarantee =
           "anytime; first cost <= `w1` * `w2` * optimum of the finest lattice, then <= last proven bound * it",
       .one_robot = true},
      {option("w1", &AMRAStar::w1, at_least(1.0), "In the first round, this weight inflates every heuristic."),
       option("w2", &AMRAStar::w2, at_least(1.0),
              "In the first round, the keys of the inadmissible searches may exceed the anchor search's by this "
              "factor."),
       option("final_weight", &AMRAStar::final_weight, at_least(1.0), "The search ends once this bound is proven.")},
      {"amra*"});
}

RegisteredPlanner parallel_weighted_astar() {
  RegisteredPlanner result =
      planner<WPASE>({.id = "wPASE",
                      .class_name = "WPASE",
                      .summary = "parallel weighted search; the same path for every number of threads",
                      .papers = "ePA*SE: Mukherjee, Aine, Likhachev 2022; PA*SE: Phillips, Likhachev, Koenig 2014",
                      .guarantee = "cost <= `weight` * optimum",
                      .one_robot = true},
                     {search_weight<WPASE>(), multi_resolution<WPASE>(),
                      option("num_threads", &WPASE::num_threads, thread_count(),
                             "This many threads evaluate edges; the path does not depend on it. More pay where a check "
                             "takes much longer than "
                             "waking a thread, some 50 us."),
                      option("batch_size", &WPASE::batch_size, above(0.0),
                             "This many edges are evaluated together; another size may find another path.")},
                     {"wpa*se", "wpastarse", "epa*se", "epase"});
  // PA*SE tests by these whether two states are independent. Here batches are fixed, and nothing depends on them.
  result.ignored.push_back(describe("i_heuristic", std::string(), heuristic_names(), ""));
  result.ignored.push_back(describe("i_weight", 1.0, at_least(1.0), ""));
  return result;
}

RegisteredPlanner conflict_based_search() {
  return planner<CBS>({.id = "CBS",
                       .class_name = "CBS",
                       .summary = "many robots: the least sum of costs on their lattices",
                       .papers = "CBS: Sharon, Stern, Felner, Sturtevant 2015",
                       .guarantee = "sum of costs = optimum, without `independence_detection`",
                       .many_robots = true},
                      {independence_detection<CBS>(), large_neighbourhood_search<CBS>(), robot_threads<CBS>()});
}

RegisteredPlanner enhanced_cbs() {
  return planner<ECBS>({.id = "ECBS",
                        .class_name = "ECBS",
                        .summary = "many robots: sum of costs within a bound",
                        .papers = "ECBS: Barer, Sharon, Stern, Felner 2014",
                        .guarantee = "sum of costs <= product of its three factors * optimum, without "
                                     "`independence_detection`",
                        .many_robots = true},
                       conflict_options<ECBS>());
}

RegisteredPlanner experience_accelerated_ecbs() {
  return planner<XECBS>({.id = "xECBS",
                         .class_name = "XECBS",
                         .summary = "many robots: ECBS that reuses its previous searches; quick",
                         .papers = "xECBS: Shaoul, Mishani, Likhachev, Li 2024",
                         .guarantee = "none beforehand; sum of costs <= `bound` of its statistics * optimum",
                         .many_robots = true},
                        conflict_options<XECBS>());
}

RegisteredPlanner prioritised() {
  return planner<Prioritised>({.id = "prioritised",
                               .class_name = "Prioritised",
                               .summary = "many robots: robots of lower priority give way; quick, nothing is proven",
                               .papers = "priority-based search: Ma, Harabor, Stuckey, Li, Koenig 2019",
                               .guarantee = "none; it may find no path where there is one",
                               .many_robots = true},
                              {low_level_weight<Prioritised>(), independence_detection<Prioritised>(),
                               large_neighbourhood_search<Prioritised>(), robot_threads<Prioritised>()},
                              {"prioritized", "pbs", "pp"});
}

/// In lower case, without what does not count in an id.
std::string normalized(const std::string& id) {
  std::string result;
  for (const char c : id)
    if (c != '-' && c != '_' && c != ' ') result += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

}  // namespace

const std::vector<RegisteredPlanner>& registry() {
  static const std::vector<RegisteredPlanner> planners{
      automatic(),
      astar(),
      weighted_astar(),
      ara_star(),
      mha_star(),
      parallel_weighted_astar(),
      amra_star(),
      rrt_connect(),
      conflict_based_search(),
      enhanced_cbs(),
      experience_accelerated_ecbs(),
      prioritised(),
  };
  return planners;
}

const RegisteredPlanner& registered_planner(const std::string& id) {
  const std::string name = normalized(id);
  std::vector<std::string> known;
  for (const RegisteredPlanner& planner : registry()) {
    known.push_back(planner.info.id);
    const std::vector<std::string>& others = planner.other_names;
    if (normalized(planner.info.id) == name || std::find(others.begin(), others.end(), name) != others.end())
      return planner;
  }
  const std::string theirs = planner_of_other_library(id);
  throw InvalidArgument("there is no planner '" + id + "'" + (theirs.empty() ? or_known(id, known) : "; " + theirs));
}

const RegisteredPlanner& registered_planner(const PlannerOptions& options) {
  return *std::find_if(registry().begin(), registry().end(),
                       [&](const RegisteredPlanner& planner) { return planner.defaults.index() == options.index(); });
}

const std::vector<RobotOptionSpec>& robot_option_specs() {
  static const std::vector<RobotOptionSpec> specs{
      {"heuristic", &RobotOptions::heuristic, true},
      {"mprim_path", &RobotOptions::mprim_path, false},
  };
  return specs;
}

const RobotOptionMap& single_robots(const PlannerOptions& options) {
  static const RobotOptionMap none;
  return std::visit(
      [](const auto& typed) -> const RobotOptionMap& {
        if constexpr (requires { typed.robots; }) return typed.robots;
        return none;
      },
      options);
}

std::string planner_id(const PlannerOptions& options) { return registered_planner(options).info.id; }

const std::vector<PlannerInfo>& available_planners() {
  static const std::vector<PlannerInfo> infos = [] {
    std::vector<PlannerInfo> list;
    for (const RegisteredPlanner& planner : registry()) list.push_back(planner.info);
    return list;
  }();
  return infos;
}

const PlannerInfo& planner_info(const std::string& id) { return registered_planner(id).info; }

}  // namespace srmp
