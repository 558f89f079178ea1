#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "srmp/robot/robot_model.hpp"
#include "srmp/trajectory/cubic.hpp"
#include "srmp/trajectory/path_constraint.hpp"

namespace srmp {

/// A path constraint whose names were looked up.
struct PlacedConstraint {
  PathConstraint constraint;         ///< `target` is not used
  std::size_t link{};                ///< of the robot
  Eigen::Isometry3d body;            ///< in the link's frame: the constrained frame, at the constrained point
  std::optional<std::size_t> frame;  ///< link of the robot, in whose frame `target` is; none: its base
  Eigen::Isometry3d target;          ///< in that frame
  std::string text;                  ///< ConstraintDeviation::constraint
};

/// The path constraints of one robot, and how fast its joints can change what they bound. Immutable; threads share it,
/// each with a ConstraintChecker of its own.
class PlacedConstraints {
 public:
  /// The model outlives this. At least one constraint.
  PlacedConstraints(const RobotModel& robot, const Eigen::VectorXd& other_positions,
                    std::vector<PlacedConstraint> constraints);

  const RobotModel& robot() const { return robot_; }
  const Eigen::VectorXd& other_positions() const { return other_positions_; }
  const std::vector<PlacedConstraint>& constraints() const { return constraints_; }
  /// (dof,) by constraint: the fraction of its tolerance by which a unit of each joint changes it, at most.
  const std::vector<Eigen::VectorXd>& rates() const { return rates_; }
  /// [rad, prismatic joints m]: straight motions of this length between configurations on the constraints mostly
  /// remain within half of the tolerances.
  double step() const;

 private:
  Eigen::VectorXd rate(const PlacedConstraint& constraint) const;

  const RobotModel& robot_;
  const Eigen::VectorXd other_positions_;
  const std::vector<PlacedConstraint> constraints_;
  std::vector<Eigen::VectorXd> rates_;
};

/// Evaluates path constraints, with the scratch memory of one thread. Deviations are fractions of what is allowed.
///
/// What lies between two configurations is proved: a constraint's deviation changes by no more than its rates times the
/// change of the joints, so over a part of a motion it is at most half of the sum of its values at both ends and of
/// what the joints can change it by in the part. Parts are halved until that is enough.
class ConstraintChecker {
 public:
  explicit ConstraintChecker(const PlacedConstraints& constraints);

  const PlacedConstraints& constraints() const { return constraints_; }
  /// One for each constraint, with a deviation of 0.
  std::vector<ConstraintDeviation> none() const;
  /// The largest of all constraints: above 1, one is broken.
  double deviation(const Eigen::VectorXd& q);
  /// Which constraint is broken most at q and by how much, as the end of a sentence; "": none.
  std::string violation(const Eigen::VectorXd& q);
  /// Whether the straight joint-space motion from a to b is proved to stay within `most`, or within what its ends have
  /// if that is more, but never above 1. Ends unproved after 20 000 halvings, so that it takes milliseconds.
  bool keeps(const Eigen::VectorXd& a, const Eigen::VectorXd& b, double most);
  /// Raises `worst`, one entry a constraint, to what is proved of a motion of all joints, each along its cubic from
  /// `start` [s] on.
  void add(std::span<const detail::Cubic> joints, double start, std::vector<ConstraintDeviation>& worst);
  /// Moves q onto the constraints, to a deviation of at most `most`, within the joint limits, by Newton's method on
  /// those that are broken (damped least squares); false: it does not converge.
  bool project(Eigen::VectorXd& q, double most);

  /// One bound of a constraint: `value` is to be at most `limit`.
  struct Row {
    double value, limit;
    Eigen::Vector3d linear, angular;  ///< gradient along the target's axes, by the body's velocities
  };

 private:
  void evaluate(const Eigen::VectorXd& q);  // into rows_
  void deviations(const Eigen::VectorXd& q, std::vector<double>& out);
  bool keeps_part(const Eigen::VectorXd& a, const Eigen::VectorXd& change, double from, double to, double at_from,
                  double at_to, double most);
  struct Sample {
    double time;
    std::vector<double> deviations;
  };
  Sample sample(std::span<const detail::Cubic> joints, double time);
  void add_part(std::span<const detail::Cubic> joints, const Sample& from, const Sample& to, double start,
                std::vector<ConstraintDeviation>& worst);
  Eigen::VectorXd newton_step(const Eigen::VectorXd& q, double most);
  Eigen::MatrixXd relative_jacobian(std::size_t constraint);

  const PlacedConstraints& constraints_;
  RobotDataPtr data_;
  std::vector<std::vector<Row>> rows_;  // by constraint
  Eigen::VectorXd q_, change_;
  double largest_rate_{};  // of a motion: what all of it changes a deviation by, at most
  int halvings_{0};        // of a motion, so far
};

}  // namespace srmp
