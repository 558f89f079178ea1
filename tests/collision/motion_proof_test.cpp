#include "srmp/collision/motion_proof.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"
#include "srmp/core/error.hpp"
#include "srmp/trajectory/trajectory.hpp"
#include "support/amount.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace worlds;
using Eigen::Vector2d;

namespace {

constexpr double step = 1e-4;  // [m] of motion between samples
constexpr double gjk = 3e-6;   // [m] that two distances of the same pair may differ
constexpr double infinity = std::numeric_limits<double>::infinity();

/// The rows of a motion; Trajectory::sample says where it is.
Trajectory motion_of(const Checker& checker, Eigen::Index rows) {
  const auto dof = static_cast<Eigen::Index>(checker.dof());
  Trajectory t;
  for (Eigen::Index j = 0; j < dof; ++j) t.joint_names.push_back("j" + std::to_string(j));
  t.positions.resize(rows, dof);
  t.velocities.resize(rows, dof);
  t.times.resize(rows);
  return t;
}

/// A walk of `rows` rows, joints moving by up to `size` from one to the next, half of the time with velocities.
Trajectory random_walk(Dice& dice, const Checker& checker, Eigen::Index rows, double size) {
  Trajectory t = motion_of(checker, rows);
  const RobotModel& robot = checker.robot();
  for (Eigen::Index i = 0; i < rows; ++i) {
    t.times[i] = i == 0 ? dice.in(-1, 1) : t.times[i - 1] + dice.in(0.01, 0.5);
    for (Eigen::Index j = 0; j < t.positions.cols(); ++j) {
      t.positions(i, j) = i == 0 ? dice.configuration(robot)[j % static_cast<Eigen::Index>(robot.dof())]
                                 : t.positions(i - 1, j) + dice.in(-size, size);
      t.velocities(i, j) = dice.in(-size, size) * 4.0;
    }
  }
  if (dice.below(2)) t.velocities.resize(0, t.positions.cols());
  return t;
}

MotionProof prove(const Checker& checker, const Trajectory& t, Checker::Workspace& workspace,
                  const ProofOptions& options = {}) {
  return prove_motion(checker, {t.times, t.positions, t.velocities}, workspace, options);
}

struct Sampled {
  double smallest{infinity};  // distance found, within half a millimetre of the smallest
  double deepest{0.0};        // of contacts found
};

/// The nearest pair at samples between which nothing moves by more than `step`; those that cannot come nearer than what
/// is known already are left out.
Sampled sample(const Checker& checker, const Trajectory& t, Checker::Workspace& workspace) {
  const Eigen::VectorXd reach = checker.reach();
  Sampled sampled;
  int left_out = 0;
  for (Eigen::Index row = 0; row + 1 < t.positions.rows(); ++row) {
    const double h = t.times[row + 1] - t.times[row];
    const Eigen::VectorXd step_of_joints = (t.positions.row(row + 1) - t.positions.row(row)).transpose().cwiseAbs();
    Eigen::VectorXd fastest = step_of_joints / h;  // of a cubic: |v| <= 1.5 |mean| + |v0| + |v1|
    if (t.velocities.rows() > 0)
      fastest = 1.5 * fastest + (t.velocities.row(row).cwiseAbs() + t.velocities.row(row + 1).cwiseAbs()).transpose();
    const int steps = 1 + static_cast<int>(h * fastest.dot(reach) / step);
    for (int i = 0; i <= steps; ++i) {
      if (left_out-- > 0) continue;
      const auto nearest = checker.nearest(t.sample(t.times[row] + h * i / steps), workspace);
      const double apart = nearest ? nearest->distance : 1.0;
      sampled.smallest = std::min(sampled.smallest, apart);
      sampled.deepest = std::max(sampled.deepest, -apart);
      left_out = static_cast<int>(std::min(apart, apart - sampled.smallest + 5e-4) / (2 * step));
    }
  }
  return sampled;
}

struct Tally {
  int free{}, proved{}, contacts{}, near{};
};

/// Everything that a proof claims, against dense sampling.
void compare(const Checker& checker, const Trajectory& t, Tally& tally) {
  const auto workspace = checker.make_workspace(), other = checker.make_workspace();
  const MotionProof proof = prove(checker, t, *workspace);
  const Sampled sampled = sample(checker, t, *other);
  BOOST_TEST((proof.time >= t.times[0] && proof.time <= t.times[t.times.size() - 1]));
  const auto there = checker.nearest(t.sample(proof.time), *other);
  BOOST_REQUIRE(there.has_value());
  if (!proof.free) {
    ++tally.contacts;
    BOOST_TEST(there->distance <= gjk);
    BOOST_TEST(proof.proved == 0.0);
    return;
  }
  ++tally.free;
  tally.near += proof.clearance < 0.01;
  BOOST_TEST(sampled.smallest > -Checker::motion_floor);
  BOOST_TEST(std::abs(there->distance - proof.clearance) < gjk);
  BOOST_TEST((there->body_a == proof.body_a && there->body_b == proof.body_b));
  BOOST_TEST(proof.proved <= sampled.smallest);
  BOOST_TEST(proof.proved <= proof.clearance);
  for (const MotionProof::Part& part : proof.unproved) BOOST_TEST(part.from < part.to);
  if (!proof.unproved.empty()) return;
  ++tally.proved;
  BOOST_TEST(sampled.smallest > 0.0);
  BOOST_TEST(proof.proved >= std::min(0.5 * proof.clearance, proof.clearance - 2.5e-5));
}

Tally compare_many(const Scene& scene, const std::string& robot, const std::vector<std::string>& other_robots,
                   int motions, double size, unsigned seed) {
  const SceneChecker checker(scene, robot, {.mode = CheckMode::coal, .other_robots = other_robots});
  const auto workspace = checker.make_workspace();
  Dice dice(seed);
  Tally tally;
  for (int i = 0; i < motions;) {
    const auto rows = static_cast<Eigen::Index>(2 + dice.below(i % 4 ? 4 : 30));
    const Trajectory t = random_walk(dice, checker, rows, size / static_cast<double>(rows));
    if (dice.below(8) && !checker.is_free(t.positions.row(0).transpose(), *workspace)) continue;
    compare(checker, t, tally);
    ++i;
  }
  BOOST_TEST_MESSAGE(robot << ": " << motions << " motions, " << tally.free << " free, " << tally.proved << " proved, "
                           << tally.contacts << " in contact, " << tally.near << " within 10 mm");
  BOOST_TEST(tally.proved >= 0.9 * tally.free);
  BOOST_TEST(tally.proved >= motions / 10);
  BOOST_TEST(tally.contacts >= motions / 20);
  return tally;
}

/// The planar robot beside a sphere.
struct Beside {
  explicit Beside(const Pose& sphere, CheckMode mode = CheckMode::coal, double padding = 0.0)
      : scene(with(sphere, padding)), checker(scene, "planar", {.mode = mode}) {}
  static Scene with(const Pose& sphere, double padding) {
    Scene scene;
    scene.add_robot(robots::planar());
    scene.add_object("x", Sphere{0.1}, sphere, padding);
    return scene;
  }
  Scene scene;
  SceneChecker checker;
  Checker::WorkspacePtr workspace = checker.make_workspace();
};

Trajectory straight(const Checker& checker, ConstVector a, ConstVector b) {
  Trajectory t = motion_of(checker, 2);
  t.positions << a.transpose(), b.transpose();
  t.velocities.resize(0, a.size());
  t.times << 0.0, 1.0;
  return t;
}

}  // namespace

