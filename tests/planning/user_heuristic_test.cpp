#include "srmp/planning/user_heuristic.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>

#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

namespace {

using srmp::ConstRows;
using srmp::GoalConstraint;
using srmp::InvalidArgument;

/// The planar arm with a post in its way, and its own measure of the way as the heuristic "mine".
struct World {
  srmp::PlannerInterface planner;
  Eigen::Vector2d start{0.0, 0.5}, goal{2.5, 0.5};
  Eigen::Index max_at_once{0};
  srmp::RowMatrix goals;

  explicit World(bool consistent = false) {
    planner.add_articulation(robots::planar_description());
    planner.add_sphere("post", 0.1, {.p = {0.0, 1.2, 0.0}});
    planner.add_heuristic("mine", [this](ConstRows q, ConstRows to) { return distance(q, to); }, consistent);
  }

  Eigen::VectorXd distance(ConstRows q, ConstRows to) {
    max_at_once = std::max(max_at_once, q.rows());
    goals = to;
    Eigen::VectorXd values(q.rows());
    for (Eigen::Index i = 0; i < q.rows(); ++i) values[i] = (to.rowwise() - q.row(i)).rowwise().norm().minCoeff();
    return values;
  }

  const srmp::PlanStatistics& plan(const srmp::PlannerOptions& options) {
    planner.make_planner({"planar"}, options);
    planner.plan("planar", start, GoalConstraint::joints(goal));
    return planner.get_planning_stats();
  }

  /// What `plan` with wAstar says when "bad" is the heuristic.
  void check_refused(srmp::HeuristicFunction bad, const std::string& sentence) {
    planner.add_heuristic("bad", std::move(bad));
    check_throws<InvalidArgument>([&] { plan(srmp::WAStar{.common = {.heuristic = "bad", .direction = "forward"}}); },
                                  sentence);
    planner.remove_heuristic("bad");
  }
};

srmp::CommonOptions mine(const std::string& direction = "forward") {
  return {.heuristic = "mine", .direction = direction};
}

}  // namespace

BOOST_AUTO_TEST_SUITE(user_heuristic)

BOOST_AUTO_TEST_CASE(every_planner_takes_it_and_asks_for_many_states_at_once) {
  for (const srmp::PlannerOptions& options :
       {srmp::PlannerOptions(srmp::Auto{mine()}), srmp::PlannerOptions(srmp::AStar{mine()}),
        srmp::PlannerOptions(srmp::WAStar{mine()}), srmp::PlannerOptions(srmp::ARAStar{mine()}),
        srmp::PlannerOptions(srmp::MHAStar{.inadmissible_heuristics = {"mine"}}),
        srmp::PlannerOptions(srmp::WPASE{mine()})}) {
    World world;
    world.plan(options);
    BOOST_TEST(world.max_at_once > 1, srmp::planner_id(options));
    BOOST_TEST(world.goals.rows() == 1);
  }
}

BOOST_AUTO_TEST_CASE(it_serves_as_the_library_s_own_would) {
  World world(true);
  const double cost = world.plan(srmp::AStar{mine()}).search_cost_rad;
  BOOST_TEST(cost == world.plan(srmp::AStar{{.direction = "forward"}}).search_cost_rad);
}

BOOST_AUTO_TEST_CASE(goals_are_where_the_search_is_going) {
  World world;
  world.plan(srmp::WAStar{mine("forward")});
  BOOST_TEST(world.goals.row(0).transpose().isApprox(world.goal));
  world.plan(srmp::WAStar{mine("backward")});
  BOOST_TEST(world.goals.row(0).transpose().isApprox(world.start));
}

BOOST_AUTO_TEST_CASE(bounds_are_proven_only_by_a_consistent_one) {
  BOOST_TEST(std::isinf(World(false).plan(srmp::WAStar{mine()}).bound));
  BOOST_TEST(World(true).plan(srmp::WAStar{mine()}).bound <= 50.0);
}

BOOST_AUTO_TEST_CASE(wrong_values_are_refused_with_name_value_and_configuration) {
  World world;
  world.check_refused([](ConstRows q, ConstRows) { return Eigen::VectorXd::Constant(q.rows(), -1.0).eval(); },
                      "heuristic 'bad' is -1 at [0, 0.5]; it must be finite and at least 0");
  world.check_refused([](ConstRows q, ConstRows) { return Eigen::VectorXd::Constant(q.rows(), NAN).eval(); },
                      "heuristic 'bad' is NaN at [0, 0.5]");
  world.check_refused([](ConstRows q, ConstRows) { return Eigen::VectorXd::Constant(q.rows(), INFINITY).eval(); },
                      "it must be finite");
  world.check_refused([](ConstRows q, ConstRows) { return Eigen::VectorXd::Zero(q.rows() + 1).eval(); },
                      "heuristic 'bad' returned 2 values for 1 configurations; it must be one each");
}

BOOST_AUTO_TEST_CASE(names_are_checked) {
  World world;
  const auto add = [&](const std::string& name, const srmp::HeuristicFunction& function) {
    world.planner.add_heuristic(name, function);
  };
  const srmp::HeuristicFunction zero = [](ConstRows q, ConstRows) { return Eigen::VectorXd::Zero(q.rows()).eval(); };
  check_throws<InvalidArgument>([&] { add("mine", zero); }, "there is a heuristic 'mine' already");
  check_throws<InvalidArgument>([&] { add("bfs", zero); }, "there is a heuristic 'bfs' already");
  check_throws<InvalidArgument>([&] { add("", zero); }, "must not be empty");
  check_throws<InvalidArgument>([&] { add("a,b", zero); }, "spaces, commas or brackets");
  check_throws<InvalidArgument>([&] { add("empty", {}); }, "has an empty function");
  check_throws<InvalidArgument>([&] { world.planner.remove_heuristic("mime"); }, "did you mean 'mine'");
  check_throws<InvalidArgument>([&] { world.plan(srmp::WAStar{.common = {.heuristic = "mime"}}); },
                                "option 'heuristic' is 'mime', did you mean 'mine'");
  check_throws<InvalidArgument>([&] { world.plan(srmp::MHAStar{.inadmissible_heuristics = {"bfs", "mime"}}); },
                                "option 'inadmissible_heuristics' is 'mime', did you mean 'mine'");
  world.planner.make_planner({"planar"}, srmp::WAStar{mine()});
  world.planner.remove_heuristic("mine");
  BOOST_TEST(world.planner.heuristic_names().empty());
  check_throws<InvalidArgument>([&] { world.planner.plan("planar", world.start, GoalConstraint::joints(world.goal)); },
                                "'heuristic' is 'mine'");
}

BOOST_AUTO_TEST_CASE(a_grid_has_its_cell_in_its_name) {
  BOOST_TEST(srmp::bfs_cell("bfs(0.1)").value() == 0.1);
  BOOST_TEST(!srmp::bfs_cell("bfs").has_value());
  for (const char* wrong : {"bfs()", "bfs(0)", "bfs(-1)", "bfs(0.1", "bfs(0.1)x", "bfs(big)", "bfs(inf)"})
    check_throws<InvalidArgument>([&] { srmp::bfs_cell(wrong); }, std::string("heuristic '") + wrong + "'");
  World world;
  const auto memory = [&](const std::string& name) {
    return world.plan(srmp::WAStar{.common = {.heuristic = name}}).memory_bytes;
  };
  BOOST_TEST(memory("bfs(0.05)") == memory("bfs"));
  BOOST_TEST(memory("bfs(0.2)") < memory("bfs"));
}

BOOST_AUTO_TEST_SUITE_END()
