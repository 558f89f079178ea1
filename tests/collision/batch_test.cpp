#include <array>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <random>

#include "srmp/collision/batch/batch_checker.hpp"
#include "srmp/core/error.hpp"
#include "support/amount.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

double uniform(std::mt19937& random, double low = -1, double high = 1) {
  return low + (high - low) * (random() * 0x1p-32);
}
Eigen::Vector3d vector(std::mt19937& random, double size) {
  return {uniform(random, -size, size), uniform(random, -size, size), uniform(random, -size, size)};
}
Eigen::Isometry3d pose(std::mt19937& random, double size) {
  Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d axis = vector(random, 1).normalized();
  t.linear() = Eigen::AngleAxisd(uniform(random, -3, 3), axis).toRotationMatrix();
  t.translation() = vector(random, size);
  return t;
}

/// A robot of eight joints with a branch, a prismatic joint and a mimic; one exact body of five spheres and one body
/// with coarse, fine and inner spheres on each actuated joint; obstacles of every kind, most of them farther away.
BatchWorld random_world(unsigned seed, double spread = 1.0) {
  std::mt19937 random(seed);
  BatchWorld world;
  world.dof = 7;
  for (int k = 0; k < 8; ++k) {
    BatchActuatedJoint actuated;
    actuated.parent = k == 5 ? 2 : k - 1;
    actuated.frame = pose(random, 0.25);
    if (k % 3 == 1) actuated.frame.linear() = Eigen::AngleAxisd(M_PI_2, Eigen::Vector3d::Unit(k % 2)).matrix();
    actuated.prismatic = k == 3;
    actuated.joint = k == 7 ? 4 : k;
    actuated.ratio = k == 7 ? -0.5 : 1.0;
    actuated.offset = k == 7 ? 0.3 : 0.0;
    actuated.max_travel = k == 3 ? 4.0 : 0.0;
    world.actuated_joints.push_back(actuated);
  }
  for (int k = -1; k < 8; ++k) {
    BatchBody exact;
    exact.actuated_joint = k;
    exact.exact = true;
    for (int i = 0; i < 5; ++i) exact.coarse.push_back({vector(random, 0.08), uniform(random, 0.01, 0.05)});
    exact.bound = {{0, 0, 0}, 0.2};
    exact.padding = 0.002;
    world.bodies.push_back(exact);
    BatchBody covered;  // the body is the spheres of radius 0.03; fine and coarse spheres are around them
    covered.actuated_joint = k;
    const Eigen::Vector3d c = vector(random, 0.1);
    covered.bound = {c, 0.1};
    covered.coarse = {{c, 0.08}};
    covered.children.resize(1);
    for (std::uint32_t i = 0; i < 4; ++i) {
      const Eigen::Vector3d of_part = c + vector(random, 0.025);
      covered.fine.push_back({of_part, 0.033});
      covered.children[0].push_back(i);
      covered.inner.push_back({of_part, 0.03});
    }
    world.bodies.push_back(covered);
  }
  constexpr int near = 12, obstacles = 40;
  for (int i = 0; i < obstacles; ++i) {
    BatchObstacle o;
    o.kind = static_cast<BatchObstacle::Kind>(i % 4);
    const Eigen::Vector3d s = vector(random, 1).cwiseAbs();
    o.size = Eigen::Vector3d(0.02, 0.02, 0.02) + 0.2 * s;
    o.pose = pose(random, i < near ? spread : 3 * spread);
    if (i % 3 == 0) o.pose.linear().setIdentity();
    o.padding = i % 2 ? 0.0 : 0.003;
    world.obstacles.push_back(o);
  }
  for (int b = 2; b < 18; ++b)
    for (int o = 0; o < obstacles; ++o) world.obstacle_pairs.push_back({b, o});
  for (int a = 0; a < 18; ++a)
    for (int b = a + 1; b < 18; ++b)
      if (world.bodies[a].actuated_joint + 3 < world.bodies[b].actuated_joint) world.self_pairs.push_back({a, b, 0.0});
  return world;
}

