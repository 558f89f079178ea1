// Planar and floating joints of the URDF, virtual joints of the SRDF, and bases that are in neither become three or six
// planned joints.

#include "srmp/robot/multi_dof_joint.hpp"

#include <boost/test/unit_test.hpp>
#include <limits>
#include <string>

#include "srmp/core/error.hpp"
#include "srmp/core/pose.hpp"
#include "srmp/robot/robot_model.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

const std::string kTrolley = R"(<robot name='trolley'>
  <link name='floor'/><link name='body'/><link name='arm'/>
  <joint name='wheels' type='planar'><origin xyz='1 2 0.5' rpy='0 0 1.5707963267948966'/>
    <parent link='floor'/><child link='body'/><axis xyz='0 0 1'/><limit velocity='0.7'/></joint>
  <joint name='turn' type='revolute'><origin xyz='0 0 1'/><parent link='body'/><child link='arm'/><axis xyz='0 1 0'/>
    <limit lower='-1' upper='1' velocity='1'/></joint>
</robot>)";

const std::string kStand = R"(<robot name='stand'>
  <link name='body'/><link name='arm'/>
  <joint name='turn' type='revolute'><origin xyz='0 0 1'/><parent link='body'/><child link='arm'/><axis xyz='0 1 0'/>
    <limit lower='-1' upper='1' velocity='1'/></joint>
</robot>)";

RobotDescription driving(const std::string& urdf, const std::string& srdf = "") {
  RobotDescription description;
  description.urdf_text = urdf;
  description.srdf_text = srdf;
  description.planar_bounds = PlanarBounds{{-2, -1}, {3, 4}};
  return description;
}

const std::string kDrone = R"(<robot name='drone'>
  <link name='ground'/><link name='body'/><link name='arm'/>
  <joint name='lift' type='prismatic'><parent link='ground'/><child link='pad'/><axis xyz='0 0 1'/>
    <limit lower='0' upper='1' velocity='1'/></joint><link name='pad'/>
  <joint name='air' type='floating'><origin xyz='1 2 0.5' rpy='0.3 0 1.5707963267948966'/>
    <parent link='pad'/><child link='body'/><limit velocity='0.7'/></joint>
  <joint name='turn' type='revolute'><origin xyz='0 0 1'/><parent link='body'/><child link='arm'/><axis xyz='0 1 0'/>
    <limit lower='-1' upper='1' velocity='1'/></joint>
</robot>)";

RobotDescription flying(const std::string& urdf, const std::string& srdf = "") {
  RobotDescription description;
  description.urdf_text = urdf;
  description.srdf_text = srdf;
  description.floating_bounds = FloatingBounds{{-2, -1, 0}, {3, 4, 5}};
  return description;
}

using Names = std::vector<std::string>;
using Vector7d = Eigen::Matrix<double, 7, 1>;

Names six_of(const std::string& joint) {
  return {joint + "/x", joint + "/y", joint + "/z", joint + "/yaw", joint + "/pitch", joint + "/roll"};
}

Names with(Names names, const std::string& last) {
  names.push_back(last);
  return names;
}

Eigen::Isometry3d arm_pose(const RobotModel& robot, const Eigen::VectorXd& q) {
  const RobotDataPtr data = robot.make_data();
  robot.forward(*data, q);
  return robot.link_pose(*data, robot.link_index("arm"));
}

}  // namespace

BOOST_AUTO_TEST_SUITE(multi_dof_joint)

BOOST_AUTO_TEST_CASE(a_planar_joint_is_three_planned_joints) {
  const auto robot = RobotModel::load(driving(kTrolley));
  BOOST_TEST(robot->joint_names() == (std::vector<std::string>{"wheels/x", "wheels/y", "wheels/theta", "turn"}),
             boost::test_tools::per_element());
  BOOST_TEST(robot->joints()[0].lower == -2.0);
  BOOST_TEST(robot->joints()[1].upper == 4.0);
  BOOST_TEST(robot->joints()[1].max_velocity == 0.7);
  BOOST_TEST((robot->joints()[2].kind == JointKind::continuous));
  BOOST_TEST(robot->warnings().empty());

  const Eigen::Isometry3d origin = Pose::from_rpy({1, 2, 0.5}, {0, 0, M_PI / 2}).isometry();
  const Eigen::Isometry3d drive = Pose::from_rpy({1.5, -0.5, 0}, {0, 0, 0.8}).isometry();
  const Eigen::Isometry3d turn = Pose::from_rpy({0, 0, 1}, {0, 0.3, 0}).isometry();
  const Eigen::Isometry3d pose = arm_pose(*robot, Eigen::Vector4d(1.5, -0.5, 0.8, 0.3));
  BOOST_TEST((pose.matrix() - (origin * drive * turn).matrix()).norm() < 1e-12);
}