// --- against dense sampling

BOOST_AUTO_TEST_CASE(what_is_proved_holds_at_samples_of_a_tenth_of_a_millimetre) {
  const auto robot = arm7();
  int near = 0;
  for (unsigned world = 0; world < 3; ++world) {
    const std::size_t held = world == 0 ? 99 : 3 * world - 1;  // nothing, a cylinder, a mesh
    near += compare_many(crowd(robot, world, held, "arm7_hand"), "arm7", {}, amount(40), 0.5, 50 + world).near;
  }
  BOOST_TEST(near > (amount(10) == 10 ? 10 : 0));  // a tenth of the cases has few of them
}

BOOST_AUTO_TEST_CASE(mimic_and_prismatic_joints_are_proved) {
  Scene scene;
  scene.add_robot(slide());
  Dice dice(4);
  for (int i = 0; i < 6; ++i) scene.add_object("x" + std::to_string(i), Box{{0.2, 0.3, 0.2}}, dice.pose(0.6, 2.5));
  scene.add_object("held", Sphere{0.1}, {});
  scene.attach_object("held", "slide", "tip", {"fore"});
  compare_many(scene, "slide", {}, amount(60), 0.5, 6);
}

BOOST_AUTO_TEST_CASE(robots_that_move_together_are_proved) {
  Scene scene;
  scene.add_robot(arm7("left"), at(0, 0.35, 0));
  scene.add_robot(arm7("right"), at(0, -0.35, 0, 0, 0, 1.0));
  scene.add_object("post", Cylinder{0.05, 0.8}, at(0.5, 0, 0.4));
  compare_many(scene, "left", {"right"}, amount(60), 0.7, 8);
}

