#include "srmp/planning/strategies/robot_path.hpp"

#include <algorithm>
#include <optional>
#include <string>

#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/strategies/anytime.hpp"
#include "srmp/planning/strategies/joint_barriers.hpp"
#include "srmp/planning/strategies/lattice_portfolio.hpp"
#include "srmp/planning/strategies/lattice_search.hpp"
#include "srmp/planning/strategies/rrt_connect.hpp"

namespace srmp {

namespace {

/// Inverse kinematics finds many targets. Paths to the nearest ones are shorter, and often found earlier.
struct NearestOptions {
  std::size_t targets{2};
  std::uint64_t checks{512};  ///< of motions, before all targets are tried; for `RRTConnect`: attempts
};
const NearestOptions nearest;

/// With the `count` targets that are nearest to the start.
RobotEndpoints nearest_targets(const RobotContext& context, const RobotEndpoints& endpoints, std::size_t count) {
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < endpoints.targets.size(); ++i)
    order.emplace_back(context.robot.difference(endpoints.start, endpoints.targets[i]).norm(), i);
  std::sort(order.begin(), order.end());
  order.resize(std::min(count, order.size()));
  RobotEndpoints few = endpoints;
  few.targets.clear(), few.goal_indices.clear(), few.approaches.clear();
  for (const auto& [distance, i] : order) {
    few.targets.push_back(endpoints.targets[i]);
    few.goal_indices.push_back(endpoints.goal_indices[i]);
    few.approaches.push_back(endpoints.approaches[i]);
  }
  return few;
}

/// Adds its work to the statistics when it is done, found or not.
class CountedPortfolio : public LatticePortfolio {
 public:
  CountedPortfolio(RobotLattices& lattices, double weight)
      : LatticePortfolio(lattices, lattices.portfolio_options(weight)), lattices_(lattices) {}
  ~CountedPortfolio() override { lattices_.count(*this); }

 private:
  RobotLattices& lattices_;
};

bool has_users_heuristic(const RobotContext& context) {
  std::vector<std::string> names{context.common.heuristic};
  if (const auto* mha = std::get_if<MHAStar>(&context.options))
    names.insert(names.end(), mha->inadmissible_heuristics.begin(), mha->inadmissible_heuristics.end());
  return std::ranges::any_of(names, [&](const std::string& name) { return context.problem.heuristics.contains(name); });
}

/// May the search begin and end near the path's own ends? It may for the planners whose path is about the first that is
/// found: that would differ where problems are only similar. What the user gives to the search holds for the own ends.
bool rounds_ends(const RobotContext& context) {
  if (!context.common.mprim_path.empty() || context.task.constraints || has_users_heuristic(context)) return false;
  if (std::holds_alternative<Auto>(context.options)) return true;
  return searches_several_lattices(context.options) && !std::holds_alternative<ARAStar>(context.options);
}

class PathSearch {
 public:
  PathSearch(RobotContext& context, const RobotEndpoints& endpoints)
      : context_(context), endpoints_(endpoints), best_(context) {
    for (const Eigen::VectorXd& target : endpoints.targets)
      direct_ = std::min(direct_, context.robot.difference(endpoints.start, target).norm());
  }

  RowMatrix run() {
    try {
      if (const auto* options = std::get_if<Auto>(&context_.options))
        run_auto(*options);
      else if (std::holds_alternative<RRTConnect>(context_.options))
        run_rrt_connect();
      else
        run_lattice_search();
    } catch (const MotionCheckStopped&) {
      if (best_.empty()) context_.stop_if_late("a check of a motion");
    }
    return best_.waypoints();
  }

 private:
  void run_auto(const Auto& options) {
    best_.bound(direct_, every_path);
    FoundPath first = find_first(options);
    if (!best_.take(first, context_.deadline, quick_shortcut) || !improvement(context_.options).requested()) return;
    prepare_search();
    improve_path(context_, exact_endpoints(endpoints_), lattices(), best_, std::move(first), direct_,
                 {.trees = wants_rrt_connect()});
  }

  FoundPath find_first(const Auto& options) {
    const PhaseTimer timer(context_.deadline, context_.statistics.search_time_s);
    if (wants_rrt_connect())
      if (auto found = find_among_nearest({.alone = false, .fraction = 0.0, .first_checks = nearest.checks},
                                          options.weight * direct_))
        return *std::move(found);
    Strategies strategies;
    const search::RrtConnect* trees = nullptr;
    if (wants_rrt_connect()) {
      auto strategy =
          std::make_unique<RrtConnectStrategy>(context_, search_endpoints(), direct_, RrtConnectBudget{.alone = false});
      trees = &strategy->trees();
      strategies.push_back(std::move(strategy));
    }
    const JointBarriers* barriers = add_barriers(strategies, trees);
    auto portfolio = std::make_unique<CountedPortfolio>(lattices(), options.weight);
    const LatticePortfolio& searches = *portfolio;
    strategies.push_back(std::move(portfolio));
    const auto used_up = [&]() -> std::optional<std::string> {
      if (options.max_expansions == 0) return std::nullopt;
      const std::uint64_t expansions = searches.statistics().expansions;
      if (expansions < static_cast<std::uint64_t>(options.max_expansions)) return std::nullopt;
      return "no path within max_expansions, " + std::to_string(options.max_expansions) + " (" +
             std::to_string(expansions) + " states expanded)";
    };
    return attempt(strategies, *barriers, options.weight, used_up);
  }

