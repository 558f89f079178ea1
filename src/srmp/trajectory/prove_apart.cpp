#include "srmp/trajectory/prove_apart.hpp"

#include <algorithm>
#include <limits>
#include <set>
#include <vector>

namespace srmp {

namespace {

/// Where a robot is at a time in [from, to], during which its velocity does not jump.
void copy_state(const Trajectory& motion, double time, double from, double to, Eigen::Ref<Eigen::RowVectorXd> position,
                Eigen::Ref<Eigen::RowVectorXd> velocity) {
  position = motion.sample(time).transpose();
  if (from >= end_of(motion))
    velocity.setZero();
  else if (motion.velocities.rows() > 0)
    velocity = motion.state(time).velocity.transpose();
  else
    velocity = (motion.sample(to) - motion.sample(from)).transpose() / (to - from);
}

/// The times between which no velocity jumps: at its end a robot rests, without velocities it turns at every row.
std::vector<double> jumps(const Trajectory& a, const Trajectory& b) {
  std::set<double> times{0.0};
  for (const Trajectory* motion : {&a, &b}) {
    times.insert(end_of(*motion));
    if (motion->velocities.rows() == 0) times.insert(motion->times.begin(), motion->times.end());
  }
  return {times.begin(), times.end()};
}

std::vector<double> rows_within(const Trajectory& a, const Trajectory& b, double from, double to) {
  std::set<double> times{from, to};
  for (const Trajectory* motion : {&a, &b})
    for (const double time : motion->times)
      if (time > from && time < to) times.insert(time);
  return {times.begin(), times.end()};
}

MotionProof prove_part(const Checker& judge, const Trajectory& a, const Trajectory& b, double from, double to,
                       Checker::Workspace& workspace, const ProofOptions& options) {
  const std::vector<double> rows = rows_within(a, b, from, to);
  const auto n = static_cast<Eigen::Index>(rows.size());
  const Eigen::Index of_a = a.positions.cols(), of_b = b.positions.cols();
  const Eigen::VectorXd times = Eigen::Map<const Eigen::VectorXd>(rows.data(), n);
  RowMatrix positions(n, of_a + of_b), velocities(n, of_a + of_b);
  for (Eigen::Index i = 0; i < n; ++i) {
    copy_state(a, times[i], from, to, positions.row(i).head(of_a), velocities.row(i).head(of_a));
    copy_state(b, times[i], from, to, positions.row(i).tail(of_b), velocities.row(i).tail(of_b));
  }
  return prove_motion(judge, {times, positions, velocities}, workspace, options);
}

}  // namespace

double end_of(const Trajectory& motion) { return motion.times[motion.times.size() - 1]; }

MotionProof prove_apart(const Checker& judge, const Trajectory& a, const Trajectory& b, const ProofOptions& options) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto workspace = judge.make_workspace();
  const std::vector<double> times = jumps(a, b);
  MotionProof all{.free = true, .clearance = infinity, .proved = infinity};
  for (std::size_t i = 0; i == 0 || i + 1 < times.size(); ++i) {
    MotionProof part = prove_part(judge, a, b, times[i], times[std::min(i + 1, times.size() - 1)], *workspace, options);
    if (!part.free) return part;
    part.unproved.insert(part.unproved.begin(), all.unproved.begin(), all.unproved.end());
    part.proved = std::min(part.proved, all.proved);
    if (i > 0 && all.clearance <= part.clearance) {
      part.clearance = all.clearance;
      part.time = all.time;
      part.body_a = all.body_a;
      part.body_b = all.body_b;
    }
    all = std::move(part);
  }
  return all;
}

MotionProof seen_from_companion(MotionProof proof, const Checker& judge, const std::string& companion) {
  const std::vector<std::string>& links = judge.robot().link_names();
  const std::string prefix = companion + "/";
  const auto swap = [&](std::string& mine, std::string& other) {
    if (std::find(links.begin(), links.end(), mine) != links.end()) mine = judge.robot().name() + "/" + mine;
    if (other.starts_with(prefix)) other.erase(0, prefix.size());
    std::swap(mine, other);
  };
  swap(proof.body_a, proof.body_b);
  for (MotionProof::Part& part : proof.unproved) swap(part.body_a, part.body_b);
  return proof;
}

}  // namespace srmp
