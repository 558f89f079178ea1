#include "srmp/trajectory/cartesian_deviation.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/stopping.hpp"

namespace srmp {

namespace {

constexpr double longest_turn = 0.4;    // [rad] of a part, for the constants of the rotation
constexpr double shortest_part = 1e-7;  // of the time: below, motion from the nearer end is added instead

void take_larger(CartesianDeviation& sum, double position, double rotation, const CartesianTolerance& tolerance,
                 double time) {
  const double worst = std::max(sum.position / tolerance.position, sum.rotation / tolerance.rotation);
  if (std::max(position / tolerance.position, rotation / tolerance.rotation) > worst) sum.time = time;
  sum.position = std::max(sum.position, position);
  sum.rotation = std::max(sum.rotation, rotation);
}

}  // namespace

CartesianDeviationProof::CartesianDeviationProof(const RobotModel& robot, const Eigen::VectorXd& other_positions,
                                                 std::size_t link, const CartesianPath& path,
                                                 const CartesianTolerance& tolerance, const Deadline& deadline)
    : robot_(robot),
      link_(link),
      path_(path),
      tolerance_(tolerance),
      deadline_(deadline),
      data_(robot.make_data(other_positions)),
      chain_(robot, *data_, link, Eigen::Vector3d::Zero()),
      q_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(robot.dof()))),
      straight_(robot.dof()) {}

CartesianDeviationProof::End CartesianDeviationProof::end_at(std::span<const detail::Cubic> joints, double time,
                                                             std::size_t first, double ahead) {
  constexpr std::uint64_t period = 256;  // some tenths of a millisecond
  if (++ends_ % period == 0) stop_if_late(deadline_, "the deviation from the Cartesian path was proved");
  for (std::size_t j = 0; j < joints.size(); ++j) q_[static_cast<Eigen::Index>(j)] = joints[j].position(time);
  robot_.forward(*data_, q_);
  const Pose pose = Pose::from_isometry(robot_.link_pose(*data_, link_));
  return {time, pose, path_.miss(pose, first, ahead, tolerance_)};
}

/// Of a link that moves for so long, in tolerances.
double CartesianDeviationProof::ahead(const LinkChain::Bounds& motion, double time) const {
  return 1.0 + std::max(motion.speed * time / tolerance_.position, motion.turning * time / tolerance_.rotation);
}

/// Bounds on the misses between two ends; none while they are not fine enough.
std::optional<CartesianDeviationProof::Bound> CartesianDeviationProof::bound_of(const LinkChain::Bounds& motion,
                                                                                const End& from, const End& to,
                                                                                const CartesianTolerance& fine) const {
  const double time = to.time - from.time;
  const double position = motion.acceleration * time * time / 8.0;
  const double rotation = 0.38 * motion.turning_acceleration * time * time;
  const double position_at_ends = std::max(from.miss.position, to.miss.position);
  const double rotation_at_ends = std::max(from.miss.rotation, to.miss.rotation);
  if (from.miss.segment == to.miss.segment && position <= fine.position && rotation <= fine.rotation &&
      motion.turning * time <= longest_turn)
    return Bound{position_at_ends + position, 1.01 * rotation_at_ends + rotation};
  const double moved = motion.speed * time / 2.0, turned = motion.turning * time / 2.0;  // from the nearer end
  if ((moved <= fine.position && turned <= fine.rotation) || time <= shortest_part)
    return Bound{position_at_ends + moved, rotation_at_ends + turned};
  return std::nullopt;
}

CartesianDeviationProof::End CartesianDeviationProof::middle_of(std::span<const detail::Cubic> joints,
                                                                const LinkChain::Bounds& motion, const End& from,
                                                                const End& to) {
  return end_at(joints, (from.time + to.time) / 2.0, from.miss.segment, ahead(motion, to.time - from.time));
}

void CartesianDeviationProof::add_part(std::span<const detail::Cubic> joints, const End& from, const End& to,
                                       CartesianDeviation& sum) {
  const LinkChain::Bounds motion = chain_.bounds(joints, from.time, to.time);
  if (const auto bound = bound_of(motion, from, to, fine()))
    return take_larger(sum, bound->position, bound->rotation, tolerance_, to.time);
  const End middle = middle_of(joints, motion, from, to);
  add_part(joints, from, middle, sum);
  add_part(joints, middle, to, sum);
}

