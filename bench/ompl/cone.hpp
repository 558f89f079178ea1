#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "planners.hpp"
#include "srmp/core/error.hpp"
#include "srmp/planning/constraints/place_constraints.hpp"

namespace bench {

/// PathConstraint::cone for OMPL. The error is the rotation from the direction to the axis, about the two directions
/// across the former: its length is the angle between them.
class Cone final : public Constraint {
 public:
  Cone(const srmp::Scene& scene, const std::string& robot, const srmp::PathConstraint& cone)
      : placed_(srmp::place_constraints(scene, robot, {cone})),
        cone_(placed_->constraints().front()),
        data_(placed_->robot().make_data(placed_->other_positions())) {
    if (cone.type != srmp::PathConstraintType::cone || cone_.frame)
      throw srmp::InvalidArgument("OMPL's planners keep only a cone in a frame that stands still, not '" + cone_.text +
                                  "'");
  }

  Eigen::Index size() const override { return 2; }
  double tolerance() const override { return cone_.constraint.tolerance; }

  void error(const Eigen::VectorXd& q, Eigen::Ref<Eigen::VectorXd> out) override {
    const Eigen::Vector3d axis = axis_at(q);
    out = Angle(axis).by_sine * axis.head<2>();
  }

  void jacobian(const Eigen::VectorXd& q, Eigen::Ref<Eigen::MatrixXd> out) override {
    const Eigen::Vector3d axis = axis_at(q);
    Eigen::MatrixXd of_link(6, q.size());
    placed_->robot().jacobian(*data_, cone_.link, of_link);
    const Eigen::MatrixXd turns = cone_.target.linear().transpose() * of_link.bottomRows(3);
    Eigen::Matrix3Xd moves(3, q.size());  // of the axis
    for (Eigen::Index j = 0; j < q.size(); ++j) moves.col(j) = turns.col(j).head<3>().cross(axis);
    const Angle angle(axis);
    out = angle.by_sine * moves.topRows<2>() + angle.change * axis.head<2>() * moves.row(2);
  }

 private:
  /// Between a unit vector and z.
  struct Angle {
    explicit Angle(const Eigen::Vector3d& axis) {
      const double sine = std::hypot(axis.x(), axis.y());
      if (sine < 1e-4 && axis.z() > 0.0) return;
      by_sine = std::atan2(sine, axis.z()) / std::max(sine, 1e-9);
      change = (by_sine * axis.z() - 1.0) / std::max(sine * sine, 1e-9);
    }
    double by_sine{1.0};        // the angle over its sine
    double change{-1.0 / 3.0};  // derivative of that by the cosine
  };

  /// Of the link, in the target's frame.
  Eigen::Vector3d axis_at(const Eigen::VectorXd& q) {
    placed_->robot().forward(*data_, q);
    const Eigen::Matrix3d body = (placed_->robot().link_pose(*data_, cone_.link) * cone_.body).linear();
    return cone_.target.linear().transpose() * body * cone_.constraint.axis;
  }

  std::shared_ptr<const srmp::PlacedConstraints> placed_;
  const srmp::PlacedConstraint& cone_;
  srmp::RobotDataPtr data_;
};

}  // namespace bench
