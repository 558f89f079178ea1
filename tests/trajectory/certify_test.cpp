#include "srmp/trajectory/certify.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <functional>
#include <limits>

#include "collision/worlds.hpp"
#include "srmp/collision/scene_checker.hpp"
#include "srmp/core/error.hpp"
#include "srmp/planning/certificates/verify.hpp"
#include "srmp/trajectory/parameterize.hpp"
#include "srmp/trajectory/path.hpp"
#include "support/rows.hpp"
#include "support/throws.hpp"

using namespace srmp;
using worlds::at;
using worlds::Dice;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The planar robot (joints a and b within ±3 rad, 2 rad/s) beside a sphere that its bars pass by 0.15 m at q = (0, 0).
struct World {
  World() : checker(with_sphere(), "planar", {.mode = CheckMode::coal}), limits(default_limits(checker.robot())) {}
  static Scene with_sphere() {
    Scene scene;
    scene.add_robot(robots::planar());
    scene.add_object("sphere", Sphere{0.1}, at(2.2, 0, 0));
    return scene;
  }
  Certificate certify(const Trajectory& t, const CertifyOptions& options = {}) const {
    return srmp::certify(t, checker, limits, options);
  }
  Trajectory timed(const RowMatrix& path, TimingOptions options = {}) const {
    options.reach = checker.reach();
    return time_parameterize(path, checker.robot().joint_names(), limits, options);
  }
  Trajectory good() const { return timed(rows({{-1, 0.5}, {0.2, -0.6}, {1, 0.3}})); }

  SceneChecker checker;
  MotionLimits limits;
};

const Fault* find(const Certificate& certificate, FaultKind kind) {
  const auto found = std::find_if(certificate.faults.begin(), certificate.faults.end(),
                                  [&](const Fault& fault) { return fault.kind == kind; });
  return found == certificate.faults.end() ? nullptr : &*found;
}

/// Expects the one fault and that its text holds the fragments; returns its time.
double expect_only(const Certificate& certificate, FaultKind kind, const std::vector<std::string>& fragments) {
  BOOST_TEST(!certificate.holds());
  BOOST_TEST(certificate.faults.size() == 1u, certificate.report());
  const Fault* fault = find(certificate, kind);
  BOOST_TEST_REQUIRE(fault, "no " << to_string(kind) << " in:\n" << certificate.report());
  for (const std::string& fragment : fragments)
    BOOST_TEST(fault->text.find(fragment) != std::string::npos, fault->text << " does not hold " << fragment);
  BOOST_TEST(certificate.report().find("FAULT " + to_string(kind) + ": ") != std::string::npos);
  return fault->time;
}

/// Two rows at 0 and 1 s, joint a from 0 to `to` with the velocities v0 and v1; joint b stands at 0.5.
Trajectory segment(double from, double to, double v0, double v1) {
  Trajectory t{{"a", "b"}, rows({{from, 0.5}, {to, 0.5}}), rows({{v0, 0}, {v1, 0}}), {}, Eigen::Vector2d(0, 1), {}};
  return t;
}

}  // namespace

// --- what is good

BOOST_AUTO_TEST_CASE(a_timed_path_has_no_faults) {
  const World world;
  for (const TimingMethod method : {TimingMethod::toppra, TimingMethod::ruckig}) {
    const Trajectory t = world.timed(rows({{-1, 0.5}, {0.2, -0.6}, {1, 0.3}}), {.method = method});
    const Certificate c = world.certify(t, {.jerk = method == TimingMethod::ruckig});
    BOOST_TEST(c.holds(), c.report());
    BOOST_TEST(c.proved_free());
    BOOST_TEST(c.clearance_proved > 0.0);
    BOOST_TEST(c.clearance >= c.clearance_proved);
    BOOST_TEST(c.body_b == "sphere");
    BOOST_TEST((c.velocity.fraction > 0.5 && c.velocity.fraction <= 1 + 1e-6));
    BOOST_TEST((c.acceleration.fraction > 0.9 && c.acceleration.fraction <= 1 + 1e-6));
    BOOST_TEST((c.position.fraction > 0.3 && c.position.fraction < 0.4));
    BOOST_TEST((method == TimingMethod::toppra ? std::isinf(c.jerk.fraction) : c.jerk.fraction <= 1 + 1e-6));
    BOOST_TEST((method == TimingMethod::toppra || c.deviation < 1e-9));
    BOOST_TEST(c.deviation <= 0.005 * (1 + 1e-9));
    BOOST_TEST((c.limits.velocity == world.limits.velocity));
  }
}

