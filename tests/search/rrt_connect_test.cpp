#include "srmp/search/rrt_connect.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>

#include "srmp/core/error.hpp"

using Eigen::Vector2d;
using Eigen::VectorXd;
using srmp::search::RandomSequence;
using srmp::search::RrtConnect;
using srmp::search::RrtSpace;

namespace {

constexpr std::uint64_t many = 100'000;

/// A unit square with two walls, each with a narrow gap at its opposite end.
bool is_free(const VectorXd& q) {
  const double x = q[0], y = q[1];
  const bool first = std::abs(x - 0.35) < 0.05 && y < 0.92;
  const bool second = std::abs(x - 0.65) < 0.05 && y > 0.08;
  return !first && !second;
}

bool is_motion_free(const VectorXd& a, const VectorXd& b) {
  for (int i = 0; i <= 1000; ++i)
    if (!is_free(a + (b - a) * (i / 1000.0))) return false;
  return true;
}

RrtSpace maze() {
  RrtSpace space;
  space.starts = {Vector2d(0.1, 0.1)};
  space.goals = {Vector2d(0.9, 0.9), Vector2d(0.95, 0.5)};
  space.max_step = 0.3;
  space.sample = [](RandomSequence& random) -> VectorXd {
    const double x = random.next();
    return Vector2d(x, random.next());
  };
  space.is_motion_free = is_motion_free;
  return space;
}

void check(const std::vector<VectorXd>& path, const RrtSpace& space) {
  BOOST_TEST((path.front() == space.starts.front()));
  BOOST_TEST((std::find(space.goals.begin(), space.goals.end(), path.back()) != space.goals.end()));
  for (std::size_t i = 1; i < path.size(); ++i) {
    BOOST_TEST(space.is_motion_free(path[i - 1], path[i]));
    BOOST_TEST((path[i] - path[i - 1]).norm() <= space.max_step * (1 + 1e-12));
  }
}

std::string refusal(const RrtSpace& space) {
  try {
    RrtConnect trees(space);
  } catch (const srmp::InvalidArgument& error) {
    return error.what();
  }
  return "";
}

}  // namespace

BOOST_AUTO_TEST_SUITE(rrt_connect)

BOOST_AUTO_TEST_CASE(rrt_connect_finds_a_free_path_through_a_maze) {
  const RrtSpace space = maze();
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    RrtConnect trees(space, seed);
    const auto path = trees.grow(many, {});
    BOOST_REQUIRE(path.has_value());
    check(*path, space);
    BOOST_TEST(trees.memory() > 0u);
  }
}

BOOST_AUTO_TEST_CASE(the_straight_path_is_taken_where_it_is_free) {
  RrtSpace space = maze();
  space.goals = {Vector2d(0.9, 0.9), Vector2d(0.1, 0.8)};
  RrtConnect trees(space);
  const auto path = trees.grow(1, {});
  BOOST_REQUIRE(path.has_value());
  check(*path, space);
  BOOST_TEST((path->back() == space.goals[1]));
  BOOST_TEST(path->size() == 4u);
  for (const VectorXd& q : *path) BOOST_TEST(q[0] == 0.1);
  space.goals = space.starts;
  BOOST_TEST(RrtConnect(space).grow(1, {}).value().size() == 2u);
}

BOOST_AUTO_TEST_CASE(a_seed_gives_the_same_path_every_time_and_another_seed_another) {
  const auto grown = [](std::uint64_t seed) { return *RrtConnect(maze(), seed).grow(many, {}); };
  const auto first = grown(0);
  BOOST_TEST((grown(0) == first));
  BOOST_TEST((grown(1) != first));
  RrtConnect in_parts(maze());
  std::optional<std::vector<VectorXd>> found;
  for (std::uint64_t attempts = 1; !found; ++attempts) found = in_parts.grow(attempts, {});
  BOOST_TEST((*found == first));
}

