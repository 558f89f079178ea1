#include "srmp/robot/damped_least_squares.hpp"

#include <Eigen/Geometry>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

using namespace srmp;

namespace {

using RowMatrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// A made-up robot; some of its joints slide, and some follow another joint.
struct Chain {
  std::vector<ChainJoint> joints;
  std::vector<double> lower, upper;
  DampedLeastSquares problem{};

  Chain(std::mt19937& random, std::size_t planned) {
    const auto in = [&](double low, double high) { return low + (high - low) * (random() * 0x1p-32); };
    for (std::size_t i = 0; i < planned + planned / 3; ++i) {
      ChainJoint joint{};
      place(joint.rotation, joint.translation, in);
      joint.planned = i % planned;
      joint.ratio = i < planned ? 1.0 : in(-2, 2);
      joint.prismatic = random() % 5 == 0;
      joints.push_back(joint);
    }
    for (std::size_t c = 0; c < planned; ++c) {
      const double reach = random() % 4 == 0 ? std::numeric_limits<double>::infinity() : in(0.5, 3.0);
      lower.push_back(-reach);
      upper.push_back(reach);
    }
    place(problem.end_rotation, problem.end_translation, in);
    problem.joints = joints.data();
    problem.joint_count = joints.size();
    problem.lower = lower.data();
    problem.upper = upper.data();
    problem.planned_count = planned;
    for (int axis = 0; axis < 6; ++axis)
      problem.tolerance[axis] = random() % 6 == 0 ? std::numeric_limits<double>::infinity() : 1e-5;
    problem.max_iterations = 100;
  }

  static void place(double* rotation, double* translation, const auto& in) {
    const double angle = in(-3, 3);
    const Eigen::Vector3d axis(in(-1, 1), in(-1, 1), in(0.1, 1));
    Eigen::Map<RowMatrix3>{rotation} = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    for (int i = 0; i < 3; ++i) translation[i] = in(-0.3, 0.3);
  }

  static Eigen::Isometry3d frame(const double* rotation, const double* translation) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.linear() = Eigen::Map<const RowMatrix3>{rotation};
    pose.translation() = Eigen::Map<const Eigen::Vector3d>{translation};
    return pose;
  }

  /// The link in the frame of the target, by Eigen.
  Eigen::Isometry3d link(const double* q) const {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (const ChainJoint& joint : joints) {
      const double position = joint.ratio * q[joint.planned];
      pose = pose * frame(joint.rotation, joint.translation);
      if (joint.prismatic)
        pose.translate(Eigen::Vector3d(0, 0, position));
      else
        pose.rotate(Eigen::AngleAxisd(position, Eigen::Vector3d::UnitZ()));
    }
    return pose * frame(problem.end_rotation, problem.end_translation);
  }

  /// Moves the target to where the link is at q.
  void aim_at(const std::vector<double>& q) {
    const Eigen::Isometry3d first = link(q.data()).inverse() * frame(joints[0].rotation, joints[0].translation);
    Eigen::Map<RowMatrix3>{joints[0].rotation} = first.linear();
    Eigen::Map<Eigen::Vector3d>{joints[0].translation} = first.translation();
  }
};

struct Solved {
  std::vector<double> configurations;
  std::vector<char> reached;
  bool operator==(const Solved&) const = default;
};

Solved solve(DampedLeastSquaresFunction function, const DampedLeastSquares& problem, const std::vector<double>& seeds,
             std::size_t at_once) {
  Solved result{seeds, std::vector<char>(seeds.size() / problem.planned_count)};
  for (std::size_t first = 0; first < result.reached.size(); first += at_once) {
    const std::size_t count = std::min(at_once, result.reached.size() - first);
    bool reached[64];
    function(problem, count, result.configurations.data() + first * problem.planned_count, reached);
    for (std::size_t i = 0; i < count; ++i) result.reached[first + i] = reached[i];
  }
  return result;
}

}  // namespace