std::vector<Eigen::Isometry3d> forward(const BatchWorld& world, std::span<const double> q) {
  std::vector<Eigen::Isometry3d> frames;
  for (const BatchActuatedJoint& d : world.actuated_joints) {
    const double value = d.ratio * q[d.joint] + d.offset;
    Eigen::Isometry3d t = d.parent < 0 ? d.frame : frames[d.parent] * d.frame;
    if (d.prismatic)
      t.translate(Eigen::Vector3d(0, 0, value));
    else
      t.rotate(Eigen::AngleAxisd(value, Eigen::Vector3d::UnitZ()));
    frames.push_back(t);
  }
  return frames;
}

double distance(const BatchObstacle& o, const Eigen::Vector3d& world) {
  const Eigen::Vector3d p = o.pose.inverse() * world;
  switch (o.kind) {
    case BatchObstacle::Kind::sphere: return p.norm() - o.size[0];
    case BatchObstacle::Kind::box: return (p.cwiseAbs() - o.size / 2).cwiseMax(0.0).norm();
    case BatchObstacle::Kind::cylinder:
      return std::hypot(std::max(0.0, p.head<2>().norm() - o.size[0]), std::max(0.0, std::abs(p.z()) - o.size[1] / 2));
    case BatchObstacle::Kind::capsule:
      return (p - Eigen::Vector3d(0, 0, std::clamp(p.z(), -o.size[1] / 2, o.size[1] / 2))).norm() - o.size[0];
    case BatchObstacle::Kind::field: break;  // none in these worlds
  }
  return 0;
}

/// The true bodies as spheres in the base frame.
std::vector<std::vector<PlacedSphere>> true_bodies(const BatchWorld& world, std::span<const double> q) {
  const auto frames = forward(world, q);
  std::vector<std::vector<PlacedSphere>> result;
  for (const BatchBody& b : world.bodies) {
    const Eigen::Isometry3d frame = b.actuated_joint < 0 ? Eigen::Isometry3d::Identity() : frames[b.actuated_joint];
    std::vector<PlacedSphere> spheres;
    for (const PlacedSphere& sphere : b.exact ? b.coarse : b.inner)
      spheres.push_back({frame * sphere.center, sphere.radius});
    result.push_back(spheres);
  }
  return result;
}

/// Smallest distance over all pairs, less padding; pairs of `skip_obstacle` and `skip_self` left out.
double clearance(const BatchWorld& world, std::span<const double> q, const std::vector<UndecidedPair>& skip = {}) {
  const auto bodies = true_bodies(world, q);
  std::vector<char> skipped_pairs(world.obstacle_pairs.size() + world.self_pairs.size());
  for (const UndecidedPair& u : skip)
    skipped_pairs[(u.self ? world.obstacle_pairs.size() : 0) + static_cast<std::size_t>(u.pair)] = true;
  const auto skipped = [&](bool self, std::size_t i) {
    return skipped_pairs[(self ? world.obstacle_pairs.size() : 0) + i];
  };
  double smallest = 1e9;
  for (std::size_t i = 0; i < world.obstacle_pairs.size(); ++i) {
    if (skipped(false, i)) continue;
    const auto& [b, o] = world.obstacle_pairs[i];
    const BatchObstacle& obstacle = world.obstacles[o];
    for (const PlacedSphere& sphere : bodies[b])
      smallest = std::min(
          smallest, distance(obstacle, sphere.center) - sphere.radius - obstacle.padding - world.bodies[b].padding);
  }
  for (std::size_t i = 0; i < world.self_pairs.size(); ++i) {
    if (skipped(true, i)) continue;
    for (const PlacedSphere& a : bodies[world.self_pairs[i].a])
      for (const PlacedSphere& b : bodies[world.self_pairs[i].b])
        smallest = std::min(smallest, (a.center - b.center).norm() - a.radius - b.radius - world.self_pairs[i].padding);
  }
  return smallest;
}

