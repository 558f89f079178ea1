#include "srmp/trajectory/placed_constraints.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

constexpr double no_bound = std::numeric_limits<double>::infinity();
constexpr double certificate_fineness = 0.02;  // of the tolerance: how much a certificate may add to what it samples
constexpr double smallest = 1e-7;              // of the tolerance: parts that change it by less are not halved
constexpr int most_halvings = 20'000;  // of one motion: tolerances that take more are not kept, as far as is known
constexpr int max_iterations = 25;     // of a projection
constexpr double max_change = 0.4;     // [rad or m] of a joint in one of them
/// Of a rotation vector's component by the rotation: sin(pi/2) / (pi/2), inverted, at half a turn.
constexpr double rotation_vector_rate = M_PI / 2.0;

using Row = ConstraintChecker::Row;

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

void add_position_rows(const PathConstraint& c, const Eigen::Vector3d& p, std::vector<Row>& rows) {
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < 3; ++i)
    if (!c.position_tolerance.is_free(i))
      rows.push_back(
          {std::abs(p[i]), c.position_tolerance.axes[i], std::copysign(1.0, p[i]) * Eigen::Vector3d::Unit(i), none});
}

void add_rotation_rows(const PathConstraint& c, const Eigen::Matrix3d& rotation, std::vector<Row>& rows) {
  const Eigen::AngleAxisd turn(rotation);
  const double angle = turn.angle();
  const Eigen::Vector3d e = angle * turn.axis();
  // The inverse of the left Jacobian of the rotation group (Barfoot 2017, State Estimation for Robotics, 7.1).
  const Eigen::Matrix3d s = skew(e);
  const double factor = angle < 1e-4 ? 1.0 / 12.0 : 1.0 / (angle * angle) - 1.0 / (2.0 * angle * std::tan(angle / 2.0));
  const Eigen::Matrix3d inverse = Eigen::Matrix3d::Identity() - 0.5 * s + factor * s * s;
  for (Eigen::Index i = 0; i < 3; ++i)
    if (!c.rotation_tolerance.is_free(i))
      rows.push_back({std::abs(e[i]), c.rotation_tolerance.axes[i], Eigen::Vector3d::Zero(),
                      std::copysign(1.0, e[i]) * inverse.row(i).transpose()});
}

Row cone_row(const PathConstraint& c, const Eigen::Matrix3d& rotation) {
  const Eigen::Vector3d axis = rotation * c.axis, across = axis.cross(Eigen::Vector3d::UnitZ());
  const double sine = across.norm();
  const Eigen::Vector3d about = sine > 1e-9 ? Eigen::Vector3d(across / sine) : Eigen::Vector3d::UnitX();
  return {std::atan2(sine, axis.z()), c.tolerance, Eigen::Vector3d::Zero(), -about};
}

Row line_row(const PathConstraint& c, const Eigen::Vector3d& p) {
  const double off = std::hypot(p.x(), p.y());
  const Eigen::Vector3d away = off > 1e-12 ? Eigen::Vector3d(p.x() / off, p.y() / off, 0.0) : Eigen::Vector3d::UnitX();
  return {off, c.tolerance, away, Eigen::Vector3d::Zero()};
}

Row plane_row(const PathConstraint& c, const Eigen::Vector3d& p) {
  return {std::abs(p.z()), c.tolerance, std::copysign(1.0, p.z()) * Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero()};
}

Row distance_row(const PathConstraint& c, const Eigen::Vector3d& p) {
  const double distance = p.norm(), off = distance - 0.5 * (c.min_distance + c.max_distance);
  const Eigen::Vector3d away = distance > 1e-12 ? Eigen::Vector3d(p / distance) : Eigen::Vector3d::UnitX();
  return {std::abs(off), 0.5 * (c.max_distance - c.min_distance), std::copysign(1.0, off) * away,
          Eigen::Vector3d::Zero()};
}