BOOST_AUTO_TEST_CASE(robots_of_spheres_are_proved) {
  Scene scene;
  scene.add_robot(spheres());
  Dice dice(3);
  for (int i = 0; i < 5; ++i)
    scene.add_object("x" + std::to_string(i), Sphere{0.1}, at(dice.in(-2, 2), dice.in(-2, 2), 0.1));
  compare_many(scene, "planar", {}, amount(100), 0.5, 2);
}

BOOST_AUTO_TEST_CASE(robots_of_meshes_are_proved) {
  for (const auto& robot : robots_of_meshes())
    compare_many(crowd(robot, 2, 5, hand_of(*robot)), robot->name(), {}, 2, 0.1, 3);
}

BOOST_AUTO_TEST_CASE(straight_motions_are_proved_where_the_checker_calls_them_free) {
  const auto robot = arm7();
  const Scene scene = crowd(robot, 3, 5, "arm7_hand");
  const SceneChecker checker(scene, "arm7"), coal(scene, "arm7", {.mode = CheckMode::coal});
  const auto workspace = checker.make_workspace(), other = coal.make_workspace();
  Dice dice(17);
  int free = 0;
  for (int i = 0; i < amount(1000); ++i) {
    const Eigen::VectorXd a = dice.configuration(*robot);
    const Eigen::VectorXd b = a + (dice.below(2) ? 0.1 : 0.5) * (dice.configuration(*robot) - a);
    const bool expected = checker.is_motion_free(a, b, *workspace);
    const MotionProof proof = prove(coal, straight(coal, a, b), *other);
    free += expected;
    if (!proof.free) BOOST_TEST(!expected);
    if (proof.free && proof.clearance > 5e-5) BOOST_TEST(expected);
    if (expected && proof.clearance > 5e-5) BOOST_TEST(proof.unproved.empty());
  }
  BOOST_TEST((free > amount(100) && free < amount(900)));
}

BOOST_AUTO_TEST_CASE(velocities_that_jump_at_every_row_make_straight_motions_too) {
  const Scene scene = crowd(arm7(), 3, 5, "arm7_hand");
  const SceneChecker checker(scene, "arm7", {.mode = CheckMode::coal});
  const auto workspace = checker.make_workspace();
  Dice dice(23);
  int free = 0;
  for (int i = 0; i < amount(200); ++i) {
    Trajectory t = random_walk(dice, checker, 8, 0.05);
    t.velocities.resize(0, 7);
    RowMatrix departures = RowMatrix::Zero(8, 7), arrivals = departures;
    for (Eigen::Index row = 0; row + 1 < 8; ++row)
      departures.row(row) = arrivals.row(row + 1) =
          (t.positions.row(row + 1) - t.positions.row(row)) / (t.times[row + 1] - t.times[row]);
    const MotionProof expected = prove(checker, t, *workspace);
    const MotionProof proof = prove_motion(checker, {t.times, t.positions, departures, &arrivals}, *workspace);
    free += proof.free;
    BOOST_TEST(proof.free == expected.free);
    if (!proof.free) continue;
    BOOST_TEST(proof.unproved.size() == expected.unproved.size());
    BOOST_TEST(std::abs(proof.clearance - expected.clearance) < gjk);
  }
  BOOST_TEST((free > amount(20) && free < amount(180)));
}

// --- cases that can be worked out by hand

