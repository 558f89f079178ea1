#include "srmp/planning/strategies/portfolio.hpp"

#include <algorithm>
#include <memory>
#include <optional>

#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/strategies/plan_heuristics.hpp"
#include "srmp/planning/strategies/plan_lattices.hpp"
#include "srmp/planning/strategies/robot_sampling.hpp"
#include "srmp/search/portfolio.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

using search::AnyHeuristic;

constexpr double scales[] = {3.0, 1.5, 0.75, 0.4};  // of the resolution asked for
constexpr double finest = 0.01;                     // times these, in the last rounds of better paths
constexpr std::uint64_t max_expansions = std::uint64_t{1} << 40;

/// The first path is wanted soon: what a tenth of the checks can save.
ShortcutOptions quick() {
  return {.min_gain = 1e-2, .max_rounds = 2, .halvings = 3, .pull_gain = 2e-2, .cut_gain = 1.0, .continuous = {}};
}

/// Two trees beside the lattices of the portfolio. They prove nothing, but the straight line, `direct`, is a bound for
/// all: what they find is an answer if it is no longer than `weight` times that.
class BudgetedRrtConnect {
 public:
  BudgetedRrtConnect(PlanContext& context, const Endpoints& ends, double direct, double weight)
      : context_(context),
        ends_(ends),
        direct_(direct),
        longest_(weight * direct),
        before_(context.checks.motions()),
        trees_(space()) {}
  ~BudgetedRrtConnect() {
    context_.statistics.expansions += trees_.attempts();
    context_.statistics.memory_bytes += trees_.memory();
  }

  /// Grows until seven eighths of all motions checked so far, and the first ones, are theirs.
  std::optional<FoundPath> grow() {
    std::optional<std::vector<Eigen::VectorXd>> way;
    while (!done_ && !way && !context_.deadline.stop_requested() &&
           8 * checked_ < 8 * head_start + 7 * (context_.checks.motions() - before_)) {
      const std::uint64_t before = context_.checks.motions();
      way = trees_.grow(trees_.attempts() + turn, context_.deadline);
      checked_ += std::max(turn, context_.checks.motions() - before);  // an attempt may check none
    }
    if (!way) return std::nullopt;
    done_ = true;
    const RowMatrix rows = unwrap_waypoints(stack_waypoints(*way), context_.problem.limits.continuous);
    FoundPath found{unstack_waypoints(rows), ends_.goal_index_of(way->back()), context_.length(*way), direct_,
                    "every path"};
    return found.cost <= longest_ ? std::optional(std::move(found)) : std::nullopt;
  }

 private:
  static constexpr std::uint64_t turn = 16;         // attempts between two looks at the share
  static constexpr std::uint64_t head_start = 128;  // motions

  search::RrtSpace space() const {
    search::RrtSpace space = rrt_space(context_.robot, ends_.start, ends_.targets);
    space.is_motion_free = [this](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
      return context_.checks.is_motion_free(a, b);
    };
    return space;
  }

  PlanContext& context_;
  const Endpoints& ends_;
  const double direct_;
  const double longest_;
  const std::uint64_t before_;
  std::uint64_t checked_{};
  search::RrtConnect trees_;
  bool done_{};
};

class Portfolio {
 public:
  Portfolio(PlanContext& context, const Endpoints& ends, const Auto& options, BestPath& best)
      : context_(context),
        ends_(ends),
        options_(options),
        improvement_(improvement(options)),
        best_(best),
        lattices_(context, ends),
        heuristics_(context, ends.start) {
    for (const Eigen::VectorXd& target : ends.targets)
      direct_ = std::min(direct_, context.robot.difference(ends.start, target).norm());
  }

  void run() {
    best_.bound(direct_, "every path");
    std::optional<BudgetedRrtConnect> trees;
    std::optional<FoundPath> grown;
    search::PortfolioOptions turns{.weight = options_.weight};
    if (wants_trees()) {
      trees.emplace(context_, ends_, direct_, options_.weight);
      turns.before_round = [&] { return (grown = trees->grow()).has_value(); };
    }
    const search::PortfolioResult found = search_lattices(search::infinity, 1.0, turns, context_.deadline);
    if (!grown) require_solved(found.result);
    FoundPath first = grown ? *std::move(grown) : path_of(found);
    if (best_.take(first, context_.deadline, quick()) && improvement_.wanted()) improve(std::move(first));
  }

 private:
  /// One search of the portfolio and what it needs to live.
  struct Member {
    std::unique_ptr<Lattice> lattice;  // it cannot move
    AnyHeuristic anchor;
    bool backward;
    double scale;
  };

  /// Who asks for another search gets lattices alone.
  bool wants_trees() const {
    const CommonOptions& common = context_.common;
    return common.direction == "auto" && common.heuristic == CommonOptions().heuristic && !lattices_.own_primitives();
  }

