#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/planning/multi_robot_world.hpp"
#include "srmp/planning/world_paths.hpp"

namespace srmp {

struct OneByOneOptions {
  /// Attempts to extend the trees of a motion of one robot, > 0: more find narrower passages beside the robots that
  /// stand, and take longer where there is none.
  std::uint64_t attempts{64};
  std::uint64_t attempts_of_all{512};  ///< of all motions of a search, which ends with as many
  std::uint64_t pair_attempts{512};    ///< the same for motions of two robots
  std::uint64_t pair_attempts_of_all{1'024};
  std::uint64_t known_attempts{2'048};  ///< the same for robots with a known path that is in conflict
  std::uint64_t known_attempts_of_all{4'096};
  double max_cost{search::infinity};  ///< of a path
  std::uint64_t seed{};               ///< of the trees
  bool forwards{true};                ///< from the starts to the goals
  bool backwards{true};               ///< from the goals to the starts
  std::uint64_t max_expansions{256};  ///< of a search
  /// Of a motion around others that is not known yet [rad, prismatic joints m]: more searches for fewer such motions,
  /// and finds orders with longer detours.
  double expected_detour{0.5};
  /// Of each robot that is not at its goal, in addition to detours [rad, prismatic joints m], without retreats and with
  /// them: more reaches the goals with fewer motions searched for, by longer detours.
  double goal_weight{0.5}, goal_weight_with_retreats{4.0};
  std::size_t retreats{2};             ///< of a robot, at most: more can let more robots pass each other
  std::size_t retreat_candidates{64};  ///< of a robot, that are checked: more leave the others more room
};

struct OneByOneWork {
  std::uint64_t expansions{}, attempts{};
  std::size_t memory{};  ///< [bytes]
};

struct OneByOneResult {
  std::optional<JointPath> path;
  OneByOneWork work;
};

/// Robots that move one after the other while the others stand: each along its own path where they leave it free, or
/// around them, in the order of the least detours. Where there is none in which each moves once, from its start to its
/// goal, robots may first go to retreats, which are clear of the others' starts and goals and leave their own paths as
/// free as can be; then two may move at the same time. So no search is in the joints of more than two robots, or of
/// those with a known path.
///
/// Papers: van den Berg, Snoeyink, Lin, Manocha 2009, "Centralized path planning for multiple robots: Optimal
/// decoupling into sequential plans" (the order, and robots that have to move jointly); Wang, Miao, Bekris 2021,
/// "Uniform object rearrangement: from complete monotone primitives to efficient non-monotone informed search" (sets of
/// what has moved, and places in between). Best-first search over the robots' places; motions are found by RRT-Connect,
/// and only when the search asks for them. A search from the goals finds at once what the last robots have to pass,
/// where one from the starts goes through many orders first: what moves single robots is tried from both before what
/// moves two. Guarantee: the path is free. That none is found says nothing.
///
/// `robots`: numbers in the world, increasing. `own_paths`: one a robot, as if it were alone, which ends where the
/// robot is to end; where one is empty, nothing is found. Robots that may end anywhere stay where they start. `known`:
/// paths of some of them, from their starts to their goals, no two of the same robot. Robots that move at the same time
/// there do so here first: along this path; then, if everything else but pairs fails, by trees that begin with it.
OneByOneResult one_by_one(MultiRobotWorld& world, const std::vector<std::size_t>& robots,
                          const std::vector<std::vector<Eigen::VectorXd>>& own_paths,
                          const std::vector<const JointPath*>& known, const OneByOneOptions& options,
                          const Deadline& deadline);

}  // namespace srmp