BOOST_AUTO_TEST_CASE(the_clearance_is_where_the_tip_passes_the_sphere) {
  const Beside world(at(2.2, 0, 0));
  Trajectory t = straight(world.checker, Vector2d(-1, 0), Vector2d(1, 0));
  t.times << 10.0, 14.0;
  const MotionProof proof = prove(world.checker, t, *world.workspace, {.gap_tolerance = 0.01});
  BOOST_TEST(proof.free);
  BOOST_TEST(proof.unproved.empty());
  const double smallest = 2.1 - std::hypot(1.95, 0.05);  // between the sphere and the bar's corners
  BOOST_TEST(proof.clearance >= smallest - gjk);
  BOOST_TEST(proof.clearance <= smallest / 0.99);
  BOOST_TEST(proof.proved >= 0.99 * proof.clearance);
  BOOST_TEST(proof.proved <= smallest);
  BOOST_TEST(std::abs(proof.time - 12.0) < 0.2);
  BOOST_TEST(proof.body_a == "lower");
  BOOST_TEST(proof.body_b == "x");
}

BOOST_AUTO_TEST_CASE(velocities_bend_the_way_into_a_sphere_that_the_rows_pass_by) {
  const Beside world(at(1.9, 0, 0));
  Trajectory t = straight(world.checker, Vector2d(0.5, 0), Vector2d(0.5, 0));
  BOOST_TEST(prove(world.checker, t, *world.workspace).free);
  t.velocities.resize(2, 2);
  t.velocities << -2.0, 0, 2.0, 0;  // a dip of a quarter of the velocity: to 0
  const MotionProof proof = prove(world.checker, t, *world.workspace);
  BOOST_TEST(!proof.free);
  BOOST_TEST((proof.body_a == "lower" && proof.body_b == "x"));
  BOOST_TEST((proof.time > 0.2 && proof.time < 0.8));
  t.velocities *= 0.5;  // to 0.25: 0.47 m from the sphere's middle
  BOOST_TEST(prove(world.checker, t, *world.workspace).unproved.empty());
}

BOOST_AUTO_TEST_CASE(what_arrives_faster_than_it_leaves_bends_the_way_before_the_row) {
  const Beside world(at(1.9, 0, 0));
  const Eigen::VectorXd times = Eigen::Vector3d(0, 1, 2);
  const RowMatrix positions{{0.5, 0}, {0.5, 0}, {0.5, 0}}, rest = RowMatrix::Zero(3, 2);
  const auto proof = [&](double speed) {
    const RowMatrix arrivals{{0, 0}, {speed, 0}, {0, 0}};  // a dip of 4/27 of it
    return prove_motion(world.checker, {times, positions, rest, &arrivals}, *world.workspace);
  };
  BOOST_TEST(proof(0.0).unproved.empty());
  BOOST_TEST(proof(-3.0).unproved.empty());  // away from the sphere
  const MotionProof touching = proof(3.4);
  BOOST_TEST(!touching.free);
  BOOST_TEST((touching.time > 0.3 && touching.time < 1.0));
}

BOOST_AUTO_TEST_CASE(a_thin_foil_between_two_of_a_hundred_rows_is_found) {
  Scene scene;
  scene.add_robot(robots::planar());
  scene.add_object("foil", Box{{0.1, 1e-4, 0.1}}, at(1.9, 0.0005, 0));
  const SceneChecker checker(scene, "planar", {.mode = CheckMode::coal});
  const auto workspace = checker.make_workspace();
  for (const Eigen::Index rows : {2, 3, 4, 50, 100, 127}) {
    Trajectory t = motion_of(checker, rows);
    for (Eigen::Index i = 0; i < rows; ++i) {
      t.times[i] = 0.1 * static_cast<double>(i);
      t.positions.row(i) << -1.0 + 2.0 * static_cast<double>(i) / static_cast<double>(rows - 1), 0;
    }
    t.velocities.resize(0, 2);
    const MotionProof proof = prove(checker, t, *workspace);
    BOOST_TEST(!proof.free);
    BOOST_TEST(std::abs(t.sample(proof.time)[0]) < 0.05);
  }
}

