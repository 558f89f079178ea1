#include "srmp/planning/obstacles/timed_motion.hpp"

#include <algorithm>

#include "srmp/planning/group_checkers.hpp"

namespace srmp {

namespace {

constexpr std::uint64_t looks_of_a_proof = 500;

/// All that is open from the first part on, with no gap.
Meeting unproved(const std::vector<MotionProof::Part>& parts, std::size_t other) {
  const MotionProof::Part& first = parts.front();
  Meeting meeting{first.from, first.to, other, first.body_a, first.body_b, false};
  std::vector<MotionProof::Part> sorted = parts;
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.from < b.from; });
  for (const MotionProof::Part& part : sorted)
    if (part.from <= meeting.to) meeting.to = std::max(meeting.to, part.to);
  return meeting;
}

}  // namespace

double arrival(const Trajectory& trajectory) {
  if (!trajectory.timed()) return 0.0;
  Eigen::Index row = trajectory.positions.rows() - 1;
  while (row > 0 && trajectory.positions.row(row - 1) == trajectory.positions.row(row)) --row;
  return trajectory.times[row];
}

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

Watch::Watch(const std::vector<MovingRobot>& others, const Deadline& deadline) : others_(others), deadline_(deadline) {
  for (const MovingRobot& other : others) workspaces_.push_back(other.judge->make_workspace());
}

Eigen::VectorXd Watch::both(const Trajectory& motion, std::size_t other, double time) const {
  const MovingRobot& it = others_[other];
  return side_by_side(motion.sample(time).transpose(), it.motion->sample(time).transpose(), it.stands_before_arm)
      .transpose();
}

bool Watch::is_free(const Trajectory& motion, std::size_t other, double time) {
  ++looks_;
  return others_[other].judge->is_free(both(motion, other, time), *workspaces_[other]);
}

double Watch::end(const Trajectory& motion, std::size_t other) const {
  return std::max(end_of(motion), end_of(*others_[other].motion));
}

std::optional<Meeting> Watch::look(const Trajectory& motion, double from, double to) {
  for (std::size_t other = 0; other < others_.size(); ++other) {
    const double until = std::min(to, end(motion, other));
    for (int i = 0; from + i * time_step <= until && !deadline_.stop_requested(); ++i) {
      const double time = from + i * time_step;
      if (is_free(motion, other, time)) continue;
      Meeting meeting{time, time, other, {}, {}, true};
      const auto contacts = others_[other].judge->contacts(both(motion, other, time), *workspaces_[other]);
      if (contacts.empty()) return meeting;
      meeting.body_a = contacts.front().body_a;
      meeting.body_b = contacts.front().body_b;
      return meeting;
    }
  }
  return std::nullopt;
}

std::optional<Meeting> Watch::prove(const Trajectory& motion) {
  for (std::size_t other = 0; other < others_.size(); ++other) {
    const auto& [pair, judge, stands_before_arm, its] = others_[other];
    const ProofOptions options{.gap_tolerance = 0.0, .deadline = &deadline_};
    looks_ += looks_of_a_proof;
    const MotionProof proof = stands_before_arm ? prove_collision_free(*judge, *its, motion, options)
                                                : prove_collision_free(*judge, motion, *its, options);
    if (!proof.free) return Meeting{proof.time, proof.time, other, proof.body_a, proof.body_b, true};
    if (!proof.unproved.empty()) return unproved(proof.unproved, other);
  }
  return std::nullopt;
}

std::optional<Meeting> Watch::find(const Trajectory& motion) {
  const auto seen = look(motion, 0.0, std::numeric_limits<double>::infinity());
  return seen ? seen : prove(motion);
}

Meeting Watch::extended(const Trajectory& motion, Meeting touch) {
  const auto touches = [&](double time) {
    return time >= 0.0 && time <= end(motion, touch.other) && !deadline_.stop_requested() &&
           !is_free(motion, touch.other, time);
  };
  const double fine = time_step / 4.0;
  while (touch.touch && touches(touch.from - fine)) touch.from -= fine;
  while (touch.touch && touches(touch.to + fine)) touch.to += fine;
  return touch;
}

}  // namespace srmp
