#pragma once

#include <cstdint>
#include <optional>

#include "srmp/planning/endpoints/search_endpoints.hpp"
#include "srmp/planning/robot_context.hpp"
#include "srmp/planning/strategies/strategy.hpp"
#include "srmp/search/rrt_connect.hpp"

namespace srmp {

/// How the work is divided between RRT-Connect and the strategies beside it.
struct RrtConnectBudget {
  bool alone{true};  ///< nothing else searches for a path: a round has `attempts_alone`, no limit but the deadline
  std::uint64_t attempts_alone{4096};
  /// Beside others, a round ends when this fraction of all motions checked since the beginning, and the first ones,
  /// were checked by the trees: more finds paths in narrow places earlier, less leaves easy lattices more time. A
  /// motion of a lattice takes about five times the time of one of the trees, so lattices have a seventh of the time.
  double fraction{31.0 / 32.0};
  std::uint64_t first_checks{128};       ///< motions
  std::uint64_t attempts_per_check{16};  ///< attempts between two checks of the budget
  std::uint64_t seed{};                  ///< other samples, and most often another path
  double max_length{search::infinity};   ///< RobotSamplingOptions::max_length
};

/// Two trees that grow towards each other through one robot's joint space (Kuffner, LaValle 2000), by samples that are
/// the same every time (robot_sampling.hpp). Proves nothing but that no path is shorter than the straight line.
class RrtConnectStrategy : public Strategy {
 public:
  /// References outlive this. `direct`: joint-space distance from the path's start to its nearest goal.
  RrtConnectStrategy(RobotContext& context, const SearchEndpoints& endpoints, double direct,
                     const RrtConnectBudget& budget);
  ~RrtConnectStrategy() override;  ///< adds its work to the statistics

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return false; }
  const search::RrtConnect& trees() const { return trees_; }

 private:
  search::RrtSpace space() const;
  bool has_budget(std::uint64_t attempts) const;  // after so many in this round
  search::Statistics work() const;                // of the whole plan, with that of trees before
  Attempt not_found(const Deadline& deadline) const;

  RobotContext& context_;
  const SearchEndpoints& endpoints_;
  const double direct_;
  const RrtConnectBudget budget_;
  const std::uint64_t checked_before_;
  std::uint64_t checked_{};
  search::RrtConnect trees_;
  bool done_{};  // a path was found
};

}  // namespace srmp
