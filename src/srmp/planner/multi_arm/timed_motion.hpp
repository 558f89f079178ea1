#pragma once

#include <optional>
#include <string>
#include <vector>

#include "srmp/planner/multi_arm/safe_intervals.hpp"
#include "srmp/trajectory/prove_apart.hpp"

namespace srmp {

/// [s]
double end_of(const Trajectory& motion);

/// A robot that stays: the same row again and again, from time 0 to `duration` [s].
Trajectory rest(const std::vector<std::string>& joints, const RowMatrix& rows, double duration);

/// The motion, begun after `delay` [s]; until then it rests.
Trajectory delayed(const Trajectory& motion, double delay);

/// An instant in [from, to] at which the two touch, looked for every 50 ms: quicker to find one than a proof.
std::optional<double> look(const Trajectory& motion, const MovingRobot& other, double from, double to,
                           Checker::Workspace& workspace);

/// prove_apart by the judge, the arm's joints standing where they belong.
MotionProof prove_apart(const Trajectory& motion, const MovingRobot& other, const ProofOptions& options);

/// When they first meet, or cannot be proved apart; none: they are.
std::optional<double> when_met(const Trajectory& motion, const std::vector<MovingRobot>& others,
                               const Deadline& deadline);

}  // namespace srmp