BOOST_AUTO_TEST_CASE(what_slides_along_within_a_micrometre_is_neither_proved_nor_in_contact) {
  Scene scene;
  scene.add_robot(robots::planar());
  scene.add_object("floor", Box{{6, 6, 0.1}}, at(0, 0, -0.1 - 1.5e-6));
  const SceneChecker checker(scene, "planar", {.mode = CheckMode::coal});
  const MotionProof proof =
      prove(checker, straight(checker, Vector2d(0, 0.5), Vector2d(1e-4, 0.5)), *checker.make_workspace());
  BOOST_TEST(proof.free);
  BOOST_TEST(proof.proved == 0.0);
  BOOST_REQUIRE(proof.unproved.size() == 2);  // both bars, each from start to end
  for (const MotionProof::Part& part : proof.unproved) {
    BOOST_TEST((part.from == 0.0 && part.to == 1.0));
    BOOST_TEST(part.body_b == "floor");
  }
}

BOOST_AUTO_TEST_CASE(padding_counts_in_proofs) {
  const Vector2d a(-1, 0), b(1, 0);
  const Beside near(at(2.2, 0, 0), CheckMode::coal, 0.1), touching(at(2.2, 0, 0), CheckMode::coal, 0.16);
  const MotionProof proof = prove(near.checker, straight(near.checker, a, b), *near.workspace);
  BOOST_TEST(proof.free);
  BOOST_TEST((proof.clearance > 0.049 && proof.clearance < 0.1));
  BOOST_TEST(proof.proved <= 0.05);
  BOOST_TEST(!prove(touching.checker, straight(touching.checker, a, b), *touching.workspace).free);
}

BOOST_AUTO_TEST_CASE(one_row_is_a_motion_too) {
  const Beside world(at(1.5, 0.3, 0));
  for (const bool velocities : {false, true}) {
    Trajectory t = motion_of(world.checker, 1);
    t.positions.setZero();
    t.times << 3.0;
    t.velocities = RowMatrix::Constant(velocities, 2, 7.0);
    const MotionProof proof = prove(world.checker, t, *world.workspace);
    BOOST_TEST(proof.free);
    BOOST_TEST(std::abs(proof.clearance - 0.15) < gjk);
    BOOST_TEST((proof.proved <= 0.15 && proof.proved > 0.15 - 2 * gjk));
    BOOST_TEST(proof.time == 3.0);
    BOOST_TEST(proof.unproved.empty());
    t.positions << 0.2, 0;
    BOOST_TEST(!prove(world.checker, t, *world.workspace).free);
  }
}

BOOST_AUTO_TEST_CASE(with_nothing_to_collide_with_there_is_no_nearest_pair) {
  Scene scene;
  scene.add_robot(robots::planar());
  const SceneChecker checker(scene, "planar");
  const MotionProof proof =
      prove(checker, straight(checker, Vector2d(-3, -3), Vector2d(3, 3)), *checker.make_workspace());
  BOOST_TEST(proof.free);
  BOOST_TEST(proof.clearance == infinity);
  BOOST_TEST(proof.proved == infinity);
  BOOST_TEST((proof.body_a.empty() && proof.body_b.empty() && proof.unproved.empty()));
}

BOOST_AUTO_TEST_CASE(bodies_that_overlap_and_never_move_are_a_contact_all_along) {
  Scene scene;
  scene.add_robot(arm7());
  scene.add_object("table", Box{{1, 1, 0.1}}, at(0, 0, -0.049));
  const SceneChecker checker(scene, "arm7");
  const Eigen::VectorXd q = Eigen::VectorXd::Zero(7);
  const MotionProof proof = prove(checker, straight(checker, q, q), *checker.make_workspace());
  BOOST_TEST(!proof.free);
  BOOST_TEST((proof.body_a == "arm7_base" && proof.body_b == "table"));
}

// --- limits

BOOST_AUTO_TEST_CASE(when_time_is_up_all_that_is_open_is_called_unproved) {
  const Deadline passed(-1.0);
  const Beside world(at(1.5, 0.3, 0));
  const MotionProof proof = prove(world.checker, straight(world.checker, Vector2d(-1, 0), Vector2d(0, 0)),
                                  *world.workspace, {.deadline = &passed});
  BOOST_TEST(proof.free);  // at the rows that were checked
  BOOST_TEST(proof.proved == 0.0);
  BOOST_REQUIRE(proof.unproved.size() == 2);
  for (const MotionProof::Part& part : proof.unproved) BOOST_TEST((part.from == 0.0 && part.to == 1.0));
  const auto robot = arm7();
  const Scene scene = crowd(robot, 1, 2, "arm7_hand");
  const SceneChecker checker(scene, "arm7", {.mode = CheckMode::coal});
  Dice dice(2);
  for (int i = 0; i < 50; ++i) {
    const MotionProof stopped =
        prove(checker, random_walk(dice, checker, 10, 0.05), *checker.make_workspace(), {.deadline = &passed});
    BOOST_TEST((!stopped.free || !stopped.unproved.empty()));
    BOOST_TEST(stopped.proved == 0.0);
  }
}

