#include "srmp/planning/strategies/anytime.hpp"

#include <algorithm>

#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/strategies/lattice_portfolio.hpp"
#include "srmp/planning/strategies/rrt_connect.hpp"

namespace srmp {

namespace {

/// There is time: gains of a thousandth count.
const ShortcutOptions careful_shortcut{
    .min_gain = 1e-3, .halvings = 5, .pull_gain = 1e-3, .cut_gain = 5e-3, .continuous = {}};

class Anytime {
 public:
  Anytime(RobotContext& context, const SearchEndpoints& endpoints, RobotLattices& lattices, BestPath& best,
          double direct, const AnytimeOptions& options)
      : context_(context),
        endpoints_(endpoints),
        lattices_(lattices),
        best_(best),
        direct_(direct),
        options_(options),
        improvement_(improvement(context.options)),
        until_(context.deadline.within(improvement_.max_time())) {}

  void run(FoundPath first) {
    // With less care than others: trees are about to find shorter ones.
    if (!best_.take(std::move(first), until_)) return;
    std::uint64_t expansions = options_.first_expansions;
    std::uint64_t tree_checks = options_.trees ? options_.first_tree_checks : 0;
    double finer = 1.0;
    for (int round = 0; improvement_.goes_on_after(round); ++round) {
      if (!grow_trees(tree_checks) || !run_round(expansions, finer)) return;
      tree_checks = std::min(options_.tree_growth * tree_checks, options_.max_expansions);
      expansions = std::min(options_.growth * expansions, options_.max_expansions);
      finer = std::max(options_.refinement * finer, options_.min_scale);
    }
  }

 private:
  /// False: as of run_round.
  bool grow_trees(std::uint64_t checks) {
    for (std::uint64_t spent = 0; spent < checks;) {
      if (best_.good_enough(improvement_.final_weight, direct_) || until_.stop_requested()) return false;
      const std::uint64_t before = context_.checks.motions(),
                          most = std::min(options_.checks_of_a_tree, checks - spent);
      Attempt found = grow_tree(most);
      const bool is_path = found.status == Status::solved;
      // Most are not worth much care.
      if (is_path &&
          !best_.take_if_promising(std::move(found.found), until_, options_.promising_length, careful_shortcut))
        return false;
      spent += std::max(context_.checks.motions() - before,
                        is_path ? options_.least_of_a_tree : most);  // attempts may check nothing
    }
    return true;
  }

  Attempt grow_tree(std::uint64_t checks) {
    const PhaseTimer timer(context_.deadline, context_.statistics.search_time_s);
    std::uint64_t& memory = context_.statistics.memory_bytes;
    const std::uint64_t before = memory;
    Attempt found = RrtConnectStrategy(context_, endpoints_, direct_,
                                       {.alone = false,
                                        .fraction = 0.0,
                                        .first_checks = checks,
                                        .seed = ++seed_,
                                        .max_length = options_.sampled_length * best_cost()})
                        .attempt({}, until_);
    memory = std::max(before, memory - before);  // the trees before are gone
    return found;
  }

  /// False: no better path is needed, or none can be found.
  bool run_round(std::uint64_t expansions, double finer) {
    for (const double fraction : options_.fractions)
      while (true) {
        if (best_.good_enough(improvement_.final_weight, direct_) || until_.stop_requested()) return false;
        const double before = best_cost(), limit = direct_ + fraction * (before - direct_);
        LatticePortfolio searches(lattices_, lattices_.portfolio_options(1.0, finer, limit, expansions));
        Attempt found = search(searches);
        for (const std::string& graph : searches.exhausted_graphs())
          if (!best_.prove(limit, graph)) return false;
        if (found.status == Status::solved && !best_.take(std::move(found.found), until_, careful_shortcut))
          return false;
        const bool can_be_finer = !lattices_.own_primitives() && finer > options_.min_scale;
        if (!can_be_finer && fraction == 1.0 && searches.all_exhausted()) return false;
        if (best_cost() >= before) break;
      }
    return true;
  }

  Attempt search(LatticePortfolio& searches) {
    const PhaseTimer timer(context_.deadline, context_.statistics.search_time_s);
    Attempt result = searches.run(until_);
    lattices_.count(searches);
    return result;
  }

  double best_cost() const { return context_.statistics.path_cost_rad; }

  RobotContext& context_;
  const SearchEndpoints& endpoints_;
  std::uint64_t seed_{};  // of the trees that were grown last
  RobotLattices& lattices_;
  BestPath& best_;
  const double direct_;
  const AnytimeOptions& options_;
  const Improvement improvement_;
  const Deadline until_;
};

}  // namespace

void improve_path(RobotContext& context, const SearchEndpoints& endpoints, RobotLattices& lattices, BestPath& best,
                  FoundPath first, double direct, const AnytimeOptions& options) {
  Anytime(context, endpoints, lattices, best, direct, options).run(std::move(first));
}

}  // namespace srmp