/// Of the body's pose in the target's frame.
void add_rows(const PathConstraint& c, const Eigen::Isometry3d& x, std::vector<Row>& rows) {
  switch (c.type) {
    case PathConstraintType::cone: rows.push_back(cone_row(c, x.linear())); break;
    case PathConstraintType::line: rows.push_back(line_row(c, x.translation())); break;
    case PathConstraintType::plane: rows.push_back(plane_row(c, x.translation())); break;
    case PathConstraintType::distance: rows.push_back(distance_row(c, x.translation())); break;
    case PathConstraintType::box: add_position_rows(c, x.translation(), rows); break;
    case PathConstraintType::orientation: add_rotation_rows(c, x.linear(), rows); break;
    case PathConstraintType::pose: add_position_rows(c, x.translation(), rows); add_rotation_rows(c, x.linear(), rows);
  }
}

const Row& worst_row(const std::vector<Row>& rows) {
  return *std::max_element(rows.begin(), rows.end(),
                           [](const Row& a, const Row& b) { return a.value / a.limit < b.value / b.limit; });
}

/// The smallest position and rotation by which a constraint could go from 0 to its whole tolerance.
std::pair<double, double> scales(const PathConstraint& c) {
  switch (c.type) {
    case PathConstraintType::cone: return {no_bound, c.tolerance};
    case PathConstraintType::line:
    case PathConstraintType::plane: return {c.tolerance, no_bound};
    case PathConstraintType::distance: return {0.5 * (c.max_distance - c.min_distance), no_bound};
    case PathConstraintType::box: return {c.position_tolerance.axes.minCoeff(), no_bound};
    case PathConstraintType::orientation:
      return {no_bound, c.rotation_tolerance.axes.minCoeff() / rotation_vector_rate};
    case PathConstraintType::pose:
      return {c.position_tolerance.axes.minCoeff(), c.rotation_tolerance.axes.minCoeff() / rotation_vector_rate};
  }
  return {no_bound, no_bound};
}

/// Deviations are fractions of the tolerance of their axis; as lengths or angles they are of this one.
double worst_tolerance(const PathConstraint& c) {
  switch (c.type) {
    case PathConstraintType::distance: return 0.5 * (c.max_distance - c.min_distance);
    case PathConstraintType::box: return c.position_tolerance.axes.minCoeff();
    case PathConstraintType::orientation: return c.rotation_tolerance.axes.minCoeff();
    case PathConstraintType::pose:
      return std::isfinite(c.position_tolerance.axes.minCoeff()) ? c.position_tolerance.axes.minCoeff()
                                                                 : c.rotation_tolerance.axes.minCoeff();
    default: return c.tolerance;
  }
}

/// Whether second_order bounds this constraint, within parts of a motion in which the joints turn by at most
/// `max_turn` in all: rows that are smooth, which are not those of cones, lines and distances, nor rotation vectors far
/// from zero, and joints that turn, each of which moves itself alone.
bool has_second_order(const PlacedConstraints& all, std::size_t constraint) {
  constexpr double small_rotation = 0.17;  // [rad] about an axis: the rotation vector is then below 0.3
  const PathConstraint& c = all.constraints()[constraint].constraint;
  const bool is_box = c.type == PathConstraintType::box;
  const bool is_rotation = c.type == PathConstraintType::orientation || c.type == PathConstraintType::pose;
  if (!is_box && !(is_rotation && c.rotation_tolerance.axes.maxCoeff() <= small_rotation)) return false;
  std::vector<char> is_seen(all.robot().dof(), 0);
  for (const ActuatedJoint& joint : all.robot().actuated_joints()) {
    if (all.rates()[constraint][static_cast<Eigen::Index>(joint.joint)] == 0.0) continue;
    if (joint.prismatic || is_seen[joint.joint] || joint.ratio != 1.0) return false;
    is_seen[joint.joint] = 1;
  }
  return true;
}

constexpr double max_turn = 0.12;  // [rad] of all joints together, where second_order holds

