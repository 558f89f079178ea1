#include "srmp/robot/inverse_kinematics.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <memory>
#include <numbers>

#include "srmp/core/error.hpp"
#include "srmp/core/low_discrepancy.hpp"
#include "srmp/robot/damped_least_squares.hpp"

namespace srmp {

namespace {

constexpr std::size_t min_block = 8, max_block = 64;  // seeds that are solved side by side

/// The rotation vector of `rotation` [rad], at most pi long.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
  Eigen::Quaterniond q(rotation);
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  return sine < 1e-12 ? Eigen::Vector3d(2 * q.vec()) : Eigen::Vector3d(q.vec() * (2 * std::atan2(sine, q.w()) / sine));
}

void copy(const Eigen::Isometry3d& frame, double* rotation, double* translation) {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{rotation} = frame.linear();
  Eigen::Map<Eigen::Vector3d>{translation} = frame.translation();
}

class Solver {
 public:
  Solver(const RobotModel& robot, const Pose& target, ConstVector reference, const IkOptions& options, std::size_t link)
      : robot_(robot),
        target_(target.isometry()),
        options_(options),
        link_(link),
        data_(robot.make_data(options.other_positions)),
        reference_(reference),
        moves_link_(robot.dof(), false),
        whole_turns_(robot.dof(), true) {
    for (const Joint& joint : robot.joints()) {
      lower_.push_back(joint.lower);
      upper_.push_back(joint.upper);
    }
    reference_ = reference_.cwiseMax(map(lower_)).cwiseMin(map(upper_));
    for (const ActuatedJoint& actuated : robot.actuated_joints())
      if (actuated.prismatic || actuated.ratio != std::round(actuated.ratio)) whole_turns_[actuated.joint] = false;
    set_problem();
  }

  const Eigen::VectorXd& reference() const { return reference_; }

  /// Solutions from `count` seeds on, in their order.
  std::vector<Eigen::VectorXd> solve(std::size_t first, std::size_t count) {
    static const DampedLeastSquaresFunction function = damped_least_squares(default_simd_backend());
    const auto dof = static_cast<Eigen::Index>(robot_.dof());
    configurations_.resize(dof, static_cast<Eigen::Index>(count));
    for (std::size_t i = 0; i < count; ++i) configurations_.col(static_cast<Eigen::Index>(i)) = seed(first + i);
    function(problem_, count, configurations_.data(), reached_.data());
    std::vector<Eigen::VectorXd> solutions;
    for (std::size_t i = 0; i < count; ++i) {
      if (!reached_[i]) continue;
      solutions.emplace_back(configurations_.col(static_cast<Eigen::Index>(i)));
      bring_near_reference(solutions.back());
    }
    return solutions;
  }

  /// Does Pinocchio say that q is within the tolerances?
  bool arrives(const Eigen::VectorXd& q) {
    robot_.forward(*data_, q);
    const Eigen::Isometry3d pose = robot_.link_pose(*data_, link_);
    const Eigen::Matrix3d to_target = target_.linear().transpose();
    const Eigen::Vector3d position = to_target * (target_.translation() - pose.translation());
    const Eigen::Vector3d rotation = to_target * rotation_error(pose.linear());
    return within(position, options_.position_tolerance) && within(rotation, options_.rotation_tolerance);
  }

 private:
  static Eigen::Map<const Eigen::VectorXd> map(const std::vector<double>& values) {
    return {values.data(), static_cast<Eigen::Index>(values.size())};
  }

  static bool within(const Eigen::Vector3d& error, const AxisTolerance& tolerance) {
    return (error.array().abs() <= tolerance.axes.array()).all();
  }

  /// Lists the joints that move the link: their axes and the link are seen where all joints are at 0.
  void set_problem() {
    robot_.forward(*data_, Eigen::VectorXd::Zero(reference_.size()));
    Eigen::Isometry3d before = target_;
    for (std::uint64_t support = robot_.link_support(link_); support != 0; support &= support - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(support));
      const ActuatedJoint& actuated = robot_.actuated_joints()[k];
      moves_link_[actuated.joint] = true;
      const auto [point, axis] = robot_.actuated_joint_axis(*data_, k);
      Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
      frame.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
      frame.translation() = point;
      ChainJoint& joint = chain_.emplace_back();
      copy(before.inverse() * frame, joint.rotation, joint.translation);
      joint.ratio = actuated.ratio;
      joint.planned = actuated.joint;
      joint.prismatic = actuated.prismatic;
      before = frame;
    }
    copy(before.inverse() * robot_.link_pose(*data_, link_), problem_.end_rotation, problem_.end_translation);
    problem_.joints = chain_.data();
    problem_.joint_count = chain_.size();
    problem_.lower = lower_.data();
    problem_.upper = upper_.data();
    problem_.planned_count = robot_.dof();
    Eigen::Map<Eigen::Vector3d>{problem_.tolerance} = options_.position_tolerance.axes;
    Eigen::Map<Eigen::Vector3d>{problem_.tolerance + 3} = options_.rotation_tolerance.axes;
    problem_.max_iterations = options_.max_iterations;
  }

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
  Eigen::VectorXd reference_;
  std::vector<bool> moves_link_;   // by joint
  std::vector<bool> whole_turns_;  // by joint: does a whole turn leave all link poses unchanged?
  std::vector<double> lower_, upper_;
  std::vector<ChainJoint> chain_;
  DampedLeastSquares problem_{};
  Eigen::MatrixXd configurations_;  // a column each
  std::array<bool, max_block> reached_{};
};

/// Does no joint differ by `distance` [rad or m] or more?
bool are_close(const RobotModel& robot, const Eigen::VectorXd& a, const Eigen::VectorXd& b, double distance) {
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    double change = b[i] - a[i];
    if (robot.joints()[static_cast<std::size_t>(i)].kind == JointKind::continuous)
      change = std::remainder(change, 2 * std::numbers::pi);
    if (!(std::abs(change) < distance)) return false;
  }
  return true;
}

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
  const auto seeds = static_cast<std::size_t>(options.seeds), enough = static_cast<std::size_t>(options.max_solutions);
  const std::size_t block = std::clamp(enough, min_block, max_block);
  const auto is_new = [&](const Eigen::VectorXd& q) {
    return std::none_of(solutions.begin(), solutions.end(),
                        [&](const Eigen::VectorXd& other) { return are_close(robot, other, q, options.distinct); });
  };
  for (std::size_t i = 0; i < seeds && solutions.size() < enough && !deadline.stop_requested(); i += block)
    for (const Eigen::VectorXd& q : solver.solve(i, std::min(block, seeds - i)))
      if (solutions.size() < enough && is_new(q) && solver.arrives(q)) solutions.push_back(q);
  const auto distance = [&](const Eigen::VectorXd& q) { return robot.difference(reference, q).norm(); };
  std::stable_sort(solutions.begin(), solutions.end(),
                   [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return distance(a) < distance(b); });
  return solutions;
}

}  // namespace srmp
