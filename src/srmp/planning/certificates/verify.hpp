#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "srmp/planning/verify.hpp"
#include "srmp/scene/scene.hpp"
#include "srmp/trajectory/certify.hpp"
#include "srmp/trajectory/placed_constraints.hpp"

namespace srmp {

/// How far q misses the nearest of the goals: joint goals in rad (m), the worst joint; poses and positions as a
/// fraction of their tolerances, the worst axis of all links. NaN when there is none.
struct GoalError {
  double error{std::numeric_limits<double>::quiet_NaN()};
  double allowed{};
};
GoalError goal_error(const std::vector<GoalConstraint>& goals, const Checker& checker, ConstVector q);

/// What the options of one robot name in the scene; null: nothing.
struct PlacedVerifyOptions {
  std::shared_ptr<const PlacedConstraints> constraints{};
  std::shared_ptr<const Checker> with_clearance{};
};
void require_clearance(double clearance);  ///< throws InvalidArgument where it is not 0 m or above
/// Throws InvalidArgument as place_constraints, and for a clearance out of range.
PlacedVerifyOptions place(const VerifyOptions& options, const Scene& scene, const std::string& robot);

/// certify, and whether the trajectory begins and ends where it should. Throws InvalidArgument for options out of
/// range.
Certificate verify(const Trajectory& trajectory, const Checker& checker, const MotionLimits& limits,
                   const VerifyOptions& options, const PlacedVerifyOptions& placed = {});

}  // namespace srmp
