#include "srmp/planning/strategies/barrier_proof.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

using search::CellDecomposition;

Eigen::VectorXd values_of(const RobotModel& robot, const std::vector<std::size_t>& joints, const Eigen::VectorXd& q) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t k = 0; k < joints.size(); ++k) {
    double& value = values[static_cast<Eigen::Index>(k)];
    value = q[static_cast<Eigen::Index>(joints[k])];
    if (robot.joints()[joints[k]].kind == JointKind::continuous) value = std::remainder(value, 2.0 * std::numbers::pi);
  }
  return values;
}

/// All that the joints can do that the limits allow.
CellDecomposition::Problem problem_of(const RobotModel& robot, const std::vector<std::size_t>& joints,
                                      const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  CellDecomposition::Problem problem{.whole = {from, from}, .from = from, .to = to};
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const Joint& joint = robot.joints()[joints[k]];
    const bool wraps = joint.kind == JointKind::continuous;
    const auto i = static_cast<Eigen::Index>(k);
    problem.wraps.push_back(wraps);
    problem.whole.low[i] = wraps ? -std::numbers::pi : std::min({joint.lower, from[i], to[i]});
    problem.whole.high[i] = wraps ? std::numbers::pi : std::max({joint.upper, from[i], to[i]});
  }
  return problem;
}

std::string point_text(const Eigen::VectorXd& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "(" : ", ") + to_text(value);
  return text + ")";
}

double volume(const search::Cell& cell) { return (cell.high - cell.low).prod(); }

}  // namespace

BarrierProof::BarrierProof(const RobotModel& robot, std::vector<std::size_t> joints, const Eigen::VectorXd& from,
                           const Eigen::VectorXd& to, Checker::Workspace& workspace)
    : robot_(robot),
      joints_(joints, from, workspace),
      from_(values_of(robot, joints, from)),
      to_(values_of(robot, joints, to)),
      decomposition_(problem_of(robot, joints, from_, to_),
                     [this](const search::Cell& cell, std::size_t parent) { return label(cell, parent); }) {}

void BarrierProof::run(std::size_t cells) { outcome_ = decomposition_.run(decomposition_.cells() + cells); }

search::CellLabel BarrierProof::label(const search::Cell& cell, std::size_t parent) {
  JointCells::Pairs near = parent == CellDecomposition::no_cell ? joints_.pairs() : near_[parent];
  const CollisionStatus status = joints_.verdict(cell.low, cell.high, near).status;
  near_.push_back(std::move(near));
  if (status == CollisionStatus::free) return search::CellLabel::free;
  return status == CollisionStatus::colliding ? search::CellLabel::blocked : search::CellLabel::mixed;
}

std::string BarrierProof::reason() {
  const std::vector<std::size_t>& barrier = decomposition_.barrier();
  const auto larger = [&](std::size_t a, std::size_t b) {
    return volume(decomposition_.cell(a)) < volume(decomposition_.cell(b));
  };
  const std::size_t largest = *std::max_element(barrier.begin(), barrier.end(), larger);
  const search::Cell& cell = decomposition_.cell(largest);
  JointCells::Pairs near = near_[largest];
  const std::uint32_t pair = joints_.verdict(cell.low, cell.high, near).pair;
  std::vector<std::string> names;
  for (const std::size_t joint : joints_.joints()) names.push_back(robot_.joints()[joint].name);
  return "there is no path: joints " + quoted_list(names) + " cannot get from " + point_text(from_) + " to " +
         point_text(to_) + " wherever the other joints are, because they are in collision all around; so at " +
         point_text(0.5 * (cell.low + cell.high)) + ", where " + joints_.contact(pair).describe();
}

}  // namespace srmp
