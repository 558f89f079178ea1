#include <boost/test/unit_test.hpp>
#include <thread>

#include "srmp/planner/planner_interface.hpp"
#include "support/robots.hpp"

namespace {

using Eigen::Vector2d;
using srmp::GoalConstraint;

/// Six planar arms of 2 m on a line, 3 m apart: each sweeps where its neighbours do.
struct Line {
  explicit Line(const srmp::PlannerOptions& options) {
    srmp::RobotDescription description = robots::planar_description();
    std::vector<std::string> names;
    for (int k = 0; k < 6; ++k) {
      names.push_back(description.name = "arm" + std::to_string(k));
      planner.add_articulation(description, srmp::Pose::from_rpy({3.0 * k, 0, 0}, {0, 0, k % 2 == 0 ? 0.0 : M_PI}));
      starts[description.name] = Vector2d(1.2, 0.1 * k);
      goals[description.name] = GoalConstraint::joints(Vector2d(-1.2, 0.05 * k));
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
void check_threads(const Options& options) {
  Line line(with_threads(options, 1));
  const srmp::MultiTrajectory alone = line.planner.plan_multi(line.starts, line.goals);
  const srmp::PlanStatistics one = line.planner.get_planning_stats();
  BOOST_TEST_CONTEXT(srmp::planner_id(options)) {
    for (const int threads : {2, 4}) {
      Line again(with_threads(options, threads));
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
  check_threads(srmp::XECBS{.improve_rounds = 2});
  check_threads(srmp::Auto{.improve_rounds = 1});
  check_threads(srmp::Prioritised{});
}

BOOST_AUTO_TEST_CASE(so_is_the_reason_why_there_is_none) {
  std::string known;
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
      if (known.empty()) known = error.what();
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
