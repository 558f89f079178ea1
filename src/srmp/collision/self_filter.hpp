#pragma once

#include <Eigen/Core>
#include <vector>

#include "srmp/scene/scene.hpp"

namespace srmp {

/// Removes what a camera saw of the robots: returns, in their order, those of the points [m], given in the frame `pose`
/// in the world, that are farther than `distance` [m] from every link of every robot, where set_qpos put it, and from
/// every object that one holds. A link's mesh is its surface (a convex one its inside, too). Throws InvalidArgument
/// unless `distance` is positive and finite.
std::vector<Eigen::Vector3d> points_clear_of_robots(const Scene& scene, const std::vector<Eigen::Vector3d>& points,
                                                    const Pose& pose, double distance);

}  // namespace srmp
