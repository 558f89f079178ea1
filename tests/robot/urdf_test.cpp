// Every mistake in a URDF is an error that gives the line and a remedy.
#include "srmp/robot/urdf.hpp"

#include <boost/test/unit_test.hpp>

#include "srmp/core/error.hpp"
#include "srmp/robot/robot_model.hpp"
#include "support/files.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

/// Two links and a joint; `joint` replaces the joint's inside, `rest` goes before the end.
std::string two_links(const std::string& joint, const std::string& rest = "", const std::string& type = "revolute") {
  return "<robot name='r'>\n<link name='base'/>\n<link name='tip'/>\n<joint name='j' type='" + type + "'>\n" + joint +
         "\n</joint>\n" + rest + "</robot>";
}

const std::string kEnds = "<parent link='base'/><child link='tip'/>";
const std::string kLimit = "<limit lower='-1' upper='1' velocity='1' effort='1'/>";

void refused(const std::string& text, const std::string& fragment) {
  check_throws<FileError>([&] { Urdf::parse(text); }, fragment);
}

std::string with_collision(const std::string& collision) {
  return "<robot name='r'>\n<link name='base'>\n" + collision + "</link></robot>";
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_valid_urdf_is_read) {
  const Urdf urdf =
      Urdf::parse(two_links(kEnds + kLimit + "<axis xyz='0 0 2'/><origin xyz='+1 .5 2.' rpy='0 0 1e-1'/>"));
  BOOST_TEST(urdf.joints[0].axis.z() == 1.0);
  BOOST_TEST(urdf.joints[0].xyz == Eigen::Vector3d(1, 0.5, 2));
  BOOST_TEST(urdf.joints[0].rpy.z() == 0.1);
  BOOST_TEST(urdf.links[urdf.root].name == "base");
}

BOOST_AUTO_TEST_CASE(xml_errors_give_the_line) {
  refused("<robot name='r'>\n<link name='a'>\n</robot>", ":2: broken XML");
  refused("", "URDF text is empty");
  refused(" \n\t", "URDF text is empty");
  refused("<!-- nothing -->", "contains no XML element");
  refused("<model name='r'/>", ":1: the outermost tag is <model>, expected <robot>");
  refused("<robot name='r'/>", "has no <link>");
  refused("<robot/>", "robot 'robot' has no <link>");
  refused("just words", "broken XML");
}

BOOST_AUTO_TEST_CASE(errors_name_missing_files) {
  const TemporaryDirectory directory;
  check_throws<FileError>([] { Urdf::read_file("/no/such/file.urdf"); }, "'/no/such/file.urdf' does not exist");
  check_throws<FileError>([&] { Urdf::read_file(directory.path()); }, "is not a file");
  const std::string empty = directory.write("empty.urdf", "");
  check_throws<FileError>([&] { Urdf::read_file(empty); }, "empty.urdf is empty");
}

BOOST_AUTO_TEST_CASE(errors_for_misspelt_tags_and_attributes_suggest_the_right_one) {
  refused("<robot name='r'>\n<link name='a'/>\n<jiont name='j'/></robot>",
          ":3: unknown tag <jiont> in <robot>, did you mean 'joint'?");
  refused(with_collision("<colision/>"), ":3: unknown tag <colision> in <link>, did you mean 'collision'?");
  refused(two_links(kEnds + "<limits lower='-1'/>"), ":5: unknown tag <limits> in <joint>, did you mean 'limit'?");
  refused(two_links(kEnds + "<limit lowr='-1' upper='1'/>"),
          "unknown attribute 'lowr' of <limit>, did you mean 'lower'?");
  refused(with_collision("<collision><geometry><shpere radius='1'/></geometry></collision>"), "did you mean 'sphere'?");
}

BOOST_AUTO_TEST_CASE(extension_tags_are_ignored) {
  const Urdf urdf = Urdf::parse(
      two_links(kEnds + kLimit + "<dynamics damping='1'/><safety_controller k_velocity='1'/><calibration rising='0'/>",
                "<gazebo reference='base'><colision/></gazebo><transmission name='t'><type>x</type></transmission>"
                "<drake:property name='p' value='1'/><ros2_control name='c'/><material name='m'/><zzzzzzzzzz/>"));
  BOOST_TEST(urdf.joints.size() == 1);
}