bool CartesianDeviationProof::part_keeps(std::span<const detail::Cubic> joints, const End& from, const End& to) {
  const auto keep = [&](double position, double rotation) { return is_within(position, rotation, tolerance_); };
  if (!keep(from.miss.position, from.miss.rotation) || !keep(to.miss.position, to.miss.rotation)) return false;
  const LinkChain::Bounds motion = chain_.bounds(joints, from.time, to.time);
  const auto coarse = bound_of(motion, from, to, tolerance_);
  if (coarse && keep(coarse->position, coarse->rotation)) return true;
  if (const auto bound = bound_of(motion, from, to, fine())) return keep(bound->position, bound->rotation);
  const End middle = middle_of(joints, motion, from, to);
  return part_keeps(joints, from, middle) && part_keeps(joints, middle, to);
}

bool CartesianDeviationProof::keeps(const Eigen::VectorXd& a, const Eigen::VectorXd& b, std::size_t segment) {
  set_straight(a, b);
  const auto [from, to] = ends_of(straight_, segment);
  return part_keeps(straight_, from, to);
}

std::pair<CartesianDeviationProof::End, CartesianDeviationProof::End> CartesianDeviationProof::ends_of(
    std::span<const detail::Cubic> joints, std::size_t segment) {
  const double time = joints.front().h;
  const LinkChain::Bounds motion = chain_.bounds(joints, 0.0, time);
  const End from = end_at(joints, 0.0, segment, 1.0);
  return {from, end_at(joints, time, from.miss.segment, ahead(motion, time))};
}

CartesianDeviation CartesianDeviationProof::over(std::span<const detail::Cubic> joints, std::size_t& segment) {
  const auto [from, to] = ends_of(joints, segment);
  CartesianDeviation deviation;
  take_larger(deviation, from.miss.position, from.miss.rotation, tolerance_, 0.0);
  add_part(joints, from, to, deviation);
  segment = to.miss.segment;
  return deviation;
}

void CartesianDeviationProof::set_straight(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::VectorXd change = robot_.difference(a, b);
  for (std::size_t j = 0; j < straight_.size(); ++j) {
    const auto joint = static_cast<Eigen::Index>(j);
    straight_[j] = detail::line(a[joint], a[joint] + change[joint], 1.0);
  }
}

CartesianDeviation prove_cartesian_deviation(const Trajectory& trajectory, const PlacedRobot& robot,
                                             const std::string& link, const CartesianPath& path,
                                             const CartesianTolerance& tolerance, const Deadline& deadline) {
  const CartesianPath in_base = path.seen_from(robot.base);
  const std::size_t number = robot.model->link_index(link.empty() ? robot.model->end_effector() : link);
  CartesianDeviationProof proof(*robot.model, robot.other_positions, number, in_base, tolerance, deadline);
  CartesianDeviation worst;
  std::vector<detail::Cubic> cubics(trajectory.dof());
  std::size_t segment = 0;
  for (Eigen::Index row = 0; row + 1 < trajectory.positions.rows(); ++row) {
    stop_if_late(deadline, "the deviation from the Cartesian path was proved");
    for (std::size_t j = 0; j < cubics.size(); ++j)
      cubics[j] = detail::segment_of(trajectory, row, static_cast<Eigen::Index>(j));
    const CartesianDeviation part = proof.over(cubics, segment);
    take_larger(worst, part.position, part.rotation, tolerance, trajectory.times[row] + part.time);
  }
  // It is to begin and to end where the path does.
  const auto add_end = [&](Eigen::Index row, std::size_t end_segment, double fraction) {
    const Pose at = robot.model->compute_fk(trajectory.positions.row(row).transpose(), link, robot.other_positions);
    const Pose off = in_base.pose(end_segment, fraction).inverse() * at;
    take_larger(worst, off.p.norm(), 2.0 * std::atan2(off.q.vec().norm(), std::abs(off.q.w())), tolerance,
                trajectory.times[row]);
  };
  add_end(0, 0, 0.0);
  add_end(trajectory.positions.rows() - 1, in_base.segments() - 1, 1.0);
  return worst;
}

}  // namespace srmp
