#include "srmp/trajectory/prove_collision_free.hpp"

#include <algorithm>
#include <vector>

namespace srmp {

namespace {

std::vector<double> rows_of_both(const Trajectory& a, const Trajectory& b) {
  std::vector<double> times{0.0};
  for (const Trajectory* motion : {&a, &b}) times.insert(times.end(), motion->times.begin(), motion->times.end());
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  return times;
}

/// Fills a motion's columns. Between two of the times it follows one polynomial; after its own end it does not move.
void copy_columns(const Trajectory& motion, const Eigen::VectorXd& times, Eigen::Ref<RowMatrix> positions,
                  Eigen::Ref<RowMatrix> departures, Eigen::Ref<RowMatrix> arrivals) {
  const bool straight = motion.velocities.rows() == 0;
  for (Eigen::Index i = 0; i < times.size(); ++i) {
    const MotionState here = motion.state(times[i]);
    positions.row(i) = here.position.transpose();
    const bool reached = i > 0 && times[i - 1] < end_of(motion);
    if (reached && straight)
      arrivals.row(i) = departures.row(i - 1);
    else if (reached)
      arrivals.row(i) = here.velocity.transpose();
    if (times[i] < end_of(motion)) departures.row(i) = here.velocity.transpose();
  }
}

}  // namespace

double end_of(const Trajectory& motion) { return motion.times[motion.times.size() - 1]; }

MotionProof prove_collision_free(const Checker& checker, const Trajectory& a, const Trajectory& b,
                                 const ProofOptions& options) {
  std::vector<double> rows = rows_of_both(a, b);
  const bool too_late = options.deadline && options.deadline->stop_requested();
  if (too_late && rows.size() > 2) rows = {rows.front(), rows.back()};  // nothing between them would be proved
  const auto n = static_cast<Eigen::Index>(rows.size());
  const Eigen::Index of_a = a.positions.cols(), of_b = b.positions.cols();
  const Eigen::VectorXd times = Eigen::Map<const Eigen::VectorXd>(rows.data(), n);
  RowMatrix positions(n, of_a + of_b);
  RowMatrix departures = RowMatrix::Zero(n, of_a + of_b), arrivals = departures;
  copy_columns(a, times, positions.leftCols(of_a), departures.leftCols(of_a), arrivals.leftCols(of_a));
  copy_columns(b, times, positions.rightCols(of_b), departures.rightCols(of_b), arrivals.rightCols(of_b));
  return prove_motion(checker, {times, positions, departures, &arrivals}, *checker.make_workspace(), options);
}

MotionProof seen_from_other_robot(MotionProof proof, const Checker& checker, const std::string& other_robot) {
  const std::vector<std::string>& links = checker.robot().link_names();
  const std::string prefix = other_robot + "/";
  const auto swap = [&](std::string& own, std::string& other) {
    if (std::find(links.begin(), links.end(), own) != links.end()) own = checker.robot().name() + "/" + own;
    if (other.starts_with(prefix)) other.erase(0, prefix.size());
    std::swap(own, other);
  };
  swap(proof.body_a, proof.body_b);
  for (MotionProof::Part& part : proof.unproved) swap(part.body_a, part.body_b);
  return proof;
}

}  // namespace srmp
