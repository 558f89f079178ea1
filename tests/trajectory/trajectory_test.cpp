#include "srmp/trajectory/trajectory.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/path.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

constexpr double pi = std::numbers::pi;

Trajectory ramp() {
  Trajectory t;
  t.joint_names = {"a", "b"};
  t.positions.resize(3, 2);
  t.positions << 0, 0, 3, 4, 3, 5;
  t.times = Eigen::Vector3d(0, 1, 3);
  return t;
}

RowMatrix rows(std::initializer_list<std::initializer_list<double>> values) {
  RowMatrix m(static_cast<Eigen::Index>(values.size()), static_cast<Eigen::Index>(values.begin()->size()));
  Eigen::Index i = 0;
  for (const auto& row : values) {
    Eigen::Index j = 0;
    for (const double v : row) m(i, j++) = v;
    ++i;
  }
  return m;
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_trajectory_knows_its_length_and_duration) {
  BOOST_TEST(ramp().length() == 6.0);
  BOOST_TEST(ramp().duration() == 3.0);
  BOOST_TEST(ramp().size() == 3u);
  BOOST_TEST(ramp().dof() == 2u);
  BOOST_TEST(Trajectory{}.duration() == 0.0);
  BOOST_TEST(Trajectory{}.length() == 0.0);
}

BOOST_AUTO_TEST_CASE(sampling_is_linear_and_stays_at_the_ends) {
  const Trajectory t = ramp();
  BOOST_TEST((t.sample(0.5) - Eigen::Vector2d(1.5, 2)).norm() < 1e-15);
  BOOST_TEST((t.sample(2.0) - Eigen::Vector2d(3, 4.5)).norm() < 1e-15);
  BOOST_TEST((t.sample(1.0) == Eigen::Vector2d(3, 4)));
  BOOST_TEST((t.sample(-1.0) == Eigen::Vector2d(0, 0)));
  BOOST_TEST((t.sample(3.0) == Eigen::Vector2d(3, 5)));
  BOOST_TEST((t.sample(std::numeric_limits<double>::infinity()) == Eigen::Vector2d(3, 5)));
}

BOOST_AUTO_TEST_CASE(sampling_refuses_nonsense) {
  check_throws<InvalidArgument>([] { ramp().sample(NAN); }, "NaN");
  check_throws<InvalidArgument>([] { Trajectory{}.sample(0.0); }, "no rows");
}

BOOST_AUTO_TEST_CASE(redundant_waypoints_go_and_the_path_stays) {
  const RowMatrix path = rows({{0, 0}, {0, 0}, {1, 1}, {2, 2}, {2, 2}, {2, 3}, {2, 5}, {2, 4}});
  const RowMatrix kept = without_redundant_waypoints(path);
  BOOST_TEST((kept == rows({{0, 0}, {2, 2}, {2, 5}, {2, 4}})));  // the way back is not on the way
  BOOST_TEST(path_length(kept) == path_length(path), boost::test_tools::tolerance(1e-15));
}

BOOST_AUTO_TEST_CASE(nearly_collinear_waypoints_stay) {
  const RowMatrix bent = rows({{0, 0}, {1, 1e-11}, {2, 0}});
  BOOST_TEST((without_redundant_waypoints(bent) == bent));
  BOOST_TEST(without_redundant_waypoints(rows({{0, 0}, {1, 1e-13}, {2, 0}})).rows() == 2);
  // A slow curve must not be straightened bit by bit.
  RowMatrix curve(200, 2);
  for (Eigen::Index i = 0; i < 200; ++i) curve.row(i) << static_cast<double>(i), 1e-12 * static_cast<double>(i * i);
  const RowMatrix kept = without_redundant_waypoints(curve);
  for (Eigen::Index i = 0, k = 0; i < 200; ++i) {
    while (kept(k + 1, 0) < curve(i, 0)) ++k;
    const double share = (curve(i, 0) - kept(k, 0)) / (kept(k + 1, 0) - kept(k, 0));
    BOOST_TEST(std::abs(kept(k, 1) + share * (kept(k + 1, 1) - kept(k, 1)) - curve(i, 1)) < 3e-10);
  }
}

BOOST_AUTO_TEST_CASE(short_paths_are_left_alone) {
  BOOST_TEST(without_redundant_waypoints(RowMatrix(0, 3)).rows() == 0);
  BOOST_TEST((without_redundant_waypoints(rows({{1, 2}})) == rows({{1, 2}})));
  BOOST_TEST((without_redundant_waypoints(rows({{1, 2}, {1, 2}})) == rows({{1, 2}})));
  BOOST_TEST((without_redundant_waypoints(rows({{1, 2}, {2, 2}, {1, 2}})) == rows({{1, 2}, {2, 2}, {1, 2}})));
}

BOOST_AUTO_TEST_CASE(unwrapping_goes_the_short_way_and_keeps_other_joints) {
  const RowMatrix unwrapped = unwrap_waypoints(rows({{3, 3}, {-3, -3}, {3, 3}, {9, 0}}), {true, false});
  const RowMatrix expected = rows({{3, 3}, {-3 + 2 * pi, -3}, {3, 3}, {9 - 2 * pi, 0}});
  BOOST_TEST((unwrapped - expected).norm() < 1e-14);
  BOOST_CHECK_NO_THROW(require_short_way(unwrapped, {true, false}));
}

BOOST_AUTO_TEST_CASE(the_long_way_round_is_refused) {
  const std::vector<std::string> names{"wrist", "elbow"};
  check_throws<InvalidArgument>([&] { require_short_way(rows({{3, 0}, {-3, 0}}), {true, false}, names); },
                                "wrist: the continuous joint moves by -6 rad from waypoint 0 to 1");
  BOOST_CHECK_NO_THROW(require_short_way(rows({{0, 3}, {0, -3}}), {true, false}, names));
  check_throws<InvalidArgument>([&] { unwrap_waypoints(rows({{3, 0}}), {true}); }, "2 joints, but 1 flags");
}

BOOST_AUTO_TEST_CASE(stacking_refuses_mixed_sizes) {
  const std::vector<Eigen::VectorXd> good{Eigen::Vector2d(1, 2), Eigen::Vector2d(3, 4)};
  BOOST_TEST((stack_waypoints(good) == rows({{1, 2}, {3, 4}})));
  const std::vector<Eigen::VectorXd> bad{Eigen::Vector2d(1, 2), Eigen::Vector3d(3, 4, 5)};
  check_throws<InvalidArgument>([&] { stack_waypoints(bad); }, "waypoint 1 has 3 entries");
}