BOOST_AUTO_TEST_CASE(the_deadline_is_seen_between_pairs) {
  Scene scene = crowd(arm7(), 1, 2, "arm7_hand");
  const SceneChecker checker(scene, "arm7", {.mode = CheckMode::coal});
  const Deadline passed(-1.0);
  Dice dice(2);
  const Trajectory t = random_walk(dice, checker, 10, 0.05);
  const auto whole = checker.make_workspace(), stopped = checker.make_workspace();
  prove(checker, t, *whole);
  prove(checker, t, *stopped, {.deadline = &passed});
  BOOST_TEST(checker.statistics(*stopped).narrow_phase <= 6);  // of the nearest pair in three configurations
  BOOST_TEST(checker.statistics(*whole).narrow_phase > 20);
}

BOOST_AUTO_TEST_CASE(a_deadline_that_does_not_pass_changes_nothing) {
  const Deadline never;
  const Scene scene = crowd(arm7(), 1, 2, "arm7_hand");
  const SceneChecker checker(scene, "arm7", {.mode = CheckMode::coal});
  const auto used = checker.make_workspace();
  Dice dice(5);
  for (int i = 0; i < 50; ++i) {
    const Trajectory t = random_walk(dice, checker, 10, 0.05);
    const MotionProof a = prove(checker, t, *used),
                      b = prove(checker, t, *checker.make_workspace(), {.deadline = &never});
    BOOST_TEST((a.free == b.free && a.clearance == b.clearance && a.proved == b.proved && a.time == b.time));
    BOOST_TEST((a.body_a == b.body_a && a.body_b == b.body_b && a.unproved.size() == b.unproved.size()));
  }
}

BOOST_AUTO_TEST_CASE(a_million_turns_end_unproved_and_not_never) {
  const Beside world(at(1.5, 0, 0.2));  // the bars pass 50 mm below it
  const MotionProof proof =
      prove(world.checker, straight(world.checker, Vector2d(0, 0), Vector2d(1e9, 0)), *world.workspace);
  BOOST_TEST(proof.free);
  BOOST_TEST(!proof.unproved.empty());
  BOOST_TEST(proof.proved == 0.0);
  BOOST_CHECK_NO_THROW(
      prove(world.checker, straight(world.checker, Vector2d(0, 0), Vector2d(-9e99, 9e99)), *world.workspace));
}

BOOST_AUTO_TEST_CASE(any_gap_will_do_where_the_motion_has_to_be_free_only) {
  const Beside world(at(2.2, 0, 0));
  const MotionProof proof = prove(world.checker, straight(world.checker, Vector2d(-1, 0), Vector2d(1, 0)),
                                  *world.workspace, {.gap_tolerance = 1.0});
  BOOST_TEST((proof.free && proof.unproved.empty()));
  BOOST_TEST(proof.proved <= 0.15);
}

BOOST_AUTO_TEST_CASE(what_is_proved_free_does_not_depend_on_the_gap) {
  // A link far smaller than the clearance, within the box around a large cloud: no distance was computed there.
  Scene scene;
  scene.add_robot(robots::planar());
  std::vector<Eigen::Vector3d> points;
  for (double x = -3.0; x <= 3.0; x += 0.05)
    for (double y = -3.0; y <= 3.0; y += 0.05)
      for (const double z : {-2.0, 2.0}) points.emplace_back(x, y, z);
  scene.add_object("cloud", PointCloud{points, 0.05}, Pose());
  const SceneChecker checker(scene, "planar", {.mode = CheckMode::coal});
  const auto workspace = checker.make_workspace();
  for (const double gap : {0.01, 0.1, 0.5, 0.9, 1.0}) {
    const MotionProof proof =
        prove(checker, straight(checker, Vector2d(-1, 0), Vector2d(1, 2)), *workspace, {.gap_tolerance = gap});
    BOOST_TEST((proof.free && proof.unproved.empty()));
    if (gap > 0.05 && gap < 1.0) BOOST_TEST(proof.proved >= (1.0 - gap) * proof.clearance);
  }
  BOOST_TEST(workspace->statistics.configurations < 5000u);  // each took 200 000 where the goal was not reached
}

