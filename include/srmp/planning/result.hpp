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

/// What became of a request, whose answer is a Motion.
template <class Motion>
class ResultOf {
 public:
  ResultOf() = default;
  explicit ResultOf(PlanStatistics statistics, std::optional<Motion> trajectory = {})
      : statistics_(std::move(statistics)), trajectory_(std::move(trajectory)) {}

  bool solved() const { return trajectory_.has_value(); }
  Status status() const { return statistics_.status; }
  const std::string& reason() const { return statistics_.reason; }  ///< why there is no trajectory; "" when solved
  const PlanStatistics& statistics() const { return statistics_; }
  /// Throws PlanningError with status and reason unless solved.
  const Motion& trajectory() const {
    if (!trajectory_) throw PlanningError(statistics_.status, statistics_.reason);
    return *trajectory_;
  }

 private:
  PlanStatistics statistics_;
  std::optional<Motion> trajectory_;
};
using PlanResult = ResultOf<Trajectory>;
using MultiPlanResult = ResultOf<MultiTrajectory>;

/// Of plan or of plan_multi, whichever was last.
using LastRequest = std::variant<PlanRequest, MultiPlanRequest>;
using LastResult = std::variant<PlanResult, MultiPlanResult>;

}  // namespace srmp