BOOST_AUTO_TEST_CASE(a_random_sequence_is_spread_over_the_unit_interval) {
  RandomSequence random(7);
  std::vector<int> tenths(10);
  for (int i = 0; i < 10'000; ++i) ++tenths[static_cast<std::size_t>(10 * random.next())];  // throws outside [0, 1)
  for (const int count : tenths) BOOST_TEST(std::abs(count - 1000) < 150);
}

BOOST_AUTO_TEST_CASE(an_angle_may_wrap_around) {
  RrtSpace space = maze();
  space.starts = {Vector2d(3.0, 0.0)};
  space.goals = {Vector2d(-3.0, 0.0)};
  space.wraps = {1, 0};
  // The longer way around is not free.
  space.is_motion_free = [](const VectorXd& a, const VectorXd& b) {
    const double path = std::remainder(b[0] - a[0], 2 * std::numbers::pi);
    for (int i = 0; i <= 100; ++i)
      if (std::abs(std::remainder(a[0] + path * i / 100, 2 * std::numbers::pi)) < 2.5) return false;
    return true;
  };
  space.sample = [](RandomSequence& random) -> VectorXd {
    const double x = -std::numbers::pi + 2 * std::numbers::pi * random.next();
    return Vector2d(x, random.next());
  };
  BOOST_TEST(RrtConnect(space).grow(many, {}).has_value());
  space.wraps = {};
  BOOST_TEST(!RrtConnect(space).grow(2'000, {}).has_value());
}

BOOST_AUTO_TEST_CASE(directions_lead_out_of_a_passage_that_samples_seldom_leave) {
  RrtSpace space = maze();
  space.goals = {Vector2d(0.9, 0.2)};  // in a passage along y that is 0.002 wide
  space.is_motion_free = [](const VectorXd& a, const VectorXd& b) {
    for (int i = 0; i <= 100; ++i)
      if (const VectorXd q = a + (b - a) * (i / 100.0); q[1] < 0.6 && q[0] > 0.8 && std::abs(q[0] - 0.9) > 0.001)
        return false;
    return true;
  };
  std::uint64_t by_samples = 0, with_directions = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    space.directions = 0;
    space.advance = {};
    RrtConnect samples(space, seed);
    samples.grow(many, {});
    by_samples += samples.attempts();
    space.directions = 4;
    space.advance = [](VectorXd& q, std::size_t direction) {
      q[static_cast<Eigen::Index>(direction / 2)] += direction % 2 == 0 ? 0.1 : -0.1;
      return q[0] <= 1.0 && q[1] <= 1.0 && q.minCoeff() >= 0.0;
    };
    RrtConnect trees(space, seed);
    const auto path = trees.grow(many, {});
    BOOST_REQUIRE(path.has_value());
    check(*path, space);
    with_directions += trees.attempts();
    space.find_colliding = [&](const srmp::RowMatrix& ends, std::span<bool> colliding) {
      for (std::size_t i = 0; i < colliding.size(); ++i) {
        const VectorXd q = ends.row(static_cast<Eigen::Index>(i)).transpose();
        colliding[i] = !space.is_motion_free(q, q);
      }
    };
    space.on_colliding = [] {};
    RrtConnect looking_ahead(space, seed);
    BOOST_TEST((looking_ahead.grow(many, {}) == path));
    BOOST_TEST(looking_ahead.attempts() == trees.attempts());
    space.find_colliding = {};
  }
  BOOST_TEST(10 * with_directions < by_samples);
}

BOOST_AUTO_TEST_CASE(trees_that_follow_a_path_only_search_where_it_is_not_free) {
  const auto known = RrtConnect(maze()).grow(many, {});
  BOOST_REQUIRE(known.has_value());
  RrtSpace space = maze();
  space.is_motion_free = [&](const VectorXd& a, const VectorXd& b) {  // a post between the walls stands in the path
    for (int i = 0; i <= 1000; ++i)
      if (const VectorXd q = a + (b - a) * (i / 1000.0); std::abs(q[0] - 0.5) < 0.05 && std::abs(q[1] - 0.5) < 0.3)
        return false;
    return is_motion_free(a, b);
  };
  RrtConnect anew(space), along(space);
  along.follow(*known, {});
  const auto found_anew = anew.grow(many, {}), found_along = along.grow(many, {});
  BOOST_REQUIRE((found_anew.has_value() && found_along.has_value()));
  check(*found_along, space);
  BOOST_TEST(along.attempts() < anew.attempts() / 4);
  RrtConnect free(maze());
  free.follow(*known, {});
  check(*free.grow(many, {}), maze());
  BOOST_CHECK_THROW(free.follow({}, {}), srmp::InvalidArgument);
  BOOST_CHECK_THROW(free.follow({VectorXd::Zero(3)}, {}), srmp::InvalidArgument);
}

BOOST_AUTO_TEST_CASE(steps_that_are_known_to_end_in_contact_change_nothing_but_what_is_checked) {
  std::uint64_t all_without_check = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    std::uint64_t checks = 0, without_check = 0;
    RrtSpace space = maze();
    space.is_motion_free = [&](const VectorXd& a, const VectorXd& b) {
      ++checks;
      return is_motion_free(a, b);
    };
    RrtConnect one_by_one(space, seed);
    const auto expected = one_by_one.grow(many, {});
    const std::uint64_t all_checks = std::exchange(checks, 0);
    space.find_colliding = [&](const srmp::RowMatrix& ends, std::span<bool> colliding) {
      BOOST_TEST((ends.rows() == static_cast<Eigen::Index>(colliding.size()) && ends.cols() == 2));
      for (std::size_t i = 0; i < colliding.size(); ++i)  // not of all that collide
        colliding[i] = i % 3 != 0 && !is_free(ends.row(static_cast<Eigen::Index>(i)).transpose());
    };
    space.on_colliding = [&] { ++without_check; };
    RrtConnect together(space, seed);
    std::optional<std::vector<VectorXd>> found;  // in portions that end within what was drawn ahead
    while (!found && together.attempts() < many) found = together.grow(together.attempts() + 3, {});
    BOOST_TEST((found == expected));
    BOOST_TEST(together.attempts() == one_by_one.attempts());
    BOOST_TEST(checks + without_check == all_checks);
    all_without_check += without_check;
  }
  BOOST_TEST(all_without_check > 0u);
}

BOOST_AUTO_TEST_CASE(rrt_connect_stops_after_its_attempts_and_at_the_deadline) {
  RrtSpace closed = maze();
  closed.is_motion_free = [](const VectorXd&, const VectorXd&) { return false; };
  RrtConnect stuck(closed);
  BOOST_TEST(!stuck.grow(1'000, {}).has_value());
  BOOST_TEST(stuck.attempts() == 1'000u);
  RrtConnect late(maze());
  BOOST_TEST(!late.grow(many, srmp::Deadline(1e-9)).has_value());
  BOOST_TEST(late.attempts() == 0u);
  RrtSpace nowhere = maze();
  nowhere.goals.clear();
  BOOST_TEST(!RrtConnect(nowhere).grow(many, {}).has_value());
}

BOOST_AUTO_TEST_CASE(invalid_spaces_are_refused) {
  RrtSpace space = maze();
  space.max_step = 0.0;
  BOOST_TEST(refusal(space) == "max_step is 0, it must be finite and more than 0");
  space = maze();
  space.goals.push_back(VectorXd::Zero(3));
  BOOST_TEST(refusal(space) == "starts and goals have 2 and 3 components, they must have equally many");
  space = maze();
  space.wraps = {1};
  BOOST_TEST(refusal(space) == "wraps has 1 entries, it must have 2 or none");
}

BOOST_AUTO_TEST_SUITE_END()
