#include "srmp/io/primitives.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>

#include "io/temp_file.hpp"
#include "srmp/core/error.hpp"
#include "support/throws.hpp"

using namespace srmp;
using srmp::io::read_primitives;

namespace {

const double degree = std::numbers::pi / 180;

std::vector<Joint> joints() {
  return {{"slide", JointKind::prismatic, 0, 1, 1},
          {"turn", JointKind::revolute, -2, 2, 1},
          {"wrist", JointKind::continuous, -INFINITY, INFINITY, 1}};
}

PrimitiveSet read(const std::string& text) { return read_primitives(TempFile(text).path(), joints()); }

const std::string good = R"(units: degrees
near_distance: 0.3
families:
  - name: long
    joints: each
    by: 15
    use: far
  - name: both
    joints: [turn, wrist]
    by: [[10, 10], [10, -10]]
)";

void check_refused(const std::string& from, const std::string& to, const std::string& fragment) {
  check_throws<FileError>([&] { read(replaced(good, from, to)); }, fragment);
}

}  // namespace

BOOST_AUTO_TEST_CASE(families_become_moves_in_both_directions) {
  const PrimitiveSet set = read(good);
  BOOST_TEST(set.near_distance == 0.3);
  BOOST_REQUIRE(set.families.size() == 2u);
  const PrimitiveFamily &each = set.families[0], &both = set.families[1];
  BOOST_TEST(each.name == "long");
  BOOST_TEST((each.use == PrimitiveUse::far && both.use == PrimitiveUse::always));
  BOOST_REQUIRE(each.moves.size() == 6u);
  BOOST_TEST((each.moves[0] == Eigen::Vector3d(0.05, 0, 0)));
  BOOST_TEST((each.moves[1] == Eigen::Vector3d(-0.05, 0, 0)));
  BOOST_TEST((each.moves[2] - Eigen::Vector3d(0, 15 * degree, 0)).norm() < 1e-15);
  BOOST_TEST((each.moves[5] - Eigen::Vector3d(0, 0, -15 * degree)).norm() < 1e-15);
  BOOST_REQUIRE(both.moves.size() == 4u);
  BOOST_TEST((both.moves[3] - Eigen::Vector3d(0, -10, 10) * degree).norm() < 1e-15);
}

BOOST_AUTO_TEST_CASE(one_number_or_one_list_moves_joints_together) {
  const PrimitiveSet set = read(R"(units: radians
prismatic: 0.02
families:
  - {name: a, joints: [wrist, turn], by: 0.1}
  - {name: b, joints: [slide, turn], by: [0.1, -0.2]}
  - {name: c, joints: each, by: 0.5}
)");
  BOOST_TEST((set.families[0].moves[0] == Eigen::Vector3d(0, 0.1, 0.1)));
  BOOST_TEST((set.families[1].moves[1] == Eigen::Vector3d(-0.1, 0.2, 0)));
  BOOST_TEST((set.families[2].moves[0] == Eigen::Vector3d(0.02, 0, 0)));
  BOOST_TEST(set.near_distance == 0.4);
}

BOOST_AUTO_TEST_CASE(the_installed_example_can_be_read) {
  const PrimitiveSet set = read_primitives(SRMP_SOURCE_DIR "/python/srmp/data/primitives/default.yaml", joints());
  BOOST_TEST(set.families.size() == 2u);
}