std::vector<double> random_q(std::mt19937& random, std::size_t count, double size = 3.1) {
  std::vector<double> q(count);
  for (double& x : q) x = uniform(random, -size, size);
  return q;
}

bool same(const std::vector<UndecidedPair>& a, const std::vector<UndecidedPair>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const UndecidedPair& x, const UndecidedPair& y) {
    return x.t == y.t && x.half == y.half && x.self == y.self && x.pair == y.pair;
  });
}

}  // namespace

BOOST_AUTO_TEST_CASE(kernel_kinematics_equal_double_precision) {
  const BatchWorld world = random_world(1);
  std::mt19937 random(2);
  for (SimdBackend backend : available_simd_backends()) {
    const BatchChecker checker(world, backend);
    const auto workspace = checker.make_workspace();
    double worst = 0;
    for (int i = 0; i < amount(500); ++i) {
      const auto q = random_q(random, 7, i % 2 ? 3.1 : 20.0);  // continuous joints may be turns away
      auto bounded = q;
      bounded[3] = std::clamp(q[3], -3.0, 3.0);
      const auto frames = forward(world, bounded);
      for (std::size_t k = 0; k < frames.size(); ++k) {
        const auto pose = checker.actuated_joint_pose(bounded, k, *workspace);
        worst = std::max(worst, (pose.matrix() - frames[k].matrix()).cwiseAbs().maxCoeff());
      }
    }
    BOOST_TEST(worst < 1e-5, to_string(backend) << ": " << worst);
    BOOST_TEST(worst < checker.error_bound());
  }
}

BOOST_AUTO_TEST_CASE(backends_agree_bit_for_bit) {
  std::mt19937 random(3);
  std::size_t free = 0, colliding = 0, undecided = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const BatchWorld world = random_world(seed, seed % 2 ? 2.0 : 1.0);
    std::vector<BatchChecker> checkers;
    for (SimdBackend backend : available_simd_backends()) checkers.emplace_back(world, backend);
    std::vector<BatchChecker::WorkspacePtr> workspaces;
    for (const auto& checker : checkers) workspaces.push_back(checker.make_workspace());
    for (int i = 0; i < amount(600); ++i) {
      const auto q = random_q(random, 7 * 16, 2.0);
      const auto a = random_q(random, 7, 3.0), d = random_q(random, 7, i % 3 ? 0.1 : 1.0);
      const auto block = checkers[0].check_block(q, *workspaces[0]);
      const auto block_pairs = checkers[0].undecided(*workspaces[0]);
      const BatchChecker::MotionOptions options{.step = i % 2 ? 0.05 : 0.6, .refinements = i % 4};
      const CollisionStatus motion = checkers[0].motion(a, d, *workspaces[0], options);
      const auto motion_pairs = checkers[0].undecided(*workspaces[0]);
      (motion == CollisionStatus::free ? free : motion == CollisionStatus::colliding ? colliding : undecided) += 1;
      for (std::size_t k = 1; k < checkers.size(); ++k) {
        const auto lanes = checkers[k].check_block(q, *workspaces[k]);
        BOOST_REQUIRE(lanes.colliding == block.colliding);
        BOOST_REQUIRE(lanes.undecided == block.undecided);
        BOOST_REQUIRE(same(checkers[k].undecided(*workspaces[k]), block_pairs));
        BOOST_REQUIRE((checkers[k].motion(a, d, *workspaces[k], options) == motion));
        BOOST_REQUIRE(same(checkers[k].undecided(*workspaces[k]), motion_pairs));
      }
    }
  }
  BOOST_TEST((free > amount(250u) && colliding > amount(250u) && undecided > amount(100u)));
}

