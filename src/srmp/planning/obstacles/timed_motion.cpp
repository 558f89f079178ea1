#include "srmp/planning/obstacles/timed_motion.hpp"

#include <algorithm>

#include "srmp/planning/group_checkers.hpp"

namespace srmp {

namespace {

/// The first part that is not proved, joined with all that overlap it.
CollisionInterval unproved_interval(const std::vector<MotionProof::Part>& parts, std::size_t other) {
  const MotionProof::Part& first = parts.front();
  CollisionInterval interval{first.from, first.to, other, first.body_a, first.body_b, false};
  std::vector<MotionProof::Part> sorted = parts;
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.from < b.from; });
  for (const MotionProof::Part& part : sorted)
    if (part.from <= interval.to) interval.to = std::max(interval.to, part.to);
  return interval;
}

}  // namespace

double arrival_time(const Trajectory& trajectory) {
  if (!trajectory.timed()) return 0.0;
  Eigen::Index row = trajectory.positions.rows() - 1;
  while (row > 0 && trajectory.positions.row(row - 1) == trajectory.positions.row(row)) --row;
  return trajectory.times[row];
}

Trajectory stationary(const std::vector<std::string>& joints, const RowMatrix& rows, double duration) {
  const RowMatrix zero = RowMatrix::Zero(rows.rows(), rows.cols());
  return {joints, rows, zero, zero, Eigen::VectorXd::LinSpaced(rows.rows(), 0.0, duration), rows.topRows(1)};
}

Trajectory delayed(const Trajectory& motion, double delay) {
  if (delay == 0.0) return motion;
  const RowMatrix start = motion.positions.row(0).replicate(2, 1);
  Trajectory result = stationary(motion.joint_names, start, delay).followed_by(motion);
  result.robot = motion.robot;
  return result;
}

CollisionMonitor::CollisionMonitor(const std::vector<MovingRobot>& other_robots, const Deadline& deadline)
    : other_robots_(other_robots), deadline_(deadline) {
  for (const MovingRobot& other : other_robots) workspaces_.push_back(other.exact_checker->make_workspace());
}

Eigen::VectorXd CollisionMonitor::configuration_of_both(const Trajectory& motion, std::size_t other,
                                                        double time) const {
  const MovingRobot& moving = other_robots_[other];
  return side_by_side(motion.sample(time).transpose(), moving.motion->sample(time).transpose(), moving.joints_first)
      .transpose();
}

bool CollisionMonitor::is_free(const Trajectory& motion, std::size_t other, double time) {
  ++checks_;
  return other_robots_[other].exact_checker->is_free(configuration_of_both(motion, other, time), *workspaces_[other]);
}

/// When both robots have become stationary.
double CollisionMonitor::end(const Trajectory& motion, std::size_t other) const {
  return std::max(end_of(motion), end_of(*other_robots_[other].motion));
}

std::optional<CollisionInterval> CollisionMonitor::find_collision_at_samples(const Trajectory& motion, double from,
                                                                             double to) {
  for (std::size_t other = 0; other < other_robots_.size(); ++other) {
    const double until = std::min(to, end(motion, other));
    for (int i = 0; from + i * time_step <= until && !deadline_.stop_requested(); ++i) {
      const double time = from + i * time_step;
      if (is_free(motion, other, time)) continue;
      CollisionInterval found{time, time, other, {}, {}, true};
      const Checker& exact = *other_robots_[other].exact_checker;
      const auto contacts = exact.contacts(configuration_of_both(motion, other, time), *workspaces_[other]);
      if (contacts.empty()) return found;
      found.body_a = contacts.front().body_a;
      found.body_b = contacts.front().body_b;
      return found;
    }
  }
  return std::nullopt;
}

std::optional<CollisionInterval> CollisionMonitor::prove(const Trajectory& motion) {
  for (std::size_t other = 0; other < other_robots_.size(); ++other) {
    const auto& [checker, exact_checker, joints_first, other_motion] = other_robots_[other];
    const ProofOptions options{.gap_tolerance = 1.0, .deadline = &deadline_};
    checks_ += checks_per_proof;
    const MotionProof proof = joints_first ? prove_collision_free(*exact_checker, *other_motion, motion, options)
                                           : prove_collision_free(*exact_checker, motion, *other_motion, options);
    if (!proof.free) return CollisionInterval{proof.time, proof.time, other, proof.body_a, proof.body_b, true};
    if (!proof.unproved.empty()) return unproved_interval(proof.unproved, other);
  }
  return std::nullopt;
}

std::optional<CollisionInterval> CollisionMonitor::find(const Trajectory& motion) {
  const auto found = find_collision_at_samples(motion, 0.0, std::numeric_limits<double>::infinity());
  return found ? found : prove(motion);
}

CollisionInterval CollisionMonitor::extended(const Trajectory& motion, CollisionInterval contact) {
  const auto collides = [&](double time) {
    return time >= 0.0 && time <= end(motion, contact.other) && !deadline_.stop_requested() &&
           !is_free(motion, contact.other, time);
  };
  const double fine_step = time_step / 4.0;
  while (contact.contact && collides(contact.from - fine_step)) contact.from -= fine_step;
  while (contact.contact && collides(contact.to + fine_step)) contact.to += fine_step;
  return contact;
}

}  // namespace srmp
