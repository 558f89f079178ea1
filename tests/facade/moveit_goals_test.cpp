#include "srmp/facade/moveit_goals.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "support/data.hpp"

using namespace srmp;

namespace {

constexpr double kFree = std::numeric_limits<double>::infinity();

/// MoveIt's own rule (OrientationConstraint::decide): does the rotation between the required and the actual
/// orientation, in the required frame, keep the tolerances? `required` is the orientation in the constraint's header.
bool moveit_accepts(const io::OrientationConstraint& constraint, const Eigen::Matrix3d& difference) {
  Eigen::Vector3d error;
  if (constraint.rotation_vector) {
    const Eigen::AngleAxisd turn(difference);
    error = (constraint.orientation * (turn.axis() * turn.angle())).cwiseAbs();
  } else {
    error = {std::abs(std::atan2(-difference(1, 2), difference(2, 2))), std::abs(std::asin(difference(0, 2))),
             std::abs(std::atan2(-difference(0, 1), difference(0, 0)))};
  }
  return (error.array() <= constraint.tolerance.array() + 1e-9).all();
}

struct Draw {
  std::mt19937 random{7};
  double between(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(random); }
  Eigen::Quaterniond rotation() {
    return Eigen::Quaterniond(between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)).normalized();
  }
  /// A rotation by quarter turns.
  Eigen::Quaterniond quarter_turns() {
    const auto turn = [&](const Eigen::Vector3d& axis) {
      return Eigen::AngleAxisd(std::floor(between(0, 4)) * std::numbers::pi / 2, axis);
    };
    return Eigen::Quaterniond(turn(Eigen::Vector3d::UnitX()) * turn(Eigen::Vector3d::UnitY()) *
                              turn(Eigen::Vector3d::UnitZ()));
  }
};

/// A rotation of the end effector that inverse kinematics accepts: at the edge of the tolerances, or anywhere in them.
/// A free axis is first turned about at will, then tilted by what the other two allow.
Eigen::Matrix3d accepted_rotation(const Eigen::Vector3d& tolerance, Draw& draw) {
  Eigen::Vector3d tilt;
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double part = draw.between(-1, 1);
    tilt[axis] =
        std::isinf(tolerance[axis]) ? 0.0 : tolerance[axis] * (std::abs(part) > 0.5 ? std::copysign(1, part) : part);
    if (std::isinf(tolerance[axis]))
      turned = Eigen::AngleAxisd(draw.between(-std::numbers::pi, std::numbers::pi), Eigen::Vector3d::Unit(axis))
                   .toRotationMatrix();
  }
  const double angle = tilt.norm();
  if (angle == 0.0) return turned;
  return Eigen::AngleAxisd(angle, tilt / angle).toRotationMatrix() * turned;
}

/// A rotation of the link from the target of a path constraint that keeps it: at its edge, or anywhere in it.
Eigen::Matrix3d kept_rotation(const PathConstraint& constraint, Draw& draw) {
  const double part = draw.between(0, 1) < 0.5 ? 1.0 : draw.between(0, 1);
  const Eigen::Vector3d any = Eigen::Vector3d(draw.between(-1, 1), draw.between(-1, 1), draw.between(-1, 1));
  if (constraint.type == PathConstraintType::cone) {  // the axis tilted from the direction, and turned about it
    const Eigen::Vector3d direction = constraint.target.q * Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d tilted =
        Eigen::AngleAxisd(part * constraint.tolerance, direction.cross(any).normalized()) * direction;
    return Eigen::AngleAxisd(draw.between(-3.1, 3.1), tilted) *
           Eigen::Quaterniond::FromTwoVectors(constraint.axis, tilted).toRotationMatrix();
  }
  Eigen::Vector3d turn = any;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double most = constraint.rotation_tolerance.axes[axis];
    turn[axis] *= std::isinf(most) ? 3.0 : most * (part == 1.0 ? 1.0 / std::abs(any[axis]) : 1.0);
  }
  if (turn.norm() > 3.1) turn *= 3.1 / turn.norm();
  return constraint.target.q.toRotationMatrix() * Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
}

}  // namespace

BOOST_AUTO_TEST_CASE(what_keeps_a_path_constraint_keeps_that_of_moveit) {
  Scene scene;
  const auto model = RobotModel::load(arm7());
  scene.add_robot(model);
  const io::FrameLookup frames(scene, {}, model->name());
  Draw draw;
  std::map<PathConstraintType, int> seen;
  for (int i = 0; i < 2000; ++i) {
    io::RequestFile request;
    io::OrientationConstraint constraint;
    constraint.link = i % 5 == 0 ? "arm7_elbow" : "arm7_hand";
    constraint.frame = i % 7 == 0 ? "arm7_shoulder" : "";
    constraint.rotation_vector = i % 2 == 0;
    constraint.orientation = i % 3 == 0 ? draw.rotation() : draw.quarter_turns();
    for (double& tolerance : constraint.tolerance)
      tolerance = draw.between(0, 1) < 0.4 ? draw.between(3.0, 7.0) : std::pow(10.0, draw.between(-4, 0.3));
    if (allows_all(constraint)) continue;
    request.path_constraints.orientations = {constraint};
    const PathConstraint kept = moveit_path_constraints(request, scene, frames, model->name()).at(0);
    kept.validate();
    ++seen[kept.type];
    BOOST_REQUIRE(kept.link == constraint.link);
    for (int k = 0; k < 20; ++k) {
      const Eigen::Matrix3d difference =
          constraint.orientation.toRotationMatrix().transpose() * kept_rotation(kept, draw);
      BOOST_REQUIRE_MESSAGE(moveit_accepts(constraint, difference), "tolerances " << constraint.tolerance.transpose());
    }
  }
  BOOST_TEST(seen[PathConstraintType::cone] > 100);
  BOOST_TEST(seen[PathConstraintType::orientation] > 100);
}

