#pragma once

#include <string>
#include <vector>

#include "srmp/lattice/lattice.hpp"
#include "srmp/planning/goal.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

/// A pose or position target of a link as inverse kinematics wants it.
struct IkGoal {
  std::string link;   ///< "" = the end effector
  Pose in_base;       ///< of the link, robot base frame
  IkOptions options;  ///< met as closely as IkOptions' defaults say, or more loosely along free axes only
};

/// Of a goal that is no joint goal: one for each link, at least one.
std::vector<IkGoal> ik_goals(const GoalConstraint& goal, const Eigen::VectorXd& target, const PlacedRobot& robot);

/// All configurations that inverse kinematics finds for one of these from its seeds, the nearest to `reference` first.
std::vector<Eigen::VectorXd> all_solutions(const RobotModel& robot, const IkGoal& target,
                                           const Eigen::VectorXd& reference, const Deadline& deadline);

/// For states whose end effector is near a pose or position target: the configuration that inverse kinematics, started
/// from that very state, finds there. Near is what a lattice step makes good: the position is missed by no more than
/// one `step` of a revolute joint at the target's distance from the base (and one of a prismatic joint), the
/// orientation by no more than two. No joint of the result is more than two steps away. ConnectedGoal::goal counts all
/// targets of all goals. Goals for several links are left out. Empty, and so free of charge, when no other than these
/// and joint goals is there.
GoalConnection make_ik_goal_connection(const PlacedRobot& robot, const std::vector<GoalConstraint>& goals,
                                       const Eigen::VectorXd& step);

}  // namespace srmp
