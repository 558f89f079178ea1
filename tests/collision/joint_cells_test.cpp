// JointCells, by configurations in the boxes.
#include "srmp/collision/joint_cells.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <set>

#include "collision/worlds.hpp"

using namespace srmp;
using namespace worlds;

BOOST_AUTO_TEST_CASE(boxes_are_free_or_in_contact_wherever_the_other_joints_are) {
  int free = 0, colliding = 0, undecided = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    Dice dice(seed);
    const auto robot = seed % 3 == 0 ? spheres() : seed % 3 == 1 ? arm7() : RobotModel::load(mesh_arm::description());
    Scene scene = robot->dof() == 2 ? Scene() : crowd(robot, seed, seed % 8, hand_of(*robot));
    if (robot->dof() == 2) {
      scene.add_robot(robot);
      for (int i = 0; i < 4; ++i)
        scene.add_object("box" + std::to_string(i), Box{{dice.in(0.1, 0.5), dice.in(0.1, 0.5), 0.4}},
                         at(dice.in(-2, 2), dice.in(-2, 2), 0.0, 0, 0, dice.in(-3, 3)));
    }
    const auto checker = make_checker(scene, robot->name());
    const auto workspace = checker->make_workspace(), other = checker->make_workspace();
    for (const auto& joints : JointCells::sets_of_joints(3, *workspace)) {
      BOOST_REQUIRE(joints.size() >= 2 && joints.size() <= 3);
      JointCells cells(joints, dice.configuration(*robot), *workspace);
      for (int trial = 0; trial < 20; ++trial) {
        Eigen::VectorXd middle = dice.configuration(*robot);
        for (int draw = 0; draw < 10 && trial % 2 && checker->is_free(middle, *other); ++draw)
          middle = dice.configuration(*robot);
        Eigen::VectorXd low(joints.size()), high(joints.size());
        for (std::size_t k = 0; k < joints.size(); ++k) {
          const double half = std::pow(10.0, dice.in(-3, -0.5));
          low[k] = middle[joints[k]] - half;
          high[k] = middle[joints[k]] + half;
        }
        JointCells::Pairs pairs = cells.pairs();
        const JointCells::Result result = cells.check(low, high, pairs);
        const std::string in_contact = [&]() -> std::string {
          if (result.status != CollisionStatus::colliding) return "";
          const Contact contact = cells.contact(result.pair);
          return contact.body_a + " and " + contact.body_b;
        }();
        std::vector<std::uint32_t> removed;
        std::ranges::set_difference(cells.pairs(), pairs, std::back_inserter(removed));
        for (int sample = 0; sample < 10; ++sample) {
          Eigen::VectorXd q = dice.configuration(*robot);
          for (std::size_t k = 0; k < joints.size(); ++k)
            q[joints[k]] = sample == 0 ? low[k] : sample == 1 ? high[k] : dice.in(low[k], high[k]);
          const std::set<std::string> contacts = contacts_at(*checker, q, *other);
          if (result.status == CollisionStatus::colliding) BOOST_REQUIRE(contacts.count(in_contact));
          if (result.status != CollisionStatus::free) continue;
          for (const std::uint32_t pair : removed) {
            const auto& scene_workspace = dynamic_cast<const detail::SceneWorkspace&>(*other);
            const detail::Pair& bodies = scene_workspace.model().bodies.pairs[pair];
            BOOST_REQUIRE(
                !contacts.count(scene_workspace.body_a(bodies).name + " and " + scene_workspace.body_b(bodies).name));
          }
        }
        ++(result.status == CollisionStatus::free        ? free
           : result.status == CollisionStatus::colliding ? colliding
                                                         : undecided);
      }
    }
  }
  BOOST_TEST_MESSAGE(free << " free, " << colliding << " colliding, " << undecided << " undecided");
  BOOST_TEST(free > 100);
  BOOST_TEST(colliding > 80);
  BOOST_TEST(undecided > 100);
}
