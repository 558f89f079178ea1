#include "srmp/robot/inverse_kinematics.hpp"

#include <boost/test/unit_test.hpp>
#include <limits>
#include <numbers>

#include "srmp/core/error.hpp"
#include "srmp/core/low_discrepancy.hpp"
#include "support/data.hpp"
#include "support/numbers.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

double position_error(const Pose& a, const Pose& b) { return (a.p - b.p).norm(); }
double rotation_error(const Pose& a, const Pose& b) { return a.q.angularDistance(b.q); }

}  // namespace

BOOST_AUTO_TEST_CASE(a_hundred_poses_are_reached) {
  const auto robot = RobotModel::load(arm7());
  const Eigen::VectorXd reference = robot->group_states().at("ready");
  int found = 0;
  for (std::size_t i = 1; i <= 100; ++i) {
    const Pose target = robot->compute_fk(sample_configuration(*robot, i));
    const auto solutions = inverse_kinematics(*robot, target, reference);
    found += !solutions.empty();
    double last = 0.0;
    for (const Eigen::VectorXd& q : solutions) {
      BOOST_TEST(position_error(robot->compute_fk(q), target) <= 1e-5);
      BOOST_TEST(rotation_error(robot->compute_fk(q), target) <= 1e-4);
      BOOST_TEST(!robot->limit_violation(q, 0.0));
      const double distance = robot->difference(reference, q).norm();
      BOOST_TEST(distance >= last);
      last = distance;
    }
    BOOST_TEST((inverse_kinematics(*robot, target, reference) == solutions));  // bit for bit
  }
  BOOST_TEST(found >= 99);
}

BOOST_AUTO_TEST_CASE(both_elbow_solutions_of_the_planar_robot_are_found) {
  const auto robot = robots::planar();
  IkOptions options;
  options.rotation_tolerance = std::numeric_limits<double>::infinity();
  const Pose target{{1, 1, 0}, Eigen::Quaterniond::Identity()};
  const auto solutions = inverse_kinematics(*robot, target, Eigen::Vector2d(0.1, 1.0), options);
  BOOST_REQUIRE_EQUAL(solutions.size(), 2);
  const double quarter = std::numbers::pi / 2;
  BOOST_TEST((solutions[0] - Eigen::Vector2d(0, quarter)).norm() < 1e-4);
  BOOST_TEST((solutions[1] - Eigen::Vector2d(quarter, -quarter)).norm() < 1e-4);
  options.max_solutions = 1;
  BOOST_TEST(inverse_kinematics(*robot, target, Eigen::Vector2d(0.1, 1.0), options).size() == 1);
}

BOOST_AUTO_TEST_CASE(free_axes_are_those_of_the_target) {
  const auto robot = RobotModel::load(arm7());
  const Eigen::VectorXd reference = robot->group_states().at("ready");
  const double free = std::numeric_limits<double>::infinity();
  int found[3] = {};
  for (int i = 1; i <= 60; ++i) {
    Eigen::VectorXd q = low_discrepancy_point(static_cast<std::size_t>(i), 7);
    for (Eigen::Index k = 0; k < 7; ++k) {
      const Joint& joint = robot->joints()[static_cast<std::size_t>(k)];
      q[k] = joint.lower + q[k] * (joint.upper - joint.lower);
    }
    const Pose target = robot->compute_fk(q);
    for (int axis = 0; axis < 3; ++axis) {
      IkOptions options;
      options.max_solutions = 4;
      options.rotation_tolerance.axes[axis] = free;
      options.position_tolerance.axes[(axis + 1) % 3] = free;
      const auto solutions = inverse_kinematics(*robot, target, reference, options);
      found[axis] += !solutions.empty();
      for (const Eigen::VectorXd& solution : solutions) {
        const Pose off = target.inverse() * robot->compute_fk(solution);  // in the target's axes
        for (int k = 0; k < 3; ++k) {
          if (k != (axis + 1) % 3) BOOST_TEST(std::abs(off.p[k]) < 1.1e-5);
          if (k != axis) BOOST_TEST(std::abs(off.q.vec()[k]) < 1.1e-4);
        }
      }
    }
  }
  for (int count : found) BOOST_TEST(count >= 59);
}