/// How far a constraint's deviation can rise above those of both ends of a part of a motion, in which the joints change
/// by at most `change` (dof,) [rad] at a steady speed; nothing: this is not known.
///
/// Of a chain of joints that turn, the second derivative of a point by two of them is at most its distance from the
/// farther one along the chain, and that of the rotation vector, below 0.5, at most 1.11 times the square of the sum of
/// their speeds. Both are bounded by the smaller of the two joints' rates, and what a function with the second
/// derivative m has above its chord by m / 8.
double second_order(const Eigen::VectorXd& rates, const Eigen::VectorXd& change) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < change.size(); ++i)
    for (Eigen::Index j = 0; j < change.size(); ++j)
      sum += std::abs(change[i] * change[j]) * std::min(rates[i], rates[j]);
  return 0.125 * sum;
}

/// ConstraintChecker::keeps of constraints that have a second order: the motion is halved until it is proved.
class SecondOrderProof {
 public:
  SecondOrderProof(ConstraintChecker& checker, const Eigen::VectorXd& a, const Eigen::VectorXd& change, double most)
      : checker_(checker), a_(a), change_(change), most_(most) {
    for (const Eigen::VectorXd& rate : checker.constraints().rates()) {
      largest_ = std::max(largest_, second_order(rate, change));
      turn_ = std::max(turn_, (rate.array() > 0.0).select(change.array().abs(), 0.0).sum());
    }
  }

  bool keeps(double from, double to, double at_from, double at_to) {
    const double part = to - from, rise = largest_ * part * part;
    if (part * turn_ <= max_turn && std::max(at_from, at_to) + rise <= most_) return true;
    if (rise <= smallest && part * turn_ <= max_turn) return true;
    if (++halvings_ > most_halvings) return false;
    const double middle = 0.5 * (from + to);
    q_ = a_ + middle * change_;
    const double at_middle = checker_.deviation(q_);
    return at_middle <= most_ && keeps(from, middle, at_from, at_middle) && keeps(middle, to, at_middle, at_to);
  }

 private:
  ConstraintChecker& checker_;
  const Eigen::VectorXd &a_, &change_;
  Eigen::VectorXd q_;
  double most_, largest_{}, turn_{};
  int halvings_{0};
};

std::string amount(double value, bool position) {
  const double rounded = std::round(1e3 * value * (position ? 1e3 : 180.0 / M_PI)) / 1e3;
  return to_text(rounded) + (position ? " mm" : " degrees");
}

}  // namespace

PlacedConstraints::PlacedConstraints(const RobotModel& robot, const Eigen::VectorXd& other_positions,
                                     std::vector<PlacedConstraint> constraints)
    : robot_(robot), other_positions_(other_positions), constraints_(std::move(constraints)) {
  for (const PlacedConstraint& constraint : constraints_) rates_.push_back(rate(constraint));
}

/// Joints that move both frames alike do not count. The others form a chain from the body to the common parent and on
/// to the frame; the body is never farther from a joint's axis than the lengths of that chain.
Eigen::VectorXd PlacedConstraints::rate(const PlacedConstraint& constraint) const {
  const std::uint64_t of_body = robot_.link_support(constraint.link);
  const std::uint64_t of_frame = constraint.frame ? robot_.link_support(*constraint.frame) : 0;
  const std::vector<ActuatedJoint>& joints = robot_.actuated_joints();
  std::vector<std::size_t> chain;
  for (std::size_t k = joints.size(); k-- > 0;)
    if ((of_body & ~of_frame) >> k & 1) chain.push_back(k);
  for (std::size_t k = 0; k < joints.size(); ++k)
    if ((of_frame & ~of_body) >> k & 1) chain.push_back(k);
  const RobotDataPtr data = robot_.make_data(other_positions_);
  const auto [position, rotation] = scales(constraint.constraint);
  Eigen::VectorXd by_position = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(robot_.dof()));
  Eigen::VectorXd by_rotation = by_position;
  robot_.forward(*data, by_position);
  Eigen::Vector3d next = (robot_.link_pose(*data, constraint.link) * constraint.body).translation();
  double reach = 0.0;
  for (const std::size_t k : chain) {
    const ActuatedJoint& actuated = joints[k];
    const Joint& planned = robot_.joints()[actuated.joint];
    const Eigen::Vector3d origin = robot_.actuated_joint_axis(*data, k).first;
    reach += (next - origin).norm();
    next = origin;
    const double ratio = std::abs(actuated.ratio);
    if (actuated.prismatic) reach += ratio * std::max(std::abs(planned.lower), std::abs(planned.upper));
    const auto joint = static_cast<Eigen::Index>(actuated.joint);
    by_position[joint] += ratio * (actuated.prismatic ? 1.0 : reach) / position;
    by_rotation[joint] += ratio * (actuated.prismatic ? 0.0 : 1.0) / rotation;
  }
  return by_position.cwiseMax(by_rotation);
}