  const JointBarriers* add_barriers(Strategies& strategies, const search::RrtConnect* trees) {
    auto barriers = std::make_unique<JointBarriers>(context_, endpoints_, trees);
    const JointBarriers* result = barriers.get();
    strategies.push_back(std::move(barriers));
    return result;
  }

  /// For a first path. A plan that ends by its time limit says what may block the way, if that is known.
  FoundPath attempt(const Strategies& strategies, const JointBarriers& barriers, double weight,
                    const WorkUsedUp& used_up = {}) {
    try {
      return attempt_in_rounds(strategies, direct_, weight, context_.deadline, used_up);
    } catch (const MotionCheckStopped&) {
      context_.stop_if_late("a check of a motion" + barriers.suspicion());
      throw;
    } catch (const PlanningError& error) {
      if (error.status() != Status::timed_out) throw;
      throw PlanningError(Status::timed_out, error.what() + barriers.suspicion());
    }
  }

  void run_rrt_connect() {
    best_.bound(direct_, every_path);
    best_.take(find_by_rrt_connect(), context_.deadline);
  }

  FoundPath find_by_rrt_connect() {
    const PhaseTimer timer(context_.deadline, context_.statistics.search_time_s);
    if (auto found = find_among_nearest({.attempts_alone = nearest.checks}, search::infinity)) return *std::move(found);
    Strategies strategies;
    auto trees = std::make_unique<RrtConnectStrategy>(context_, search_endpoints(), direct_, RrtConnectBudget{});
    const JointBarriers* barriers = add_barriers(strategies, &trees->trees());
    strategies.push_back(std::move(trees));
    return attempt(strategies, *barriers, search::infinity);
  }

  void run_lattice_search() {
    prepare_search();
    Strategies strategies;
    add_barriers(strategies, nullptr);
    strategies.push_back(std::make_unique<LatticeSearch>(context_, search_endpoints(), lattices(), best_, direct_));
    FoundPath found = attempt_in_rounds(strategies, 0.0, 1.0, context_.deadline);
    if (!best_.empty()) return;  // an anytime planner has handed in its paths
    best_.take(std::move(found), context_.deadline);
  }

  /// Options that ask for a certain search get lattices alone.
  bool wants_rrt_connect() const {
    const CommonOptions& common = context_.common;
    return common.direction == "auto" && common.heuristic == CommonOptions().heuristic && common.mprim_path.empty();
  }

  /// Where there are more targets than a few, RRT-Connect to the nearest ones alone.
  std::optional<FoundPath> find_among_nearest(const RrtConnectBudget& budget, double max_cost) {
    if (endpoints_.targets.size() <= nearest.targets) return std::nullopt;
    const SearchEndpoints few = search_endpoints_of(nearest_targets(context_, endpoints_, nearest.targets));
    Attempt found =
        RrtConnectStrategy(context_, few, direct_, budget).attempt({.max_cost = max_cost}, context_.deadline);
    if (found.status != Status::solved) return std::nullopt;
    return std::move(found.found);
  }

  SearchEndpoints search_endpoints_of(const RobotEndpoints& endpoints) const {
    if (!rounds_ends(context_)) return exact_endpoints(endpoints);
    try {
      return rounded_endpoints(context_, endpoints);
    } catch (const MotionCheckStopped&) {
      return exact_endpoints(endpoints);
    }
  }

  void prepare_search() {
    const PhaseTimer timer(context_.deadline, context_.statistics.search_time_s);
    lattices();
  }
  const SearchEndpoints& search_endpoints() {
    if (!search_endpoints_) search_endpoints_ = search_endpoints_of(endpoints_);
    return *search_endpoints_;
  }
  RobotLattices& lattices() {
    if (!lattices_) lattices_.emplace(context_, search_endpoints());
    return *lattices_;
  }

  RobotContext& context_;
  const RobotEndpoints& endpoints_;
  BestPath best_;
  std::optional<SearchEndpoints> search_endpoints_;  // with all targets; made when needed, since that takes checks
  std::optional<RobotLattices> lattices_;
  double direct_{search::infinity};  // straight to the nearest goal: no path at all is shorter
};

RobotEndpoints endpoints_of(RobotContext& context) {
  try {
    return find_endpoints(context);
  } catch (const MotionCheckStopped&) {
    context.stop_if_late("the checks of start and goals");
    throw;
  }
}

}  // namespace

RobotPath find_robot_path(RobotContext& context) {
  RobotPath path{endpoints_of(context), {}};
  if (!path.endpoints.targets.empty())
    path.waypoints = with_approach(context, path.endpoints, PathSearch(context, path.endpoints).run());
  context.checks.write(context.statistics);
  return path;
}

}  // namespace srmp
