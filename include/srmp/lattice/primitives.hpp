#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "srmp/robot/robot_model.hpp"

namespace srmp {

/// Where on the way a family of motion primitives is used.
enum class PrimitiveUse {
  always,
  far,   ///< only from states farther than PrimitiveSet::near_distance from both ends of the path
  near,  ///< only from the others
  /// Everywhere, but the signs say nothing: each joint turns by its entry towards the target, those nearer to it than
  /// half of that stay. Where fewer than three are left to turn there is no such move.
  towards,
};

/// Moves that belong together. A move is a joint displacement [rad or m], one entry a planned joint.
struct PrimitiveFamily {
  std::string name;
  PrimitiveUse use{PrimitiveUse::always};
  std::vector<Eigen::VectorXd> moves;
};

/// The action space of a lattice (Cohen, Chitta, Likhachev 2010, "Search-based planning for manipulation with motion
/// primitives"; long and short ones as in Cohen et al. 2011, "Planning for manipulation with adaptive motion
/// primitives").
struct PrimitiveSet {
  std::vector<PrimitiveFamily> families;
  double near_distance{0.4};  ///< joint-space distance to the start or a goal [rad, prismatic joints m], >= 0
};

/// Configurations of a lattice are whole multiples of this away from their anchor: 1e-4 degree [rad], or 1e-6 m.
double grid_unit(const Joint& joint);

/// One step a joint: `turn` [rad], or `slide` [m] where it is prismatic.
Eigen::VectorXd lattice_step(const std::vector<Joint>& joints, double turn, double slide);

/// Every planned joint alone, both ways: by one step everywhere and, near the ends of the path, where room is scarce
/// and precision wanted, by a third of a step too. `step` has one entry a joint [rad or m], > 0.
PrimitiveSet axis_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step);

/// Two planned joints that turn about parallel axes when all stand at 0, neighbours or with one joint between them:
/// turned against each other they shift what they carry, and keep its orientation.
using JointPair = std::pair<Eigen::Index, Eigen::Index>;
std::vector<JointPair> parallel_pairs(const RobotModel& robot);

/// For several lattices side by side: by one step, all planned joints at once towards the other end, every joint alone,
/// and the two of each pair, all four ways. Short moves would only crowd them.
PrimitiveSet rich_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step,
                             const std::vector<JointPair>& pairs);

/// For one lattice: the rich ones and, within half a step of the ends, every joint by a third of a step. A coarse
/// lattice may have no way out of a narrow end; short moves anywhere farther would be tried by the thousand there.
PrimitiveSet default_primitives(const std::vector<Joint>& joints, const Eigen::VectorXd& step,
                                const std::vector<JointPair>& pairs);

}  // namespace srmp