BOOST_AUTO_TEST_CASE(random_timed_paths_have_no_faults) {
  const auto robot = worlds::arm7();
  Scene scene;
  scene.add_robot(robot);
  const SceneChecker checker(scene, "arm7", {.mode = CheckMode::coal});
  const MotionLimits limits = default_limits(*robot);
  Dice dice(3);
  for (int i = 0; i < 100; ++i) {
    RowMatrix path(2 + static_cast<Eigen::Index>(dice.below(6)), 7);
    for (Eigen::Index row = 0; row < path.rows(); ++row) path.row(row) = 0.9 * dice.configuration(*robot).transpose();
    TimingOptions options{.blend_deviation = dice.below(2) ? 0.005 : 0.05};
    options.reach = checker.reach();
    const Trajectory t = time_parameterize(path, robot->joint_names(), limits, options);
    const Certificate c = certify(t, checker, limits, {.collisions = false});
    BOOST_TEST(c.holds(), c.report());
    BOOST_TEST(!c.collisions_checked);
    BOOST_TEST(!c.proved_free());
    BOOST_TEST(c.deviation <= options.blend_deviation * (1 + 1e-6));
  }
}

BOOST_AUTO_TEST_CASE(long_paths_of_many_small_corners_have_no_faults) {
  const auto robot = worlds::arm7();
  Scene scene;
  scene.add_robot(robot);
  const SceneChecker checker(scene, "arm7", {.mode = CheckMode::coal});
  const MotionLimits limits = default_limits(*robot);
  Dice dice(9);
  for (int i = 0; i < 60; ++i) {
    const Eigen::VectorXd from = 0.9 * dice.configuration(*robot), to = 0.9 * dice.configuration(*robot);
    RowMatrix path(120, 7);
    for (Eigen::Index row = 0; row < path.rows(); ++row) {
      const double u = static_cast<double>(row) / static_cast<double>(path.rows() - 1);
      path.row(row) = (from + u * (to - from)).transpose().array() + 0.1 * std::sin(7.0 * u);
    }
    TimingOptions options{.blend_deviation = dice.below(2) ? 5e-4 : 1e-4};
    options.reach = checker.reach();
    const Certificate c =
        certify(time_parameterize(path, robot->joint_names(), limits, options), checker, limits, {.collisions = false});
    BOOST_TEST(c.holds(), c.report());
  }
}

BOOST_AUTO_TEST_CASE(straight_segments_without_velocities_are_checked_against_limits_too) {
  const World world;
  Trajectory t{{"a", "b"}, rows({{0.2, 0.5}, {1.2, 0.5}}), RowMatrix(0, 2), {}, Eigen::Vector2d(0, 0.6), {}};
  Certificate c = world.certify(t);
  BOOST_TEST(c.holds(), c.report());
  BOOST_TEST(c.velocity.fraction == 1.0 / 0.6 / 2.0, boost::test_tools::tolerance(1e-12));
  t.times[1] = 0.4;
  BOOST_TEST(expect_only(world.certify(t), FaultKind::velocity_limit, {"a: the velocity reaches 2.5", "limit is 2"}) ==
             0.0);
  // Velocities that jump at a row pass for accelerations between the middles of the segments beside it.
  Trajectory jump{
      {"a", "b"}, rows({{0.2, 0.5}, {0.5, 0.5}, {0.8, 0.2}}), RowMatrix(0, 2), {}, Eigen::Vector3d(0, 0.2, 0.4), {}};
  BOOST_TEST(expect_only(world.certify(jump), FaultKind::acceleration_limit,
                         {"b: the acceleration reaches -7.", "limit is 4"}) == 0.2);
  BOOST_TEST(world.certify(jump, {.limits = false}).holds());
}