BOOST_AUTO_TEST_CASE(tolerances_apply_to_each_axis) {
  const auto robot = robots::planar();  // it cannot leave the plane z = 0
  const Pose above{{1, 1, 0.02}, Eigen::Quaterniond::Identity()};
  IkOptions options;
  options.rotation_tolerance = std::numeric_limits<double>::infinity();
  const Eigen::Vector2d reference(0.1, 1.0);
  options.position_tolerance = {0.05, 0.05, 0.01};
  BOOST_TEST(inverse_kinematics(*robot, above, reference, options).empty());
  options.position_tolerance = {1e-4, 1e-4, 0.03};
  BOOST_TEST(!inverse_kinematics(*robot, above, reference, options).empty());
  options.position_tolerance = {1e-4, 1e-4, std::numeric_limits<double>::infinity()};
  BOOST_TEST(!inverse_kinematics(*robot, above, reference, options).empty());
}

BOOST_AUTO_TEST_CASE(out_of_reach_is_empty_and_the_reference_itself_comes_first) {
  const auto robot = RobotModel::load(arm7());
  const Eigen::VectorXd reference = robot->group_states().at("ready");
  BOOST_TEST(inverse_kinematics(*robot, Pose{{2, 0, 0}, Eigen::Quaterniond::Identity()}, reference).empty());
  const auto solutions = inverse_kinematics(*robot, robot->compute_fk(reference), reference);
  BOOST_TEST((solutions.at(0) - reference).norm() < 1e-9);
}

BOOST_AUTO_TEST_CASE(continuous_joints_stay_near_the_reference) {
  const auto robot = robots::planar("continuous");
  IkOptions options;
  options.rotation_tolerance = std::numeric_limits<double>::infinity();
  const Eigen::Vector2d reference(20.0, 0.5);
  const Pose target = robot->compute_fk(Eigen::Vector2d(20.3, 0.6));
  const auto solutions = inverse_kinematics(*robot, target, reference, options);
  BOOST_REQUIRE(!solutions.empty());
  BOOST_TEST((solutions[0] - Eigen::Vector2d(20.3, 0.6)).norm() < 1e-3);
  for (const auto& q : solutions) BOOST_TEST(std::abs(q[0] - 20.0) <= std::numbers::pi + 1e-9);
}

BOOST_AUTO_TEST_CASE(joints_that_do_not_move_the_link_keep_their_value) {
  const auto robot = RobotModel::load(arm7());
  const Eigen::VectorXd reference = Eigen::VectorXd::Constant(7, 0.2);
  const Pose target = robot->compute_fk(Eigen::VectorXd::Constant(7, 0.4), "arm7_forearm");
  const auto solutions = inverse_kinematics(*robot, target, reference, {}, "arm7_forearm");
  BOOST_REQUIRE(!solutions.empty());
  for (const auto& q : solutions) BOOST_TEST((q.tail<3>() == reference.tail<3>()));
}

BOOST_AUTO_TEST_CASE(axes_that_are_nearly_opposite_to_the_bases_are_as_good_as_others) {
  using robots::bar;
  using robots::joint;
  const std::string limit = "<limit lower='-3' upper='3' velocity='2' effort='1'/>";
  for (const std::string tilt : {"0", "1e-8", "1e-7", "1e-6", "1.45e-6", "3e-6", "1e-5", "1e-3"}) {
    RobotDescription description;
    description.urdf_text = "<robot name='tilted'><link name='base'/>" + bar("upper") + bar("lower") +
                            "<link name='tip'/>" + joint("a", "revolute", "base", "upper", "0 0 0", "0 0 1", limit) +
                            joint("b", "revolute", "upper", "lower", "1 0 0", "0 " + tilt + " -1", limit) +
                            joint("c", "revolute", "lower", "tip", "1 0 0", tilt + " 0 -1", limit) + "</robot>";
    description.end_effector = "tip";
    const auto robot = RobotModel::load(description);
    const IkOptions options{.position_tolerance = 1e-7, .rotation_tolerance = 1e-6};
    for (std::size_t i = 1; i <= 20; ++i) {
      const Eigen::VectorXd reference = sample_configuration(*robot, i);
      const auto solutions = inverse_kinematics(*robot, robot->compute_fk(reference), reference, options);
      BOOST_REQUIRE(!solutions.empty());
      BOOST_TEST((solutions.front() - reference).norm() < 1e-9);
    }
  }
}

