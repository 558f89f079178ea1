#pragma once

#include <string>
#include <vector>

#include "srmp/lattice/primitives.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp::io {

/// Reads motion primitives for a robot's planned joints from YAML:
///
///     units: degrees            # or radians, for `by` of revolute joints; prismatic joints are always in metres
///     near_distance: 0.4        # joint-space distance to the goal [rad] where near replaces far (default 0.4)
///     prismatic: 0.05           # [m] step of prismatic joints in families of `each` joint (default 0.05)
///     families:
///       - name: long            # unique
///         joints: each          # every planned joint alone; or a list of joints that move together
///         by: 15                # one number, for all of them; or a list, one number a joint: [10, -10];
///                               # or several of these: [[10, 10], [10, -10]]
///         use: far              # far, near or always (default)
///
/// Every move is made in both directions, so the lattice can be searched from either end. The order of moves is that of
/// the file, then that of `joints`, + before -.
///
/// Throws FileError with file and line for: a missing or empty file, unknown keys or joints (with the nearest known
/// name), a move of zero, by more than half a turn, or repeated in its family, a wrong number of values,
/// NaN, a family name used twice, and a set without moves near or far from the goal.
PrimitiveSet read_primitives(const std::string& path, const std::vector<Joint>& joints);

}  // namespace srmp::io