BOOST_AUTO_TEST_CASE(extrema_are_those_of_dense_samples) {
  const World world;
  Dice dice(8);
  for (int k = 0; k < 100; ++k) {
    const auto n = static_cast<Eigen::Index>(2 + dice.below(5));
    Trajectory t{{"a", "b"}, RowMatrix(n, 2), RowMatrix(n, 2), {}, Eigen::VectorXd(n), {}};
    for (Eigen::Index i = 0; i < n; ++i) {
      t.times[i] = i ? t.times[i - 1] + dice.in(0.05, 1) : dice.in(-2, 2);
      for (Eigen::Index j = 0; j < 2; ++j) t.positions(i, j) = dice.in(-3.5, 3.5), t.velocities(i, j) = dice.in(-5, 5);
    }
    const Certificate c = world.certify(t, {.collisions = false});
    std::array<double, 4> most{};
    std::array<double, 4> when{};
    std::array<Eigen::Index, 4> joint{};
    for (int i = 0; i <= 40000; ++i) {
      const double time = t.times[0] + t.duration() * i / 40000;
      const MotionState s = t.state(time);
      const std::array<Eigen::ArrayXd, 4> fractions{s.position.array().abs() / 3.0,
                                                    s.velocity.array().abs() / world.limits.velocity.array(),
                                                    s.acceleration.array().abs() / world.limits.acceleration.array(),
                                                    s.jerk.array().abs() / world.limits.jerk.array()};
      for (std::size_t what = 0; what < 4; ++what) {
        Eigen::Index j{};
        const double fraction = fractions[what].maxCoeff(&j);
        if (fraction > most[what]) most[what] = fraction, when[what] = time, joint[what] = j;
      }
    }
    const std::array<const LimitUse*, 4> uses{&c.position, &c.velocity, &c.acceleration, &c.jerk};
    for (std::size_t what = 0; what < 4; ++what) {
      const LimitUse& use = *uses[what];
      BOOST_TEST(use.fraction >= most[what] * (1 - 1e-9));
      if (what == 3 && std::isinf(use.fraction)) continue;  // accelerations jump
      BOOST_TEST(use.fraction <= most[what] * (1 + 1e-2));  // samples miss the ends of the segments
      BOOST_TEST((use.joint == "a" || use.joint == "b"));
      if (what < 2 && use.fraction < most[what] * (1 + 1e-7)) {
        const MotionState s = t.state(use.time);
        const Eigen::Index j = use.joint == "a" ? 0 : 1;
        const double there =
            what == 0 ? std::abs(s.position[j]) / 3.0 : std::abs(s.velocity[j]) / world.limits.velocity[j];
        BOOST_TEST(there == use.fraction, boost::test_tools::tolerance(1e-9));
      }
    }
    BOOST_TEST((find(c, FaultKind::position_limit) != nullptr) == (most[0] > 1 + 1e-6));
    BOOST_TEST((find(c, FaultKind::velocity_limit) != nullptr) == (most[1] > 1 + 1e-6));
    BOOST_TEST((find(c, FaultKind::acceleration_limit) != nullptr) == (most[2] > 1 + 1e-6));
    BOOST_TEST(!find(c, FaultKind::jerk_limit));
    BOOST_TEST((find(world.certify(t, {.jerk = true, .collisions = false}), FaultKind::jerk_limit) != nullptr) ==
               (c.jerk.fraction > 1 + 1e-6));
  }
}