BOOST_AUTO_TEST_CASE(the_axis_of_a_planar_joint_is_the_normal_of_its_plane) {
  std::string wall = kTrolley;
  wall.replace(wall.find("<axis xyz='0 0 1'/>"), 19, "<axis xyz='1 0 0'/>");
  const auto robot = RobotModel::load(driving(wall));
  const Eigen::Isometry3d still = arm_pose(*robot, Eigen::Vector4d::Zero());
  const Eigen::Isometry3d origin = Pose::from_rpy({1, 2, 0.5}, {0, 0, M_PI / 2}).isometry();
  for (const Eigen::Vector4d& q : {Eigen::Vector4d(1, 0, 0, 0), Eigen::Vector4d(0, 1, 0, 0)}) {
    const Eigen::Vector3d moved =
        origin.linear().transpose() * (arm_pose(*robot, q).translation() - still.translation());
    BOOST_TEST(std::abs(moved.x()) < 1e-12);
    BOOST_TEST(std::abs(moved.norm() - 1.0) < 1e-12);
  }
}

BOOST_AUTO_TEST_CASE(a_planar_virtual_joint_is_planned_with_the_group) {
  const std::string srdf = R"(<robot name='stand'>
    <virtual_joint name='world_joint' type='planar' parent_frame='odom' child_link='body'/>
    <group name='arm'><joint name='turn'/></group><group name='base'><joint name='world_joint'/></group>
    <group_state name='up' group='arm'><joint name='turn' value='0.5'/></group_state>
    <group_state name='away' group='arm'><joint name='turn' value='0'/><joint name='world_joint' value='1 2 3'/></group_state>
  </robot>)";
  RobotDescription description = driving(kStand, srdf);
  description.group = "arm";
  const auto robot = RobotModel::load(description);
  BOOST_TEST(
      robot->joint_names() == (std::vector<std::string>{"world_joint/x", "world_joint/y", "world_joint/theta", "turn"}),
      boost::test_tools::per_element());
  BOOST_TEST((robot->group_states().at("up") - Eigen::Vector4d(0, 0, 0, 0.5)).norm() == 0.0);
  BOOST_TEST((robot->group_states().at("away") - Eigen::Vector4d(1, 2, 3, 0)).norm() == 0.0);

  description.srdf_text.replace(srdf.find("1 2 3"), 5, "1 2");
  check_throws<FileError>([&] { RobotModel::load(description); }, "gives 2 values of joint 'world_joint'");
  description.srdf_text = srdf;
  description.group = "base";
  BOOST_TEST(RobotModel::load(description)->joint_names().size() == 3u);
  // What is saved describes the same robot, without the bounds.
  const auto again = RobotModel::load(robot->self_contained_description());
  BOOST_TEST(again->joint_names() == robot->joint_names(), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(without_a_planar_joint_the_root_link_moves) {
  RobotDescription description = driving(kStand);
  const auto robot = RobotModel::load(description);
  BOOST_TEST(robot->joint_names() == (std::vector<std::string>{"base/x", "base/y", "base/theta", "turn"}),
             boost::test_tools::per_element());
  description.joint_names = {"turn"};
  BOOST_TEST(RobotModel::load(description)->joint_names() == robot->joint_names(), boost::test_tools::per_element());
  description.joint_names = {"turn", "base/theta"};
  BOOST_TEST(RobotModel::load(description)->joint_names() == description.joint_names, boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(names_that_are_taken_are_refused) {
  for (const std::string name : {"base", "base/theta"}) {
    std::string urdf = kStand;
    urdf.replace(urdf.find("'turn'"), 6, "'" + name + "'");
    check_throws<InvalidArgument>([&] { RobotModel::load(driving(urdf)); }, "rename");
  }
}

BOOST_AUTO_TEST_CASE(states_of_a_gripper_stay_as_they_are) {
  std::string urdf = kStand;
  urdf.insert(urdf.find("</robot>"), R"(<link name='finger'/>
    <joint name='slide' type='prismatic'><parent link='arm'/><child link='finger'/><axis xyz='1 0 0'/>
      <limit lower='0' upper='0.1' velocity='1'/></joint>)");
  RobotDescription description = driving(urdf, R"(<robot name='stand'>
    <group name='arm'><joint name='turn'/></group><group name='hand'><joint name='slide'/></group>
    <end_effector name='gripper' parent_link='arm' group='hand'/>
    <group_state name='open' group='hand'><joint name='slide' value='0.1'/></group_state>
  </robot>)");
  description.group = "arm";
  const auto robot = RobotModel::load(description);
  BOOST_TEST(robot->end_effectors().at(0).states.at("open").size() == 1u);
}

BOOST_AUTO_TEST_CASE(bounds_that_hold_nothing_are_refused) {
  RobotDescription description = driving(kTrolley);
  description.planar_bounds->upper.y() = -1;
  check_throws<InvalidArgument>([&] { RobotModel::load(description); },
                                "planar_bounds: y is from -1 to -1 m; the lower bound must be below the upper one");
  description.planar_bounds->upper.y() = std::numeric_limits<double>::quiet_NaN();
  check_throws<InvalidArgument>([&] { RobotModel::load(description); }, "bounds must be finite numbers");
  description.planar_bounds->upper.y() = 2000;
  check_throws<InvalidArgument>([&] { RobotModel::load(description); }, "at most 1000 m are allowed");
}

BOOST_AUTO_TEST_CASE(a_floating_joint_in_the_middle_of_the_tree_is_six_planned_joints) {
  const auto robot = RobotModel::load(flying(kDrone));
  Names names = with(six_of("air"), "turn");
  names.insert(names.begin(), "lift");
  BOOST_TEST(robot->joint_names() == names, boost::test_tools::per_element());
  const std::vector<Joint>& joints = robot->joints();
  BOOST_TEST(joints[1].lower == -2.0);
  BOOST_TEST(joints[3].upper == 5.0);
  BOOST_TEST(joints[3].max_velocity == 0.7);
  BOOST_TEST((joints[4].kind == JointKind::continuous && joints[6].kind == JointKind::continuous));
  BOOST_TEST(joints[4].max_velocity == 1.0);
  BOOST_TEST((joints[5].kind == JointKind::revolute && joints[5].lower == -M_PI / 2 && joints[5].upper == M_PI / 2));
  BOOST_TEST(robot->warnings().empty());

  Eigen::VectorXd q(8);
  q << 0.25, 1.5, -0.5, 2.0, 0.8, -1.1, 2.5, 0.3;
  const Eigen::Isometry3d origin = Pose::from_rpy({1, 2, 0.75}, {0.3, 0, M_PI / 2}).isometry();
  const Eigen::Isometry3d flight = Pose::from_rpy({1.5, -0.5, 2.0}, {2.5, -1.1, 0.8}).isometry();
  const Eigen::Isometry3d turn = Pose::from_rpy({0, 0, 1}, {0, 0.3, 0}).isometry();
  BOOST_TEST((arm_pose(*robot, q).matrix() - (origin * flight * turn).matrix()).norm() < 1e-12);
}

BOOST_AUTO_TEST_CASE(the_first_of_two_floating_joints_is_planned) {
  std::string urdf = kDrone;
  urdf.insert(urdf.find("</robot>"), R"(<link name='bird'/>
    <joint name='bird' type='floating'><parent link='ground'/><child link='bird'/></joint>)");
  RobotDescription description = flying(urdf);
  description.end_effector = "arm";
  const auto robot = RobotModel::load(description);
  BOOST_TEST(robot->joint_names()[1] == "air/x");
  BOOST_REQUIRE(robot->warnings().size() == 1u);
  BOOST_TEST(robot->warnings()[0] ==
             "joint 'bird' has more than one degree of freedom; it is not planned and stays at its origin; "
             "floating_bounds plans the first joint of its type alone");
}

BOOST_AUTO_TEST_CASE(a_floating_virtual_joint_is_planned_with_the_group) {
  const std::string srdf = R"(<robot name='stand'>
    <virtual_joint name='world_joint' type='floating' parent_frame='odom' child_link='body'/>
    <group name='arm'><joint name='turn'/></group>
    <group_state name='up' group='arm'><joint name='turn' value='0.5'/></group_state>
    <group_state name='away' group='arm'><joint name='turn' value='0'/>
      <joint name='world_joint' value='1 2 3 0 0.6 0 0.8'/></group_state>
  </robot>)";
  RobotDescription description = flying(kStand, srdf);
  description.group = "arm";
  const auto robot = RobotModel::load(description);
  BOOST_TEST(robot->joint_names() == with(six_of("world_joint"), "turn"), boost::test_tools::per_element());
  Vector7d up = Vector7d::Zero(), away;
  up[6] = 0.5;
  away << 1, 2, 3, 0, 2 * std::atan2(0.6, 0.8), 0, 0;
  BOOST_TEST((robot->group_states().at("up") - up).norm() == 0.0);
  BOOST_TEST((robot->group_states().at("away") - away).norm() < 1e-12);
  const auto again = RobotModel::load(robot->self_contained_description());
  BOOST_TEST(again->joint_names() == robot->joint_names(), boost::test_tools::per_element());

  description.srdf_text.replace(srdf.find("1 2 3 0 0.6"), 11, "1 2 3");
  check_throws<FileError>(
      [&] { RobotModel::load(description); },
      "a state of the SRDF gives 5 values of joint 'world_joint', which is floating; it takes x, y, "
      "z, qx, qy, qz, qw");
}

BOOST_AUTO_TEST_CASE(without_a_floating_joint_the_root_link_flies) {
  for (const std::string& urdf : {kStand, kTrolley}) {
    const auto robot = RobotModel::load(flying(urdf));
    BOOST_TEST(robot->joint_names() == with(six_of("base"), "turn"), boost::test_tools::per_element());
  }
  RobotDescription description = flying(kStand);
  description.joint_names = {"turn"};
  BOOST_TEST(RobotModel::load(description)->joint_names() == with(six_of("base"), "turn"),
             boost::test_tools::per_element());
  description.urdf_text = "<robot name='box'><link name='body'/></robot>";
  description.joint_names.clear();
  BOOST_TEST(RobotModel::load(description)->joint_names() == six_of("base"), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(every_transform_of_a_floating_joint_has_positions_within_its_limits) {
  RobotDescription description = flying("<robot name='box'><link name='arm'/></robot>");
  const auto robot = RobotModel::load(description);
  for (const double yaw : {-3.0, -0.4, 0.0, 2.0})
    for (const double pitch : {-M_PI / 2, -M_PI / 2 + 1e-9, -1.0, 0.0, 1e-9, 1.5, M_PI / 2})
      for (const double roll : {-2.9, 0.0, M_PI}) {
        const Pose pose = Pose::from_rpy({0.5, -0.25, 2}, {roll, pitch, yaw});
        const auto positions = multi_dof_positions(*robot, "base", pose);
        Eigen::VectorXd q(6);
        for (Eigen::Index j = 0; j < 6; ++j) {
          const Joint& joint = robot->joints()[static_cast<std::size_t>(j)];
          q[j] = positions.at(joint.name);
          BOOST_TEST((q[j] >= joint.lower && q[j] <= joint.upper));
        }
        BOOST_TEST((arm_pose(*robot, q).matrix() - pose.matrix()).norm() < 1e-12);
      }
  BOOST_TEST(multi_dof_positions(*robot, "root", Pose{}).empty());
}

BOOST_AUTO_TEST_CASE(floating_bounds_that_hold_nothing_are_refused) {
  RobotDescription description = flying(kDrone);
  const auto refused = [&](const std::string& sentence) {
    check_throws<InvalidArgument>([&] { RobotModel::load(description); }, sentence);
  };
  description.floating_bounds->upper.z() = -1;
  refused("floating_bounds: z is from 0 to -1 m; the lower bound must be below the upper one");
  description.floating_bounds->upper.z() = std::numeric_limits<double>::infinity();
  refused("bounds must be finite numbers");
  description.floating_bounds->upper.z() = 2000;
  refused("floating_bounds: z is from 0 to 2000 m; at most 1000 m are allowed");
  description.floating_bounds->upper.z() = 2;
  description.planar_bounds = PlanarBounds{{-2, -1}, {3, 4}};
  refused("planar_bounds and floating_bounds are both given; a robot drives or flies: give one of them");
  for (const std::string name : {"base", "base/pitch"}) {
    description = flying(kStand);
    description.urdf_text.replace(kStand.find("'turn'"), 6, "'" + name + "'");
    refused("rename");
  }
  description = flying(kStand);
  for (std::size_t at; (at = description.urdf_text.find("'arm'")) != std::string::npos;)
    description.urdf_text.replace(at, 5, "'base/at_yaw'");
  refused("the URDF has a link 'base/at_yaw' already, which the floating joint 'base' needs; rename one of them");
}

BOOST_AUTO_TEST_SUITE_END()
