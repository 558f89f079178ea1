#include "srmp/robot/inverse_kinematics.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "srmp/core/error.hpp"
#include "srmp/core/low_discrepancy.hpp"

namespace srmp {

namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr double kMaxStep = 0.5;  // [rad or m] largest change of a joint in one step, because the Jacobian is local
constexpr double kMinDamping = 1e-9;
constexpr int kPatience = 6;     // a seed is abandoned after this many steps without progress: 1 in 100 would arrive
constexpr int kPolishSteps = 3;  // after the tolerance is met, where convergence is quadratic

/// The rotation vector of `rotation` [rad], at most pi long.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  return sine < 1e-12 ? Eigen::Vector3d(2 * q.vec()) : Eigen::Vector3d(q.vec() * (2 * std::atan2(sine, q.w()) / sine));
}

/// Solves from one seed at a time.
class Solver {
 public:
  Solver(const RobotModel& robot, const Pose& target, ConstVector reference, const IkOptions& options, std::size_t link)
      : robot_(robot),
        target_(target.isometry()),
        options_(options),
        link_(link),
        data_(robot.make_data(options.other_positions)),
        jacobian_(6, reference.size()),
        step_(reference.size()),
        reference_(reference),
        moves_link_(robot.dof(), false),
        whole_turns_(robot.dof(), true) {
    for (std::size_t k = 0; k < robot.actuated_joints().size(); ++k) {
      const ActuatedJoint& actuated = robot.actuated_joints()[k];
      if (robot.link_support(link) >> k & 1) moves_link_[actuated.joint] = true;
      if (actuated.prismatic || actuated.ratio != std::round(actuated.ratio)) whole_turns_[actuated.joint] = false;
    }
    project(reference_);
  }

  const Eigen::VectorXd& reference() const { return reference_; }

  /// Seed 0 is the reference; joints that do not move the link always keep its value.
  Eigen::VectorXd seed(std::size_t index) const {
    Eigen::VectorXd q = reference_;
    if (index == 0) return q;
    const Eigen::VectorXd unit = low_discrepancy_point(index, q.size());
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Joint& joint = robot_.joints()[static_cast<std::size_t>(i)];
      if (!moves_link_[static_cast<std::size_t>(i)]) continue;
      q[i] = joint.kind == JointKind::continuous ? (2 * unit[i] - 1) * std::numbers::pi
                                                 : joint.lower + unit[i] * (joint.upper - joint.lower);
    }
    return q;
  }

  std::optional<Eigen::VectorXd> solve(Eigen::VectorXd q) {
    double best = std::numeric_limits<double>::infinity();
    int since_best = 0, polished = 0;
    std::optional<Eigen::VectorXd> solution;
    double solution_error = std::numeric_limits<double>::infinity();
    for (int i = 0; i < options_.max_iterations || (solution && polished < kPolishSteps); ++i) {
      const double error = evaluate(q);
      if (!std::isfinite(error)) break;
      if (within_tolerance() && error < solution_error) {
        solution = q;
        solution_error = error;
      }
      if (solution && polished++ == kPolishSteps) break;
      since_best = error < 0.999 * best ? 0 : since_best + 1;
      best = std::min(best, error);
      if (since_best > kPatience) break;
      advance(q);
    }
    if (solution) bring_near_reference(*solution);
    return solution;
  }

 private:
  /// Computes the error and the Jacobian at q along the target's axes, with zeros for free axes; returns the norm of
  /// the error.
  double evaluate(const Eigen::VectorXd& q) {
    robot_.forward(*data_, q);
    const Eigen::Isometry3d pose = robot_.link_pose(*data_, link_);
    robot_.jacobian(*data_, link_, jacobian_);
    const Eigen::Matrix3d to_target = target_.linear().transpose();
    jacobian_.topRows<3>() = to_target * jacobian_.topRows<3>();
    jacobian_.bottomRows<3>() = to_target * jacobian_.bottomRows<3>();
    error_.head<3>() = to_target * (target_.translation() - pose.translation());
    error_.tail<3>() = to_target * rotation_error(pose.linear());
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (options_.position_tolerance.is_free(axis)) error_[axis] = 0, jacobian_.row(axis).setZero();
      if (options_.rotation_tolerance.is_free(axis)) error_[3 + axis] = 0, jacobian_.row(3 + axis).setZero();
    }
    return error_.norm();
  }

  /// The rotation vector [rad] from the current to the target orientation. Where exactly one axis is free, the shortest
  /// rotation that aligns this axis.
  Eigen::Vector3d rotation_error(const Eigen::Matrix3d& rotation) const {
    Eigen::Index free = -1;
    int count = 0;
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      if (options_.rotation_tolerance.is_free(axis)) {
        free = axis;
        ++count;
      }
    if (count == 3) return Eigen::Vector3d::Zero();
    if (count != 1) return rotation_vector(target_.linear() * rotation.transpose());
    const Eigen::Vector3d current = rotation.col(free), required = target_.linear().col(free);
    const Eigen::Vector3d axis = current.cross(required);
    const double sine = axis.norm(), cosine = current.dot(required);
    if (sine > 1e-12) return axis * (std::atan2(sine, cosine) / sine);
    return cosine > 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(std::numbers::pi * current.unitOrthogonal());
  }

  bool within_tolerance() const {
    return (error_.head<3>().array().abs() <= options_.position_tolerance.axes.array()).all() &&
           (error_.tail<3>().array().abs() <= options_.rotation_tolerance.axes.array()).all();
  }

  /// One damped step within the limits. Joints that the step would move beyond a limit are held, and the step is solved
  /// again for the other joints.
  void advance(Eigen::VectorXd& q) {
    for (Eigen::Index round = 0; round <= q.size(); ++round) {
      damped_step();
      bool held = false;
      for (Eigen::Index i = 0; i < q.size(); ++i) {
        const Joint& joint = robot_.joints()[static_cast<std::size_t>(i)];
        if ((q[i] <= joint.lower && step_[i] < 0) || (q[i] >= joint.upper && step_[i] > 0)) {
          jacobian_.col(i).setZero();
          held = true;
        }
      }
      if (!held) break;
    }
    const double max_change = step_.cwiseAbs().maxCoeff();
    q += step_ * std::min(1.0, kMaxStep / std::max(max_change, 1e-300));
    project(q);
  }

  /// step = J^T (J J^T + damping)^-1 error, the damping falling with the error (Sugihara 2011).
  void damped_step() {
    Matrix6d normal = jacobian_ * jacobian_.transpose();
    normal.diagonal().array() += 0.05 * error_.squaredNorm() + kMinDamping;
    step_.noalias() = jacobian_.transpose() * normal.llt().solve(error_);
  }

  void project(Eigen::VectorXd& q) const {
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Joint& joint = robot_.joints()[static_cast<std::size_t>(i)];
      q[i] = std::clamp(q[i], joint.lower, joint.upper);
    }
  }

  /// Rotates joints by whole turns to the position nearest to the reference that is within the limits.
  void bring_near_reference(Eigen::VectorXd& q) const {
    constexpr double full_turn = 2 * std::numbers::pi;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Joint& joint = robot_.joints()[static_cast<std::size_t>(i)];
      if (!whole_turns_[static_cast<std::size_t>(i)]) continue;
      double value = reference_[i] + std::remainder(q[i] - reference_[i], full_turn);
      if (value < joint.lower) value += full_turn;
      if (value > joint.upper) value -= full_turn;
      if (value >= joint.lower && value <= joint.upper) q[i] = value;
    }
  }

  const RobotModel& robot_;
  const Eigen::Isometry3d target_;
  const IkOptions& options_;
  const std::size_t link_;
  RobotDataPtr data_;
  Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian_;
  Vector6d error_{Vector6d::Zero()};
  Eigen::VectorXd step_;
  Eigen::VectorXd reference_;
  std::vector<bool> moves_link_;   // by joint
  std::vector<bool> whole_turns_;  // by joint: does a whole turn leave all link poses unchanged?
};