BOOST_AUTO_TEST_CASE(no_point_of_the_robot_leaves_its_way_by_more_than_the_deviation) {
  Scene scene;
  scene.add_robot(robots::planar());
  const SceneChecker checker(scene, "planar", {.mode = CheckMode::coal});
  const auto points = [](const Eigen::VectorXd& q) {  // corners of both bars, and the tip
    Eigen::Matrix2Xd p(2, 9);
    const Eigen::Rotation2Dd first(q[0]), both(q[0] + q[1]);
    int i = 0;
    for (const double x : {0.05, 0.95})
      for (const double y : {-0.05, 0.05}) {
        p.col(i++) = first * Eigen::Vector2d(x, y);
        p.col(i++) = first * Eigen::Vector2d(1, 0) + both * Eigen::Vector2d(x, y);
      }
    p.col(i) = first * Eigen::Vector2d(1, 0) + both * Eigen::Vector2d(1, 0);
    return p;
  };
  Dice dice(4);
  for (int k = 0; k < 20; ++k) {
    RowMatrix path(3 + static_cast<Eigen::Index>(dice.below(3)), 2);
    for (double& x : path.reshaped()) x = dice.in(-1.5, 1.5);
    const double blend = k % 2 ? 0.005 : 0.1;
    const MotionLimits limits = default_limits(checker.robot());
    TimingOptions options{.blend_deviation = blend};
    options.reach = checker.reach();
    const Trajectory t = time_parameterize(path, {"a", "b"}, limits, options);
    const Certificate c = certify(t, checker, limits);
    std::vector<Eigen::Matrix2Xd> path_points;
    constexpr int fine = 2000;
    for (Eigen::Index i = 0; i + 1 < path.rows(); ++i)
      for (int s = 0; s <= fine; ++s)
        path_points.push_back(points((path.row(i) + (path.row(i + 1) - path.row(i)) * s / fine).transpose()));
    double most = 0.0;
    for (int i = 0; i <= 200; ++i) {
      const Eigen::Matrix2Xd here = points(t.sample(t.duration() * i / 200));
      double smallest = infinity;
      for (const auto& there : path_points) smallest = std::min(smallest, (here - there).colwise().norm().maxCoeff());
      most = std::max(most, smallest);
    }
    BOOST_TEST(most <= c.deviation + 2e-3);  // the path is known every 4 mm, 2 mm to either side
    BOOST_TEST(c.deviation <= blend * (1 + 1e-6));
    BOOST_TEST((blend < 0.1 || most > 0.2 * c.deviation));
  }
  // A known one: between two waypoints in a straight line, joint b swings out by 0.1 rad.
  Trajectory t{{"a", "b"},
               rows({{0, 0.5}, {0.1, 0.6}, {0.2, 0.5}}),
               RowMatrix(0, 2),
               {},
               Eigen::Vector3d(0, 1, 2),
               rows({{0, 0.5}, {0.2, 0.5}})};
  const Certificate c = certify(t, checker, default_limits(checker.robot()));
  BOOST_TEST(c.deviation == 0.1 * checker.reach()[1], boost::test_tools::tolerance(1e-9));
  t.waypoints = rows({{0, 0.5}});  // a path of one waypoint
  BOOST_TEST(
      certify(t, checker, default_limits(checker.robot())).deviation == checker.reach().dot(Eigen::Vector2d(0.2, 0.0)),
      boost::test_tools::tolerance(0.5));
  t.waypoints.resize(0, 2);
  BOOST_TEST(certify(t, checker, default_limits(checker.robot())).deviation == 0.0);
}

// --- every fault, planted

