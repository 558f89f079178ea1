#include "srmp/collision/pair_table.hpp"

#include <bit>
#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"
#include "support/amount.hpp"
#include "support/files.hpp"

using namespace srmp;
using namespace worlds;

namespace {

std::string stl(const Mesh& mesh) {
  std::string text = "solid s\n";
  for (const auto& t : mesh.triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const int i : t) {
      const Eigen::Vector3d& v = mesh.vertices[static_cast<std::size_t>(i)];
      text += "vertex " + std::to_string(v.x()) + " " + std::to_string(v.y()) + " " + std::to_string(v.z()) + "\n";
    }
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid s\n";
}

/// Three angle irons in a row, turning about z and y: the last can hit the first. And one that nothing reaches.
/// `planned`: joints, all when empty.
std::shared_ptr<const RobotModel> irons(const TemporaryDirectory& directory,
                                        const std::vector<std::string>& planned = {}) {
  const std::string file = directory.write("iron.stl", stl(angle_iron()));
  const auto iron = [&](const std::string& name) {
    return "<link name='" + name + "'><collision><geometry><mesh filename='" + file +
           "'/></geometry></collision></link>";
  };
  const std::string limit = "<limit lower='-1' upper='1' velocity='2' effort='1'/>";
  RobotDescription description;
  description.urdf_text = "<robot name='irons'>" + iron("first") + iron("second") + iron("third") + iron("far") +
                          "<link name='tip'/>" +
                          robots::joint("a", "revolute", "first", "second", "0.15 0 0.1", "0 0 1", limit) +
                          robots::joint("b", "revolute", "second", "third", "0.1 0 0.1", "0 1 0", limit) +
                          robots::joint("f", "fixed", "first", "far", "-3 0 0", "0 0 1", "") +
                          robots::joint("t", "fixed", "third", "tip", "0 0 0", "0 0 1", "") + "</robot>";
  description.end_effector = "tip";
  description.joint_names = planned;
  return RobotModel::load(description);
}

bool same(const PairTables& a, const PairTables& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const PairTable& x, const PairTable& y) {
    return x.geometry_a == y.geometry_a && x.geometry_b == y.geometry_b && x.joints == y.joints && x.free == y.free;
  });
}

}  // namespace

BOOST_AUTO_TEST_CASE(what_a_table_calls_free_is_free) {
  const TemporaryDirectory directory;
  const auto robot = irons(directory);
  PairTableStore store("");
  const auto tables = store.tables(robot, parts_of_all(*robot));
  BOOST_TEST(store.tables(robot, {}) == tables);  // known
  Scene scene;
  scene.add_robot(robot);
  const SceneChecker coal(scene, "irons", {.mode = CheckMode::coal});
  const auto workspace = coal.make_workspace();
  int contacts = 0;
  bool far_dropped = false;
  for (const PairTable& table : *tables) {
    const auto link = [&](std::size_t i) { return robot->geometries()[i].link; };
    const std::string a = link(table.geometry_a), b = link(table.geometry_b);
    if (a == "far" || b == "far") {
      BOOST_TEST(table.never_collide(), a << ' ' << b);
      far_dropped = true;
      continue;
    }
    BOOST_TEST(!table.never_collide());
    Dice dice(1);
    int proved = 0;
    for (int i = 0; i < amount(4000); ++i) {  // far beyond the limits, too
      Eigen::Vector2d q(dice.in(-7, 7), dice.in(-7, 7));
      const std::array<double, 2> at{q[table.joints[0]], table.joints[1] < 0 ? 0 : q[table.joints[1]]};
      bool contact = false;
      for (const Contact& c : coal.contacts(q, *workspace))
        contact = contact || (c.body_a == a && c.body_b == b) || (c.body_a == b && c.body_b == a);
      const bool free = table.is_free(at, at);
      BOOST_TEST(!(free && contact));
      proved += free;
      contacts += contact;
    }
    BOOST_TEST(proved > amount(1000));
    // A range is free when all of it is.
    BOOST_TEST(!table.is_free({-4, -4}, {4, 4}));
  }
  BOOST_TEST(contacts > amount(100));
  BOOST_TEST(far_dropped);
}