BOOST_AUTO_TEST_CASE(names_are_unique_and_exist) {
  refused("<robot name='r'>\n<link name='a'/>\n<link name='a'/></robot>", ":3: link 'a' is already defined in line 2");
  refused(two_links(kEnds + kLimit,
                    "<link name='x'/><joint name='j' type='fixed'><parent link='tip'/><child link='x'/></joint>"),
          "joint 'j' is already defined in line 4");
  refused(two_links("<parent link='bsae'/><child link='tip'/>" + kLimit),
          ":5: joint 'j': there is no parent link 'bsae', did you mean 'base'?");
  refused(two_links("<parent link='base'/><child link='tipp'/>" + kLimit), "no child link 'tipp', did you mean 'tip'?");
  refused(two_links("<parent link='base'/>" + kLimit), "joint 'j' has no <child>");
  refused("<robot name='r'><link/></robot>", "<link> has no attribute 'name'");
}

BOOST_AUTO_TEST_CASE(joints_form_one_tree) {
  refused("<robot name='r'><link name='a'/><link name='b'/></robot>", "links 'a' and 'b' have no parent joint");
  refused(two_links(kEnds + kLimit, "<joint name='k' type='fixed'>" + kEnds + "</joint>"),
          "is the child of both joint 'j' and joint 'k'");
  refused(two_links(kEnds + kLimit, "<joint name='k' type='fixed'><parent link='tip'/><child link='base'/></joint>"),
          "form a loop");
  refused(two_links(
              kEnds + kLimit,
              "<link name='x'/><link name='y'/><joint name='k' type='fixed'><parent link='x'/><child link='y'/></joint>"
              "<joint name='l' type='fixed'><parent link='y'/><child link='x'/></joint>"),
          "form a loop apart from the root 'base'");
}

BOOST_AUTO_TEST_CASE(joint_types_axes_and_limits_are_checked) {
  refused(two_links(kEnds + kLimit, "", "revolut"),
          ":4: joint 'j' has the unknown type 'revolut', did you mean 'revolute'?");
  refused(two_links(kEnds), "joint 'j' is revolute and has no <limit>");
  refused(two_links(kEnds, "", "prismatic"), "joint 'j' is prismatic and has no <limit>");
  refused(two_links(kEnds + "\n<limit lower='1' upper='-1' velocity='1'/>"),
          ":6: joint 'j': the lower limit 1 is above the upper limit -1");
  refused(two_links(kEnds + "<limit lower='-1' upper='1' velocity='-2'/>"), "the velocity limit -2 is negative");
  refused(two_links(kEnds + "<limit lower='nan' upper='1' velocity='1'/>"), "attribute 'lower' of <limit> is NaN");
  refused(two_links(kEnds + "<limit lower='-1' upper='inf' velocity='1'/>"),
          "attribute 'upper' of <limit> is infinity");
  refused(two_links(kEnds + "<limit lower='${pi}' upper='1' velocity='1'/>"),
          "attribute 'lower' of <limit> is '${pi}', an expression of Xacro; expand the file first");
  refused(two_links(kEnds + kLimit, "<xacro:include filename='$(find x)/y.xacro'/>"),
          "<xacro:include> is Xacro, which is not read; expand the file first (xacro FILE.xacro > FILE)");
  refused(two_links(kEnds + kLimit + "<axis xyz='0 0 0'/>"), "the axis of joint 'j' is zero");
  refused(two_links(kEnds + kLimit + "<origin xyz='0 0'/>"), "'0 0'; expected three numbers");
  BOOST_CHECK_NO_THROW(Urdf::parse(two_links(kEnds, "", "continuous")));
  BOOST_CHECK_NO_THROW(Urdf::parse(two_links(kEnds + "<axis xyz='0 0 0'/>", "", "fixed")));
}