/// A link that turns by t on the way leaves the chord by about t^2 / 8, and moves a point 1 m away by as much.
double PlacedConstraints::step() const {
  double least = no_bound;
  for (const PlacedConstraint& constraint : constraints_) {
    const auto [position, rotation] = scales(constraint.constraint);
    least = std::min({least, position, rotation});
  }
  return std::clamp(std::sqrt(2.0 * least), 0.02, 0.7);
}

ConstraintChecker::ConstraintChecker(const PlacedConstraints& constraints)
    : constraints_(constraints),
      data_(constraints.robot().make_data(constraints.other_positions())),
      rows_(constraints.constraints().size()) {}

void ConstraintChecker::evaluate(const Eigen::VectorXd& q) {
  const RobotModel& robot = constraints_.robot();
  robot.forward(*data_, q);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const PlacedConstraint& c = constraints_.constraints()[i];
    const Eigen::Isometry3d body = robot.link_pose(*data_, c.link) * c.body;
    const Eigen::Isometry3d target = c.frame ? robot.link_pose(*data_, *c.frame) * c.target : c.target;
    rows_[i].clear();
    add_rows(c.constraint, target.inverse() * body, rows_[i]);
  }
}

void ConstraintChecker::deviations(const Eigen::VectorXd& q, std::vector<double>& out) {
  evaluate(q);
  out.clear();
  for (const std::vector<Row>& rows : rows_) {
    const Row& row = worst_row(rows);
    out.push_back(row.value / row.limit);
  }
}

std::vector<ConstraintDeviation> ConstraintChecker::none() const {
  std::vector<ConstraintDeviation> result;
  for (const PlacedConstraint& placed : constraints_.constraints())
    result.push_back({placed.text, 0.0, worst_tolerance(placed.constraint), 0.0});
  return result;
}

double ConstraintChecker::deviation(const Eigen::VectorXd& q) {
  evaluate(q);
  double largest = 0.0;
  for (const std::vector<Row>& rows : rows_)
    for (const Row& row : rows) largest = std::max(largest, row.value / row.limit);
  return largest;
}

std::string ConstraintChecker::violation(const Eigen::VectorXd& q) {
  evaluate(q);
  std::string text;
  double largest = 1.0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = worst_row(rows_[i]);
    if (row.value / row.limit <= largest) continue;
    largest = row.value / row.limit;
    const PlacedConstraint& c = constraints_.constraints()[i];
    const bool position = row.angular.isZero();
    text = "it breaks the constraint '" + c.text + "': it is off by " + amount(row.value, position) + ", " +
           amount(row.limit, position) + " are allowed";
  }
  return text;
}

bool ConstraintChecker::keeps(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double most) {
  const double at_a = deviation(a), at_b = deviation(b);
  if (std::max(at_a, at_b) > 1.0) return false;
  change_ = constraints_.robot().difference(a, b);
  bool all_second = true;
  for (std::size_t i = 0; i < rows_.size(); ++i) all_second &= has_second_order(constraints_, i);
  if (all_second) {
    SecondOrderProof proof(*this, a, change_, std::max({most, at_a, at_b}));
    return proof.keeps(0.0, 1.0, at_a, at_b);
  }
  halvings_ = 0;
  largest_rate_ = 0.0;
  for (const Eigen::VectorXd& rate : constraints_.rates())
    largest_rate_ = std::max(largest_rate_, rate.dot(change_.cwiseAbs()));
  return keeps_part(a, change_, 0.0, 1.0, at_a, at_b, std::max({most, at_a, at_b}));
}