BOOST_AUTO_TEST_CASE(deferred_pairs_are_checked_where_that_is_asked_for) {
  int by_deferred = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    BatchWorld world = random_world(seed, 2.0);
    const BatchChecker whole(world);
    world.deferred = {0, 2, 4, 6, 8, 10, 12, 14};
    const BatchChecker checker(world);
    for (int i = 0; i < amount(300); ++i) {
      const auto workspace = checker.make_workspace();
      const auto a = random_q(random, 7, 3.0), d = random_q(random, 7, i % 3 ? 0.1 : 1.0);
      const CollisionStatus others = checker.motion(a, d, *workspace, {});
      const CollisionStatus rest = checker.motion_of_pairs(a, d, *workspace, {}, world.deferred);
      for (const UndecidedPair& pair : checker.undecided(*workspace)) BOOST_REQUIRE((pair.self && pair.pair % 2 == 0));
      const bool free = whole.motion(a, d, *whole.make_workspace(), {}) == CollisionStatus::free;
      BOOST_REQUIRE(free == (others == rest && rest == CollisionStatus::free));
      BOOST_REQUIRE((checker.motion(a, d, *workspace, {}) == others));  // whatever hit before
      by_deferred += others == CollisionStatus::free && !free;
    }
  }
  BOOST_TEST(by_deferred > amount(20));
}

BOOST_AUTO_TEST_CASE(with_proofs_only_a_checker_proves_as_much) {
  std::mt19937 random(7);
  std::size_t free = 0, open = 0, of_blocks = 0, of_proofs = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    const BatchWorld world = random_world(seed, 2.0);
    for (SimdBackend backend : available_simd_backends()) {
      const BatchChecker checker(world, backend);
      const auto workspace = checker.make_workspace();
      std::mt19937 same_for_each = random;
      const std::vector<double> turns{0, 0, 0, 0, 0, 0, 200.0};
      for (int i = 0; i < amount(120); ++i) {
        const auto q = random_q(same_for_each, 7 * 16, 2.0);
        const auto lanes = checker.check_block(q, *workspace),
                   proofs = checker.check_block(q, *workspace, {.proofs_only = true});
        BOOST_REQUIRE((lanes.colliding | lanes.undecided) == (proofs.colliding | proofs.undecided));
        const auto a = random_q(same_for_each, 7, 3.0), d = random_q(same_for_each, 7, i % 3 ? 0.1 : 1.0);
        const std::uint64_t before = checker.statistics(*workspace).blocks;
        const CollisionStatus status = checker.motion(a, d, *workspace, {});
        const std::uint64_t between = checker.statistics(*workspace).blocks;
        BOOST_REQUIRE(checker.proves_free(a, d, *workspace, {}) == (status == CollisionStatus::free));
        (status == CollisionStatus::free ? free : open) += 1;
        if (status == CollisionStatus::undecided) {
          of_blocks += between - before;
          of_proofs += checker.statistics(*workspace).blocks - between;
        }
        // Whatever was checked before: a motion in many intervals, such as full turns of the last joint.
        const auto b = random_q(same_for_each, 7, 3.0), difference = random_q(same_for_each, 7, i % 2 ? 0.02 : 0.3);
        const bool proved = checker.motion(b, difference, *workspace, {}) == CollisionStatus::free;
        checker.motion(b, turns, *workspace, {});
        BOOST_REQUIRE(checker.proves_free(b, difference, *workspace, {}) == proved);
      }
    }
    random.discard(1000);
  }
  BOOST_TEST(free > 50u);
  BOOST_TEST(open > 50u);
  BOOST_TEST(of_proofs < of_blocks);
}

