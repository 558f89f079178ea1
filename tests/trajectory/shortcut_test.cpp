#include "srmp/trajectory/shortcut.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/path.hpp"
#include "srmp/trajectory/skip_waypoints.hpp"
#include "support/throws.hpp"

using namespace srmp;

namespace {

using Point = Eigen::VectorXd;

/// Spheres in the plane or in space.
struct World {
  std::vector<Point> centers;
  std::vector<double> radii;

  bool is_free(const Point& a, const Point& b) const {
    const Point edge = b - a;
    for (std::size_t k = 0; k < centers.size(); ++k) {
      const double along =
          edge.squaredNorm() > 0 ? std::clamp((centers[k] - a).dot(edge) / edge.squaredNorm(), 0.0, 1.0) : 0.0;
      if ((a + along * edge - centers[k]).norm() < radii[k]) return false;
    }
    return true;
  }
};

/// A path of unit-grid steps such as a lattice search returns: round each sphere on a random side.
RowMatrix staircase(const World& world, const Point& start, const Point& goal, double step) {
  // Greedy best-first over the grid; small worlds, so a plain list does.
  using Cell = std::vector<int>;
  struct Entry {
    double h;
    int number;
    Cell cell;
    int parent;
  };
  const auto at = [&](const Cell& cell) {
    Point p = start;
    for (Eigen::Index j = 0; j < p.size(); ++j) p[j] += step * cell[static_cast<std::size_t>(j)];
    return p;
  };
  const auto later = [](const Entry& a, const Entry& b) { return a.h != b.h ? a.h > b.h : a.number > b.number; };
  std::vector<Entry> open{{(goal - start).norm(), 0, Cell(static_cast<std::size_t>(start.size()), 0), -1}}, closed;
  std::set<Cell> seen{open[0].cell};
  for (int number = 1; !open.empty();) {
    std::pop_heap(open.begin(), open.end(), later);
    const Entry entry = open.back();
    open.pop_back();
    closed.push_back(entry);
    const Point p = at(entry.cell);
    if ((goal - p).norm() < 2 * step && world.is_free(p, goal)) break;
    for (std::size_t j = 0; j < entry.cell.size(); ++j)
      for (const int sign : {-1, 1}) {
        Cell next = entry.cell;
        next[j] += sign;
        if (std::abs(next[j]) > 60 || !world.is_free(p, at(next)) || !seen.insert(next).second) continue;
        open.push_back({(goal - at(next)).norm(), number++, next, static_cast<int>(closed.size()) - 1});
        std::push_heap(open.begin(), open.end(), later);
      }
  }
  std::vector<Point> path{goal};
  for (int i = static_cast<int>(closed.size()) - 1; i >= 0; i = closed[static_cast<std::size_t>(i)].parent)
    path.push_back(at(closed[static_cast<std::size_t>(i)].cell));
  std::reverse(path.begin(), path.end());
  return stack_waypoints(path);
}

/// Length of the taut string that the path can be pulled into: an elastic band of many beads, pushed out of the
/// spheres.
double taut_length(const World& world, const RowMatrix& path) {
  std::vector<Point> beads;
  for (Eigen::Index i = 0; i + 1 < path.rows(); ++i) {
    const Point a = path.row(i), edge = path.row(i + 1) - path.row(i);
    const int parts = std::max(1, static_cast<int>(edge.norm() / 0.1));
    for (int k = 0; k < parts; ++k) beads.push_back(a + edge * k / parts);
  }
  beads.push_back(path.row(path.rows() - 1));
  for (int iteration = 0; iteration < 800; ++iteration)
    for (std::size_t i = 1; i + 1 < beads.size(); ++i) {
      beads[i] = 0.5 * (beads[i - 1] + beads[i + 1]);
      for (std::size_t k = 0; k < world.centers.size(); ++k) {
        const Point offset = beads[i] - world.centers[k];
        if (offset.norm() < world.radii[k]) beads[i] = world.centers[k] + offset * (world.radii[k] / offset.norm());
      }
    }
  return path_length(stack_waypoints(beads));
}

struct Problem {
  World world;
  RowMatrix path;
};

Problem random_problem(std::mt19937& engine, Eigen::Index dim) {
  const auto uniform = [&](double low, double high) { return low + (high - low) * (engine() / 4294967296.0); };
  const auto point = [&](double low, double high) {
    Point p(dim);
    for (Eigen::Index j = 0; j < dim; ++j) p[j] = uniform(low, high);
    return p;
  };
  Problem problem;
  const Point start = point(-3, -1), goal = point(1, 3);
  while (problem.world.centers.size() < (dim == 2 ? 10u : 16u)) {
    Point center = point(-3, 3);
    if (problem.world.centers.size() % 2) center = start + (goal - start) * uniform(0.2, 0.8) + point(-1, 1);
    const double radius = uniform(0.4, 1.0);
    if ((center - start).norm() < radius + 0.15 || (center - goal).norm() < radius + 0.15) continue;
    problem.world.centers.push_back(center);
    problem.world.radii.push_back(radius);
  }
  problem.path = staircase(problem.world, start, goal, 0.2);
  return problem;
}

RowMatrix rows(std::initializer_list<std::initializer_list<double>> values) {
  std::vector<Point> points;
  for (const auto& row : values)
    points.push_back(Eigen::Map<const Point>(row.begin(), static_cast<Eigen::Index>(row.size())));
  return stack_waypoints(points);
}

const MotionFree always = [](const Point&, const Point&) { return true; };
const MotionFree never = [](const Point&, const Point&) { return false; };

std::vector<double> key(const Point& a, const Point& b) {
  std::vector<double> values(a.begin(), a.end());
  values.insert(values.end(), b.begin(), b.end());
  return values;
}

/// Ends kept, not longer, and every segment from the input or called free itself.
void check_result(const ShortcutResult& result, const RowMatrix& path, const std::set<std::vector<double>>& proved) {
  BOOST_TEST((result.waypoints.row(0) == path.row(0)));
  BOOST_TEST((result.waypoints.bottomRows(1) == path.bottomRows(1)));
  BOOST_TEST(result.length_before == path_length(path));
  BOOST_TEST(result.length_after == path_length(result.waypoints));
  BOOST_TEST(result.length_after <= result.length_before * (1 + 1e-14));
  for (Eigen::Index i = 1; i < result.waypoints.rows(); ++i)
    BOOST_TEST(proved.contains(key(result.waypoints.row(i - 1), result.waypoints.row(i))));
}

std::set<std::vector<double>> segments_of(const RowMatrix& path) {
  std::set<std::vector<double>> segments;
  for (Eigen::Index i = 1; i < path.rows(); ++i) segments.insert(key(path.row(i - 1), path.row(i)));
  return segments;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_farthest_waypoint_is_that_of_a_linear_search) {
  for (std::size_t last = 1; last <= 20; ++last)
    for (std::size_t from = 0; from < last; ++from)
      for (std::size_t reach = from + 1; reach <= last; ++reach)
        for (const bool last_first : {true, false}) {
          std::size_t tried = 0;
          const auto can_reach = [&](std::size_t waypoint) {
            BOOST_REQUIRE(from + 1 < waypoint);
            BOOST_REQUIRE(waypoint <= last);
            ++tried;
            return waypoint <= reach;
          };
          BOOST_TEST(farthest_waypoint(from, last, can_reach, {.last_first = last_first}) == reach);
          BOOST_TEST(tried <= 6);  // the last one, and bisection of 20
          if (last_first && reach == last) BOOST_TEST(tried <= 1);
        }
}

BOOST_AUTO_TEST_CASE(skipped_waypoints_leave_free_segments_and_both_ends) {
  std::mt19937 random(3);
  for (int k = 0; k < 50; ++k) {
    const std::size_t last = 1 + random() % 30;
    std::vector<char> free((last + 1) * (last + 1));
    for (char& f : free) f = random() % 3 == 0;
    const auto is_free = [&](std::size_t a, std::size_t b) { return free[a * (last + 1) + b] != 0; };
    const std::vector<std::size_t> kept = skip_waypoints(last, is_free);
    BOOST_TEST(kept.front() == 0);
    BOOST_TEST(kept.back() == last);
    for (std::size_t i = 1; i < kept.size(); ++i)
      BOOST_TEST((kept[i] == kept[i - 1] + 1 || (kept[i] > kept[i - 1] && is_free(kept[i - 1], kept[i]))));
  }
}

BOOST_AUTO_TEST_CASE(an_empty_world_gives_the_straight_line_with_one_check) {
  const ShortcutResult result = shortcut(rows({{0, 0}, {1, 0}, {1, 1}, {2, 1}}), always);
  BOOST_TEST((result.waypoints == rows({{0, 0}, {2, 1}})));
  BOOST_TEST(result.checks == 1u);
  BOOST_TEST(result.finished);
}

BOOST_AUTO_TEST_CASE(where_nothing_is_free_the_path_stays) {
  const RowMatrix path = rows({{0, 0}, {1, 0}, {1, 1}, {2, 1}});
  const ShortcutResult result = shortcut(path, never);
  BOOST_TEST((result.waypoints == path));
  BOOST_TEST(result.checks < 50u);
}

BOOST_AUTO_TEST_CASE(short_paths_need_no_check) {
  for (const RowMatrix& path : {rows({{1, 2}}), rows({{1, 2}, {3, 4}})}) {
    const ShortcutResult result = shortcut(path, never);
    BOOST_TEST((result.waypoints == path));
    BOOST_TEST(result.checks == 0u);
  }
  BOOST_TEST((shortcut(rows({{1, 2}, {1, 2}, {3, 4}, {3, 4}}), never).waypoints == rows({{1, 2}, {3, 4}})));
}

BOOST_AUTO_TEST_CASE(staircases_come_near_the_taut_string_with_few_checks) {
  for (const Eigen::Index dim : {2, 3}) {
    std::mt19937 engine(static_cast<unsigned>(dim));
    double ratio = 0.0, raw = 0.0, checks = 0.0;
    const int count = 40;
    for (int i = 0; i < count; ++i) {
      const Problem problem = random_problem(engine, dim);
      std::set<std::vector<double>> proved = segments_of(problem.path);
      const ShortcutResult result = shortcut(problem.path, [&](const Point& a, const Point& b) {
        const bool free = problem.world.is_free(a, b);
        if (free) proved.insert(key(a, b));
        return free;
      });
      check_result(result, problem.path, proved);
      const double taut = taut_length(problem.world, result.waypoints);
      ratio += result.length_after / taut / count;
      raw += result.length_before / taut / count;
      checks += static_cast<double>(result.checks) / count;
    }
    BOOST_TEST_MESSAGE(dim << "-D: staircase " << raw << ", shortcut " << ratio << " of the taut string; " << checks
                           << " checks");
    BOOST_TEST(raw > 1.2);
    BOOST_TEST(ratio < (dim == 2 ? 1.025 : 1.04));
    BOOST_TEST(checks < 110);
  }
}

BOOST_AUTO_TEST_CASE(the_same_path_gives_the_same_bits_and_checks) {
  std::mt19937 engine(9);
  const Problem problem = random_problem(engine, 3);
  const auto run = [&] {
    return shortcut(problem.path, [&](const Point& a, const Point& b) { return problem.world.is_free(a, b); });
  };
  const ShortcutResult a = run(), b = run();
  BOOST_TEST((a.waypoints == b.waypoints));
  BOOST_TEST(a.checks == b.checks);
}

BOOST_AUTO_TEST_CASE(at_the_deadline_it_stops_with_a_valid_path) {
  std::mt19937 engine(11);
  const Problem problem = random_problem(engine, 2);
  const ShortcutResult none = shortcut(problem.path, always, Deadline(0.0));
  BOOST_TEST((none.waypoints == problem.path));
  BOOST_TEST(none.checks == 0u);
  BOOST_TEST(!none.finished);
  // Cut off after any number of checks (by a caller who cancels, so that the clock plays no part).
  const MotionFree is_free = [&](const Point& a, const Point& b) { return problem.world.is_free(a, b); };
  const std::size_t all = shortcut(problem.path, is_free).checks;
  for (std::size_t allowed = 1; allowed <= all; ++allowed) {
    std::set<std::vector<double>> proved = segments_of(problem.path);
    std::size_t used = 0;
    const ShortcutResult result = shortcut(problem.path, [&](const Point& a, const Point& b) {
      const bool free = ++used <= allowed && is_free(a, b);  // refusals at the end stand for the time being up
      if (free) proved.insert(key(a, b));
      return free;
    });
    check_result(result, problem.path, proved);
  }
}

BOOST_AUTO_TEST_CASE(a_checker_that_refuses_parts_of_what_it_called_free_is_believed) {
  // Only motions between "even" points are free for it, so parts are often refused.
  std::mt19937 engine(5);
  for (int i = 0; i < 20; ++i) {
    const Problem problem = random_problem(engine, 2);
    std::set<std::vector<double>> proved = segments_of(problem.path);
    const ShortcutResult result = shortcut(problem.path, [&](const Point& a, const Point& b) {
      const bool free = problem.world.is_free(a, b) && std::fmod(std::abs(a.sum() * 1e3 + b.sum() * 7e3), 2.0) < 1.2;
      if (free) proved.insert(key(a, b));
      return free;
    });
    check_result(result, problem.path, proved);
  }
}

BOOST_AUTO_TEST_CASE(continuous_joints_take_the_short_way) {
  const double pi = std::numbers::pi;
  // Three quarters round one way is a quarter the other way.
  const RowMatrix path = rows({{0, 0}, {pi / 2, 0.1}, {pi, 0.1}, {1.5 * pi, 0}});
  ShortcutOptions options;
  options.continuous = {true, false};
  const ShortcutResult result = shortcut(path, always, {}, options);
  BOOST_TEST(result.waypoints.rows() == 2);
  BOOST_TEST(result.waypoints(1, 0) == -pi / 2, boost::test_tools::tolerance(1e-15));
  BOOST_TEST(result.length_after == pi / 2, boost::test_tools::tolerance(1e-15));
  BOOST_TEST((shortcut(path, always).waypoints == rows({{0, 0}, {1.5 * pi, 0}})));
  check_throws<InvalidArgument>([&] { shortcut(rows({{0, 0}, {4, 0}}), always, {}, options); },
                                "continuous joint moves by 4 rad");
}

BOOST_AUTO_TEST_CASE(a_path_to_and_fro_asks_about_no_motion_of_nan) {
  const MotionFree is_long = [](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    BOOST_TEST((a.allFinite() && b.allFinite()));
    return (b - a).norm() > 1.0;
  };
  const RowMatrix path{{0.0, 0.0}, {1.0, 0.5}, {0.0, 0.0}};
  const RowMatrix found = shortcut(path, is_long, {}).waypoints;
  BOOST_TEST(found.allFinite());
  BOOST_TEST((found.row(0) == path.row(0) && found.bottomRows(1) == path.row(2)));
}

BOOST_AUTO_TEST_CASE(bad_input_is_refused) {
  const RowMatrix path = rows({{0, 0}, {1, 0}, {1, 1}});
  const auto with = [&](auto&& change) {
    ShortcutOptions options;
    change(options);
    return [=] { shortcut(path, always, {}, options); };
  };
  check_throws<InvalidArgument>([] { shortcut(RowMatrix(0, 2), always); }, "at least one waypoint");
  check_throws<InvalidArgument>([] { shortcut(rows({{0, 0}, {NAN, 0}}), always); }, "waypoint 1: joint 0 is NaN");
  check_throws<InvalidArgument>([&] { shortcut(path, {}); }, "is empty");
  check_throws<InvalidArgument>(with([](ShortcutOptions& o) { o.min_gain = 0; }), "min_gain is 0");
  check_throws<InvalidArgument>(with([](ShortcutOptions& o) { o.pull_gain = NAN; }), "pull_gain is NaN");
  check_throws<InvalidArgument>(with([](ShortcutOptions& o) { o.cut_gain = -1; }), "cut_gain is -1");
  check_throws<InvalidArgument>(with([](ShortcutOptions& o) { o.max_rounds = -1; }), "max_rounds is -1");
  check_throws<InvalidArgument>(with([](ShortcutOptions& o) { o.halvings = 0; }), "halvings is 0");
  check_throws<InvalidArgument>(with([](ShortcutOptions& o) { o.continuous = {true}; }), "2 joints, but 1 flags");
}