BOOST_AUTO_TEST_CASE(limits_broken_between_rows_only_are_found) {
  const World world;
  MotionLimits wide = world.limits;
  wide.acceleration.setConstant(100);
  // Both rows at 0.2 rad/s; in the middle 1.5 * 1.6 - 0.5 * 0.2 = 2.3 rad/s.
  const Certificate fast = certify(segment(0.3, 1.9, 0.2, 0.2), world.checker, wide, {.at_rest = false});
  const double when = expect_only(fast, FaultKind::velocity_limit,
                                  {"a: the velocity reaches 2.3 at 0.5 s (between rows 0 and 1)", "its limit is 2"});
  BOOST_TEST(when == 0.5, boost::test_tools::tolerance(1e-9));
  // Rows within ±3, the motion between them not: 2.9 + 0.25 * 1.
  const Certificate out = certify(segment(2.9, 2.9, 1.0, -1.0), world.checker, wide, {.at_rest = false});
  BOOST_TEST(expect_only(out, FaultKind::position_limit,
                         {"a: the position is 3.15 at 0.5 s (between rows 0 and 1)", "[-3, 3]"}) == 0.5);
  BOOST_TEST(out.position.fraction == 3.15 / 3.0, boost::test_tools::tolerance(1e-12));
  // The row says 0, but the polynomial there starts with 6 * 1 - 4 * 0 - 2 * 0.
  Trajectory jerky = segment(0.3, 1.3, 0, 0);
  jerky.accelerations = RowMatrix::Zero(2, 2);
  BOOST_TEST(expect_only(world.certify(jerky), FaultKind::acceleration_limit,
                         {"a: the acceleration reaches 6 at 0 s", "its limit is 4"}) == 0.0);
  // What a row says counts too, whatever the polynomials do.
  Trajectory lying = segment(0.3, 0.3, 0, 0);
  lying.accelerations = RowMatrix::Zero(2, 2);
  lying.accelerations(1, 0) = -1e6;
  expect_only(world.certify(lying), FaultKind::acceleration_limit,
              {"a: the acceleration reaches -1e+06", "its limit is 4"});
  MotionLimits jerk = wide;
  jerk.jerk.setConstant(11);
  expect_only(certify(jerky, world.checker, jerk, {.jerk = true, .at_rest = false}), FaultKind::jerk_limit,
              {"a: the jerk reaches -12", "its limit is 11"});
  expect_only(certify(jerky, world.checker, jerk, {.jerk = true}), FaultKind::jerk_limit,
              {"a: the acceleration jumps at 0 s", "the jerk is unbounded; its limit is 11"});
  BOOST_TEST(certify(jerky, world.checker, jerk).holds());
}

BOOST_AUTO_TEST_CASE(limits_hold_to_a_millionth) {
  const World world;
  MotionLimits wide = world.limits;
  wide.acceleration.setConstant(100);
  const auto speed = [&](double v) {
    Trajectory t{{"a", "b"}, rows({{0.3, 0.5}, {0.3 + v, 0.5}}), rows({{v, 0}, {v, 0}}), {}, Eigen::Vector2d(0, 1), {}};
    return certify(t, world.checker, wide, {.at_rest = false}).holds();
  };
  BOOST_TEST(speed(2.0));
  BOOST_TEST(speed(2.0 * (1 + 0.9e-6)));
  BOOST_TEST(!speed(2.0 * (1 + 1.1e-6)));
  const auto position = [&](double q) { return certify(segment(q, q, 0, 0), world.checker, wide).holds(); };
  BOOST_TEST((position(3.0) && position(-3.0) && position(3.0 + 0.9e-6)));
  BOOST_TEST((!position(3.0 + 4e-6) && !position(-3.0 - 4e-6)));
}

BOOST_AUTO_TEST_CASE(collisions_between_rows_only_are_found) {
  World world;
  Scene scene = World::with_sphere();
  scene.add_object("foil", Box{{0.1, 1e-4, 0.1}}, at(1.9, 0, 0));
  const SceneChecker checker(scene, "planar", {.mode = CheckMode::coal});
  Trajectory t{{"a", "b"}, rows({{-0.5, 0}, {0.5, 0}}), RowMatrix(0, 2), {}, Eigen::Vector2d(2, 3), {}};
  const Certificate c = certify(t, checker, world.limits);
  const double time = expect_only(c, FaultKind::collision, {"link 'lower' and object 'foil' overlap", " s"});
  BOOST_TEST(std::abs(time - 2.5) < 0.1);
  BOOST_TEST(c.clearance_proved == 0.0);
  BOOST_TEST(c.collisions_checked);
  BOOST_TEST(certify(t, checker, world.limits, {.collisions = false}).holds());
  // A recovery from a start in collision: rows before free_from are not checked for collisions.
  Trajectory later{{"a", "b"}, rows({{0, 0}, {0.3, 0}, {0.8, 0}}), RowMatrix(0, 2), {}, Eigen::Vector3d(0, 1, 2), {}};
  BOOST_TEST(find(certify(later, checker, world.limits), FaultKind::collision));
  for (const double from : {1.0, 0.5}) {
    const Certificate part = certify(later, checker, world.limits, {.free_from = from});
    BOOST_TEST(part.holds(), part.report());
    BOOST_TEST(part.checked_from == 1.0);  // from a row on
  }
  BOOST_TEST(certify(later, checker, world.limits, {.free_from = 99}).checked_from == 2.0);
}