  /// Better and better paths. Each round searches only where a path could be shorter than the best by a good part of
  /// what it is longer than the straight line (Gammell, Srinivasa, Barfoot 2014, "Informed RRT*"); a lattice exhausted
  /// there proves its optimum longer. When no round finds any, the next rounds have more time, in finer lattices.
  void improve(FoundPath first) {
    const Deadline until(improvement_.time_of(context_.deadline.remaining()),
                         [this] { return context_.deadline.cancelled(); });
    if (!best_.take(std::move(first), until)) return;  // now with all the care that shortening can take
    std::uint64_t expansions = 64;
    double finer = 1.0;
    const auto next = [&] {
      expansions = std::min(4 * expansions, max_expansions);
      finer = std::max(0.87 * finer, finest);
    };
    for (int round = 0; improvement_.goes_on_after(round); ++round, next())
      for (const double share : {0.5, 0.75, 0.9, 1.0})
        while (true) {
          if (good_enough() || until.stop_requested()) return;
          const double before = best_cost(), limit = direct_ + share * (before - direct_);
          const auto found = search_lattices(limit, finer, {.max_expansions = expansions}, until);
          if (!prove_exhausted(found, limit)) return;
          if (found.result.status == Status::solved && !best_.take(path_of(found), until)) return;
          const auto& exhausted = found.exhausted;
          const bool can_be_finer = !lattices_.own_primitives() && finer > finest;
          if (!can_be_finer && share == 1.0 && std::count(exhausted.begin(), exhausted.end(), 0) == 0) return;
          if (best_cost() >= before) break;
        }
  }

  double best_cost() const { return context_.statistics.path_cost_rad; }

  /// A shortened path may well be shorter than all of a lattice, so a bound of 1 there is no reason to stop.
  bool good_enough() const {
    if (improvement_.final_weight > 1.0 && context_.statistics.bound <= improvement_.final_weight) return true;
    return best_cost() <= direct_ * (1.0 + 1e-9);
  }

  /// False: the user wants no better path.
  bool prove_exhausted(const search::PortfolioResult& found, double limit) {
    for (std::size_t i = 0; i < members_.size(); ++i)
      if (found.exhausted[i] && !best_.prove(limit, describe(members_[i]))) return false;
    return true;
  }

  /// Searches whose states lie on paths no longer than `limit`, all lattices `finer` times the usual scale.
  search::PortfolioResult search_lattices(double limit, double finer, const search::PortfolioOptions& options,
                                          const Deadline& deadline) {
    make_members(finer);
    const auto make = [&](std::size_t i) { return make_search(members_[i], limit); };
    PlanStatistics& statistics = context_.statistics;
    const PhaseTimer timer(context_.deadline, statistics.search_time_s);
    auto found = search::portfolio<Lattice, AnyHeuristic>(members_.size(), make, options, deadline);
    context_.count(found.result.statistics);
    std::uint64_t memory = found.result.statistics.memory;
    for (const Member& member : members_)
      if (member.lattice) {
        statistics.states += member.lattice->size();
        memory += member.lattice->memory();
      }
    statistics.memory_bytes = std::max(statistics.memory_bytes, memory);
    return found;
  }

  void make_members(double finer) {
    members_.clear();
    const std::vector<double> all{std::begin(scales), std::end(scales)};
    const std::string& direction = context_.common.direction;
    for (const double scale : lattices_.own_primitives() ? std::vector<double>{1.0} : all)
      for (const bool backward : {true, false})
        if (direction == "auto" || backward == (direction == "backward"))
          members_.push_back({nullptr, {}, backward, finer * scale});
  }

  search::PortfolioMember<Lattice, AnyHeuristic> make_search(Member& member, double limit) {
    member.lattice.reset(new Lattice(lattices_.rich(member.backward, member.scale)));
    Lattice& lattice = *member.lattice;
    member.anchor = [&lattice, limit](search::StateId s) {
      const double ahead = lattice.distance_to_targets(s);
      if (limit == search::infinity || ahead + lattice.distance_from_roots(s) < limit + 1e-9) return ahead;
      return search::infinity;
    };
    return {&lattice, lattice.starts(), &member.anchor, heuristics_.inadmissible_heuristics(lattice)};
  }

  FoundPath path_of(const search::PortfolioResult& found) const {
    const Member& winner = members_[found.winner];
    return lattices_.path_of(found.result, *winner.lattice, winner.backward, winner.scale);
  }

  std::string describe(const Member& member) const { return lattices_.describe(member.backward, member.scale); }

  void require_solved(const search::Result& result) const {
    const std::size_t count = members_.size();
    context_.require_solved(result, count > 1 ? "none of the " + std::to_string(count) + " lattices holds a"
                                              : describe(members_.front()) + " holds no");
  }

  PlanContext& context_;
  const Endpoints& ends_;
  const Auto& options_;
  const Improvement improvement_;
  BestPath& best_;
  PlanLattices lattices_;
  PlanHeuristics heuristics_;
  std::vector<Member> members_;
  double direct_{search::infinity};  // straight to the nearest goal: no path at all is shorter
};

}  // namespace

void search_in_turns(PlanContext& context, const Endpoints& ends, const Auto& options, BestPath& best) {
  Portfolio(context, ends, options, best).run();
}

}  // namespace srmp