BOOST_AUTO_TEST_CASE(what_a_block_calls_free_is_free_and_what_it_calls_colliding_collides) {
  std::mt19937 random(4);
  int lanes_free = 0, hits = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    const BatchWorld world = random_world(seed, 1.8);
    const BatchChecker checker(world);
    const auto workspace = checker.make_workspace();
    for (int i = 0; i < amount(100); ++i) {
      const auto q = random_q(random, 7 * 16, 2.0);
      const auto lanes = checker.check_block(q, *workspace);
      const auto undecided = checker.undecided(*workspace);
      for (int lane = 0; lane < 16; ++lane) {
        const std::span<const double> here(q.data() + 7 * lane, 7);
        if (lanes.colliding >> lane & 1) {
          ++hits;
          BOOST_REQUIRE(clearance(world, here) < 0);
          continue;
        }
        std::vector<UndecidedPair> skip;
        for (const UndecidedPair& u : undecided)
          if (u.t == lane) skip.push_back(u);
        BOOST_REQUIRE((lanes.undecided >> lane & 1) == !skip.empty());
        lanes_free += skip.empty();
        BOOST_REQUIRE(clearance(world, here, skip) > 0);  // every pair not handed over is apart
      }
    }
  }
  BOOST_TEST(lanes_free > 500);
  BOOST_TEST(hits > 50);
}

BOOST_AUTO_TEST_CASE(what_a_motion_calls_free_is_free_between_samples) {
  std::mt19937 random(5);
  int free = 0, hits = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    const BatchWorld world = random_world(seed, 2.0);
    const BatchChecker checker(world);
    const auto workspace = checker.make_workspace();
    for (int i = 0; i < 30; ++i) {
      const auto a = random_q(random, 7, 2.0), d = random_q(random, 7, 0.4);
      const CollisionStatus status =
          i % 2 ? checker.motion(a, d, *workspace, {}) : checker.motion_block(a, d, *workspace);
      if (status == CollisionStatus::undecided) continue;
      double smallest = 1e9;
      for (int s = 0; s <= 300; ++s) {
        std::vector<double> q(7);
        for (int k = 0; k < 7; ++k) q[k] = a[k] + d[k] * s / 300.0;
        smallest = std::min(smallest, clearance(world, q));
      }
      (status == CollisionStatus::free ? free : hits) += 1;
      BOOST_REQUIRE((status == CollisionStatus::free ? smallest > 0 : smallest < 0.02));
    }
  }
  BOOST_TEST(free > 15);
  BOOST_TEST(hits > 15);
}

BOOST_AUTO_TEST_CASE(what_has_no_end_is_not_called_free) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const BatchWorld world = random_world(seed, 100.0);
    const std::vector<double> start(world.dof, 0.1), difference(world.dof, 1e8);
    for (const SimdBackend backend : available_simd_backends()) {
      const BatchChecker checker(world, backend);
      const auto workspace = checker.make_workspace();
      const auto whole = BatchChecker::MotionOptions{.step = 1e9, .refinements = 0, .max_blocks = 1};
      BOOST_TEST(static_cast<int>(checker.motion(start, difference, *workspace, whole)) !=
                 static_cast<int>(CollisionStatus::free));
    }
  }
}

/// Though spheres that hit before are tested first.
BOOST_AUTO_TEST_CASE(what_is_found_of_a_motion_does_not_depend_on_those_before) {
  std::mt19937 random(7);
  int hits = 0, others = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    const BatchWorld world = random_world(seed, seed % 2 ? 2.0 : 0.5);
    const BatchChecker checker(world);
    const auto used = checker.make_workspace();
    for (int i = 0; i < 100; ++i) {
      const auto a = random_q(random, 7, 2.0), d = random_q(random, 7, i % 3 ? 0.3 : 3.0);
      const auto fresh = checker.make_workspace();
      const CollisionStatus status = checker.motion(a, d, *fresh, {});
      BOOST_REQUIRE(checker.motion(a, d, *used, {}) == status);
      BOOST_REQUIRE(same(checker.undecided(*used), checker.undecided(*fresh)));
      (status == CollisionStatus::colliding ? hits : others) += 1;
    }
  }
  BOOST_TEST(hits > 100);
  BOOST_TEST(others > 100);
}

