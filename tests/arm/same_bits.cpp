// Verdicts of the batch checker on a made-up world, nearest configurations of a tree and solutions of inverse
// kinematics, as text: the same on every processor. Needs no library but Eigen, so that it can be built for another
// processor; tests/python/test_arm.py compares.

#include <cstdio>
#include <random>

#include "srmp/collision/batch/batch_checker.hpp"
#include "srmp/robot/damped_least_squares.hpp"
#include "srmp/search/configuration_tree.hpp"

using namespace srmp;

int main() {
  std::mt19937 random(7);
  const auto in = [&](double low, double high) { return low + (high - low) * (random() * 0x1p-32); };
  const auto vector = [&](double low, double high) {  // one after the other: compilers order arguments as they like
    Eigen::Vector3d v;
    for (double& x : v) x = in(low, high);
    return v;
  };
  const auto turned = [&](const Eigen::Vector3d& place) {
    const double angle = in(-2, 2);
    Eigen::Isometry3d pose(Eigen::AngleAxisd(angle, (vector(-1, 1) + Eigen::Vector3d(0, 0, 1.5)).normalized()));
    pose.translation() = place;
    return pose;
  };
  BatchWorld world;
  world.dof = 7;
  for (int k = 0; k < 7; ++k) {
    BatchActuatedJoint actuated;
    actuated.parent = k - 1;
    actuated.joint = k;
    actuated.frame = turned(vector(-0.05, 0.05) + Eigen::Vector3d(0, 0, 0.2));
    world.actuated_joints.push_back(actuated);
    BatchBody body;
    body.actuated_joint = k;
    for (int i = 0; i < 6; ++i) {
      const Eigen::Vector3d center = vector(-0.1, 0.1);
      body.coarse.push_back({center, in(0.03, 0.06)});
    }
    body.bound = {Eigen::Vector3d::Zero(), 0.3};
    body.exact = true;
    world.bodies.push_back(body);
  }
  using Kind = BatchObstacle::Kind;
  for (int i = 0; i < 24; ++i) {
    BatchObstacle o;
    o.kind = std::array{Kind::box, Kind::sphere, Kind::cylinder, Kind::capsule}[static_cast<std::size_t>(i % 4)];
    o.size = vector(0.05, 0.2);
    o.pose = turned(vector(-1, 1));
    world.obstacles.push_back(o);
    for (int body = 0; body < 7; ++body) world.obstacle_pairs.emplace_back(body, i);
  }
  for (int a = 0; a < 7; ++a)
    for (int b = a + 2; b < 7; ++b) world.self_pairs.push_back({a, b, 0.0, true});
  const BatchChecker checker(world, SimdBackend::portable);
  const auto workspace = checker.make_workspace();
  std::vector<double> a(7), d(7), block(7 * 16);
  search::ConfigurationTree tree({1, 0, 0, 1, 0, 0, 1});
  std::vector<ChainJoint> joints(7);
  const auto copy = [](const Eigen::Isometry3d& frame, double* rotation, double* translation) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) rotation[3 * r + c] = frame(r, c);
      translation[r] = frame(r, 3);
    }
  };
  for (std::size_t k = 0; k < joints.size(); ++k) {
    copy(turned(vector(-0.3, 0.3)), joints[k].rotation, joints[k].translation);
    joints[k].ratio = 1.0;
    joints[k].planned = k;
    joints[k].prismatic = k == 3;
  }
  const std::vector<double> lower(7, -2.0), upper(7, 2.0);
  DampedLeastSquares aim{.joints = joints.data(),
                         .joint_count = 7,
                         .lower = lower.data(),
                         .upper = upper.data(),
                         .planned_count = 7,
                         .tolerance = {1e-5, 1e-5, 1e-5, 1e-4, 1e-4, 1e-4},
                         .max_iterations = 50};
  for (int i = 0; i < 2000; ++i) {
    for (double& x : a) x = in(-3, 3);
    for (double& x : d) x = in(-0.3, 0.3);
    for (double& x : block) x = in(-3, 3);
    const CollisionStatus status = checker.motion(a, d, *workspace, {});
    std::printf("%d", static_cast<int>(status));
    for (const UndecidedPair& u : checker.undecided(*workspace))
      std::printf(" %a %a %d %d", u.t, u.half, u.self, u.pair);
    const auto lanes = checker.check_block(block, *workspace);
    std::printf(" %x %x", static_cast<unsigned>(lanes.colliding), static_cast<unsigned>(lanes.undecided));
    const Eigen::Isometry3d pose = checker.actuated_joint_pose(a, 6, *workspace);
    for (int r = 0; r < 3; ++r) std::printf(" %a", pose(r, 3));
    const Eigen::VectorXd q = Eigen::VectorXd::Map(a.data(), 7);
    if (i > 0) std::printf(" %zu", tree.nearest(q));
    i == 0 ? tree.add_root(q) : tree.add(q, 0);
    std::printf(" %a", tree.cost(tree.size() - 1));
    bool reached = false;
    copy(turned(vector(-0.3, 0.3)), aim.end_rotation, aim.end_translation);
    damped_least_squares(SimdBackend::portable)(aim, 1, a.data(), &reached);
    std::printf(" %d %a\n", reached, a[0]);
  }
}
