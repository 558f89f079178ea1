// The package's own arm, the same arm of meshes, and the robots of MotionBenchMaker where that data is, load as they
// are; numbers are Pinocchio's own.
#include <boost/test/unit_test.hpp>

#include "srmp/robot/inverse_kinematics.hpp"
#include "support/data.hpp"
#include "support/files.hpp"
#include "support/mesh_arm.hpp"
#include "support/numbers.hpp"

using namespace srmp;

namespace {

struct Case {
  std::string robot, urdf, group, end_effector;
  std::size_t dof, geometries;
  Eigen::Vector3d position;  // of the end effector with every joint at 0.3
};

RobotDescription description_of(const Case& c) {
  if (c.robot == "arm7") return arm7();
  if (c.robot == "arm7 of meshes") return mesh_arm::description();
  RobotDescription description;
  description.urdf_path = mbm_file(c.robot, c.urdf);
  description.srdf_path = mbm_file(c.robot, c.robot + ".srdf");
  return description;
}

std::shared_ptr<const RobotModel> load(const Case& c, bool with_srdf = true) {
  RobotDescription description = description_of(c);
  if (description.urdf_path.empty()) return nullptr;
  description.group = c.group;
  if (!with_srdf) description.srdf_path = description.group = "";
  description.end_effector = c.end_effector;
  return RobotModel::load(description);
}

const std::vector<Case> kCases{
    {"arm7", "", "arm", "arm7_hand", 7, 14, {0.39041183, 0.19997376, 1.01903122}},
    {"arm7 of meshes", "", "arm", "arm7_hand", 7, 14, {0.39041183, 0.19997376, 1.01903122}},
    {"panda", "panda.urdf", "panda_arm", "panda_hand", 7, 11, {0.17006073, 0.09246023, 0.92151821}},
    {"panda", "panda_spherized.urdf", "panda_arm", "panda_hand", 7, 59, {0.17006073, 0.09246023, 0.92151821}},
    {"ur5", "ur5.urdf", "manipulator", "ee_link", 6, 18, {-0.37713631, 0.58558456, 0.57859498}},
    {"fetch", "fetch.urdf", "arm_with_torso", "wrist_roll_link", 8, 15, {0.78719334, 0.29854386, 0.70420338}},
};

}  // namespace

BOOST_AUTO_TEST_CASE(robots_load_and_agree_with_pinocchio) {
  for (const Case& c : kCases) {
    const auto robot = load(c);
    if (!robot) continue;
    BOOST_TEST(robot->dof() == c.dof);
    BOOST_TEST(robot->geometries().size() == c.geometries);
    const Eigen::VectorXd q = Eigen::VectorXd::Constant(static_cast<Eigen::Index>(c.dof), 0.3);
    BOOST_TEST((robot->compute_fk(q).p - c.position).norm() < 1e-7);
    BOOST_TEST(!robot->self_pairs().empty());
  }
}

BOOST_AUTO_TEST_CASE(an_srdf_for_a_variant_of_the_arm_gives_one_warning) {
  const TemporaryDirectory directory;
  RobotDescription arm = arm7();
  std::ifstream srdf(arm.srdf_path);
  std::string text{std::istreambuf_iterator<char>(srdf), {}};
  text.insert(text.rfind("</robot>"),
              "<disable_collisions link1='arm7_base' link2='camera' reason='Never'/>"
              "<disable_collisions link1='arm7_hand' link2='camera' reason='Never'/>");
  arm.srdf_path = directory.write("variant.srdf", text);
  BOOST_TEST(RobotModel::load(arm)->warnings().size() == 1);
  BOOST_TEST(RobotModel::load(arm7())->warnings().empty());
}

BOOST_AUTO_TEST_CASE(an_srdf_for_a_variant_of_fetch_gives_one_warning) {
  if (const auto fetch = load(kCases.back())) {
    BOOST_TEST(fetch->warnings().size() == 1);
    BOOST_TEST(fetch->joint_names()[0] == "torso_lift_joint");
    BOOST_TEST((fetch->joints()[0].kind == JointKind::prismatic));
  }
}

BOOST_AUTO_TEST_CASE(without_an_srdf_nothing_of_the_arm_always_collides) {
  for (const Case& c : {kCases[0], kCases[1]}) {
    const auto arm = load(c, false);
    BOOST_TEST(arm->dof() == 7);
    BOOST_TEST(arm->always_colliding().empty());
    BOOST_TEST(arm->allowed("arm7_forearm", "arm7_elbow"));
    BOOST_TEST(!arm->allowed("arm7_base", "arm7_wrist"));
  }
}

BOOST_AUTO_TEST_CASE(without_an_srdf_nothing_of_the_panda_always_collides) {
  if (const auto panda = load(kCases[2], false)) {
    BOOST_TEST(panda->dof() == 7);
    BOOST_TEST(panda->always_colliding().empty());
    BOOST_TEST(panda->allowed("panda_link3", "panda_link4"));
    BOOST_TEST(!panda->allowed("panda_link0", "panda_link5"));
  }
}

BOOST_AUTO_TEST_CASE(inverse_kinematics_finds_solutions_for_every_robot) {
  for (const Case& c : kCases) {
    const auto robot = load(c);
    if (!robot) continue;
    const Eigen::VectorXd reference = sample_configuration(*robot, 0);
    int found = 0;
    for (std::size_t i = 1; i <= 20; ++i)
      found += !inverse_kinematics(*robot, robot->compute_fk(sample_configuration(*robot, i)), reference).empty();
    BOOST_TEST(found >= 19);
  }
}