/// Pairs of bodies that a checker leaves out of an interval stay apart in it. Returns how many motions were undecided.
int check_that_pairs_left_out_stay_apart(unsigned worlds, double length, const BatchChecker::MotionOptions& options) {
  std::mt19937 random(6);
  int seen = 0;
  for (unsigned seed = 0; seed < worlds; ++seed) {
    const BatchWorld world = random_world(seed, 2.0);
    const BatchChecker checker(world);
    const auto workspace = checker.make_workspace();
    for (int i = 0; i < 30; ++i) {
      const auto a = random_q(random, 7, 2.0), d = random_q(random, 7, length);
      if (checker.motion(a, d, *workspace, options) != CollisionStatus::undecided) continue;
      ++seen;
      const auto undecided = checker.undecided(*workspace);
      for (int s = 0; s <= 100; ++s) {
        std::vector<double> q(7);
        for (int k = 0; k < 7; ++k) q[k] = a[k] + d[k] * s / 100.0;
        std::vector<UndecidedPair> here;
        for (const UndecidedPair& u : undecided)
          if (std::abs(u.t - s / 100.0) <= u.half + 1e-12) here.push_back(u);
        BOOST_REQUIRE(clearance(world, q, here) > 0);
      }
    }
  }
  return seen;
}

BOOST_AUTO_TEST_CASE(undecided_pairs_of_a_motion_are_all_that_may_touch) {
  for (const int refinements : {1, 2, 3})
    BOOST_TEST(check_that_pairs_left_out_stay_apart(amount(12u), 0.2, {.refinements = refinements}) > amount(10));
}

/// Where paths of points bend by centimetres to decimetres.
BOOST_AUTO_TEST_CASE(undecided_pairs_of_long_intervals_are_all_that_may_touch) {
  const double long_step = 1e9;
  for (const double length : {1.0, 3.0, 6.0})
    BOOST_TEST(check_that_pairs_left_out_stay_apart(amount(20u), length, {.step = long_step, .refinements = 0}) >
               amount(10));
}

/// Spheres of radius 0.1, each carried by a joint of its own along the axis, `apart` from each other across it.
BatchWorld sliding_spheres(std::size_t count, double apart, const Eigen::Vector3d& axis) {
  BatchWorld world;
  world.dof = count;
  for (std::size_t k = 0; k < count; ++k) {
    BatchActuatedJoint along;
    along.frame.linear() = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
    along.frame.translation().z() = apart * static_cast<double>(k);
    along.prismatic = true;
    along.max_travel = 2.0;
    along.joint = k;
    world.actuated_joints.push_back(along);
    BatchBody body;
    body.actuated_joint = static_cast<int>(k);
    body.bound = {Eigen::Vector3d::Zero(), 0.1};
    body.coarse = {body.bound};
    body.exact = true;
    world.bodies.push_back(body);
  }
  return world;
}

/// A body that moves along a wall, or along another body, 2 mm from it, needs no subdivision.
BOOST_AUTO_TEST_CASE(what_moves_along_without_coming_nearer_is_free_at_once) {
  BatchWorld world = sliding_spheres(2, 0.202, Eigen::Vector3d::UnitX());
  BatchObstacle wall;
  wall.kind = BatchObstacle::Kind::box;
  wall.size = {4.0, 4.0, 0.1};
  wall.pose.translation().z() = -0.152;
  world.obstacles = {wall};
  world.obstacle_pairs = {{0, 0}, {1, 0}};
  world.self_pairs = {{0, 1, 0.0}};
  const BatchChecker checker(world);
  const auto workspace = checker.make_workspace();
  const std::vector<double> start{-1.0, -1.0};
  const BatchChecker::MotionOptions at_once{.step = 1e9, .refinements = 0, .max_blocks = 1};
  for (const double other : {2.0, 1.0, 0.0, -1.0})
    BOOST_CHECK(checker.motion(start, std::vector<double>{2.0, other}, *workspace, at_once) == CollisionStatus::free);
}

