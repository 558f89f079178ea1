#pragma once

#include "srmp/scene/scene.hpp"
#include "support/robots.hpp"

namespace worlds {

/// The planar robot, its base rotated, with an attached object and one object of every kind of shape around it.
inline srmp::Scene every_kind() {
  const auto pose = [](double x, double y, double angle) {
    return srmp::Pose::from_rpy({x, y, 0.1 / 3}, {angle, angle / 3, 1.0});
  };
  const std::vector<Eigen::Vector3d> corners{{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 1.0 / 30}};
  srmp::Scene scene;
  scene.add_robot(robots::planar(), srmp::Pose::from_rpy({0.01, 0.02, 0.03}, {0, 0, 0.1}));
  scene.set_qpos("planar", Eigen::Vector2d(0.1, -1.0 / 3));
  scene.set_robot_padding("planar", 0.001);
  scene.add_object("box", srmp::Box{{0.1, 0.2, 1.0 / 3}}, pose(-1.5, 0, 0.3), 0.01);
  scene.add_object("sphere", srmp::Sphere{0.1 / 7}, pose(-1.5, 0.5, 0.7));
  scene.add_object("cylinder", srmp::Cylinder{0.1, 0.3}, pose(-1.5, 1, 0.9));
  scene.add_object("capsule", srmp::Capsule{0.05, 0.3}, pose(-1.5, 1.5, 1.1));
  scene.add_object("cone \"x\"\n\\", srmp::Cone{0.1, 0.3}, pose(0, 1.3, 1.3));
  scene.add_object("surface", srmp::Mesh{corners, {{0, 1, 2}, {0, 1, 3}, {1, 2, 3}, {0, 2, 3}}}, pose(0.7, 1.3, 1.5));
  scene.add_object("hull", srmp::Mesh{corners, {}, true}, pose(1.5, 1.5, 1.7));
  scene.add_object("cloud", srmp::PointCloud{corners, 0.1 / 3}, pose(-0.5, -1.5, 1.9));
  scene.add_object("attached", srmp::Sphere{0.05}, {});
  scene.attach_object("attached", "planar", "tip", {"lower"}, pose(0.1, 0, 2.1));
  scene.set_allowed_collision("planar", "cloud");
  scene.set_allowed_collision("planar/upper", "cloud", false);
  scene.set_allowed_collision("attached", "box");
  return scene;
}

}  // namespace worlds
