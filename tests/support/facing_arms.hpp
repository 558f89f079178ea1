#pragma once

#include <boost/test/unit_test.hpp>
#include <memory>
#include <string>
#include <vector>

#include "srmp/planner_interface.hpp"
#include "srmp/planning/world_paths.hpp"
#include "support/robots.hpp"

namespace robots {

/// Two planar arms face to face, 3 m apart, each 2 m long when straight, that pass each other.
///
///     left ──────── ──────── right
struct FacingArms {
  explicit FacingArms(const Eigen::Vector2d& goal = {-1.2, 0.0}) : FacingArms(task_to(goal), task_to(goal)) {}
  FacingArms(const srmp::WorldTask& left, const srmp::WorldTask& right, const std::string& first_joint = "revolute") {
    srmp::RobotDescription description = planar_description(first_joint);
    description.name = "left";
    planner.add_articulation(description);
    description.name = "right";
    planner.add_articulation(description, srmp::Pose::from_rpy({3, 0, 0}, {0, 0, M_PI}));
    checkers = std::make_unique<srmp::GroupCheckers>(planner.scene(), std::vector<std::string>{"left", "right"},
                                                     srmp::CheckerOptions{});
    world = std::make_unique<srmp::MultiRobotWorld>(*checkers, std::vector{left, right},
                                                    srmp::MultiRobotWorld::Options{22.5 * M_PI / 180, 0.1});
  }

  static srmp::WorldTask task_to(const Eigen::Vector2d& goal) {
    const Eigen::Vector2d start(1.2, 0.0);
    return {start, {goal}, {start, goal}};
  }

  void check_free(const srmp::JointPath& path) {
    for (std::size_t row = 0; row + 1 < path.size(); ++row) {
      std::vector<Eigen::VectorXd> from, to;
      for (std::size_t i = 0; i < 2; ++i) {
        from.push_back(srmp::position_at(path, i, path.steps[row]));
        to.push_back(srmp::position_at(path, i, path.steps[row + 1]));
        BOOST_TEST(world->is_free_for_one(i, from[i], to[i]));
      }
      BOOST_TEST(world->are_collision_free(0, from[0], to[0], 1, from[1], to[1]));
    }
  }

  srmp::PlannerInterface planner;
  std::unique_ptr<srmp::GroupCheckers> checkers;
  std::unique_ptr<srmp::MultiRobotWorld> world;
};

}  // namespace robots