/// Two spherical bodies, hollow or solid, on a line. What is inside of a hollow one does not touch it.
struct SphericalBodies {
  std::array<double, 2> radii{};
  std::array<bool, 2> hollow{};
  double padding{};

  bool touch(double distance) const {
    if (distance > radii[0] + radii[1] + padding) return false;
    for (std::size_t k = 0; k < 2; ++k)
      if (hollow[k] && distance + radii[1 - k] < radii[k] - padding) return false;
    return true;
  }

  /// Each has two coarse spheres, and inner ones that only the first connects.
  BatchWorld world() const {
    BatchWorld world = sliding_spheres(2, 0.0, Eigen::Vector3d::UnitX());
    for (std::size_t k = 0; k < 2; ++k) {
      const double r = radii[k];
      BatchBody& body = world.bodies[k];
      body.hollow = hollow[k];
      body.exact = false;
      body.bound = {Eigen::Vector3d::Zero(), 1.1 * r};
      body.coarse = {{{0, 0, 0.01 * r}, 1.01 * r}, {{0.02 * r, 0, 0}, 1.02 * r}};
      body.inner.push_back({Eigen::Vector3d::Zero(), 0.6 * r});
      for (int i = 0; i < 6; ++i)
        body.inner.push_back({(i < 3 ? 1 : -1) * 0.75 * r * Eigen::Vector3d::Unit(i % 3), 0.24 * r});
    }
    world.self_pairs = {{0, 1, padding}};
    return world;
  }
};

BOOST_AUTO_TEST_CASE(inner_spheres_of_hollow_bodies_hit_where_surfaces_intersect) {
  std::mt19937 random(10);
  int hits = 0, touching = 0, inside = 0;
  for (int i = 0; i < amount(400); ++i) {
    SphericalBodies two;
    for (double& radius : two.radii) radius = uniform(random, 0.05, 0.15);
    two.hollow = {i % 4 != 1, i % 4 != 2};
    two.padding = i % 3 ? 0.0 : 0.01;
    std::vector<double> q;
    for (int lane = 0; lane < 16; ++lane) {
      q.push_back(0.0);
      q.push_back(uniform(random, -0.3, 0.3));
    }
    std::optional<BatchChecker::Lanes> first;
    for (const SimdBackend backend : available_simd_backends()) {
      const BatchChecker checker(two.world(), backend);
      const auto lanes = checker.check_block(q, *checker.make_workspace());
      if (first) BOOST_REQUIRE((lanes.colliding == first->colliding && lanes.undecided == first->undecided));
      first = lanes;
    }
    for (std::size_t lane = 0; lane < 16; ++lane) {
      const double distance = std::abs(q[2 * lane + 1] - q[2 * lane]);
      const bool touch = two.touch(distance), hit = first->colliding >> lane & 1;
      if (hit) BOOST_REQUIRE(touch);
      if (touch) BOOST_REQUIRE(((first->colliding | first->undecided) >> lane & 1));
      hits += hit;
      touching += touch;
      inside += !touch && distance < two.radii[0];
    }
  }
  BOOST_TEST(hits > touching / 2);
  BOOST_TEST(inside > amount(300));
}

