#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <thread>

#include "srmp/core/error.hpp"
#include "srmp/robot/robot_model.hpp"
#include "support/data.hpp"
#include "support/numbers.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using namespace srmp;
using std::numbers::pi;

namespace {

/// A rail, a wheel on it and a finger that mimics the wheel, and one that mimics the rail:
///   base ─rail (prismatic x)─ cart ─wheel (continuous z)─ disc ─finger (revolute y, = 0.5 wheel + 0.1)─ nail
///                               └─ mast (prismatic z, = -2 rail)─ lamp
const char* kCart = R"(<robot name='cart'>
<link name='base'/><link name='cart'><collision><geometry><box size='0.2 0.2 0.1'/></geometry></collision></link>
<link name='disc'><collision><geometry><cylinder radius='0.3' length='0.4'/></geometry></collision></link>
<link name='nail'><collision><origin xyz='0 0 1'/><geometry><capsule radius='0.3' length='0.4'/></geometry></collision></link>
<link name='lamp'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>
<joint name='rail' type='prismatic'><parent link='base'/><child link='cart'/><axis xyz='1 0 0'/>
  <limit lower='-1' upper='2' velocity='1' effort='1'/></joint>
<joint name='wheel' type='continuous'><parent link='cart'/><child link='disc'/><axis xyz='0 0 1'/><origin xyz='0 0 1'/>
  <limit velocity='1' effort='1'/></joint>
<joint name='finger' type='revolute'><parent link='disc'/><child link='nail'/><axis xyz='0 1 0'/><origin xyz='1 0 0'/>
  <limit lower='-2' upper='2' velocity='1' effort='1'/><mimic joint='wheel' multiplier='0.5' offset='0.1'/></joint>
<joint name='mast' type='prismatic'><parent link='cart'/><child link='lamp'/><axis xyz='0 0 1'/>
  <limit lower='-9' upper='9' velocity='1' effort='1'/><mimic joint='rail' multiplier='-2'/></joint>
</robot>)";

std::shared_ptr<const RobotModel> cart() {
  RobotDescription description;
  description.urdf_text = kCart;
  description.end_effector = "nail";
  return RobotModel::load(description);
}

