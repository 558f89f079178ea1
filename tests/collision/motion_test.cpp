#include <algorithm>
#include <atomic>
#include <boost/test/unit_test.hpp>
#include <cstdlib>
#include <new>
#include <thread>

#include "collision/worlds.hpp"
#include "support/amount.hpp"

using namespace srmp;
using namespace worlds;
using Eigen::Vector2d;

// --- every allocation of this program is counted

namespace {
std::atomic<long> allocations{0};

void* counted(std::size_t size, std::size_t alignment) {
  ++allocations;
  void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (!memory) throw std::bad_alloc();
  return memory;
}
}  // namespace

void* operator new(std::size_t size) { return counted(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return counted(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace {

struct Motion {
  Eigen::VectorXd a, b;
};

/// Half of them small, half of one joint only.
Motion random_motion(Dice& dice, const RobotModel& robot, double largest) {
  Motion motion{dice.configuration(robot), {}};
  motion.b = motion.a;
  const double size = largest * (dice.below(2) ? 1.0 : 0.2);
  if (dice.below(2))
    motion.b[static_cast<Eigen::Index>(dice.below(robot.dof()))] += dice.in(-size, size);
  else
    for (double& value : motion.b) value += dice.in(-size, size);
  return motion;
}

/// Every configuration of the motion, no point of a robot of `reach` moving more than `step` between two.
template <class Visit>
bool sample(const RobotModel& robot, const Motion& motion, double reach, double step, Visit&& visit) {
  const Eigen::VectorXd delta = robot.difference(motion.a, motion.b);
  const int steps = 1 + static_cast<int>(delta.cwiseAbs().sum() * reach / step);
  for (int i = 0; i <= steps; ++i)
    if (!visit(motion.a + delta * (double(i) / steps))) return false;
  return true;
}

struct Tally {
  int motions{}, free{}, wrongly_free{}, clear{}, clear_accepted{};
};

/// Compares is_motion_free with dense sampling: nothing in contact may be called free, nothing clear refused.
Tally compare(const Scene& scene, const RobotModel& robot, int motions, double largest, unsigned seed, double step) {
  constexpr double reach = 1.3, clearance = 0.005;
  const SceneChecker checker(scene, robot.name());
  const auto workspace = checker.make_workspace(), dense = checker.make_workspace();
  Dice dice(seed);
  Tally tally;
  while (tally.motions < motions) {
    const Motion motion = random_motion(dice, robot, largest);
    if (dice.below(4) && !checker.is_free(motion.a, *dense)) continue;
    ++tally.motions;
    const bool free = checker.is_motion_free(motion.a, motion.b, *workspace);
    if (checker.is_free(motion.a, *dense))
      BOOST_TEST(free == checker.is_motion_free(motion.a, motion.b, *workspace, {.start_is_free = true}));
    tally.free += free;
    const bool sampled_free =
        sample(robot, motion, reach, step, [&](const Eigen::VectorXd& q) { return checker.is_free(q, *dense); });
    if (free && !sampled_free) ++tally.wrongly_free;
    if (free) {
      ++tally.clear;
      ++tally.clear_accepted;
    } else if (sampled_free && sample(robot, motion, reach, 2 * clearance, [&](const Eigen::VectorXd& q) {
                 const auto nearest = checker.nearest(q, *dense);
                 return !nearest || nearest->distance > clearance;
               })) {
      ++tally.clear;
    }
  }
  return tally;
}

/// Is nothing within `clearance` of the robot anywhere on the motion, at steps of 0.1 mm? Steps that cannot come so
/// near are left out: neither body of a pair moves farther than a step from one to the next.
bool is_clear(const Checker& checker, const Motion& motion, double reach, double clearance,
              Checker::Workspace& workspace) {
  constexpr double step = 1e-4;
  int left_out = 0;
  return sample(checker.robot(), motion, reach, step, [&](const Eigen::VectorXd& q) {
    if (left_out-- > 0) return true;
    const auto nearest = checker.nearest(q, workspace);
    const double room = nearest ? nearest->distance - clearance : 1.0;
    left_out = static_cast<int>(room / (2 * step));
    return room > 0.0;
  });
}

void expect_sound_and_useful(const Tally& tally) {
  BOOST_TEST(tally.wrongly_free == 0);
  BOOST_TEST(tally.clear_accepted >= 0.95 * tally.clear);
  BOOST_TEST(tally.free > tally.motions / 10);
  BOOST_TEST(tally.free < tally.motions);
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_motion_does_not_jump_over_a_thin_wall) {
  Scene scene;
  scene.add_robot(robots::planar());
  scene.add_object("foil", Box{{0.1, 1e-4, 0.1}}, at(1.9, 0, 0));
  const SceneChecker checker(scene, "planar");
  const auto workspace = checker.make_workspace();
  BOOST_TEST(checker.is_free(Vector2d(-1, 0), *workspace));
  BOOST_TEST(checker.is_free(Vector2d(1, 0), *workspace));
  BOOST_TEST(!checker.is_motion_free(Vector2d(-1, 0), Vector2d(1, 0), *workspace));
  BOOST_TEST(!checker.is_motion_free(Vector2d(-1, 0), Vector2d(1, 0), *workspace, {.start_is_free = true}));
  BOOST_TEST(checker.is_motion_free(Vector2d(0.2, 0), Vector2d(2, 0), *workspace));
}

BOOST_AUTO_TEST_CASE(both_ends_belong_to_the_motion) {
  Scene scene;
  scene.add_robot(robots::planar());
  scene.add_object("x", Sphere{0.1}, at(1.5, 0, 0));
  const SceneChecker checker(scene, "planar");
  const auto workspace = checker.make_workspace();
  BOOST_TEST(!checker.is_motion_free(Vector2d(0, 0), Vector2d(0.5, 0), *workspace));
  BOOST_TEST(!checker.is_motion_free(Vector2d(0.5, 0), Vector2d(0, 0), *workspace));
  BOOST_TEST(!checker.is_motion_free(Vector2d(0, 0), Vector2d(0, 0), *workspace));
  BOOST_TEST(checker.is_motion_free(Vector2d(0.5, 0), Vector2d(0.5, 0), *workspace));
}

BOOST_AUTO_TEST_CASE(a_pair_that_a_motion_does_not_move_is_checked_unless_the_start_is_known_free) {
  Scene scene;
  scene.add_robot(robots::planar());
  scene.add_object("x", Sphere{0.1}, at(0.5, 0, 0));
  for (const CheckMode mode : {CheckMode::exact, CheckMode::coal}) {
    const SceneChecker checker(scene, "planar", {.mode = mode});
    const auto workspace = checker.make_workspace();
    BOOST_TEST(!checker.is_motion_free(Vector2d(0, 0), Vector2d(0, 0.5), *workspace));
  }
  const SceneChecker coal(scene, "planar", {.mode = CheckMode::coal});
  BOOST_TEST(coal.is_motion_free(Vector2d(0, 0), Vector2d(0, 0.5), *coal.make_workspace(), {.start_is_free = true}));
}

BOOST_AUTO_TEST_CASE(continuous_joints_go_the_short_way) {
  const auto robot = robots::planar("continuous");
  Scene scene;
  scene.add_robot(robot);
  scene.add_object("x", Sphere{0.1}, at(-1.5, 0, 0));
  const SceneChecker checker(scene, "planar");
  const auto workspace = checker.make_workspace();
  BOOST_TEST(!checker.is_motion_free(Vector2d(3, 0), Vector2d(-3, 0), *workspace));
  BOOST_TEST(checker.is_motion_free(Vector2d(1, 0), Vector2d(-1, 0), *workspace));
}

BOOST_AUTO_TEST_CASE(a_wide_corridor_is_free_and_a_clearance_of_a_tenth_of_a_millimetre_too) {
  Scene scene;
  scene.add_robot(robots::planar());
  scene.add_object("floor", Box{{6, 6, 0.1}}, at(0, 0, -0.1 - 1e-4));  // 0.1 mm below the bars
  const SceneChecker checker(scene, "planar");
  const auto workspace = checker.make_workspace();
  BOOST_TEST(checker.is_motion_free(Vector2d(-1, 0.5), Vector2d(1, -0.5), *workspace));
}

BOOST_AUTO_TEST_CASE(meshes_that_pass_each_other_closely_take_few_distances) {
  for (const double gap : {4e-5, -4e-5}) {  // [m] of an angle iron that slides along in another
    const auto robot = slide();
    Scene scene;
    scene.add_robot(robot);
    scene.set_qpos("slide", Eigen::Vector3d(0, 0, 0));
    const Pose held = at(-0.5, 0, 0.5);
    scene.add_object("held", angle_iron(), {});
    scene.attach_object("held", "slide", "cart", {}, held);
    const double corner = 0.03 + gap;  // the irons are 3 cm thick
    scene.add_object("rail", angle_iron(), scene.link_pose("slide", "cart") * held * at(-corner, 0, -corner));
    const SceneChecker checker(scene, "slide");
    const auto workspace = checker.make_workspace();
    const bool is_free = checker.is_motion_free(Eigen::Vector3d(-0.05, 0, 0), Eigen::Vector3d(0.06, 0, 0), *workspace);
    BOOST_TEST(is_free == (gap > 0));
    BOOST_TEST(checker.statistics(*workspace).narrow_phase <= 300u);  // by distances alone 5 000
  }
}

namespace {

/// The smallest distance along the motion, at so many configurations.
double smallest_distance(const Scene& scene, const Motion& motion, int samples) {
  const SceneChecker checker(scene, "slide", {.mode = CheckMode::coal});
  const auto workspace = checker.make_workspace();
  double smallest = 1.0;
  sample(checker.robot(), motion, 1.0, (motion.b - motion.a).lpNorm<1>() / samples, [&](const Eigen::VectorXd& q) {
    smallest = std::min(smallest, checker.nearest(q, *workspace)->distance);
    return true;
  });
  return smallest;
}

/// A shape on the cart passes another one at about this distance, or does not.
void check_passing(const Mesh& held, const Mesh& beside, double clearance, Dice& dice) {
  Scene scene;
  scene.add_robot(slide());
  scene.set_qpos("slide", Eigen::Vector3d(0, 0, 0));
  scene.add_object("held", held, {});
  scene.attach_object("held", "slide", "cart", {}, at(0, 0, 0.5, dice.in(-3, 3), dice.in(-3, 3), dice.in(-3, 3)));
  Pose place = scene.link_pose("slide", "cart") * at(0, 0, 0.5, dice.in(-3, 3), dice.in(-3, 3), dice.in(-3, 3));
  place.p.x() += 0.3;
  scene.add_object("beside", beside, place);
  const Motion motion{Eigen::Vector3d(-0.15, 0, 0), Eigen::Vector3d(0.15, 0, 0)};
  for (int k = 0; k < 4; ++k) {
    place.p.x() -= smallest_distance(scene, motion, 60) - clearance;
    scene.set_object_pose("beside", place);
  }
  const double smallest = smallest_distance(scene, motion, 600);
  const SceneChecker checker(scene, "slide");
  const auto workspace = checker.make_workspace();
  const bool is_free = checker.is_motion_free(motion.a, motion.b, *workspace);
  if (smallest < 1e-6) BOOST_TEST(!is_free);
  if (smallest > 6e-5) BOOST_TEST(is_free);
}

}  // namespace

BOOST_AUTO_TEST_CASE(meshes_that_pass_each_other_closely_are_free_where_they_stay_apart) {
  const Mesh mesh = dented(), hull = hull_of(mesh);
  Dice dice(23);
  for (int i = 0; i < amount(3); ++i)
    for (const double clearance : {-2e-5, 2e-5, 8e-5, 2e-4}) {
      check_passing(mesh, mesh, clearance, dice);
      check_passing(hull, mesh, clearance, dice);
      check_passing(mesh, hull, clearance, dice);
    }
}

BOOST_AUTO_TEST_CASE(a_long_check_stops_at_the_deadline_and_a_short_one_need_not) {
  Scene scene;
  scene.add_robot(robots::planar());
  scene.add_object("floor", Box{{6, 6, 0.1}}, at(0, 0, -0.1 - 1e-4));
  const SceneChecker checker(scene, "planar");
  const auto workspace = checker.make_workspace();
  const Deadline passed(1e-9), never;
  checker.stop_at(passed, *workspace);
  BOOST_CHECK_THROW(checker.is_motion_free(Vector2d(-1, 0.5), Vector2d(1, -0.5), *workspace), MotionCheckStopped);
  BOOST_TEST(checker.is_motion_free(Vector2d(-1, 0.5), Vector2d(-1, 0.5), *workspace));
  checker.stop_at(never, *workspace);  // and nothing is left over of the check that was stopped
  BOOST_TEST(checker.is_motion_free(Vector2d(-1, 0.5), Vector2d(1, -0.5), *workspace));
}

BOOST_AUTO_TEST_CASE(long_queries_of_one_configuration_stop_at_the_deadline) {
  Scene scene;
  scene.add_robot(robots::planar());
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 20'000; ++i) points.emplace_back(0.01 * (i % 200) - 1.0, 0.02 * (i / 200) - 1.0, 0.5);
  scene.add_object("cloud", PointCloud{points, 0.01}, Pose());
  const SceneChecker checker(scene, "planar", {.mode = CheckMode::coal});
  const auto workspace = checker.make_workspace();
  const Vector2d q(0.3, -0.5);
  const auto before = checker.nearest(q, *workspace);
  const Deadline passed(1e-9), never;
  checker.stop_at(passed, *workspace);
  BOOST_CHECK_THROW(checker.nearest(q, *workspace), MotionCheckStopped);
  checker.stop_at(never, *workspace);
  const auto after = checker.nearest(q, *workspace);
  BOOST_TEST(before->distance == after->distance);
}

BOOST_AUTO_TEST_CASE(motions_among_every_kind_of_object_are_sound_and_useful) {
  const auto robot = arm7();
  for (unsigned world = 0; world < 4; ++world) {
    const std::size_t held = world == 0 ? 99 : 2 * world - 1;  // nothing, a sphere, a capsule, a mesh
    expect_sound_and_useful(compare(crowd(robot, world, held, "arm7_hand"), *robot, 300, 0.6, 100 + world, 2e-4));
  }
}

BOOST_AUTO_TEST_CASE(long_motions_are_sound_and_useful) {
  const auto robot = arm7();
  expect_sound_and_useful(compare(crowd(robot, 11, 7, "arm7_hand"), *robot, 100, 3.0, 7, 2e-3));
}

BOOST_AUTO_TEST_CASE(motions_of_mimic_and_prismatic_joints_are_sound_and_useful) {
  const auto robot = slide();
  Scene scene;
  scene.add_robot(robot);
  Dice dice(4);
  for (int i = 0; i < 6; ++i) scene.add_object("x" + std::to_string(i), Box{{0.2, 0.3, 0.2}}, dice.pose(0.6, 2.5));
  scene.add_object("held", Sphere{0.1}, {});
  scene.attach_object("held", "slide", "tip", {"fore"});
  const Tally tally = compare(scene, *robot, 200, 0.5, 2, 1e-3);
  BOOST_TEST(tally.wrongly_free == 0);
  BOOST_TEST(tally.clear_accepted >= 0.95 * tally.clear);
}

BOOST_AUTO_TEST_CASE(motions_of_robots_of_meshes_are_sound_and_useful) {
  for (const auto& robot : robots_of_meshes())
    expect_sound_and_useful(compare(crowd(robot, 2, 5, hand_of(*robot)), *robot, 150, 0.6, 3, 5e-4));
}

BOOST_AUTO_TEST_CASE(a_thousand_certified_motions_hit_nothing_at_steps_of_a_tenth_of_a_millimetre) {
  constexpr double reach = 1.3, clearance = 0.005;
  const auto mesh_robot = panda();  // else the arm of primitives
  const auto robot = mesh_robot ? mesh_robot : arm7();
  const Scene scene = crowd(robot, 2, 5, mesh_robot ? "panda_hand" : "arm7_hand");
  const SceneChecker checker(scene, robot->name(), {.mode = CheckMode::coal});
  const auto workspace = checker.make_workspace();
  Dice dice(12);
  int proved = 0, hits = 0, clear = 0, clear_proved = 0;
  while (proved < amount(1000)) {
    const Motion motion = random_motion(dice, *robot, 0.2);
    if (!checker.is_free(motion.a, *workspace)) continue;
    const bool certified = checker.certify_motion(motion.a, motion.b, *workspace).proved;
    if (certified) {
      ++proved;
      hits += !sample(*robot, motion, reach, 1e-4, [&](const auto& q) { return checker.is_free(q, *workspace); });
    }
    if (is_clear(checker, motion, reach, clearance, *workspace)) {
      ++clear;
      clear_proved += certified;
    }
  }
  BOOST_TEST(hits == 0);
  BOOST_TEST(clear > amount(500));
  BOOST_TEST(clear_proved >= 0.95 * clear);
  BOOST_TEST_MESSAGE(clear_proved << " of " << clear << " motions with more than 5 mm of clearance are proved");
}

BOOST_AUTO_TEST_CASE(results_do_not_depend_on_earlier_queries) {
  const auto robot = arm7();
  const Scene scene = crowd(robot, 21, 5, "arm7_hand");
  const SceneChecker checker(scene, "arm7");
  const auto used = checker.make_workspace();
  Dice dice(1);
  for (int i = 0; i < amount(300); ++i) {
    const Motion motion = random_motion(dice, *robot, 1.0);
    const auto fresh = checker.make_workspace();
    BOOST_TEST(checker.is_free(motion.a, *used) == checker.is_free(motion.a, *fresh));
    BOOST_TEST(checker.is_motion_free(motion.a, motion.b, *used) == checker.is_motion_free(motion.a, motion.b, *fresh));
    const auto one = checker.nearest(motion.a, *used), other = checker.nearest(motion.a, *checker.make_workspace());
    BOOST_TEST(one->distance == other->distance);
    BOOST_TEST(one->point_a == other->point_a);
    BOOST_TEST(one->describe() == other->describe());
  }
}

BOOST_AUTO_TEST_CASE(two_threads_share_a_checker) {
  const auto robot = arm7();
  const Scene scene = crowd(robot, 31, 5, "arm7_hand");
  const SceneChecker checker(scene, "arm7");
  std::vector<Motion> motions;
  Dice dice(8);
  for (int i = 0; i < amount(400); ++i) motions.push_back(random_motion(dice, *robot, 0.8));
  const auto results = [&](std::string& out) {
    const auto workspace = checker.make_workspace();
    for (const Motion& m : motions) {
      out += checker.is_free(m.a, *workspace) ? '1' : '0';
      out += checker.is_motion_free(m.a, m.b, *workspace) ? '1' : '0';
    }
  };
  std::string alone, first, second;
  results(alone);
  std::thread one([&] { results(first); }), two([&] { results(second); });
  one.join();
  two.join();
  BOOST_TEST(first == alone);
  BOOST_TEST(second == alone);
}

/// Does the work twice.
template <class Work>
long allocations_of_second(const Work& work) {
  work();
  const long before = allocations;
  work();
  return allocations - before;
}

BOOST_AUTO_TEST_CASE(nothing_is_allocated_once_the_workspace_is_warm) {
  const auto robot = arm7();
  const Scene scene = crowd(robot, 41, 2, "arm7_hand");
  const SceneChecker checker(scene, "arm7");
  const auto workspace = checker.make_workspace();
  std::vector<Motion> motions;
  Dice dice(5);
  for (int i = 0; i < amount(300); ++i) motions.push_back(random_motion(dice, *robot, 0.5));
  int free = 0;
  const auto check_all = [&] {
    for (const Motion& m : motions)
      free += checker.is_free(m.a, *workspace) + checker.is_motion_free(m.a, m.b, *workspace);
  };
  BOOST_TEST(allocations_of_second(check_all) == 0);
  BOOST_TEST(free > 0);
}

BOOST_AUTO_TEST_CASE(distances_of_meshes_and_large_hulls_allocate_nothing) {
  const auto mesh = make_geometry(dented(), "mesh");
  const auto hull = make_geometry(hull_of(dented()), "hull");
  const detail::Bounds of_mesh = detail::bounds_of(*mesh), of_hull = detail::bounds_of(*hull);
  const auto bvh = make_primitive_bvh(*mesh);
  const detail::FormulaTable table;
  detail::NarrowPhase narrow(table);
  int near = 0;
  const auto measure_all = [&] {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Isometry3d here = Eigen::Isometry3d::Identity(),
                              there = at(0.2, 0.004 * i, 0.02, 0.1 * i).isometry();
      const Eigen::Vector3d center = here * of_mesh.center, center_of_other = there * of_hull.center;
      const detail::Placed a{mesh.get(), bvh.get(), of_mesh, here, center};
      const detail::Placed other_mesh{mesh.get(), bvh.get(), of_mesh, there, center_of_other};
      const detail::Placed other_hull{hull.get(), nullptr, of_hull, there, center_of_other};
      for (const detail::Placed& b : {other_mesh, other_hull}) near += narrow.primitives(a, b, {.margin = 0.1}) < 0.1;
    }
  };
  BOOST_TEST(allocations_of_second(measure_all) == 0);
  BOOST_TEST(near > 100);
}

BOOST_AUTO_TEST_CASE(the_workspace_counts) {
  Scene scene;
  scene.add_robot(robots::planar());
  scene.add_object("x", Sphere{0.1}, at(1.5, 0.3, 0));
  const SceneChecker checker(scene, "planar");
  const auto workspace = checker.make_workspace();
  checker.is_free(Vector2d(0, 0), *workspace);
  checker.is_motion_free(Vector2d(0, 0), Vector2d(0.1, 0), *workspace);
  const CheckStatistics& statistics = checker.statistics(*workspace);
  BOOST_TEST(statistics.states == 1u);
  BOOST_TEST(statistics.motions == 1u);
  BOOST_TEST(statistics.configurations >= 2u);
  BOOST_TEST(statistics.narrow_phase >= 1u);
}