BOOST_AUTO_TEST_CASE(a_box_within_a_turned_box) {
  Draw draw;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d outer(draw.between(0.01, 1), draw.between(0.01, 1), draw.between(0.01, 1));
    const Eigen::Matrix3d axes = draw.rotation().toRotationMatrix();
    const Eigen::Vector3d inner = inner_box(axes, outer);
    BOOST_TEST((inner.array() > 0.0).all());
    const Eigen::Vector3d reach = axes.cwiseAbs() * inner;
    BOOST_TEST((reach.array() <= outer.array() * (1.0 + 1e-12)).all());
    BOOST_TEST((reach.array() / outer.array()).maxCoeff() > 1.0 - 1e-9);  // it cannot be larger
  }
  const Eigen::Matrix3d swapped = Eigen::Vector3d(0, 0, 1) * Eigen::RowVector3d(1, 0, 0) +
                                  Eigen::Vector3d(1, 0, 0) * Eigen::RowVector3d(0, 1, 0) +
                                  Eigen::Vector3d(0, 1, 0) * Eigen::RowVector3d(0, 0, 1);
  BOOST_TEST((inner_box(swapped, {1, 2, 3}) - Eigen::Vector3d(3, 1, 2)).norm() < 1e-12);
}

BOOST_AUTO_TEST_CASE(what_inverse_kinematics_accepts_moveit_accepts) {
  Draw draw;
  int free_axes = 0;
  for (int i = 0; i < 4000; ++i) {
    io::OrientationConstraint constraint;
    constraint.rotation_vector = i % 2 == 0;
    constraint.orientation = i % 3 == 0 ? draw.rotation() : draw.quarter_turns();
    for (double& tolerance : constraint.tolerance)
      tolerance = draw.between(0, 1) < 0.3 ? draw.between(3.0, 7.0) : std::pow(10.0, draw.between(-4, 0.3));
    if (allows_all(constraint)) continue;
    const Eigen::Matrix3d constrained = draw.quarter_turns().toRotationMatrix();  // in the end effector's frame
    Eigen::Matrix3d to_constraint = constrained.transpose();
    if (constraint.rotation_vector) to_constraint = constraint.orientation.toRotationMatrix() * to_constraint;
    const Eigen::Vector3d tolerance = rotation_tolerance(constraint, to_constraint, Eigen::Vector3d::Zero());
    BOOST_REQUIRE((tolerance.array() > 0.0).all());
    free_axes += static_cast<int>(tolerance.array().isInf().count());
    for (int k = 0; k < 50; ++k) {
      const Eigen::Matrix3d turned = accepted_rotation(tolerance, draw);
      const Eigen::Matrix3d difference = constrained.transpose() * turned * constrained;
      BOOST_REQUIRE_MESSAGE(moveit_accepts(constraint, difference),
                            "tolerances " << constraint.tolerance.transpose() << " became " << tolerance.transpose());
    }
  }
  BOOST_TEST(free_axes > 500);
}

BOOST_AUTO_TEST_CASE(small_tolerances_stay_nearly_as_they_are) {
  io::OrientationConstraint constraint;
  constraint.tolerance = {0.01, 0.02, 0.03};
  const Eigen::Vector3d angles = rotation_tolerance(constraint, Eigen::Matrix3d::Identity(), {0, 0, 0});
  BOOST_TEST((angles - constraint.tolerance).cwiseAbs().maxCoeff() < 1e-3);
  constraint.rotation_vector = true;
  const Eigen::Vector3d vector = rotation_tolerance(constraint, Eigen::Matrix3d::Identity(), {0, 0, 0});
  BOOST_TEST((vector - constraint.tolerance).cwiseAbs().maxCoeff() < 1e-15);
}

BOOST_AUTO_TEST_CASE(an_axis_is_free_only_where_the_point_stays) {
  io::OrientationConstraint constraint;
  constraint.tolerance = {0.1, 0.1, 4.0};
  const auto along_z = [&](const Eigen::Vector3d& point) {
    return rotation_tolerance(constraint, Eigen::Matrix3d::Identity(), point).z();
  };
  BOOST_TEST(along_z({0, 0, 0}) == kFree);
  BOOST_TEST(along_z({0, 0, 0.3}) == kFree);
  BOOST_TEST(along_z({0.1, 0, 0.3}) < 4.0);
  constraint.tolerance = {0.1, 4.0, 0.1};  // the middle one of three angles is never free
  BOOST_TEST(std::isfinite(rotation_tolerance(constraint, Eigen::Matrix3d::Identity(), {0, 0, 0}).y()));
  constraint.rotation_vector = true;
  BOOST_TEST(rotation_tolerance(constraint, Eigen::Matrix3d::Identity(), {0, 0, 0}).y() == kFree);
}