BOOST_AUTO_TEST_CASE(a_clearance_takes_a_counted_number_of_distances) {
  const Beside world(at(2.2, 0, 0));
  const Trajectory t = straight(world.checker, Vector2d(-1, 0), Vector2d(1, 0));
  const auto distances = [&](double gap) {
    const auto workspace = world.checker.make_workspace();
    prove(world.checker, t, *workspace, {.gap_tolerance = gap});
    return workspace->statistics.narrow_phase;
  };
  BOOST_TEST(distances(1e-6) <= distances(1.0) + 2 * 256 + 6);  // and as many searches for planes
  const MotionProof proof = prove(world.checker, t, *world.workspace, {.gap_tolerance = 1e-6});
  BOOST_TEST((proof.free && proof.unproved.empty()));
  BOOST_TEST(proof.proved > 0.9 * proof.clearance);
}

std::shared_ptr<const RobotModel> robot_of(const std::string& urdf, const std::string& end_effector) {
  RobotDescription description;
  description.urdf_text = urdf;
  description.end_effector = end_effector;
  return RobotModel::load(description);
}

/// A link of one joint, whose axis is the z axis.
std::shared_ptr<const RobotModel> turning(const std::string& shape) {
  return robot_of(R"(<robot name="top"><link name="base"/><link name="link"><collision>)" + shape +
                      R"(</collision></link>
    <joint name="a" type="revolute"><parent link="base"/><child link="link"/><axis xyz="0 0 1"/>
      <limit lower="-3" upper="3" velocity="1" effort="1"/></joint></robot>)",
                  "link");
}

BOOST_AUTO_TEST_CASE(what_turns_about_its_own_axis_gets_no_nearer) {
  const Eigen::VectorXd a = Eigen::VectorXd::Constant(1, -3.0), b = -a;
  const std::string sphere = R"(<geometry><sphere radius="0.1"/></geometry>)",
                    capsule = R"(<geometry><capsule radius="0.1" length="0.4"/></geometry>)";
  for (const std::string& shape : {sphere, R"(<origin xyz="0 0 0.3"/>)" + sphere, capsule})
    for (const CheckMode mode : {CheckMode::coal, CheckMode::exact}) {
      Scene scene;
      scene.add_robot(turning(shape));
      scene.add_object("wall", Box{{0.1, 2, 2}}, at(0.15 + 5e-6, 0, 0));  // 5 µm away
      const SceneChecker checker(scene, "top", {.mode = mode});
      const auto workspace = checker.make_workspace();
      BOOST_TEST(checker.is_motion_free(a, b, *workspace));
      const MotionProof proof = prove(checker, straight(checker, a, b), *workspace);
      BOOST_TEST((proof.free && proof.unproved.empty()));
      BOOST_TEST(workspace->statistics.configurations < 20u);
    }
}

BOOST_AUTO_TEST_CASE(what_passes_near_a_wall_moves_along_it) {
  const Eigen::VectorXd a = Eigen::VectorXd::Constant(1, -3.0), b = -a;
  const std::string origin = R"(<origin xyz="0.08 0 0"/>)",
                    sphere = origin + R"(<geometry><sphere radius="0.06"/></geometry>)",
                    disc = origin + R"(<geometry><cylinder radius="0.06" length="0.1"/></geometry>)";
  for (const std::string& shape : {sphere, disc})
    for (const CheckMode mode : {CheckMode::coal, CheckMode::exact})
      for (const double gap : {2.8e-4, 5e-6}) {
        Scene scene;
        scene.add_robot(turning(shape));
        scene.add_object("wall", Box{{0.1, 2, 2}}, at(0.08 + 0.06 + 0.05 + gap, 0, 0));
        const SceneChecker checker(scene, "top", {.mode = mode});
        const auto workspace = checker.make_workspace();
        BOOST_TEST(checker.is_motion_free(a, b, *workspace));
        const MotionProof proof = prove(checker, straight(checker, a, b), *workspace);
        BOOST_TEST((proof.free && proof.unproved.empty()));
        BOOST_TEST(workspace->statistics.configurations < (gap > 1e-4 ? 400u : 2500u));
        BOOST_TEST_MESSAGE(gap << " m: " << workspace->statistics.configurations << " configurations");
      }
}

