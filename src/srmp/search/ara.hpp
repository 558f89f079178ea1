#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <utility>

#include "srmp/search/weighted_search.hpp"

/// ARA*: anytime repairing A* with lazily evaluated edges.
///
/// Papers: Likhachev, Gordon, Thrun 2003, "ARA*: Anytime A* with Provable Bounds on Sub-Optimality"; lazy edges as in
/// Cohen, Phillips, Likhachev 2014.
/// Guarantee: a sequence of paths whose costs never rise and whose bounds never rise, each cost <= bound * optimal
/// cost; within one weight no state is expanded twice, in the whole search no edge is evaluated twice. With enough time
/// the last bound is <= final_weight, for 1 the path is optimal. Needs: as weighted A* (astar.hpp).
namespace srmp::search {

struct AraOptions {
  double initial_weight{50.0};  ///< >= final_weight; of the first path
  double weight_delta{10.0};    ///< > 0; the weight falls by this, or straight to the proven bound when that is less
  double final_weight{1.0};     ///< >= 1; stop once this bound is proven
  /// Is called with each path that is cheaper or has a tighter bound than the one before; false stops the search. May
  /// be empty.
  std::function<bool(const Result&)> on_solution{};
};

/// One search in slices, from all `starts` (cost 0 each) to the nearest goal.
template <Graph G, Heuristic H>
class AraStar : public ResumableSearch {
 public:
  /// Graph and heuristic outlive this.
  AraStar(G& graph, std::span<const StateId> starts, H& heuristic, AraOptions options)
      : options_(std::move(options)),
        weight_(options_.initial_weight),
        search_(graph, heuristic, weight_, WeightedSearch<G, H>::Expand::again) {
    require_weight(options_.final_weight, "final_weight");
    require_weight(options_.initial_weight, "initial_weight");
    require_positive(options_.weight_delta, "weight_delta");
    if (options_.initial_weight < options_.final_weight) {
      throw InvalidArgument("initial_weight is " + to_text(options_.initial_weight) + ", less than final_weight " +
                            to_text(options_.final_weight));
    }
    search_.add_starts(starts);
  }

  std::optional<Status> improve(const Deadline& deadline, std::uint64_t expansions) override {
    const std::uint64_t first = search_.expansions();
    while (!finished()) {
      const std::uint64_t used = search_.expansions() - first;
      if (used >= expansions) return std::nullopt;
      if (const auto stop = search_.improve(deadline, expansions - used)) return stop;
      if (search_.finished()) end_round();
    }
    return std::nullopt;
  }

  /// Proven, exhausted, or on_solution wants no better path.
  bool finished() const override { return finished_; }

  /// Of the last round that ended. When time runs out or the caller cancels, that is the best path so far (`solved`,
  /// with its bound); timed_out and cancelled mean that there was none yet.
  Result result(std::optional<Status> stop) const override {
    Result result = solved() || finished_ ? best_ : search_.result(weight_, stop);
    result.statistics = statistics();
    return result;
  }
  bool solved() const override { return best_.status == Status::solved; }
  double cost() const override { return best_.cost; }
  Statistics statistics() const override { return search_.statistics(); }

 private:
  void end_round() {
    Result now = search_.result(weight_, std::nullopt);
    now.bound = std::min(now.bound, best_.bound);  // proven for a costlier path, so for this one
    const bool improved = now.cost < best_.cost || now.bound < best_.bound;
    best_ = std::move(now);
    finished_ = !solved() || (improved && options_.on_solution && !options_.on_solution(best_)) ||
                best_.bound <= options_.final_weight;
    if (finished_) return;
    weight_ = std::max(options_.final_weight, std::min(weight_ - options_.weight_delta, best_.bound));
    search_.next_round(weight_);
  }

  AraOptions options_;
  double weight_;
  WeightedSearch<G, H> search_;
  Result best_;
  bool finished_{};
};

/// The whole search at once.
template <Graph G, Heuristic H>
Result ara_star(G& graph, std::span<const StateId> starts, H& heuristic, const AraOptions& options,
                const Deadline& deadline) {
  AraStar<G, H> search(graph, starts, heuristic, options);
  const std::optional<Status> stop = search.improve(deadline, unlimited);
  return search.result(stop);
}

}  // namespace srmp::search
