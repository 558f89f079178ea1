#include <boost/test/unit_test.hpp>
#include <thread>

#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"

namespace {

using Eigen::Vector2d;
using srmp::GoalConstraint;

using Places = std::vector<double>;  // along a line [m]
const Places near_each_other{0.0, 3.0, 6.0, 9.0, 12.0, 15.0};

/// Planar arms of 2 m on a line: each sweeps where its neighbours, 3 m away, do.
struct Line {
  explicit Line(const srmp::PlannerOptions& options, const Places& places = near_each_other) {
    srmp::RobotDescription description = robots::planar_description();
    std::vector<std::string> names;
    for (std::size_t k = 0; k < places.size(); ++k) {
      names.push_back(description.name = "arm" + std::to_string(k));
      planner.add_articulation(description, srmp::Pose::from_rpy({places[k], 0, 0}, {0, 0, k % 2 == 0 ? 0.0 : M_PI}));
      starts[description.name] = Vector2d(1.2, 0.1 * static_cast<double>(k));
      goals[description.name] = GoalConstraint::joints(Vector2d(-1.2, 0.05 * static_cast<double>(k)));
    }
    planner.make_planner(names, options);
  }

  srmp::PlannerInterface planner;
  std::map<std::string, Eigen::VectorXd> starts;
  std::map<std::string, GoalConstraint> goals;
};

template <class Options>
srmp::PlannerOptions with_threads(Options options, int threads) {
  options.common.time_limit = 60.0;
  options.num_threads = threads;
  return options;
}

void check_same(const srmp::MultiTrajectory& a, const srmp::MultiTrajectory& b) {
  BOOST_REQUIRE_EQUAL(a.robots.size(), b.robots.size());
  for (const auto& [name, one] : a.robots) {
    const srmp::Trajectory& other = b.robots.at(name);
    BOOST_CHECK(one.positions == other.positions && one.times == other.times && one.waypoints == other.waypoints);
    BOOST_CHECK(one.certificate && other.certificate && one.certificate->clearance == other.certificate->clearance);
  }
}

template <class Options>
void check_threads(const Options& options, const Places& places = near_each_other) {
  Line line(with_threads(options, 1), places);
  const srmp::MultiTrajectory alone = line.planner.plan_multi(line.starts, line.goals);
  const srmp::PlanStatistics one = line.planner.get_planning_stats();
  BOOST_TEST_CONTEXT(srmp::planner_id(options)) {
    for (const int threads : {2, 4}) {
      Line again(with_threads(options, threads), places);
      for (int repeat = 0; repeat < 3; ++repeat) {
        check_same(alone, again.planner.plan_multi(again.starts, again.goals));
        const srmp::PlanStatistics& many = again.planner.get_planning_stats();
        BOOST_CHECK_EQUAL(one.path_cost_rad, many.path_cost_rad);
        BOOST_CHECK_EQUAL(one.bound, many.bound);
        BOOST_CHECK_EQUAL(one.expansions, many.expansions);
        BOOST_CHECK_EQUAL(one.edge_checks, many.edge_checks);
        BOOST_CHECK_EQUAL(one.memory_bytes, many.memory_bytes);
      }
    }
  }
}

}  // namespace

BOOST_AUTO_TEST_SUITE(threads)

BOOST_AUTO_TEST_CASE(the_answer_is_the_same_for_every_number) {
  check_threads(srmp::XECBS{});
  check_threads(srmp::Auto{.improve_rounds = 1});
  check_threads(srmp::Prioritised{});
}

/// Pairs of arms that no other arm reaches.
BOOST_AUTO_TEST_CASE(so_are_those_of_groups_that_are_planned_together_from_the_beginning) {
  check_threads(srmp::ECBS{}, {0.0, 3.8, 50.0, 53.8, 100.0, 103.8});
  check_threads(srmp::CBS{}, {0.0, 3.9, 50.0, 53.9});
}

BOOST_AUTO_TEST_CASE(so_is_the_reason_why_there_is_none) {
  std::string known;
  std::uint64_t expansions{}, checks{};
  for (const int threads : {1, 2, 4}) {
    Line line(with_threads(srmp::XECBS{}, threads));
    // Two that cannot be; the first in order is told.
    line.goals["arm2"] = GoalConstraint::joints(Vector2d(9.0, 0.0));
    line.goals["arm4"] = GoalConstraint::joints(Vector2d(-9.0, 0.0));
    try {
      line.planner.plan_multi(line.starts, line.goals);
      BOOST_ERROR("no exception");
    } catch (const srmp::PlanningError& error) {
      BOOST_CHECK(error.status() == srmp::Status::goal_invalid);
      const srmp::PlanStatistics& statistics = line.planner.get_planning_stats();
      if (known.empty()) {
        known = error.what();
        expansions = statistics.expansions;
        checks = statistics.edge_checks;
      }
      BOOST_CHECK_EQUAL(statistics.expansions, expansions);
      BOOST_CHECK_EQUAL(statistics.edge_checks, checks);
      BOOST_CHECK_EQUAL(error.what(), known);
      BOOST_CHECK(known.find("'arm2'") != std::string::npos);
    }
  }
}

BOOST_AUTO_TEST_CASE(an_interrupt_stops_all_of_them) {
  Line line(with_threads(srmp::XECBS{}, 3));
  const std::thread::id caller = std::this_thread::get_id();
  bool elsewhere = false;
  const auto stop = [&] {
    elsewhere |= std::this_thread::get_id() != caller;
    return true;
  };
  try {
    line.planner.plan_multi(line.starts, line.goals, {}, stop);
    BOOST_ERROR("no exception");
  } catch (const srmp::PlanningError& error) {
    BOOST_CHECK(error.status() == srmp::Status::cancelled);
  }
  BOOST_CHECK(!elsewhere);
}

BOOST_AUTO_TEST_SUITE_END()