bool ConstraintChecker::keeps_part(const Eigen::VectorXd& a, const Eigen::VectorXd& change, double from, double to,
                                   double at_from, double at_to, double most) {
  const double changes = largest_rate_ * (to - from);
  if (0.5 * (at_from + at_to + changes) <= most || changes <= smallest) return true;
  if (++halvings_ > most_halvings) return false;
  const double middle = 0.5 * (from + to);
  q_ = a + middle * change;
  const double at_middle = deviation(q_);
  if (at_middle > most) return false;
  return keeps_part(a, change, from, middle, at_from, at_middle, most) &&
         keeps_part(a, change, middle, to, at_middle, at_to, most);
}

ConstraintChecker::Sample ConstraintChecker::sample(std::span<const detail::Cubic> joints, double time) {
  q_.resize(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t j = 0; j < joints.size(); ++j) q_[static_cast<Eigen::Index>(j)] = joints[j].position(time);
  Sample result{time, {}};
  deviations(q_, result.deviations);
  return result;
}

void ConstraintChecker::add_part(std::span<const detail::Cubic> joints, const Sample& from, const Sample& to,
                                 double start, std::vector<ConstraintDeviation>& worst) {
  const double time = to.time - from.time, middle = 0.5 * (from.time + to.time);
  change_.resize(static_cast<Eigen::Index>(joints.size()));
  Eigen::VectorXd accelerated = change_;  // by how much a joint's change is not steady, at most
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const detail::Cubic& cubic = joints[j];
    const double acceleration =
        std::max(std::abs(cubic.acceleration(from.time)), std::abs(cubic.acceleration(to.time)));
    change_[static_cast<Eigen::Index>(j)] = time * (std::abs(cubic.velocity(middle)) + 0.5 * acceleration * time);
    accelerated[static_cast<Eigen::Index>(j)] = time * time * acceleration;
  }
  bool enough = true;
  std::vector<double> most(worst.size());
  for (std::size_t i = 0; i < worst.size(); ++i) {
    const Eigen::VectorXd& rates = constraints_.rates()[i];
    double changes = rates.dot(change_);
    most[i] = 0.5 * (from.deviations[i] + to.deviations[i] + changes);
    // Relative poses, which have tight tolerances, need the second order; others are as they always were.
    if (constraints_.constraints()[i].frame && std::max(from.deviations[i], to.deviations[i]) <= 1.5 &&
        (rates.array() > 0.0).select(change_, 0.0).sum() <= max_turn && has_second_order(constraints_, i)) {
      const double rise = second_order(rates, change_) + 0.125 * rates.dot(accelerated);
      most[i] = std::min(most[i], std::max(from.deviations[i], to.deviations[i]) + rise);
      changes = std::min(changes, rise);
    }
    const bool broken = std::max(from.deviations[i], to.deviations[i]) > 1.0 + certificate_fineness;
    enough &= most[i] * worst[i].tolerance <= worst[i].deviation || changes <= smallest ||
              (changes <= certificate_fineness && (most[i] <= 1.0 || broken));
  }
  if (enough || time <= smallest) {
    for (std::size_t i = 0; i < worst.size(); ++i)
      if (most[i] * worst[i].tolerance > worst[i].deviation) {
        worst[i].deviation = most[i] * worst[i].tolerance;
        worst[i].time = start + middle;
      }
    return;
  }
  const Sample between = sample(joints, middle);
  add_part(joints, from, between, start, worst);
  add_part(joints, between, to, start, worst);
}