void require_options(const IkOptions& o) {
  const auto require_count = [](int value, const char* name) {
    if (value <= 0) throw InvalidArgument(std::string(name) + " is " + std::to_string(value) + "; it must be above 0");
  };
  require_count(o.max_solutions, "max_solutions");
  require_count(o.seeds, "seeds");
  require_count(o.max_iterations, "max_iterations");
  o.position_tolerance.validate("position_tolerance");
  o.rotation_tolerance.validate("rotation_tolerance");
  if (o.position_tolerance.axes.array().isInf().all() && o.rotation_tolerance.axes.array().isInf().all())
    throw InvalidArgument(
        "position_tolerance and rotation_tolerance leave every axis free; at least one must be bounded");
  if (!(o.distinct >= 0.0 && std::isfinite(o.distinct)))
    throw InvalidArgument("distinct is " + to_text(o.distinct) + "; it must be a finite number, 0 or above");
}

}  // namespace

AxisTolerance AxisTolerance::tightened(double value) const {
  AxisTolerance result = *this;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    if (!is_free(axis)) result.axes[axis] = std::min(value, axes[axis]);
  return result;
}

void AxisTolerance::validate(const std::string& what) const {
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    if (!(axes[axis] > 0))
      throw InvalidArgument(what + " is " + to_text(axes[axis]) +
                            (axes == Eigen::Vector3d::Constant(axes[axis]) ? "" : std::string(" for ") + "xyz"[axis]) +
                            "; it must be above 0 (infinity: the axis is free)");
}

std::vector<Eigen::VectorXd> inverse_kinematics(const RobotModel& robot, const Pose& target, ConstVector reference,
                                                const IkOptions& options, const std::string& link,
                                                const Deadline& deadline) {
  require_options(options);
  robot.require_configuration(reference, "reference");
  const auto pose = target.to_list();
  require_finite(pose, "target");
  Solver solver(robot, target, reference, options, robot.link_or_end_effector(link));

  std::vector<Eigen::VectorXd> solutions;
  for (int i = 0; i < options.seeds && !deadline.stop_requested(); ++i) {
    const auto q = solver.solve(solver.seed(static_cast<std::size_t>(i)));
    if (!q) continue;
    const bool is_new = std::none_of(solutions.begin(), solutions.end(), [&](const Eigen::VectorXd& other) {
      return robot.difference(other, *q).cwiseAbs().maxCoeff() < options.distinct;
    });
    if (!is_new) continue;
    solutions.push_back(*q);
    if (static_cast<int>(solutions.size()) == options.max_solutions) break;
  }
  const auto distance = [&](const Eigen::VectorXd& q) { return robot.difference(reference, q).norm(); };
  std::stable_sort(solutions.begin(), solutions.end(),
                   [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return distance(a) < distance(b); });
  return solutions;
}

}  // namespace srmp
