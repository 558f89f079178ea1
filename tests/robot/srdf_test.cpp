#include <boost/test/unit_test.hpp>

#include "srmp/core/error.hpp"
#include "srmp/robot/robot_model.hpp"
#include "support/files.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

/// A chain of four links with a gripper's finger:   base ─a─ one ─b─ two ─c─ three
///                                                                     └─f─ finger (prismatic, and mimic g on thumb)
const char* kRobot = R"(<robot name='r'>
<link name='base'/><link name='one'/><link name='two'/><link name='three'/><link name='finger'/><link name='thumb'/>
<joint name='a' type='revolute'><parent link='base'/><child link='one'/><limit lower='-1' upper='1' velocity='1' effort='1'/></joint>
<joint name='b' type='continuous'><parent link='one'/><child link='two'/><limit velocity='1' effort='1'/></joint>
<joint name='c' type='revolute'><parent link='two'/><child link='three'/><limit lower='0.5' upper='1' velocity='1' effort='1'/></joint>
<joint name='f' type='prismatic'><parent link='two'/><child link='finger'/><limit lower='0' upper='0.04' velocity='1' effort='1'/></joint>
<joint name='g' type='prismatic'><parent link='two'/><child link='thumb'/><limit lower='0' upper='0.04' velocity='1' effort='1'/><mimic joint='f'/></joint>
</robot>)";

const char* kGroups = R"(<group name='arm'><chain base_link='base' tip_link='two'/></group>
<group name='hand'><joint name='f'/></group>
<group name='all'><group name='hand'/><group name='arm'/><link name='three'/></group>
)";

class Load {
 public:
  explicit Load(const std::string& inside, RobotDescription description = {}) : description_(std::move(description)) {
    description_.urdf_text = kRobot;
    description_.srdf_path = directory_.write("r.srdf", "<robot name='r'>\n" + inside + "</robot>");
    if (description_.end_effector.empty() && description_.group.empty() && description_.joint_names.empty())
      description_.end_effector = "three";
  }
  std::shared_ptr<const RobotModel> operator()() const { return RobotModel::load(description_); }

 private:
  TemporaryDirectory directory_;
  RobotDescription description_;
};

RobotDescription group(const std::string& name) {
  RobotDescription description;
  description.group = name;
  return description;
}

RobotDescription fixed(const std::map<std::string, double>& joints) {
  RobotDescription description;
  description.end_effector = "three";
  description.fixed_joints = joints;
  return description;
}

using Names = std::vector<std::string>;

RobotDescription strict() {
  RobotDescription description;
  description.strict = true;
  return description;
}

/// In any case.
void refused(const std::string& inside, const std::string& fragment) {
  for (const RobotDescription& description : {RobotDescription{}, strict()}) {
    const Load load(inside, description);
    check_throws<FileError>([&] { load(); }, fragment);
  }
}

/// When strict; otherwise it is the first warning.
std::shared_ptr<const RobotModel> warned(const std::string& inside, const std::string& fragment) {
  const Load load(inside, strict());
  check_throws<FileError>([&] { load(); }, fragment);
  auto robot = Load(inside)();
  BOOST_TEST_REQUIRE(!robot->warnings().empty());
  BOOST_TEST(robot->warnings()[0].find(fragment) != std::string::npos, robot->warnings()[0]);
  return robot;
}

}  // namespace

