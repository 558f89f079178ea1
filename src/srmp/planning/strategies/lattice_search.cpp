#include "srmp/planning/strategies/lattice_search.hpp"

#include <algorithm>

#include "srmp/planning/phase_timer.hpp"
#include "srmp/search/amra.hpp"
#include "srmp/search/ara.hpp"
#include "srmp/search/astar.hpp"
#include "srmp/search/mha.hpp"
#include "srmp/search/wpase.hpp"

namespace srmp {

namespace {

using search::AnyHeuristic;
using AnySearch = std::unique_ptr<search::ResumableSearch>;

using MakeLattice = std::function<Lattice(const LatticeChoice&)>;

/// A robot's lattices with other primitives.
class OtherLattices : public LatticeFamily {
 public:
  OtherLattices(RobotLattices& lattices, MakeLattice make) : lattices_(lattices), make_(std::move(make)) {}

  Lattice lattice(const LatticeChoice& choice) override { return make_(choice); }
  search::InadmissibleHeuristics inadmissible_heuristics(Lattice& lattice) override {
    return lattices_.inadmissible_heuristics(lattice);
  }
  FoundPath path_of(const search::Result& result, const Lattice& lattice, const LatticeChoice& choice) const override {
    return lattices_.path_of(result, lattice, choice);
  }
  std::string describe(const LatticeChoice& choice) const override { return lattices_.describe(choice); }
  std::string no_path_sentence(const search::Result& result, const std::string& no_path) const override {
    return lattices_.no_path_sentence(result, no_path);
  }

