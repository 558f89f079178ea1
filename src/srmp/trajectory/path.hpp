#pragma once

#include <span>
#include <string>
#include <vector>

#include "srmp/core/matrix.hpp"

namespace srmp {

/// Sum of the Euclidean distances between consecutive waypoints [rad, prismatic joints m]; 0 for fewer than two.
double path_length(ConstRows waypoints);

/// One row a waypoint. All must have the same size.
RowMatrix stack_waypoints(std::span<const Eigen::VectorXd> waypoints);
/// The inverse: one vector a row.
std::vector<Eigen::VectorXd> unstack_waypoints(ConstRows waypoints);

/// Drops waypoints that equal their predecessor or lie on the straight line between their neighbours, in order along
/// it, within 1e-12 of its length. First and last row stay as they are; the path does not move.
RowMatrix without_redundant_waypoints(ConstRows waypoints);

/// Adds full turns to continuous joints so that every waypoint follows its predecessor the short way (the first row
/// stays). `continuous[j]` says whether joint j is continuous; empty = none is.
RowMatrix unwrap_waypoints(ConstRows waypoints, const std::vector<bool>& continuous);

/// Throws InvalidArgument unless there are waypoints, all are finite, and there is one column a joint name.
void require_waypoints(ConstRows waypoints, std::span<const std::string> joint_names);
/// Throws InvalidArgument when a continuous joint moves by more than half a turn between two waypoints: the checker and
/// the trajectory would turn it in opposite directions. unwrap_waypoints avoids that.
void require_short_way(ConstRows waypoints, const std::vector<bool>& continuous,
                       std::span<const std::string> joint_names = {});

}  // namespace srmp
