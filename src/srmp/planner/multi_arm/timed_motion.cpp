#include "srmp/planner/multi_arm/timed_motion.hpp"

#include <algorithm>

namespace srmp {

namespace {

constexpr double look_period = 0.05;  // [s]

}  // namespace

double end_of(const Trajectory& motion) { return motion.times[motion.times.size() - 1]; }

Trajectory rest(const std::vector<std::string>& joints, const RowMatrix& rows, double duration) {
  const RowMatrix zero = RowMatrix::Zero(rows.rows(), rows.cols());
  return {joints, rows, zero, zero, Eigen::VectorXd::LinSpaced(rows.rows(), 0.0, duration), rows.topRows(1)};
}

Trajectory delayed(const Trajectory& motion, double delay) {
  if (delay == 0.0) return motion;
  Trajectory result = rest(motion.joint_names, motion.positions.row(0).replicate(2, 1), delay).followed_by(motion);
  result.robot = motion.robot;
  return result;
}

std::optional<double> look(const Trajectory& motion, const MovingRobot& other, double from, double to,
                           Checker::Workspace& workspace) {
  const Eigen::Index mine = motion.positions.cols(), its = other.motion->positions.cols();
  Eigen::VectorXd both(mine + its);
  for (int i = 0; from + i * look_period <= to; ++i) {
    const double time = from + i * look_period;
    both.segment(other.first ? its : 0, mine) = motion.sample(time);
    both.segment(other.first ? 0 : mine, its) = other.motion->sample(time);
    if (!other.judge->is_free(both, workspace)) return time;
  }
  return std::nullopt;
}

MotionProof prove_apart(const Trajectory& motion, const MovingRobot& other, const ProofOptions& options) {
  return other.first ? prove_apart(*other.judge, *other.motion, motion, options)
                     : prove_apart(*other.judge, motion, *other.motion, options);
}

std::optional<double> when_met(const Trajectory& motion, const std::vector<MovingRobot>& others,
                               const Deadline& deadline) {
  for (const MovingRobot& other : others) {
    const auto workspace = other.judge->make_workspace();
    const double end = std::max(end_of(motion), end_of(*other.motion));
    if (const auto time = look(motion, other, 0.0, end, *workspace)) return time;
  }
  for (const MovingRobot& other : others) {
    const MotionProof proof = prove_apart(motion, other, {.tightness = 0.0, .deadline = &deadline});
    if (!proof.free) return proof.time;
    if (!proof.unproved.empty()) return proof.unproved.front().from;
  }
  return std::nullopt;
}

}  // namespace srmp