 private:
  RobotLattices& lattices_;
  MakeLattice make_;
};

/// Once there is a path, so many more expansions are made: what is found first depends on small things, the cheapest of
/// some paths does not.
constexpr search::MoreExpansions more_expansions{.fraction = 0.5, .most = 1000};

}  // namespace

bool searches_several_lattices(const PlannerOptions& options) {
  return std::visit(
      [](const auto& o) {
        if constexpr (requires { o.multi_resolution; }) return o.multi_resolution;
        return false;
      },
      options);
}

LatticeSearch::LatticeSearch(RobotContext& context, const SearchEndpoints& endpoints, RobotLattices& lattices,
                             BestPath& best, double direct)
    : context_(context),
      endpoints_(endpoints),
      lattices_(lattices),
      best_(best),
      direct_(direct),
      several_(searches_several_lattices(context.options)) {}

Attempt LatticeSearch::attempt(const AttemptBudget&, const Deadline& deadline) {
  OtherLattices lattices(lattices_, [this](const LatticeChoice& choice) { return make_lattice(choice); });
  LatticePortfolio searches(lattices, portfolio_options());
  PlanStatistics& statistics = context_.statistics;
  const double elsewhere = statistics.shortcut_time_s + statistics.heuristic_time_s;
  Attempt found;
  {
    const PhaseTimer timer(context_.deadline, statistics.search_time_s);
    found = run(searches, deadline);
  }
  statistics.search_time_s -= statistics.shortcut_time_s + statistics.heuristic_time_s - elsewhere;
  context_.checks.require_not_stopped();
  lattices_.count(searches);
  bound(found.found);
  return found;
}

/// Rounds until there is a path, for an anytime planner until it can be no better or the time for better ones is over.
Attempt LatticeSearch::run(LatticePortfolio& searches, const Deadline& deadline) {
  const Deadline improve_until = deadline.within(improvement(context_.options).max_time());
  while (true) {
    if (!best_.empty() && improve_until.expired()) return {.status = Status::solved};
    Attempt result = searches.attempt({}, deadline);
    if (good_enough_) return {.status = Status::solved};  // it has been handed in
    if (result.status != Status::timed_out || !result.reason.empty()) return result;
  }
}

bool LatticeSearch::anytime() const {
  return std::holds_alternative<ARAStar>(context_.options) || std::holds_alternative<AMRAStar>(context_.options);
}

Lattice LatticeSearch::make_lattice(const LatticeChoice& choice) {
  if (std::holds_alternative<AMRAStar>(context_.options)) return lattices_.multi_resolution(choice.from);
  return several_ ? lattices_.lattice(choice) : lattices_.plain(choice.from);
}

LatticePortfolioOptions LatticeSearch::portfolio_options() {
  LatticePortfolioOptions options = lattices_.portfolio_options(1.0);
  options.first_only = !anytime();
  options.search = [this](LatticeMember& member) { return make_search(member); };
  if (several_) {
    options.more_expansions = more_expansions;
    if (!std::holds_alternative<MHAStar>(context_.options)) options.variants = lattices_.heuristics().metrics();
    prefer_narrow_end(options);
    return options;
  }
  if (std::holds_alternative<AMRAStar>(context_.options)) {
    if (!lattices_.own_primitives()) options.scales = {RobotLattices::finest_scale};
    prefer_narrow_end(options);
    return options;
  }
  options.scales = {1.0};
  if (options.ends.size() > 1) options.ends = {narrower_end()};
  options.slices = {anytime() ? std::uint64_t{64} : search::unlimited};
  return options;
}

void LatticeSearch::prefer_narrow_end(LatticePortfolioOptions& options) {
  if (options.ends.size() < 2) return;
  if (narrower_end() != options.ends.front()) std::swap(options.ends.front(), options.ends.back());
  options.slices = {12, 4};
}

/// A search out of a narrow place is easier than one into it.
SearchFrom LatticeSearch::narrower_end() {
  double at_goals = search::infinity;
  for (const Eigen::VectorXd& target : endpoints_.targets) at_goals = std::min(at_goals, clearance(target));
  return at_goals < clearance(endpoints_.start) ? SearchFrom::goals : SearchFrom::start;
}

double LatticeSearch::clearance(const Eigen::VectorXd& q) {
  context_.stop_if_late("the choice of a direction");
  return context_.checks.checker().clearance(q, context_.checks.workspace());
}

AnyHeuristic LatticeSearch::heuristic(LatticeMember& member) {
  if (several_ && lattices_.heuristics().metrics() > 1)
    return lattices_.heuristics().metric(member.variant, *member.lattice);
  return lattices_.heuristics().make(context_.common.heuristic, *member.lattice);
}

AnySearch LatticeSearch::make_search(LatticeMember& member) {
  Lattice& lattice = *member.lattice;
  const std::vector<search::StateId> starts = lattice.starts();
  member.heuristics.push_back(heuristic(member));
  const auto* mha = std::get_if<MHAStar>(&context_.options);
  if (mha)
    for (const std::string& name : mha->inadmissible_heuristics)
      member.heuristics.push_back(lattices_.heuristics().make(name, lattice));
  context_.stop_if_late("the construction of the heuristic");
  AnyHeuristic& first = member.heuristics.front();
  if (std::holds_alternative<AStar>(context_.options))
    return std::make_unique<search::WeightedAstar<Lattice, AnyHeuristic>>(lattice, starts, first,
                                                                          search::AstarOptions{.weight = 1.0});
  if (const auto* options = std::get_if<WAStar>(&context_.options))
    return std::make_unique<search::WeightedAstar<Lattice, AnyHeuristic>>(
        lattice, starts, first, search::AstarOptions{.weight = options->weight});
  if (const auto* options = std::get_if<ARAStar>(&context_.options)) return make_ara_star(member, *options);
  if (const auto* options = std::get_if<AMRAStar>(&context_.options)) return make_amra_star(member, *options);
  if (mha)
    return std::make_unique<search::MultiHeuristicSearch<Lattice, AnyHeuristic>>(
        lattice, starts, first, std::span<const AnyHeuristic>(member.heuristics).subspan(1),
        search::MhaOptions{.w1 = mha->w1, .w2 = mha->w2});
  if (const auto* options = std::get_if<WPASE>(&context_.options))
    return std::make_unique<search::ParallelWeightedAstar<Lattice, AnyHeuristic>>(
        lattice, starts, first,
        search::WpaseOptions{.weight = options->weight, .batch_size = static_cast<std::size_t>(options->batch_size)});
  throw NotSupported(planner_id(context_.options) +
                     " plans for many robots, with plan_multi; make_planner another planner, such as 'wAstar', for "
                     "plan");
}

AnySearch LatticeSearch::make_ara_star(LatticeMember& member, const ARAStar& options) {
  search::AraOptions ara;
  ara.initial_weight = std::max(options.weight, options.final_weight);
  ara.weight_delta = options.weight_delta;
  ara.final_weight = options.final_weight;
  ara.on_solution = [this, &member, final = options.final_weight](const search::Result& better) {
    return take(better, member, final);
  };
  return std::make_unique<search::AraStar<Lattice, AnyHeuristic>>(*member.lattice, member.lattice->starts(),
                                                                  member.heuristics.front(), std::move(ara));
}

AnySearch LatticeSearch::make_amra_star(LatticeMember& member, const AMRAStar& options) {
  search::AmraOptions amra{.w1 = options.w1, .w2 = options.w2, .final_weight = options.final_weight};
  amra.on_solution = [this, &member, final = options.final_weight](const search::Result& better) {
    return take(better, member, final);
  };
  Lattice& lattice = *member.lattice;
  return std::make_unique<search::AmraStar<Lattice, AnyHeuristic>>(lattice, lattice.starts(), member.heuristics.front(),
                                                                   lattices_.inadmissible_heuristics(lattice),
                                                                   std::move(amra));
}

/// False: the user wants no better one, or none is needed.
bool LatticeSearch::take(const search::Result& better, const LatticeMember& member, double final_weight) {
  if (good_enough_) return false;  // another search of this round was told so
  good_enough_ = !best_.take(found_path(better, member), context_.deadline) || best_.good_enough(final_weight, direct_);
  return !good_enough_;
}

FoundPath LatticeSearch::found_path(const search::Result& result, const LatticeMember& member) const {
  FoundPath found = lattices_.path_of(result, *member.lattice, member.choice);
  bound(found);
  return found;
}

/// What is proven of a path: by its search, and because no path is shorter than the straight line.
void LatticeSearch::bound(FoundPath& found) const {
  if (!lattices_.heuristics().consistent(context_.common.heuristic))
    found.lower = 0.0;  // the search's bound means nothing
  else if (several_)
    found.lower = std::max(found.lower, direct_);
}

}  // namespace srmp