BOOST_AUTO_TEST_CASE(a_table_knows_meshes_that_turn_beside_each_other) {
  for (const double gap : {1e-4, 1e-5}) {  // [m] between the bases of two pyramids, of which one turns on its base
    const TemporaryDirectory directory;
    const auto pyramid = [&](const std::string& name, double top) {
      const Mesh mesh{{{0, 0, 0}, {0.2, 0, 0}, {0, 0.2, 0}, {0.05, 0.05, top}},
                      {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
      return "<link name='" + name + "'><collision><geometry><mesh filename='" +
             directory.write(name + ".stl", stl(mesh)) + "'/></geometry></collision></link>";
    };
    RobotDescription description;
    description.urdf_text = "<robot name='pyramids'><link name='base'/>" + pyramid("lower", -0.1) +
                            pyramid("upper", 0.1) + robots::joint("f", "fixed", "base", "lower", "0 0 0", "0 0 1", "") +
                            robots::joint("a", "revolute", "base", "upper", "0 0 " + std::to_string(gap), "0 0 1",
                                          "<limit lower='-3' upper='3' velocity='2' effort='1'/>") +
                            "</robot>";
    description.srdf_text = "<robot name='pyramids'><enable_collisions link1='lower' link2='upper'/></robot>";
    description.end_effector = "upper";
    const auto robot = RobotModel::load(description);
    const auto tables = PairTableStore("").tables(robot, parts_of_all(*robot));
    BOOST_REQUIRE(tables->size() == 1u);
    int proved = 0;
    for (const std::uint64_t word : tables->front().free) proved += std::popcount(word);
    BOOST_TEST((gap > PairTable::reserve ? proved > 0.9 * PairTable::cells : proved < 0.6 * PairTable::cells), proved);
  }
}

BOOST_AUTO_TEST_CASE(a_range_is_free_where_all_of_its_cells_are) {
  Dice dice(3);
  constexpr double cell = 2 * M_PI / PairTable::cells;
  int free = 0;
  for (const int joints : {1, 2})
    for (int k = 0; k < amount(3000); ++k) {
      PairTable table{0, 1, {0, joints == 2 ? 1 : -1}, {}};
      const int rows = joints == 2 ? PairTable::cells : 1;
      table.free.assign(static_cast<std::size_t>(rows) * PairTable::cells / 64, ~std::uint64_t{0});
      std::array<int, 2> first{}, last{}, hole{};  // cells
      std::array<double, 2> low{}, high{};
      for (std::size_t i = 0; i < 2; ++i) {
        first[i] = static_cast<int>(dice.in(-600, 600));
        last[i] = first[i] + static_cast<int>(dice.in(0, k % 5 ? 20 : 300));
        hole[i] = static_cast<int>(dice.in(first[i] - 30, last[i] + 30));
        low[i] = (first[i] + 0.5) * cell;
        high[i] = (last[i] + 0.5) * cell;
      }
      const auto wrapped = [](int number) { return static_cast<std::size_t>(number & (PairTable::cells - 1)); };
      const std::size_t bit = (joints == 2 ? wrapped(hole[1]) * PairTable::cells : 0) + wrapped(hole[0]);
      table.free[bit / 64] &= ~(std::uint64_t{1} << bit % 64);
      const auto touches = [&](std::size_t i) {
        for (int c = first[i]; c <= last[i]; ++c)
          if (wrapped(c) == wrapped(hole[i])) return true;
        return false;
      };
      const bool expected = !(touches(0) && (joints == 1 || touches(1)));
      BOOST_REQUIRE(table.is_free(low, high) == expected);
      free += expected;
    }
  BOOST_TEST((free > amount(1000) && free < amount(5000)), free);
}

BOOST_AUTO_TEST_CASE(checkers_with_tables_give_the_same_results) {
  const TemporaryDirectory directory;
  const auto robot = irons(directory);
  Scene scene;
  scene.add_robot(robot);
  scene.add_object("post", Box{{0.05, 0.05, 0.5}}, at(0.25, 0.2, 0.2));
  CheckerOptions with;
  with.pair_tables = std::make_shared<PairTableStore>("");
  with.pair_tables->tables(robot, parts_of_all(*robot));
  const SceneChecker tables(scene, "irons", with), plain(scene, "irons", {.mode = CheckMode::coal});
  const auto w = tables.make_workspace(), v = plain.make_workspace();
  Dice dice(2);
  int free = 0;
  for (int i = 0; i < amount(1000); ++i) {
    const Eigen::Vector2d a(dice.in(-4, 4), dice.in(-4, 4)), b = a + Eigen::Vector2d(dice.in(-1, 1), dice.in(-1, 1));
    BOOST_TEST(tables.is_free(a, *w) == plain.is_free(a, *v));
    const bool is_free = tables.is_motion_free(a, b, *w);
    BOOST_TEST(is_free == plain.is_motion_free(a, b, *v));
    free += is_free;
  }
  BOOST_TEST((free > amount(100) && free < amount(900)));
  BOOST_TEST(tables.statistics(*w).by_tables > 0u);
}

BOOST_AUTO_TEST_CASE(links_that_other_joints_move_have_no_table) {
  const TemporaryDirectory directory;
  const auto robot = irons(directory, {"a"});  // b stands where the scene puts it
  PairTableStore store("");
  const auto tables = store.tables(robot, parts_of_all(*robot));
  const auto has_third = [&](const PairTable& table) {
    return robot->geometries()[table.geometry_a].link == "third" ||
           robot->geometries()[table.geometry_b].link == "third";
  };
  BOOST_TEST(!tables->empty());
  BOOST_TEST(std::none_of(tables->begin(), tables->end(), has_third));
}

BOOST_AUTO_TEST_CASE(tables_are_kept_in_a_directory_and_made_again_when_damaged) {
  const TemporaryDirectory directory;
  const auto robot = irons(directory);
  const auto load = [&] {
    PairTableStore store(directory.path("cache"));
    return store.tables(robot, parts_of_all(*robot));
  };
  const auto built = load(), loaded = load();
  BOOST_TEST(same(*built, *loaded));
  for (const auto& entry : std::filesystem::directory_iterator(directory.path("cache"))) {
    BOOST_TEST(entry.path().extension() == ".pairs");
    std::filesystem::resize_file(entry.path(), std::filesystem::file_size(entry.path()) / 2);
  }
  BOOST_TEST(same(*built, *load()));
}