BOOST_AUTO_TEST_CASE(groups_select_joints_and_end_effectors) {
  const auto arm = Load(kGroups, group("arm"))();
  BOOST_TEST(arm->joint_names() == (Names{"a", "b"}), boost::test_tools::per_element());
  BOOST_TEST(arm->end_effector() == "two");
  const auto hand = Load(kGroups, group("hand"))();
  BOOST_TEST(hand->joint_names() == (Names{"f"}), boost::test_tools::per_element());
  BOOST_TEST(hand->end_effector() == "finger");
  RobotDescription all = group("all");
  all.end_effector = "three";
  BOOST_TEST(Load(kGroups, all)()->joint_names() == (Names{"a", "b", "c", "f"}), boost::test_tools::per_element());
  BOOST_TEST(Load("")()->joint_names() == (Names{"a", "b", "c"}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(groups_with_branches_have_several_ends) {
  const auto ends_with = [](const std::string& more) { return Load(kGroups + more, group("all"))()->end_links(); };
  BOOST_TEST(ends_with("") == (Names{"three", "finger"}), boost::test_tools::per_element());
  const auto robot = Load(kGroups, group("all"))();
  BOOST_TEST(robot->end_effector() == "three");
  BOOST_TEST(robot->link_or_end_effector("two") == robot->link_index("two"));
  check_throws<InvalidArgument>([&] { robot->link_or_end_effector(""); },
                                "its planned joints move several: name the link, such as 'three' and 'finger'");
  const std::string gripper = "<end_effector name='gripper' parent_link='two' group='hand' parent_group='arm'/>";
  BOOST_TEST(ends_with(gripper) == (Names{"two"}), boost::test_tools::per_element());
  const std::string both = gripper + "<end_effector name='other' parent_link='three' group='hand'/>";
  BOOST_TEST(ends_with(both) == (Names{"two", "three"}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(end_effectors_have_joints_and_states) {
  const auto robot = Load(kGroups + std::string("<end_effector name='gripper' parent_link='two' group='hand'/>"
                                                "<group_state name='half' group='hand'><joint name='f' "
                                                "value='0.02'/></group_state>"))();
  BOOST_TEST_REQUIRE(robot->end_effectors().size() == 1u);
  const EndEffector& gripper = robot->end_effectors()[0];
  BOOST_TEST(gripper.link == "two");
  BOOST_TEST(gripper.joints == (Names{"f"}), boost::test_tools::per_element());
  BOOST_TEST(gripper.states.at("half").at("f") == 0.02);
  BOOST_TEST(!gripper.opening);  // both slide in the same direction
}

BOOST_AUTO_TEST_CASE(joint_names_keep_their_order) {
  RobotDescription description;
  description.joint_names = {"c", "a"};
  const auto robot = Load(kGroups, description)();
  BOOST_TEST(robot->joint_names() == (Names{"c", "a"}), boost::test_tools::per_element());
  BOOST_TEST(robot->end_effector() == "three");
  BOOST_TEST(robot->actuated_joints()[0].joint == 1u);  // parents first: a, then c
  BOOST_TEST(robot->actuated_joints()[1].joint == 0u);
}

BOOST_AUTO_TEST_CASE(unknown_names_are_rejected_with_the_nearest) {
  const auto refuses = [](RobotDescription description, const std::string& fragment) {
    const Load load(kGroups, std::move(description));
    check_throws<InvalidArgument>([&] { load(); }, fragment);
  };
  refuses(group("amr"), "robot 'r' has no group 'amr', did you mean 'arm'?");
  refuses(group("locomotion"), "has no group 'locomotion'; known are 'arm', 'hand' and 'all'");
  RobotDescription d;
  d.end_effector = "thre";
  refuses(d, "end effector 'thre' is not a link of robot 'r', did you mean 'three'?");
  d.end_effector = "c";
  refuses(d, "end effector 'c' is not a link of robot 'r'; it is a joint, which moves the link 'three'");
  d.end_effector = "hand";
  refuses(d, "it is a group of the SRDF: give it as group");
  d.end_effector = "palm_of_the_robot";
  refuses(d, "links at the ends of its chains are 'three', 'finger' and 'thumb'");
  d.end_effector = "base";
  refuses(d, "no movable joint leads to end effector 'base'");
  d = group("arm");
  d.end_effector = "base";
  refuses(d, "none of the planned joints of robot 'r' moves its end effector 'base'");
  d = {};
  d.joint_names = {"a", "zz"};
  refuses(d, "robot 'r' has no joint 'zz'");
  d.joint_names = {"a", "a"};
  refuses(d, "joint 'a' is named twice");
  d.joint_names = {"g"};
  refuses(d, "joint 'g' mimics joint 'f' and cannot be planned");
  d.group = "arm";
  refuses(d, "either a group or joint_names, not both");
}

BOOST_AUTO_TEST_CASE(an_ambiguous_end_effector_is_an_error_that_lists_the_candidates) {
  RobotDescription description;
  description.urdf_text = kRobot;
  check_throws<InvalidArgument>(
      [&] { RobotModel::load(description); },
      "robot 'r' has several leaf links; give an end_effector, such as 'three', 'finger' and 'thumb'");
  description.group = "arm";
  check_throws<InvalidArgument>([&] { RobotModel::load(description); }, "group 'arm' needs an SRDF");
  check_throws<InvalidArgument>([] { RobotModel::load({}); }, "needs a URDF");
  description.urdf_path = "x";
  check_throws<InvalidArgument>([&] { RobotModel::load(description); }, "not both");
}

BOOST_AUTO_TEST_CASE(other_joints_are_given_or_from_the_srdf_or_nearest_to_zero) {
  const std::string states =
      "<group_state name='open' group='hand'><joint name='f' value='0.03'/></group_state>"
      "<group_state name='home' group='hand'><joint name='f' value='0.01'/></group_state>";
  RobotDescription arm = group("arm");
  const auto value_of_f = [](const RobotModel& robot) { return robot.default_other_positions()[1]; };
  const auto plain = Load(kGroups, arm)();
  BOOST_TEST(plain->other_joints()[0].name == "c");
  BOOST_TEST(plain->default_other_positions()[0] == 0.5);  // the nearest to 0 that is allowed
  BOOST_TEST(value_of_f(*plain) == 0.0);
  BOOST_TEST(value_of_f(*Load(kGroups + states, arm)()) == 0.01);
  BOOST_TEST(value_of_f(*Load(kGroups + states.substr(0, states.find("<group_state name='home'")), arm)()) == 0.03);
  arm.fixed_joints = {{"f", 0.02}};
  BOOST_TEST(value_of_f(*Load(kGroups + states, arm)()) == 0.02);
}

BOOST_AUTO_TEST_CASE(invalid_fixed_joints_are_rejected) {
  const auto refuses = [](const std::map<std::string, double>& joints, const std::string& fragment) {
    const Load load(kGroups, fixed(joints));
    check_throws<InvalidArgument>([&] { load(); }, fragment);
  };
  refuses({{"f", 0.1}}, "f is 0.1; allowed is 0 to 0.04");
  refuses({{"f", NAN}}, "f is NaN; allowed is 0 to 0.04");
  refuses({{"ff", 0.1}}, "robot 'r' has no joint 'ff', did you mean 'f'?");
  refuses({{"a", 0.1}}, "joint 'a' of robot 'r' is planned");
  refuses({{"g", 0.1}}, "joint 'g' of robot 'r' follows joint 'f'");
}

BOOST_AUTO_TEST_CASE(group_states_of_all_planned_joints_are_kept) {
  const auto robot = Load(
      std::string(kGroups) +
          "<group_state name='up' group='arm'><joint name='a' value='0.2'/><joint name='b' value='3'/></group_state>"
          "<group_state name='half' group='arm'><joint name='a' value='0.2'/></group_state>",
      group("arm"))();
  BOOST_TEST(robot->group_states().size() == 1);
  BOOST_TEST(robot->group_states().at("up") == Eigen::Vector2d(0.2, 3));
}

BOOST_AUTO_TEST_CASE(srdf_errors_give_the_line) {
  refused("<grup name='x'/>", "r.srdf:2: unknown tag <grup> in <robot>, did you mean 'group'?");
  refused("\n<disable_collision link1='one' link2='two'/>",
          ":3: unknown tag <disable_collision> in <robot>, did you mean 'disable_collisions'?");
  refused("<disable_collisions link1='one'/>", "<disable_collisions> has no attribute 'link2'");
  refused("<disable_collisions lnk1='one' link2='two'/>",
          "unknown attribute 'lnk1' of <disable_collisions>, did you mean 'link1'?");
  refused("<enable_collisions link1='onee' link2='two'/>",
          ":2: <enable_collisions> names the unknown link 'onee', did you mean 'one'?");
  refused("<group name='x'/><group name='x'/>", "group 'x' is defined twice");
  refused("<group name='x'><group name='y'/></group><group name='y'><group name='x'/></group>", "contains itself");
  refused(
      "<group name='x'><joint name='a'/></group>\n<group_state name='s' group='x'>\n<joint name='a' "
      "value='zero'/></group_state>",
      ":4: attribute 'value' of <joint> contains 'zero', which is not a number");
  refused("<group name='x'>", "broken XML");
  RobotDescription missing;
  missing.urdf_text = kRobot;
  missing.srdf_path = "/no/such.srdf";
  check_throws<FileError>([&] { RobotModel::load(missing); }, "SRDF file '/no/such.srdf' does not exist");
}

BOOST_AUTO_TEST_CASE(what_leaves_the_meaning_of_the_rest_as_it_is_is_a_warning) {
  warned("<disable_collisions link1='onee' link2='two'/>",
         ":2: <disable_collisions> names the unknown link 'onee', did you mean 'one'?");
  warned("<group name='x'><joint name='aa'/></group>",
         ":2: group 'x' cannot be used: <joint> names the unknown joint 'aa', did you mean 'a'?");
  warned("<group name='x'><link name='on'/></group>", "<link> names the unknown link 'on', did you mean 'one'?");
  warned("<group name='x'><group name='y'/></group>", "names the unknown group 'y'");
  warned("<group_state name='s' group='x'/>", "<group_state> names the unknown group 'x'");
  warned("<end_effector name='e' parent_link='nowhere' group='x'/>", "names the unknown link 'nowhere'");
  warned("<virtual_joint name='v' type='fixed' parent_frame='world' child_link='bsae'/>",
         "unknown link 'bsae', did you mean 'base'?");
  warned("<passive_joint name='zz'/>", "names the unknown joint 'zz'");
}

BOOST_AUTO_TEST_CASE(a_group_with_an_unknown_name_is_refused_when_it_is_asked_for) {
  const std::string groups = std::string(kGroups) +
                             "<group name='lost'><joint name='aa'/></group><group name='more'><group name='lost'/>"
                             "<group name='arm'/></group>";
  BOOST_TEST(Load(groups, group("arm"))()->dof() == 2u);
  const auto refuses = [&](const std::string& name, const std::string& fragment) {
    const Load load(groups, group(name));
    check_throws<InvalidArgument>([&] { load(); }, fragment);
  };
  refuses("lost", "group 'lost' of robot 'r' cannot be used: ");
  refuses("lost", "<joint> names the unknown joint 'aa', did you mean 'a'?");
  refuses("more", "its subgroup 'lost' cannot be used");
}

BOOST_AUTO_TEST_CASE(a_chain_may_lead_up_one_branch_and_down_another) {
  const std::string groups =
      "<group name='across'><chain base_link='finger' tip_link='three'/></group>"
      "<group name='back'><chain base_link='two' tip_link='base'/></group>";
  const auto across = Load(groups, group("across"))();
  BOOST_TEST(across->joint_names() == (Names{"c", "f"}), boost::test_tools::per_element());
  BOOST_TEST(across->end_effector() == "three");
  const Load back(groups, group("back"));
  check_throws<InvalidArgument>([&] { back(); }, "none of the planned joints of robot 'r' moves its end effector");
}

BOOST_AUTO_TEST_CASE(states_count_for_the_joints_that_the_robot_has) {
  const auto robot = warned(
      "<group_state name='up'><joint name='a' value='0.2'/><joint name='b' value='3'/><joint name='c' value='1'/>"
      "<joint name='root_joint' value='0 0 0.5 0 0 0 1'/></group_state>",
      "<group_state> has no attribute 'group'");
  BOOST_TEST(robot->group_states().at("up") == Eigen::Vector3d(0.2, 3, 1));
  BOOST_TEST_REQUIRE(robot->warnings().size() == 2u);
  BOOST_TEST(robot->warnings()[1].find("<joint> names the unknown joint 'root_joint'") != std::string::npos);
}

BOOST_AUTO_TEST_CASE(rules_for_another_variant_are_ignored_with_a_warning) {
  const auto rule = [](const std::string& link) { return "<disable_collisions link1='" + link + "' link2='two'/>"; };
  warned(rule("laser") + rule("wheel"), "unknown link 'laser'");
  const auto robot = Load(rule("laser") + rule("wheel") + rule("camera") + rule("base"), strict())();
  BOOST_TEST(robot->warnings().size() == 1);
  BOOST_TEST(robot->warnings()[0].find("3 <disable_collisions> ignored; links 'camera', 'laser' and 'wheel'") !=
             std::string::npos);
  BOOST_TEST(robot->allowed("base", "two"));
}

BOOST_AUTO_TEST_CASE(positions_that_cannot_be_set_say_why) {
  const auto robot = Load("")();
  check_throws<InvalidArgument>([&] { robot->refuse_joint("g"); }, "joint 'g' of robot 'r' follows joint 'f'");
  check_throws<InvalidArgument>([&] { robot->refuse_joint("aa"); }, "robot 'r' has no joint 'aa', did you mean 'a'?");
  BOOST_TEST(robot->limit_violation(Eigen::Vector3d(30, 0, 0.6)).value() ==
             "a: 30 rad is above the upper limit 1 rad; angles are in radians (30 degrees are 0.5236 rad)");
  BOOST_TEST(robot->limit_violation(Eigen::Vector3d(3, 0, 0.6)).value() == "a: 3 rad is above the upper limit 1 rad");
}