/// Checks of robots of different sizes use the same memory.
BOOST_AUTO_TEST_CASE(checkers_that_take_turns_find_what_they_find_alone) {
  const BatchChecker large(random_world(1)), small(sliding_spheres(1, 0.0, Eigen::Vector3d::UnitX()));
  const auto of_large = large.make_workspace(), of_small = small.make_workspace();
  std::mt19937 random(11);
  for (int i = 0; i < 20; ++i) {
    const auto q = random_q(random, 7, 2.0), d = random_q(random, 7, 0.4);
    const CollisionStatus alone = large.motion(q, d, *of_large, {});
    const Eigen::Isometry3d pose = large.actuated_joint_pose(q, 4, *of_large);
    small.check_block(std::vector<double>{0.5}, *of_small);
    BOOST_TEST((large.motion(q, d, *of_large, {}) == alone));
    small.check_block(std::vector<double>{-0.5}, *of_small);
    BOOST_TEST((large.actuated_joint_pose(q, 4, *of_large).matrix() == pose.matrix()));
  }
}

/// What is left out for several lanes at once may not be more than what each would leave out.
BOOST_AUTO_TEST_CASE(backends_agree_where_a_body_passes_a_corner) {
  std::mt19937 random(9);
  int undecided = 0;
  for (int i = 0; i < amount(2000); ++i) {
    BatchWorld world = sliding_spheres(1, 0.0, Eigen::Vector3d(uniform(random, -0.1, 0.1), 1.0, 0.0).normalized());
    BatchObstacle box;
    box.kind = BatchObstacle::Kind::box;
    box.size = {0.2, 0.2, 0.2};
    box.pose.translation().x() = uniform(random, 0.2, 0.24);
    box.pose.translation().y() = uniform(random, 0.0, 1.0);
    world.obstacles = {box};
    world.obstacle_pairs = {{0, 0}};
    std::vector<UndecidedPair> first;
    for (const SimdBackend backend : available_simd_backends()) {
      const BatchChecker checker(world, backend);
      const auto workspace = checker.make_workspace();
      checker.motion(std::vector<double>{-1.0}, std::vector<double>{2.0}, *workspace, {.step = 1e9, .refinements = 0});
      if (backend == available_simd_backends().front()) first = checker.undecided(*workspace);
      BOOST_REQUIRE(same(checker.undecided(*workspace), first));
    }
    undecided += !first.empty();
  }
  BOOST_TEST(undecided > amount(100));
}

BOOST_AUTO_TEST_CASE(batch_checker_refuses_nonsense) {
  BatchWorld world = random_world(1);
  world.bodies[2].actuated_joint = 99;
  check_throws<InvalidArgument>([&] { BatchChecker checker(world); }, "actuated joint is 99");
  world = random_world(1);
  world.obstacle_pairs.push_back({0, 77});
  check_throws<InvalidArgument>([&] { BatchChecker checker(world); }, "77");
  world = random_world(1);
  world.deferred = {1000};
  check_throws<InvalidArgument>([&] { BatchChecker checker(world); }, "1000");
  world = random_world(1);
  world.actuated_joints[1].frame.translation().x() = NAN;
  check_throws<InvalidArgument>([&] { BatchChecker checker(world); }, "not finite");
  const BatchChecker checker(random_world(1));
  const auto workspace = checker.make_workspace();
  check_throws<InvalidArgument>([&] { checker.check_block(std::vector<double>(8), *workspace); }, "7 entries");
  check_throws<InvalidArgument>(
      [&] { checker.proves_free(std::vector<double>(6), std::vector<double>(7), *workspace, {}); },
      "start of the motion");
  check_throws<InvalidArgument>([&] { checker.motion(std::vector<double>(7), std::vector<double>(3), *workspace, {}); },
                                "3 entries");
}

BOOST_AUTO_TEST_CASE(simd_backend_comes_from_the_environment) {
  const char* before = std::getenv("SRMP_SIMD");
  const std::string saved = before ? before : "";
  setenv("SRMP_SIMD", "portable", 1);
  BOOST_TEST((default_simd_backend() == SimdBackend::portable));
  setenv("SRMP_SIMD", "avx51", 1);
  check_throws<InvalidArgument>([] { default_simd_backend(); }, "did you mean 'avx512'");
  before ? setenv("SRMP_SIMD", saved.c_str(), 1) : unsetenv("SRMP_SIMD");
}
