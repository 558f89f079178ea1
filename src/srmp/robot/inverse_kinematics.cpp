#include "srmp/robot/inverse_kinematics.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <optional>

#include "srmp/core/error.hpp"
#include "srmp/core/low_discrepancy.hpp"
#include "srmp/robot/damped_least_squares.hpp"
#include "srmp/robot/distinct_configurations.hpp"

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

/// Of a tolerance [rad]: as DampedLeastSquares::tolerance.
double as_tangent(double angle) {
  return std::isinf(angle) ? angle : 4.0 * std::tan(std::min(angle, std::numbers::pi) / 4.0);
}

void copy(const Eigen::Isometry3d& frame, double* rotation, double* translation) {
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{rotation} = frame.linear();
  Eigen::Map<Eigen::Vector3d>{translation} = frame.translation();
}

/// Solves for one target.
class Solver {
 public:
  Solver(const RobotModel& robot, const Pose& target, const IkOptions& options, const std::string& link)
      : robot_(robot),
        target_(target.isometry()),
        options_(options),
        link_(robot.link_or_end_effector(link)),
        data_(robot.make_data(options.other_positions)),
        moves_link_(robot.dof(), false),
        whole_turns_(robot.dof(), true) {
    for (const Joint& joint : robot.joints()) {
      lower_.push_back(joint.lower);
      upper_.push_back(joint.upper);
    }
    for (const ActuatedJoint& actuated : robot.actuated_joints())
      if (actuated.prismatic || actuated.ratio != std::round(actuated.ratio)) whole_turns_[actuated.joint] = false;
    set_problem();
  }

  /// Seed 0 is the reference; joints that do not move the link always keep its value.
  Eigen::VectorXd seed(std::size_t index, ConstVector reference) const {
    Eigen::VectorXd q = within_limits(reference);
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

  /// The solutions from these seeds, no more than max_block; nullopt: none.
  std::vector<std::optional<Eigen::VectorXd>> solve(const std::vector<Eigen::VectorXd>& seeds) {
    static const DampedLeastSquaresFunction function = damped_least_squares(default_simd_backend());
    Eigen::MatrixXd columns(static_cast<Eigen::Index>(robot_.dof()), std::ssize(seeds));
    for (Eigen::Index i = 0; i < columns.cols(); ++i) columns.col(i) = seeds[static_cast<std::size_t>(i)];
    std::array<bool, max_block> reached;
    function(problem_, seeds.size(), columns.data(), reached.data());
    std::vector<std::optional<Eigen::VectorXd>> solutions(seeds.size());
    for (std::size_t i = 0; i < seeds.size(); ++i)
      if (reached[i]) solutions[i] = columns.col(static_cast<Eigen::Index>(i));
    return solutions;
  }

  /// Rotates joints by whole turns to the position nearest to the reference that is within the limits.
  void bring_near(ConstVector reference, Eigen::VectorXd& q) const {
    constexpr double full_turn = 2 * std::numbers::pi;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Joint& joint = robot_.joints()[static_cast<std::size_t>(i)];
      if (!whole_turns_[static_cast<std::size_t>(i)]) continue;
      double value = reference[i] + std::remainder(q[i] - reference[i], full_turn);
      if (value < joint.lower) value += full_turn;
      if (value > joint.upper) value -= full_turn;
      if (value >= joint.lower && value <= joint.upper) q[i] = value;
    }
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

  Eigen::VectorXd within_limits(ConstVector q) const { return q.cwiseMax(map(lower_)).cwiseMin(map(upper_)); }

  static bool within(const Eigen::Vector3d& error, const AxisTolerance& tolerance) {
    return (error.array().abs() <= tolerance.axes.array()).all();
  }

  /// Lists the joints that move the link: their axes and the link are seen where all joints are at 0.
  void set_problem() {
    robot_.forward(*data_, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(robot_.dof())));
    Eigen::Isometry3d before = target_;
    for (std::uint64_t support = robot_.link_support(link_); support != 0; support &= support - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(support));
      const ActuatedJoint& actuated = robot_.actuated_joints()[k];
      moves_link_[actuated.joint] = true;
      const auto [point, axis] = robot_.actuated_joint_axis(*data_, k);
      Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
      const Eigen::Vector3d beside = axis.unitOrthogonal();
      frame.linear() << beside, axis.cross(beside), axis;
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
    for (int axis = 0; axis < 3; ++axis)
      problem_.tolerance[3 + axis] = as_tangent(options_.rotation_tolerance.axes[axis]);
    problem_.max_iterations = options_.max_iterations;
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

  const RobotModel& robot_;
  const Eigen::Isometry3d target_;
  const IkOptions& options_;
  const std::size_t link_;
  RobotDataPtr data_;
  std::vector<bool> moves_link_;   // by joint
  std::vector<bool> whole_turns_;  // by joint: does a whole turn leave all link poses unchanged?
  std::vector<double> lower_, upper_;
  std::vector<ChainJoint> chain_;
  DampedLeastSquares problem_{};
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
  require_finite(target.to_list(), "target");
  Solver solver(robot, target, options, link);
  DistinctConfigurations solutions(robot, options.distinct);
  const auto count = static_cast<std::size_t>(options.seeds), enough = static_cast<std::size_t>(options.max_solutions);
  const Eigen::VectorXd first = solver.seed(0, reference);
  for (std::size_t i = 0; i < count && solutions.size() < enough && !deadline.stop_requested();) {
    std::vector<Eigen::VectorXd> seeds;
    for (const std::size_t end = std::min(i + std::clamp(enough, min_block, max_block), count); i < end; ++i)
      seeds.push_back(solver.seed(i, reference));
    for (std::optional<Eigen::VectorXd>& q : solver.solve(seeds)) {
      if (!q || solutions.size() == enough) continue;
      solver.bring_near(first, *q);
      if (!solutions.has_one_close_to(*q) && solver.arrives(*q)) solutions.add(*std::move(q));
    }
  }
  return solutions.take_nearest_first(reference);
}

std::vector<std::optional<Eigen::VectorXd>> inverse_kinematics_from(const RobotModel& robot, const Pose& target,
                                                                    const std::vector<Eigen::VectorXd>& references,
                                                                    const IkOptions& options, const std::string& link) {
  require_options(options);
  for (const Eigen::VectorXd& reference : references) robot.require_configuration(reference, "reference");
  require_finite(target.to_list(), "target");
  std::vector<std::optional<Eigen::VectorXd>> solutions;
  if (references.empty()) return solutions;
  Solver solver(robot, target, options, link);
  for (std::size_t i = 0; i < references.size();) {
    std::vector<Eigen::VectorXd> seeds;
    for (const std::size_t end = std::min(i + max_block, references.size()); i < end; ++i)
      seeds.push_back(solver.seed(0, references[i]));
    for (std::optional<Eigen::VectorXd>& q : solver.solve(seeds)) {
      if (q) solver.bring_near(references[solutions.size()], *q);
      if (q && !solver.arrives(*q)) q.reset();
      solutions.push_back(std::move(q));
    }
  }
  return solutions;
}

}  // namespace srmp