BOOST_AUTO_TEST_CASE(capsules_about_any_axis_are_proved) {
  Scene scene;
  scene.add_robot(robot_of(R"(<robot name="whip"><link name="base"/>
    <link name="l1"><collision><origin xyz="0.2 0.05 0" rpy="0 1.2 0"/>
      <geometry><capsule radius="0.05" length="0.5"/></geometry></collision></link>
    <link name="l2"><collision><origin xyz="0.1 0 0.2" rpy="0.4 0 0"/>
      <geometry><capsule radius="0.06" length="0.4"/></geometry></collision>
      <collision><origin xyz="0.3 0 0"/><geometry><sphere radius="0.08"/></geometry></collision></link>
    <joint name="a" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/>
      <limit lower="-3" upper="3" velocity="1" effort="1"/></joint>
    <joint name="b" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0.3"/>
      <limit lower="-3" upper="3" velocity="1" effort="1"/></joint></robot>)",
                           "l2"));
  Dice dice(11);
  for (int i = 0; i < 10; ++i) scene.add_object("x" + std::to_string(i), Box{{0.1, 0.2, 0.1}}, dice.pose(0.4, 0.8));
  scene.add_object("held", Capsule{0.03, 0.2}, at(0.1, 0, 0.1, 0.5));
  scene.attach_object("held", "whip", "l2", {"l1"});
  compare_many(scene, "whip", {}, amount(100), 0.5, 6);
}

BOOST_AUTO_TEST_CASE(motions_are_checked_at_the_door) {
  const Beside world(at(2.2, 0, 0));
  const Trajectory good = straight(world.checker, Vector2d(-1, 0), Vector2d(1, 0));
  const auto refused = [&](auto&& change, const std::string& why, double gap_tolerance = 0.5) {
    Trajectory bad = good;
    bad.velocities = RowMatrix::Zero(2, 2);
    change(bad);
    check_throws<InvalidArgument>(
        [&] { prove(world.checker, bad, *world.workspace, {.gap_tolerance = gap_tolerance}); }, why);
  };
  const auto nothing = [](Trajectory&) {};
  refused([](Trajectory& t) { t.positions.resize(0, 2); }, "it has no rows");
  refused([](Trajectory& t) { t.times = Eigen::Vector3d(0, 1, 2); },
          "2 rows of positions, but 2 of velocities and 3 times");
  refused([](Trajectory& t) { t.velocities = RowMatrix::Zero(1, 2); }, "2 rows of positions, but 1 of velocities");
  refused([](Trajectory& t) { t.velocities = RowMatrix::Zero(2, 3); }, "velocities have 3 joints");
  refused([](Trajectory& t) { t.positions = RowMatrix::Zero(2, 3); }, "its rows have 3 joints, but 2 are planned");
  refused([](Trajectory& t) { t.positions(1, 0) = NAN; }, "NaN");
  refused([](Trajectory& t) { t.velocities(0, 1) = infinity; }, "infinity");
  refused([](Trajectory& t) { t.velocities(0, 1) = 1e101; }, "overflow");
  refused([](Trajectory& t) { t.times[1] = infinity; }, "infinity");
  refused([](Trajectory& t) { t.positions(0, 0) = 1e200; }, "overflow");
  refused([](Trajectory& t) { t.times[1] = 0.0; }, "time 1 is 0 s, not after the one before (0 s)");
  refused([](Trajectory& t) { t.times[1] = -1.0; }, "time 1 is -1 s, not after the one before (0 s)");
  refused(nothing, "gap_tolerance is 0; it must be in (0, 1]", 0.0);
  refused(nothing, "gap_tolerance is 1.1; it must be in (0, 1]", 1.1);
  refused(nothing, "gap_tolerance is NaN", NAN);
}
