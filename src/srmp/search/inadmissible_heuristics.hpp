#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "srmp/core/block_vector.hpp"
#include "srmp/core/error.hpp"
#include "srmp/search/graph.hpp"

namespace srmp::search {

/// Estimates of the cost-to-go, which may overestimate it: each >= 0, and finite unless `infinity_allowed`.
/// values(states, out) writes all `count` of the first state, then of the next.
struct InadmissibleHeuristics {
  std::size_t count{};
  std::function<void(std::span<const StateId>, std::span<double>)> values;
  bool infinity_allowed{false};
};

/// Those of a list that outlives the result. Throws InvalidArgument for an empty one.
inline InadmissibleHeuristics together(std::span<const AnyHeuristic> heuristics) {
  for (std::size_t i = 0; i < heuristics.size(); ++i)
    if (!heuristics[i]) throw InvalidArgument("inadmissible heuristic " + std::to_string(i) + " is empty");
  return {
      .count = heuristics.size(),
      .values =
          [heuristics, values = std::vector<double>()](std::span<const StateId> states, std::span<double> out) mutable {
            values.resize(states.size());
            for (std::size_t i = 0; i < heuristics.size(); ++i) {
              heuristics[i].values(states, values);
              for (std::size_t k = 0; k < states.size(); ++k) out[k * heuristics.size() + i] = values[k];
            }
          },
      .infinity_allowed = true};
}

/// Their values, each evaluated once.
class InadmissibleValues {
 public:
  explicit InadmissibleValues(InadmissibleHeuristics heuristics) : heuristics_(std::move(heuristics)) {}

  std::size_t count() const { return heuristics_.count; }
  /// Of a state that has been evaluated.
  double operator()(StateId s, std::size_t i) const { return values_[at(s, i)]; }
  std::size_t memory() const { return values_.memory(); }

  /// Evaluates the states that are new, all in one call. Throws InvalidArgument for values that are not allowed.
  void evaluate(std::span<const StateId> states) {
    if (count() == 0) return;
    new_states_.clear();
    for (const StateId s : states) {
      values_.grow_to(at(s, count()), -1.0);
      if (values_[at(s, 0)] < 0.0) new_states_.push_back(s);
    }
    if (new_states_.empty()) return;
    new_values_.resize(new_states_.size() * count());
    heuristics_.values(new_states_, new_values_);
    for (std::size_t k = 0; k < new_values_.size(); ++k) {
      const StateId s = new_states_[k / count()];
      if (!(new_values_[k] >= 0.0 && (new_values_[k] < infinity || heuristics_.infinity_allowed)))
        throw InvalidArgument("inadmissible heuristic " + std::to_string(k % count()) + " of state " +
                              std::to_string(s) + " is " + to_text(new_values_[k]) + ", it must be 0 or more" +
                              (heuristics_.infinity_allowed ? ", or infinity" : " and finite"));
      values_[at(s, k % count())] = new_values_[k];
    }
  }

 private:
  std::size_t at(StateId s, std::size_t i) const { return std::size_t{s} * count() + i; }

  InadmissibleHeuristics heuristics_;
  BlockVector<double> values_;  // by state and heuristic; negative: not evaluated yet
  std::vector<StateId> new_states_;
  std::vector<double> new_values_;
};

}  // namespace srmp::search