BOOST_AUTO_TEST_CASE(errors_name_their_line) {
  check_refused("use: far", "use: fra", ":7: use is 'fra'; it must be far, near or always");
  check_refused("use: far", "use: far\n    step: 3", ":8: unknown key 'step' in a family");
  check_refused("families", "familes", "unknown key 'familes' in a primitive file, did you mean 'families'?");
  check_refused("by: 15", "bye: 15", "did you mean 'by'?");
  check_refused("by: 15", "by: 0", ":6: a move of family 'long' is zero");
  check_refused("by: 15", "by: .nan", ":6: by, for each joint, is .nan");
  check_refused("by: 15", "by: inf", "only finite numbers");
  check_refused("by: 15", "by: 1e999", "does not fit");
  check_refused("by: 15", "by: fifteen", "must be a number, not 'fifteen'");
  check_refused("by: 15", "by: [15, 15, 15]", "must be a number, not a list");
  check_refused("by: 15", "by: 200", "at most half a turn");
  check_refused("by: 15", "", "family 'long' has no 'by'");
  check_refused("by: 15", "by: 15\n    by: 10", "key 'by' appears twice");
  check_refused("joints: each", "joints: all", "must be 'each' or a list");
  check_refused("[turn, wrist]", "[turn, wirst]", ":9: unknown joint 'wirst', did you mean 'wrist'?");
  check_refused("[turn, wrist]", "[turn, turn]", "joint 'turn' appears twice");
  check_refused("[turn, wrist]", "[]", "names no joints");
  check_refused("[[10, 10], [10, -10]]", "[10]", ":10: by must be 2 numbers, not 1");
  check_refused("[[10, 10], [10, -10]]", "[[10, 10], [10]]", "an alternative of by must be 2 numbers, not 1");
  check_refused("[[10, 10], [10, -10]]", "[[10, 10], 3]", "must be a list");
  check_refused("[[10, 10], [10, -10]]", "[[10, 10], [-10, -10]]", "is repeated");
  check_refused("[[10, 10], [10, -10]]", "[0, 0]", "is zero");
  check_refused("[[10, 10], [10, -10]]", "[]", "empty list");
  check_refused("joints: [turn, wrist]\n    by: [[10, 10], [10, -10]]", "joints: [turn, slide]\n    by: 3",
                "some of the joints are revolute and some prismatic");
  check_refused("name: both", "name: long", ":8: there are two families named 'long'");
  check_refused("name: both", "name: ''", "name is empty");
  check_refused("degrees", "degree", "units are 'degree'; they must be degrees or radians");
  check_refused("units: degrees\n", "", "has no 'units'");
  check_refused("units: degrees", "units: radians", "(are the units right?)");
  check_refused("near_distance: 0.3", "near_distance: -1", ":2: near_distance is -1");
  check_refused("near_distance: 0.3", "prismatic: 0", "prismatic is 0 m");
}

BOOST_AUTO_TEST_CASE(a_set_must_have_moves_everywhere) {
  const auto lone = [](const std::string& rest) {
    return "units: degrees\nfamilies: [{name: a, joints: each, by: 5, use: " + rest;
  };
  check_throws<FileError>([&] { read(lone("far}]")); }, "no family is used near the goal");
  check_throws<FileError>([&] { read(lone("near}]")); }, "no family is used far from the goal");
  BOOST_TEST(read(lone("far}]\nnear_distance: 0")).families.size() == 1u);
  check_throws<FileError>([&] { read("units: degrees\nfamilies: []"); }, "no family is used far");
}

BOOST_AUTO_TEST_CASE(other_files_are_refused_as_primitive_files) {
  check_throws<FileError>([] { read(""); }, "the file is empty");
  check_throws<FileError>([] { read("# only a comment\n"); }, "the file is empty");
  check_throws<FileError>([] { read("- 1\n- 2\n"); }, "must be a map of keys and values, not a list");
  check_throws<FileError>([] { read("units: [degrees\n"); }, "not valid YAML");
  check_throws<FileError>([] { read(good + "---\n" + good); }, "a second document starts here");
  check_throws<FileError>([] { read_primitives("/no/such/file.yaml", joints()); },
                          "/no/such/file.yaml: there is no such file");
  check_throws<FileError>([] { read_primitives("/", joints()); }, "this is a directory");
  check_throws<InvalidArgument>([] { read_primitives(TempFile(good).path(), {}); }, "at least one planned joint");
}