BOOST_AUTO_TEST_CASE(seeds_reach_the_target_and_each_by_itself_with_the_same_bits_for_all_instruction_sets) {
  std::mt19937 random(3);
  int reached = 0, all = 0;
  for (int trial = 0; trial < 120; ++trial) {
    const std::size_t planned = 1 + random() % 9;
    Chain chain(random, planned);
    const auto draw = [&](std::size_t c) {
      const double bound = std::min(chain.upper[c], 3.0);
      return bound * (2.0 * (random() * 0x1p-32) - 1.0);
    };
    std::vector<double> q(planned), seeds;
    for (std::size_t c = 0; c < planned; ++c) q[c] = draw(c);
    chain.aim_at(q);
    for (int i = 0; i < 37; ++i)
      for (std::size_t c = 0; c < planned; ++c) seeds.push_back(i == 0 ? q[c] : draw(c));
    const Solved solved = solve(damped_least_squares_portable, chain.problem, seeds, 37);
    BOOST_TEST(solved.reached[0]);  // the seed is a solution
    for (std::size_t i = 0; i < solved.reached.size(); ++i) {
      ++all;
      if (!solved.reached[i]) continue;
      ++reached;
      const double* at = solved.configurations.data() + i * planned;
      const Eigen::Isometry3d off = chain.link(at);
      for (int axis = 0; axis < 3; ++axis)
        BOOST_TEST(std::abs(off.translation()[axis]) <= chain.problem.tolerance[axis] + 1e-12);
      const bool no_angle_is_free =
          std::isfinite(chain.problem.tolerance[3] + chain.problem.tolerance[4] + chain.problem.tolerance[5]);
      if (no_angle_is_free) BOOST_TEST(Eigen::AngleAxisd(off.linear()).angle() < 2e-5);
      for (std::size_t c = 0; c < planned; ++c) BOOST_TEST((chain.lower[c] <= at[c] && at[c] <= chain.upper[c]));
    }
    for (const SimdBackend backend : available_simd_backends())
      for (const std::size_t at_once : {37, 1, 5})
        BOOST_TEST((solve(damped_least_squares(backend), chain.problem, seeds, at_once) == solved));
  }
  BOOST_TEST(reached > all / 4);
}

BOOST_AUTO_TEST_CASE(half_a_turn_and_many_turns_are_no_dead_ends) {
  for (const bool one_angle_is_free : {false, true})
    for (const double beyond : {0.0, 1e-9, -1e-3, 20.0 * std::numbers::pi, 1e4}) {
      const double seed = std::numbers::pi + beyond, no_limit = std::numeric_limits<double>::infinity(),
                   lowest = -no_limit;
      const ChainJoint turns{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {}, 1.0, 0, false};
      const DampedLeastSquares problem{
          .joints = &turns,
          .joint_count = 1,
          .end_rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1},
          .end_translation = {},
          .lower = &lowest,
          .upper = &no_limit,
          .planned_count = 1,
          .tolerance = {no_limit, no_limit, no_limit, 1e-9, one_angle_is_free ? no_limit : 1e-9, 1e-9},
          .max_iterations = 100};
      for (const SimdBackend backend : available_simd_backends()) {
        double q = seed;
        bool reached = false;
        damped_least_squares(backend)(problem, 1, &q, &reached);
        BOOST_TEST(reached);
        BOOST_TEST(std::abs(std::remainder(q, 2.0 * std::numbers::pi)) < 1e-9);
      }
    }
}

BOOST_AUTO_TEST_CASE(seeds_that_are_no_numbers_are_abandoned) {
  std::mt19937 random(5);
  Chain chain(random, 6);
  for (const SimdBackend backend : available_simd_backends()) {
    std::vector<double> seeds(6 * 20, 0.1);
    for (std::size_t i = 0; i < seeds.size(); i += 12) seeds[i] = std::nan("");
    const Solved solved = solve(damped_least_squares(backend), chain.problem, seeds, 20);
    for (std::size_t i = 0; i < 20; i += 2) BOOST_TEST(!solved.reached[i]);
    bool none[1];
    damped_least_squares(backend)(chain.problem, 0, seeds.data(), none);
  }
}