void ConstraintChecker::add(std::span<const detail::Cubic> joints, double start,
                            std::vector<ConstraintDeviation>& worst) {
  add_part(joints, sample(joints, 0.0), sample(joints, joints.front().h), start, worst);
}

/// (6, dof): velocities of the body in the target's frame, along the target's axes.
Eigen::MatrixXd ConstraintChecker::relative_jacobian(std::size_t constraint) {
  const RobotModel& robot = constraints_.robot();
  const PlacedConstraint& c = constraints_.constraints()[constraint];
  const Eigen::Vector3d point = (robot.link_pose(*data_, c.link) * c.body).translation();
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(6, static_cast<Eigen::Index>(robot.dof())), of_link = result;
  const auto add = [&](std::size_t link, double sign) {
    robot.jacobian(*data_, link, of_link);
    const Eigen::Vector3d arm = point - robot.link_pose(*data_, link).translation();
    result.topRows(3) += sign * (of_link.topRows(3) - skew(arm) * of_link.bottomRows(3));
    result.bottomRows(3) += sign * of_link.bottomRows(3);
  };
  add(c.link, 1.0);
  if (c.frame) add(*c.frame, -1.0);
  const Eigen::Matrix3d axes = (c.frame ? robot.link_pose(*data_, *c.frame) * c.target : c.target).linear().transpose();
  result.topRows(3) = (axes * result.topRows(3)).eval();
  result.bottomRows(3) = (axes * result.bottomRows(3)).eval();
  return result;
}

/// From the configuration that was evaluated last; empty: no row is above `most`.
Eigen::VectorXd ConstraintChecker::newton_step(const Eigen::VectorXd& q, double most) {
  std::vector<Eigen::RowVectorXd> gradients;
  std::vector<double> errors;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (std::none_of(rows_[i].begin(), rows_[i].end(), [&](const Row& r) { return r.value > most * r.limit; }))
      continue;
    const Eigen::MatrixXd jacobian = relative_jacobian(i);
    for (const Row& row : rows_[i]) {
      if (row.value <= most * row.limit) continue;
      gradients.push_back(
          (row.linear.transpose() * jacobian.topRows(3) + row.angular.transpose() * jacobian.bottomRows(3)));
      errors.push_back(0.9 * most * row.limit - row.value);
    }
  }
  if (gradients.empty()) return {};
  Eigen::MatrixXd jacobian(std::ssize(gradients), q.size());
  for (Eigen::Index i = 0; i < jacobian.rows(); ++i) jacobian.row(i) = gradients[static_cast<std::size_t>(i)];
  const Eigen::Map<const Eigen::VectorXd> error(errors.data(), std::ssize(errors));
  Eigen::VectorXd step;
  for (Eigen::Index round = 0; round <= q.size(); ++round) {  // joints that would pass a limit are held
    Eigen::MatrixXd normal = jacobian * jacobian.transpose();
    normal.diagonal().array() += 1e-9 + 1e-3 * error.squaredNorm();
    step = jacobian.transpose() * normal.ldlt().solve(error);
    bool held = false;
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      const Joint& joint = constraints_.robot().joints()[static_cast<std::size_t>(j)];
      if ((q[j] > joint.lower || step[j] >= 0.0) && (q[j] < joint.upper || step[j] <= 0.0)) continue;
      jacobian.col(j).setZero();
      held = true;
    }
    if (!held) break;
  }
  return step * std::min(1.0, max_change / std::max(1e-300, step.cwiseAbs().maxCoeff()));
}

bool ConstraintChecker::project(Eigen::VectorXd& q, double most) {
  for (int i = 0; i < max_iterations; ++i) {
    evaluate(q);
    const Eigen::VectorXd step = newton_step(q, most);
    if (step.size() == 0) return true;
    q += step;
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      const Joint& joint = constraints_.robot().joints()[static_cast<std::size_t>(j)];
      q[j] = std::clamp(q[j], joint.lower, joint.upper);
    }
  }
  return false;
}

}  // namespace srmp
