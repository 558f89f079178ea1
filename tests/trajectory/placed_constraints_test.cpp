#include "srmp/trajectory/placed_constraints.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>

#include "srmp/core/error.hpp"
#include "support/amount.hpp"
#include "support/data.hpp"
#include "support/numbers.hpp"

using namespace srmp;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// One of each type that arm7 keeps at q, in the frame of its base or of one of its own links.
PlacedConstraint constraint_at(const RobotModel& robot, const Eigen::VectorXd& q, std::size_t number) {
  const std::size_t hand = robot.link_index(robot.end_effector());
  const RobotDataPtr data = robot.make_data();
  robot.forward(*data, q);
  const bool moving = number / 7 % 2 == 1;
  const std::size_t frame = robot.link_index(robot.link_names()[3]);
  const Eigen::Isometry3d in_frame = moving ? robot.link_pose(*data, frame) : Eigen::Isometry3d::Identity();
  const Pose here = Pose::from_isometry(in_frame.inverse() * robot.link_pose(*data, hand));
  const Eigen::Vector3d z = here.q * Eigen::Vector3d::UnitZ();
  const std::vector<PathConstraint> types{
      PathConstraint::cone({0, 0, 1}, z, 0.3),
      PathConstraint::orientation(here.q, {0.2, 0.3, infinity}),
      PathConstraint::pose(here, 0.1, 0.4),
      PathConstraint::box({0.1, infinity, 0.2}, here),
      PathConstraint::plane(here.p, {0.3, 0.2, 1.0}, 0.05),
      PathConstraint::line(here.p, {1.0, 0.2, 0.1}, 0.07),
      PathConstraint::distance(here.p + Eigen::Vector3d(0.3, 0.0, 0.0), 0.25, 0.35),
  };
  const PathConstraint& chosen = types[number % types.size()];
  chosen.validate();
  return {chosen,
          hand,
          Eigen::Isometry3d::Identity(),
          moving ? std::optional(frame) : std::nullopt,
          chosen.target.isometry(),
          std::string(to_string(chosen.type))};
}

/// A motion from q whose joints pass it with velocities.
std::vector<detail::Cubic> motion_from(const RobotModel& robot, const Eigen::VectorXd& q, std::size_t seed) {
  const Eigen::VectorXd by = 0.15 * sample_configuration(robot, seed + 1),
                        v = 0.4 * sample_configuration(robot, seed + 2);
  std::vector<detail::Cubic> cubics;
  for (Eigen::Index j = 0; j < q.size(); ++j) cubics.push_back(detail::hermite(q[j], v[j], q[j] + by[j], -v[j], 0.5));
  return cubics;
}

}  // namespace

BOOST_AUTO_TEST_SUITE(placed_constraints)

BOOST_AUTO_TEST_CASE(what_is_proved_of_a_motion_holds_at_all_samples_and_is_little_more) {
  const auto robot = RobotModel::load(arm7());
  for (std::size_t seed = 0; seed < static_cast<std::size_t>(amount(280)); ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
      const Eigen::VectorXd q = 0.7 * sample_configuration(*robot, seed);
      const PlacedConstraints placed(*robot, robot->default_other_positions(), {constraint_at(*robot, q, seed)});
      ConstraintChecker checker(placed);
      const std::vector<detail::Cubic> cubics = motion_from(*robot, q, seed);
      std::vector<ConstraintDeviation> proved = checker.none();
      checker.add(cubics, 0.0, proved);
      double worst = 0.0;
      for (int i = 0; i <= 2000; ++i) {
        Eigen::VectorXd at(q.size());
        for (Eigen::Index j = 0; j < q.size(); ++j)
          at[j] = cubics[static_cast<std::size_t>(j)].position(0.5 * i / 2000.0);
        worst = std::max(worst, checker.deviation(at));
      }
      const double bound = proved.front().deviation / proved.front().tolerance;
      BOOST_TEST(worst <= bound + 1e-9);
      BOOST_TEST(bound <= worst + 0.03);
    }
}