BOOST_AUTO_TEST_CASE(wide_tolerances_are_those_that_were_asked_for) {
  const auto robot = robots::planar();
  const Eigen::Vector2d reference(0.1, 1.0);
  for (const double turn : {0.5, 1.5, 2.8, 3.1}) {  // of the target, about an axis about which the robot cannot turn
    Pose target = robot->compute_fk(reference);
    target.q = target.q * Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitX());
    IkOptions options;
    options.rotation_tolerance = {turn + 1e-3, 0.1, 0.1};
    BOOST_TEST(!inverse_kinematics(*robot, target, reference, options).empty());
    options.rotation_tolerance = {turn - 1e-3, 0.1, 0.1};
    BOOST_TEST(inverse_kinematics(*robot, target, reference, options).empty());
  }
}

BOOST_AUTO_TEST_CASE(from_many_references_comes_what_comes_from_each) {
  const auto robot = RobotModel::load(arm7());
  const Pose target = robot->compute_fk(robot->group_states().at("ready"));
  std::vector<Eigen::VectorXd> references;
  for (std::size_t i = 1; i <= 150; ++i) references.push_back(sample_configuration(*robot, i));
  const auto all = inverse_kinematics_from(*robot, target, references);
  BOOST_REQUIRE_EQUAL(all.size(), references.size());
  int found = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto alone = inverse_kinematics(*robot, target, references[i], {.max_solutions = 1, .seeds = 1});
    BOOST_TEST(all[i].has_value() == !alone.empty());
    if (all[i] && !alone.empty()) BOOST_TEST((*all[i] == alone.front()));
    found += all[i].has_value();
  }
  BOOST_TEST((found > 15 && found < 150));
  BOOST_TEST(inverse_kinematics_from(*robot, target, {}).empty());
  references[3] = Eigen::Vector2d(0, 0);
  check_throws<InvalidArgument>([&] { inverse_kinematics_from(*robot, target, references); }, "reference has 2 values");
}

BOOST_AUTO_TEST_CASE(a_passed_deadline_stops_the_search) {
  const auto robot = RobotModel::load(arm7());
  const Eigen::VectorXd reference = robot->group_states().at("ready");
  BOOST_TEST(inverse_kinematics(*robot, robot->compute_fk(reference), reference, {}, "", Deadline(0.0)).empty());
  BOOST_TEST(inverse_kinematics(*robot, robot->compute_fk(reference), reference, {}, "", Deadline(1e9, [] {
               return true;
             })).empty());
}

BOOST_AUTO_TEST_CASE(invalid_arguments_are_rejected) {
  const auto robot = robots::planar();
  const auto refuses = [&](const IkOptions& options, const std::string& fragment) {
    check_throws<InvalidArgument>([&] { inverse_kinematics(*robot, {}, Eigen::Vector2d(0, 0), options); }, fragment);
  };
  refuses({.max_solutions = 0}, "max_solutions is 0; it must be above 0");
  refuses({.seeds = -1}, "seeds is -1");
  refuses({.max_iterations = 0}, "max_iterations is 0");
  refuses({.position_tolerance = 0}, "position_tolerance is 0");
  refuses({.position_tolerance = INFINITY, .rotation_tolerance = INFINITY}, "leave every axis free");
  refuses({.position_tolerance = {1e-3, -1, 1e-3}}, "position_tolerance is -1 for y");
  refuses({.rotation_tolerance = NAN}, "rotation_tolerance is NaN");
  refuses({.distinct = -1}, "distinct is -1");
  check_throws<InvalidArgument>([&] { inverse_kinematics(*robot, {}, Eigen::Vector2d(0, NAN)); },
                                "reference: b is NaN");
  check_throws<InvalidArgument>([&] { inverse_kinematics(*robot, {}, Eigen::Vector3d(0, 0, 0)); },
                                "reference has 3 values");
  check_throws<InvalidArgument>([&] { inverse_kinematics(*robot, {}, Eigen::Vector2d(0, 0), {}, "tipp"); },
                                "did you mean 'tip'?");
  Pose nowhere;
  nowhere.p.x() = NAN;
  check_throws<InvalidArgument>([&] { inverse_kinematics(*robot, nowhere, Eigen::Vector2d(0, 0)); }, "target");
}