BOOST_AUTO_TEST_CASE(times_that_stand_still_or_run_back_are_found) {
  const World world;
  Trajectory t = world.good();
  t.times[3] = t.times[2];
  BOOST_TEST(expect_only(world.certify(t), FaultKind::times, {"time stands still from row 2 (", "to row 3 ("}) ==
             t.times[2]);
  t.times[3] = 0.5 * t.times[2];
  expect_only(world.certify(t), FaultKind::times, {"time runs back from row 2 (", "to row 3 ("});
}

BOOST_AUTO_TEST_CASE(joints_in_another_order_are_found) {
  const World world;
  Trajectory t = world.good();
  t.joint_names = {"b", "a"};
  BOOST_TEST(std::isnan(expect_only(world.certify(t), FaultKind::joint_names,
                                    {"in another order: 'b' and 'a'", "robot 'planar' are 'a' and 'b'"})));
  t.joint_names = {"a", "c"};
  expect_only(world.certify(t), FaultKind::joint_names, {"the joints are 'a' and 'c'"});
}

BOOST_AUTO_TEST_CASE(what_is_not_finite_is_found) {
  const World world;
  const std::vector<std::function<void(Trajectory&)>> plants{
      [](Trajectory& t) { t.positions(2, 1) = NAN; }, [](Trajectory& t) { t.velocities(2, 0) = infinity; },
      [](Trajectory& t) { t.accelerations(2, 1) = -infinity; }, [](Trajectory& t) { t.times[2] = NAN; }};
  for (const auto& plant : plants) {
    Trajectory t = world.good();
    plant(t);
    expect_only(world.certify(t), FaultKind::not_finite, {"row 2 holds NaN or infinity"});
  }
  Trajectory near = segment(0, 1, 0, 0);
  near.times[1] = 1e-320;
  expect_only(world.certify(near), FaultKind::not_finite, {"the polynomial of a overflows between rows 0 and 1"});
  near.velocities.resize(0, 2);
  expect_only(world.certify(near), FaultKind::not_finite, {"the polynomial of a overflows between rows 0 and 1"});
  expect_only(world.certify(segment(0, 1e200, 0, 0)), FaultKind::not_finite, {"overflows"});
  for (const double huge : {1e200, static_cast<double>(NAN), infinity}) {
    Trajectory t = world.good();
    t.waypoints(1, 0) = huge;
    expect_only(world.certify(t), FaultKind::not_finite, {"waypoint 1 holds NaN, infinity or a number that overflows"});
  }
}

BOOST_AUTO_TEST_CASE(arrays_that_do_not_fit_are_found) {
  const World world;
  const auto expect = [&](const std::function<void(Trajectory&)>& plant, const std::string& text) {
    Trajectory t = world.good();
    plant(t);
    expect_only(world.certify(t), FaultKind::shape, {text});
  };
  const auto n = std::to_string(world.good().size()), fewer = std::to_string(world.good().size() - 1);
  expect([](Trajectory& t) { t.positions.resize(0, 2); }, "the trajectory has no rows");
  expect([](Trajectory& t) { t.times.conservativeResize(t.times.size() - 1); },
         "there are " + n + " rows of positions, but " + fewer + " times");
  expect([](Trajectory& t) { t.velocities.conservativeResize(t.velocities.rows() - 1, 2); },
         "velocities have the shape (" + fewer + ", 2), not (" + n + ", 2)");
  expect([](Trajectory& t) { t.accelerations.conservativeResize(t.accelerations.rows(), 1); },
         "accelerations have the shape (" + n + ", 1), not (" + n + ", 2)");
  expect([](Trajectory& t) { t.positions.conservativeResize(t.positions.rows(), 1); },
         "positions have the shape (" + n + ", 1), not (" + n + ", 2)");
}