void check_jacobian(const RobotModel& robot, const Eigen::VectorXd& q, const std::string& link) {
  const Eigen::MatrixXd jacobian = robot.compute_jacobian(q, link);
  constexpr double h = 1e-6;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    Eigen::VectorXd ahead = q, behind = q;
    ahead[i] += h;
    behind[i] -= h;
    const Pose a = robot.compute_fk(ahead, link), b = robot.compute_fk(behind, link);
    const Eigen::AngleAxisd turn(a.q * b.q.inverse());
    const Eigen::Vector3d angular = turn.axis() * turn.angle() / (2 * h), linear = (a.p - b.p) / (2 * h);
    BOOST_TEST((jacobian.col(i).head<3>() - linear).norm() < 1e-7);
    BOOST_TEST((jacobian.col(i).tail<3>() - angular).norm() < 1e-7);
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(planar_robot_matches_the_closed_form) {
  const auto robot = robots::planar();
  for (std::size_t i = 0; i < 20; ++i) {
    const Eigen::VectorXd q = sample_configuration(*robot, i);
    const Pose end_effector = robot->compute_fk(q);
    BOOST_TEST(std::abs(end_effector.p.x() - (std::cos(q[0]) + std::cos(q[0] + q[1]))) < 1e-12);
    BOOST_TEST(std::abs(end_effector.p.y() - (std::sin(q[0]) + std::sin(q[0] + q[1]))) < 1e-12);
    check_jacobian(*robot, q, "tip");
  }
}

BOOST_AUTO_TEST_CASE(arm7_has_its_documented_pose) {
  const auto robot = RobotModel::load(arm7());
  BOOST_TEST(robot->dof() == 7);
  BOOST_TEST(robot->end_effector() == "arm7_hand");
  const Pose upright = robot->compute_fk(robot->group_states().at("upright"));
  BOOST_TEST((upright.matrix() - Pose{{0, 0, 1.16}, Eigen::Quaterniond::Identity()}.matrix()).norm() < 1e-12);
  const Pose ready = robot->compute_fk(robot->group_states().at("ready"));
  BOOST_TEST((ready.matrix() - Pose::from_rpy({0.33, 0, 0.45}, {0, pi, 0}).matrix()).norm() < 1e-9);
  for (std::size_t i = 0; i < 20; ++i) check_jacobian(*robot, sample_configuration(*robot, i), "arm7_hand");
  check_jacobian(*robot, sample_configuration(*robot, 3), "arm7_elbow");
}

BOOST_AUTO_TEST_CASE(prismatic_continuous_and_mimic_joints_move_as_they_should) {
  const auto robot = cart();
  BOOST_TEST(robot->joint_names() == (std::vector<std::string>{"rail", "wheel"}), boost::test_tools::per_element());
  BOOST_TEST(robot->other_joints().empty());
  const Eigen::Vector2d q(0.5, 4.0);  // more than half a turn
  const double finger = 0.5 * 4.0 + 0.1;
  const Pose expected = Pose::from_rpy({0.5, 0, 1}, {0, 0, 4.0}) * Pose::from_rpy({1, 0, 0}, {0, finger, 0});
  BOOST_TEST((robot->compute_fk(q).matrix() - expected.matrix()).norm() < 1e-12);
  BOOST_TEST((robot->compute_fk(q, "lamp").p - Eigen::Vector3d(0.5, 0, -1.0)).norm() < 1e-12);
  check_jacobian(*robot, q, "nail");
  check_jacobian(*robot, q, "lamp");
}

BOOST_AUTO_TEST_CASE(actuated_joints_and_supports_say_which_joint_moves_what) {
  const auto robot = cart();
  // Depth first: rail, wheel, finger, mast.
  BOOST_TEST(robot->actuated_joints().size() == 4);
  const std::vector<std::size_t> joints{0, 1, 1, 0};
  const std::vector<double> ratios{1, 1, 0.5, -2};
  for (std::size_t k = 0; k < 4; ++k) {
    BOOST_TEST(robot->actuated_joints()[k].joint == joints[k]);
    BOOST_TEST(robot->actuated_joints()[k].ratio == ratios[k]);
    BOOST_TEST(robot->actuated_joints()[k].prismatic == (k == 0 || k == 3));
  }
  BOOST_TEST(robot->link_support(robot->link_index("base")) == 0b0000u);
  BOOST_TEST(robot->link_support(robot->link_index("cart")) == 0b0001u);
  BOOST_TEST(robot->link_support(robot->link_index("nail")) == 0b0111u);
  BOOST_TEST(robot->link_support(robot->link_index("lamp")) == 0b1001u);
  for (const LinkGeometry& geometry : robot->geometries())
    BOOST_TEST(geometry.support == robot->link_support(geometry.link_index));

  const RobotDataPtr data = robot->make_data();
  robot->forward(*data, Eigen::Vector2d(0.5, pi / 2));
  const auto [point, axis] = robot->actuated_joint_axis(*data, 2);  // the finger's, turned a quarter by the wheel
  BOOST_TEST((point - Eigen::Vector3d(0.5, 1, 1)).norm() < 1e-12);
  BOOST_TEST((axis - Eigen::Vector3d(-1, 0, 0)).norm() < 1e-12);
}

BOOST_AUTO_TEST_CASE(bounding_spheres_are_tight) {
  const auto robot = cart();
  const auto radius = [&](std::size_t i) { return robot->geometries()[i].radius; };
  BOOST_TEST(robot->geometries()[0].name == "cart_0");
  BOOST_TEST(std::abs(radius(0) - std::sqrt(0.01 + 0.01 + 0.0025)) < 1e-12);
  BOOST_TEST(std::abs(radius(1) - std::hypot(0.3, 0.2)) < 1e-12);
  BOOST_TEST(std::abs(radius(2) - 0.5) < 1e-12);
  BOOST_TEST(radius(3) == 0.1);
}

BOOST_AUTO_TEST_CASE(geometry_moves_with_its_link) {
  const auto robot = cart();
  const RobotDataPtr data = robot->make_data();
  for (std::size_t i = 0; i < 5; ++i) {
    robot->forward(*data, sample_configuration(*robot, i));
    const std::size_t nail = robot->link_index("nail");
    const Eigen::Vector3d expected = robot->link_pose(*data, nail) * Eigen::Vector3d(0, 0, 1);
    BOOST_TEST((robot->geometry_pose(*data, 2).translation() - expected).norm() < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(other_positions_last_until_changed) {
  RobotDescription description;
  description.urdf_text = kCart;
  description.joint_names = {"wheel"};
  description.fixed_joints = {{"rail", 0.25}};
  const auto robot = RobotModel::load(description);
  const RobotDataPtr data = robot->make_data();
  const std::size_t cart_link = robot->link_index("cart"), lamp = robot->link_index("lamp");
  const Eigen::VectorXd q = Eigen::VectorXd::Zero(1);
  BOOST_TEST(robot->link_pose(*data, cart_link).translation().x() == 0.25);
  robot->set_other_positions(*data, Eigen::VectorXd::Constant(1, 1.5));
  robot->forward(*data, q);
  robot->forward(*data, q);
  BOOST_TEST(robot->link_pose(*data, cart_link).translation().x() == 1.5);
  BOOST_TEST(robot->link_pose(*data, lamp).translation().z() == -3.0);
  BOOST_TEST(robot->geometry_pose(*data, 0).translation().x() ==
             1.5);  // no planned joint moves it, but another joint does
  check_throws<InvalidArgument>([&] { robot->set_other_positions(*data, Eigen::Vector2d(0, 0)); },
                                "1 other joints, got 2");
}

BOOST_AUTO_TEST_CASE(a_forward_after_another_gives_the_bits_of_the_first) {
  for (const auto& robot : {cart(), RobotModel::load(arm7())}) {
    const RobotDataPtr data = robot->make_data();
    for (std::size_t i = 0; i < 50; ++i) {
      const Eigen::VectorXd q = sample_configuration(*robot, i);
      const Eigen::VectorXd others = robot->default_other_positions().array() + 0.01 * static_cast<double>(i / 10);
      if (i % 10 == 0) robot->set_other_positions(*data, others);
      robot->forward(*data, q);
      const RobotDataPtr fresh = robot->make_data();
      robot->set_other_positions(*fresh, others);
      robot->forward(*fresh, q);
      for (std::size_t link = 0; link < robot->link_names().size(); ++link)
        BOOST_TEST((robot->link_pose(*data, link).matrix() == robot->link_pose(*fresh, link).matrix()));
    }
  }
}

BOOST_AUTO_TEST_CASE(limit_violations_are_reported_and_differences_take_the_shorter_way_round) {
  const auto robot = cart();
  BOOST_TEST(!robot->limit_violation(Eigen::Vector2d(2, 100)));
  BOOST_TEST(*robot->limit_violation(Eigen::Vector2d(2.5, 0)) == "rail: 2.5 m is above the upper limit 2 m");
  BOOST_TEST(*robot->limit_violation(Eigen::Vector2d(-1.5, 0)) == "rail: -1.5 m is below the lower limit -1 m");
  BOOST_TEST(*robots::planar()->limit_violation(Eigen::Vector2d(0, 3.5)) ==
             "b: 3.5 rad is above the upper limit 3 rad");
  BOOST_TEST(!robot->limit_violation(Eigen::Vector2d(2.001, 0), 0.01));
  BOOST_TEST(robot->clamped(Eigen::Vector2d(2.001, 9), 0.01) == Eigen::Vector2d(2, 9));
  BOOST_TEST(robot->clamped(Eigen::Vector2d(2.1, 9), 0.01) == Eigen::Vector2d(2.1, 9));
  const Eigen::VectorXd d = robot->difference(Eigen::Vector2d(1, 3), Eigen::Vector2d(-1, -3));
  BOOST_TEST(d[0] == -2.0);
  BOOST_TEST(std::abs(d[1] - (2 * pi - 6)) < 1e-12);
}

BOOST_AUTO_TEST_CASE(invalid_configurations_are_rejected) {
  const auto robot = cart();
  check_throws<InvalidArgument>([&] { robot->compute_fk(Eigen::Vector3d(0, 0, 0)); },
                                "configuration has 3 values; robot 'cart' has 2 planned joints: 'rail' and 'wheel'");
  check_throws<InvalidArgument>([&] { robot->compute_fk(Eigen::Vector2d(0, NAN)); }, "wheel is NaN");
  check_throws<InvalidArgument>([&] { robot->compute_fk(Eigen::Vector2d(0, 0), "nali"); },
                                "robot 'cart' has no link 'nali', did you mean 'nail'?");
  check_throws<InvalidArgument>([&] { robot->compute_jacobian(Eigen::Vector2d(0, INFINITY)); }, "wheel is infinity");
}

BOOST_AUTO_TEST_CASE(a_planned_joint_without_a_velocity_limit_gets_one_with_a_warning) {
  RobotDescription description;
  description.urdf_text = std::string(kCart);
  description.urdf_text.replace(description.urdf_text.find("<limit velocity='1' effort='1'/>"), 32, "");
  description.end_effector = "nail";
  const auto robot = RobotModel::load(description);
  for (const Joint& joint : robot->joints())
    if (joint.name == "wheel") BOOST_TEST(joint.max_velocity == 1.0);
  BOOST_TEST_REQUIRE(robot->warnings().size() == 1u);
  BOOST_TEST(robot->warnings()[0] ==
             "joint 'wheel' of robot 'cart' is planned but has no velocity limit above 0; 1 "
             "rad/s is taken, as MoveIt does");
  description.strict = true;
  check_throws<InvalidArgument>([&] { RobotModel::load(description); },
                                "joint 'wheel' of robot 'cart' is planned but has no velocity limit");
  description.joint_names = {"rail"};
  BOOST_TEST(RobotModel::load(description)->warnings().empty());
}

BOOST_AUTO_TEST_CASE(floating_joints_stay_at_their_origin_with_a_warning) {
  RobotDescription description;
  description.urdf_text = kCart;
  description.urdf_text.replace(description.urdf_text.find("type='prismatic'"), 16, "type='floating'");
  description.urdf_text.erase(description.urdf_text.find("<mimic joint='rail' multiplier='-2'/>"), 37);
  description.end_effector = "nail";
  const auto robot = RobotModel::load(description);
  BOOST_TEST(robot->joint_names() == (std::vector<std::string>{"wheel"}), boost::test_tools::per_element());
  BOOST_TEST(robot->warnings().at(0) ==
             "joint 'rail' has more than one degree of freedom; it is not planned and stays at its origin; "
             "floating_bounds plans it");
}

BOOST_AUTO_TEST_CASE(threads_share_the_model) {
  const auto robot = RobotModel::load(arm7());
  const std::size_t hand = robot->link_index("arm7_hand");
  std::vector<std::vector<Eigen::Matrix4d>> poses(4);
  std::vector<std::thread> threads;
  for (auto& mine : poses)
    threads.emplace_back([&] {
      const RobotDataPtr data = robot->make_data();
      for (std::size_t i = 0; i < 200; ++i) {
        robot->forward(*data, sample_configuration(*robot, i));
        mine.push_back(robot->link_pose(*data, hand).matrix());
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const auto& mine : poses) BOOST_TEST((mine == poses[0]));
}
