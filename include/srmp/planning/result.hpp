#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "srmp/core/error.hpp"
#include "srmp/planning/request.hpp"
#include "srmp/planning/statistics.hpp"
#include "srmp/trajectory/multi_trajectory.hpp"

namespace srmp {

/// The result of a request: a trajectory, or the reason why there is none; and statistics in both cases.
template <class Motion>
class ResultOf {
 public:
  ResultOf() = default;
  explicit ResultOf(PlanStatistics statistics, std::optional<Motion> trajectory = {})
      : statistics_(std::move(statistics)), trajectory_(std::move(trajectory)) {}

  /// Returns whether there is a trajectory.
  bool solved() const { return trajectory_.has_value(); }
  /// How the plan ended.
  Status status() const { return statistics_.status; }
  const std::string& reason() const { return statistics_.reason; }  ///< why there is no trajectory; "" when solved
  /// What the plan did, solved or not.
  const PlanStatistics& statistics() const { return statistics_; }
  /// The trajectory. Throws PlanningError with status and reason unless solved.
  const Motion& trajectory() const {
    if (!trajectory_) throw PlanningError(statistics_.status, statistics_.reason);
    return *trajectory_;
  }

 private:
  PlanStatistics statistics_;
  std::optional<Motion> trajectory_;
};
/// The result of PlannerInterface::plan, and of one request of plan_many.
using PlanResult = ResultOf<Trajectory>;
/// The result of PlannerInterface::plan_multi.
using MultiPlanResult = ResultOf<MultiTrajectory>;

/// The request of plan or of plan_multi, whichever was last.
using LastRequest = std::variant<PlanRequest, MultiPlanRequest>;
/// The result of the last request.
using LastResult = std::variant<PlanResult, MultiPlanResult>;

}  // namespace srmp
