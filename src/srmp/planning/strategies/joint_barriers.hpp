#pragma once

#include "srmp/planning/endpoints/endpoints.hpp"
#include "srmp/planning/robot_context.hpp"
#include "srmp/planning/strategies/strategy.hpp"

namespace srmp {

/// Finds no path, but proves that there is none where each goal is behind a barrier (find_joint_barrier) and is a
/// configuration: inverse kinematics may know more ends of a path than the endpoints do. It does so in the first round.
class JointBarriers : public Strategy {
 public:
  JointBarriers(RobotContext& context, const RobotEndpoints& endpoints) : context_(context), endpoints_(endpoints) {}

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return false; }

 private:
  RobotContext& context_;
  const RobotEndpoints& endpoints_;
};

}  // namespace srmp