BOOST_AUTO_TEST_CASE(a_trajectory_that_is_not_at_rest_at_its_ends_is_found) {
  const World world;
  Trajectory t = world.good();
  const Trajectory tail = t.rows(3, t.size()), head = t.rows(0, t.size() - 3);
  BOOST_TEST(expect_only(world.certify(tail), FaultKind::not_at_rest,
                         {"the velocity is", "at the start; it should be 0"}) == tail.times[0]);
  BOOST_TEST(expect_only(world.certify(head), FaultKind::not_at_rest, {"at the end; it should be 0"}) ==
             head.times[head.times.size() - 1]);
  BOOST_TEST(world.certify(tail, {.at_rest = false}).holds());
}

BOOST_AUTO_TEST_CASE(start_goal_and_deviation_are_verified_against_the_request) {
  const World world;
  const Trajectory t = world.good();
  const Eigen::Vector2d start(-1, 0.5), goal(1, 0.3);
  VerifyOptions options;
  options.start = start;
  options.goals = {GoalConstraint::joints(goal)};
  options.max_deviation = 0.006;
  const auto verified = [&] { return verify(t, world.checker, world.limits, options); };
  BOOST_TEST(verified().holds(), verified().report());
  BOOST_TEST(verified().goal_error < 1e-9);
  options.start = Eigen::Vector2d(-1, 0.6);
  BOOST_TEST(expect_only(verified(), FaultKind::start, {"b: the trajectory starts at 0.5, not at 0.6"}) == 0.0);
  options.start = Eigen::Vector2d(0.5, -1);
  expect_only(verified(), FaultKind::joint_names, {"the columns are in another order than the joint names"});
  options.start = start;
  options.goals = {GoalConstraint::joints(Eigen::Vector2d(1, 0.4))};
  BOOST_TEST(expect_only(verified(), FaultKind::goal, {"the end misses the goal by 0.1"}) == t.duration());
  options.goals.clear();
  options.max_deviation = 0.001;
  const double time =
      expect_only(verified(), FaultKind::deviation, {"leaves its checked path by 0.00", "0.001 m are allowed"});
  BOOST_TEST((time > 0.0 && time < t.duration()));
}

BOOST_AUTO_TEST_CASE(several_faults_are_all_named) {
  const World world;
  const Certificate c = world.certify(segment(-0.9, 3.5, 0.5, 0));
  for (const FaultKind kind :
       {FaultKind::position_limit, FaultKind::velocity_limit, FaultKind::acceleration_limit, FaultKind::not_at_rest})
    BOOST_TEST(find(c, kind), to_string(kind));
}

BOOST_AUTO_TEST_CASE(options_of_certify_are_checked_at_the_door) {
  const World world;
  for (const double gap_tolerance : {0.0, 1.0, -1.0, double(NAN)})
    check_throws<InvalidArgument>([&] { world.certify(world.good(), {.gap_tolerance = gap_tolerance}); },
                                  "above 0 and below 1");
  MotionLimits limits = world.limits;
  limits.velocity[1] = 0.0;
  check_throws<InvalidArgument>([&] { certify(world.good(), world.checker, limits); }, "b");
}

BOOST_AUTO_TEST_CASE(when_time_is_up_a_certificate_says_what_is_not_proved) {
  const World world;
  const Deadline passed(-1.0);
  const Certificate c = world.certify(world.good(), {.deadline = &passed});
  BOOST_TEST(c.holds());
  BOOST_TEST(!c.proved_free());
  BOOST_TEST(c.clearance_proved == 0.0);
  BOOST_TEST(c.report().find("all but 2 parts") != std::string::npos, c.report());
}