BOOST_AUTO_TEST_CASE(a_straight_motion_that_is_kept_is_kept_at_all_samples) {
  const auto robot = RobotModel::load(arm7());
  std::size_t kept = 0, refused = 0;
  for (std::size_t seed = 0; seed < static_cast<std::size_t>(amount(280)); ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
      const Eigen::VectorXd a = 0.7 * sample_configuration(*robot, seed);
      const Eigen::VectorXd b = a + 0.06 * sample_configuration(*robot, seed + 5000);
      const PlacedConstraints placed(*robot, robot->default_other_positions(), {constraint_at(*robot, a, seed)});
      ConstraintChecker checker(placed);
      double worst = 0.0;
      for (int i = 0; i <= 500; ++i) worst = std::max(worst, checker.deviation(a + i / 500.0 * (b - a)));
      const bool is_kept = checker.keeps(a, b, 0.8);
      (is_kept ? kept : refused) += 1;
      const double most = std::min(1.0, std::max({0.8, checker.deviation(a), checker.deviation(b)}));
      BOOST_TEST((!is_kept || worst <= most + 1e-6));
      BOOST_TEST((is_kept || worst > most - 1e-6));
    }
  BOOST_TEST(kept > (kept + refused) / 14);
  BOOST_TEST(refused > (kept + refused) / 14);
}

BOOST_AUTO_TEST_CASE(configurations_are_projected_onto_constraints_within_limits) {
  const auto robot = RobotModel::load(arm7());
  std::size_t found = 0, all = 0;
  for (std::size_t seed = 0; seed < static_cast<std::size_t>(amount(280)); ++seed) BOOST_TEST_CONTEXT("seed " << seed) {
      const Eigen::VectorXd on = 0.7 * sample_configuration(*robot, seed);
      const PlacedConstraints placed(*robot, robot->default_other_positions(), {constraint_at(*robot, on, seed)});
      ConstraintChecker checker(placed);
      BOOST_TEST(checker.deviation(on) <= 0.2 + 1e-6);
      BOOST_TEST(checker.violation(on).empty());
      Eigen::VectorXd q = on + 0.3 * sample_configuration(*robot, seed + 9000), again = q;
      ++all;
      if (!checker.project(q, 0.6)) continue;
      ++found;
      BOOST_TEST(checker.deviation(q) <= 0.6 + 1e-12);
      BOOST_TEST(!robot->limit_violation(q));
      ConstraintChecker other(placed);
      BOOST_TEST(other.project(again, 0.6));
      BOOST_TEST((again == q));
    }
  BOOST_TEST(found > 8 * all / 10);
}

BOOST_AUTO_TEST_CASE(bad_constraints_are_refused_with_a_sentence) {
  const Pose here;
  const std::vector<std::pair<PathConstraint, std::string>> bad{
      {PathConstraint::cone({0, 0, 1}, {0, 0, 1}, 0.0), "tolerance of a cone"},
      {PathConstraint::cone({0, 0, 1}, {0, 0, 1}, 4.0), "below 3.14"},
      {PathConstraint::cone({0, 0, 0}, {0, 0, 1}, 0.1), "length 0"},
      {PathConstraint::cone({0, 0, 1}, {0, 0, 0}, 0.1), "length 0"},
      {PathConstraint::plane({0, 0, 0}, {0, 0, 1}, -1.0), "tolerance of a plane"},
      {PathConstraint::line({NAN, 0, 0}, {0, 0, 1}, 0.1), "not finite"},
      {PathConstraint::distance({0, 0, 0}, 0.3, 0.2), "between 0.3 m and 0.2 m"},
      {PathConstraint::box({0.1, 0.0, 0.1}, here), "half the size of a box"},
      {PathConstraint::box({infinity, infinity, infinity}, here), "leaves every axis free"},
      {PathConstraint::orientation(here.q, infinity), "leaves every axis free"},
      {PathConstraint::pose(here, infinity, infinity), "leaves every axis free"},
  };
  for (const auto& [constraint, words] : bad)
    BOOST_CHECK_EXCEPTION(constraint.validate(), InvalidArgument, [&](const InvalidArgument& error) {
      return std::string(error.what()).find(words) != std::string::npos;
    });
}

BOOST_AUTO_TEST_SUITE_END()
