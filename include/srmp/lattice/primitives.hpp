#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "srmp/robot/robot_model.hpp"

namespace srmp {

/// At which states a family of motion primitives is used.
enum class PrimitiveUse {
  always,
  far,   ///< only at states farther than PrimitiveSet::near_distance from both ends of the path
  near,  ///< only at the others
  /// At all states. Each joint moves by the absolute value of its entry towards the target; joints that are nearer to
  /// it than half of that stay. Where fewer than three joints would move there is no such move.
  to_targets,
};

/// Moves that belong together. A move is a joint displacement [rad or m], one entry per planned joint.
struct PrimitiveFamily {
  std::string name;                        ///< unique in its set
  PrimitiveUse use{PrimitiveUse::always};  ///< where its moves are used
  std::vector<Eigen::VectorXd> moves;      ///< joint displacements (dof,) [rad or m]
};

/// The action space of a lattice (Cohen, Chitta, Likhachev 2010, "Search-based planning for manipulation with motion
/// primitives"; long and short ones as in Cohen et al. 2011, "Planning for manipulation with adaptive motion
/// primitives").
struct PrimitiveSet {
  std::vector<PrimitiveFamily> families;  ///< in the order in which moves are tried
  double near_distance{0.4};  ///< joint-space distance to the start or a goal [rad, prismatic joints m], >= 0
};

/// Configurations of a lattice differ from their root by whole multiples of this: 1e-4 degree [rad], or 1e-6 m.
double grid_unit(const Joint& joint);

/// One step per joint: `revolute` [rad], or `prismatic` [m] where it is prismatic.
Eigen::VectorXd lattice_step(const std::vector<Joint>& joints, double revolute, double prismatic);

/// Every planned joint alone, in both directions: by one step at all states and, near the ends of the path, where space
/// is scarce and precision is needed, by a third of a step too. `step` has one entry per joint [rad or m]. Throws
/// InvalidArgument for steps that are not positive.
PrimitiveSet axis_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step);

/// Two planned joints, next to each other or with one joint between them, whose axes are parallel when all joints are
/// at 0: by opposite rotations they translate what they carry and keep its orientation.
using JointPair = std::pair<Eigen::Index, Eigen::Index>;
/// All such pairs of the robot.
std::vector<JointPair> parallel_pairs(const RobotModel& robot);

/// For several lattices that are searched in a portfolio: by one step, all planned joints at once to the target, every
/// joint alone, and the two of each pair, in all four combinations of directions. Short moves would only add states.
PrimitiveSet rich_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step,
                             const std::vector<JointPair>& pairs);

/// For one lattice: the rich ones and, within half a step of the ends, every joint by a third of a step. A coarse
/// lattice may have no path out of a narrow end; farther away, short moves would make thousands of states.
PrimitiveSet default_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step,
                                const std::vector<JointPair>& pairs);

}  // namespace srmp