BOOST_AUTO_TEST_CASE(mimics_are_checked_and_multiplied_out) {
  const auto chain = [](const std::string& of_k, const std::string& of_l) {
    const auto one = [](const std::string& name, const std::string& parent, const std::string& mimic) {
      return "<link name='" + name + "_link'/><joint name='" + name + "' type='revolute'><parent link='" + parent +
             "'/><child link='" + name + "_link'/>" + kLimit + mimic + "</joint>";
    };
    return two_links(kEnds + kLimit, one("k", "tip", of_k) + one("l", "tip", of_l));
  };
  const Urdf urdf = Urdf::parse(
      chain("<mimic joint='j' multiplier='2' offset='0.5'/>", "<mimic joint='k' multiplier='-3' offset='1'/>"));
  BOOST_TEST(urdf.joints[2].mimic->source == 0u);
  BOOST_TEST(urdf.joints[2].mimic->multiplier == -6.0);
  BOOST_TEST(urdf.joints[2].mimic->offset == -0.5);
  refused(chain("<mimic joint='jj'/>", ""), "joint 'k' mimics joint 'jj', which does not exist, did you mean 'j'?");
  refused(chain("<mimic joint='l'/>", "<mimic joint='k'/>"), "mimics itself");
}

BOOST_AUTO_TEST_CASE(collision_geometry_is_checked) {
  const auto shape = [](const std::string& s) {
    return with_collision("<collision><geometry>\n" + s + "</geometry></collision>");
  };
  refused(with_collision("<collision/>"), "a <collision> of link 'base' has no <geometry>");
  refused(shape(""), "is empty");
  refused(shape("<sphere radius='-1'/>"), ":4: attribute 'radius' of <sphere> is -1; it must be above 0");
  refused(shape("<sphere/>"), "<sphere> has no attribute 'radius'");
  refused(shape("<box size='1 0 1'/>"), "attribute 'size' of <box> is 0; it must be above 0");
  refused(shape("<cylinder radius='1'/>"), "<cylinder> has no attribute 'length'");
  refused(shape("<mesh/>"), "<mesh> has no attribute 'filename'");
  refused(shape("<mesh filename='a.stl' scale='1 0 1'/>"), "no component of the scale of a <mesh> may be 0");
  refused(shape("<torus radius='1'/>"), "unknown geometry <torus>; known are box, sphere, cylinder, capsule and mesh");
}

BOOST_AUTO_TEST_CASE(what_does_not_change_the_meaning_is_a_warning) {
  const auto warned = [](const std::string& text, const std::string& sentence, bool when_strict = true) {
    const Urdf urdf = Urdf::parse(text);
    BOOST_TEST_REQUIRE(urdf.warnings.size() == 1u);
    BOOST_TEST(urdf.warnings[0].find(sentence) != std::string::npos, urdf.warnings[0]);
    if (when_strict) check_throws<FileError>([&] { Urdf::parse(text, "URDF text", true); }, sentence);
  };
  const auto limit = [](const std::string& attributes) { return two_links(kEnds + "<limit " + attributes + "/>"); };
  warned(limit("lower='-1' upper='1' velocity='1' gear_velocity='10' effort='1'"),
         "URDF text:5: unknown attribute 'gear_velocity' of <limit> is not read; 'velocity' is");
  warned(limit("lower='-1' upper='1' gear_velocity='10'"),
         "unknown attribute 'gear_velocity' of <limit> is not read; 'velocity' is missing");
  refused(limit("lower='-1' upper='1' velocty='10'"), "unknown attribute 'velocty' of <limit>, did you mean");
  warned(with_collision("<collision_boxes/><collision_boxes/>"),
         "unknown tag <collision_boxes> in <link> is not read; <collision> would be (and once more)", false);
  warned("<robot><link name='a'/></robot>", "<robot> has no attribute 'name'");
  warned(with_collision("<collision_boxes/>"), "unknown tag <collision_boxes> in <link> is not read");
  warned(two_links(kEnds + kLimit + "<mimic joint='index_j1'/>"), "'index_j1', which does not exist; it is taken for");
  warned(limit("lower='-170' upper='170' velocity='1'"),
         "joint 'j' has the limits -170 to 170 rad, more than two turns; are they in degrees?", false);
  warned("<robot name='r'><link name='base'/><link name='tip'/><joint name='j' type='prismatic'>" + kEnds +
             "<limit lower='-1e6' upper='1' velocity='1'/></joint></robot>",
         "joint 'j' has the limits -1e+06 to 1 m; it is planned within 1000 m of 0", false);
  warned(two_links(kEnds + kLimit + "<origin rpy='0 0 90'/>"), "an angle of 90 rad, more than a turn", false);
}
