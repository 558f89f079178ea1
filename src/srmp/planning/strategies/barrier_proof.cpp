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

/// All that the limits of the joints allow.
CellDecomposition::Space space_of(const RobotModel& robot, const std::vector<std::size_t>& joints) {
  const auto count = static_cast<Eigen::Index>(joints.size());
  CellDecomposition::Space space{.whole = {Eigen::VectorXd(count), Eigen::VectorXd(count)}};
  for (Eigen::Index k = 0; k < count; ++k) {
    const Joint& joint = robot.joints()[joints[static_cast<std::size_t>(k)]];
    const bool wraps = joint.kind == JointKind::continuous;
    space.wraps.push_back(wraps);
    space.whole.low[k] = wraps ? -std::numbers::pi : joint.lower;
    space.whole.high[k] = wraps ? std::numbers::pi : joint.upper;
  }
  return space;
}

std::string point_text(const Eigen::VectorXd& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "(" : ", ") + to_text(value);
  return text + ")";
}

double volume(const search::Cell& cell) { return (cell.high - cell.low).prod(); }

}  // namespace

BarrierProof::BarrierProof(const RobotModel& robot, std::vector<std::size_t> joints, const Eigen::VectorXd& from,
                           Checker::Workspace& workspace)
    : robot_(robot),
      joints_(joints, from, workspace),
      from_(values_of(robot, joints, from)),
      decomposition_(space_of(robot, joints),
                     [this](const search::Cell& cell, std::size_t parent) { return label(cell, parent); }) {}

BarrierProof::Outcome BarrierProof::run(const Eigen::VectorXd& to, std::size_t cells) {
  return decomposition_.run(from_, values_of(robot_, joints_.joints(), to), decomposition_.cells() + cells);
}

search::CellLabel BarrierProof::label(const search::Cell& cell, std::size_t parent) {
  JointCells::Pairs near = parent == CellDecomposition::no_cell ? joints_.pairs() : near_[parent];
  const CollisionStatus status = joints_.check(cell.low, cell.high, near).status;
  near_.push_back(std::move(near));
  if (status == CollisionStatus::free) return search::CellLabel::free;
  return status == CollisionStatus::colliding ? search::CellLabel::blocked : search::CellLabel::mixed;
}

std::string BarrierProof::reason(const Eigen::VectorXd& to) {
  const std::vector<std::size_t>& barrier = decomposition_.barrier();
  const auto larger = [&](std::size_t a, std::size_t b) {
    return volume(decomposition_.cell(a)) < volume(decomposition_.cell(b));
  };
  const std::size_t largest = *std::max_element(barrier.begin(), barrier.end(), larger);
  const search::Cell& cell = decomposition_.cell(largest);
  JointCells::Pairs near = near_[largest];
  const std::uint32_t pair = joints_.check(cell.low, cell.high, near).pair;
  std::vector<std::string> names;
  for (const std::size_t joint : joints_.joints()) names.push_back(robot_.joints()[joint].name);
  return "there is no path: joints " + quoted_list(names) + " cannot get from " + point_text(from_) + " to " +
         point_text(values_of(robot_, joints_.joints(), to)) +
         " wherever the other joints are, because they are in collision all around; so at " +
         point_text(0.5 * (cell.low + cell.high)) + ", where " + joints_.contact(pair).describe();
}

}  // namespace srmp
