#pragma once

#include <cmath>
#include <cstdlib>
#include <random>
#include <set>

#include "srmp/collision/scene_checker.hpp"
#include "srmp/scene/shape_geometry.hpp"
#include "support/mesh_arm.hpp"
#include "support/robots.hpp"

namespace worlds {

using namespace srmp;

inline Pose at(double x, double y, double z, double roll = 0, double pitch = 0, double yaw = 0) {
  return Pose::from_rpy({x, y, z}, {roll, pitch, yaw});
}

inline std::shared_ptr<const RobotModel> arm7(const std::string& name = "arm7") {
  RobotDescription description;
  description.urdf_path = SRMP_SOURCE_DIR "/python/srmp/data/arm7.urdf";
  description.srdf_path = SRMP_SOURCE_DIR "/python/srmp/data/arm7.srdf";
  description.end_effector = "arm7_hand";
  description.name = name;
  return RobotModel::load(description);
}

/// What PairTableStore::tables needs of a robot's geometries.
inline std::vector<GeometryParts> parts_of_all(const RobotModel& robot) {
  std::vector<GeometryParts> parts;
  for (const LinkGeometry& geometry : robot.geometries()) parts.push_back(parts_of(geometry.shape));
  return parts;
}

/// A slide that carries an arm whose second joint follows the first, backwards and half as fast, with a drawer at its
/// end.
inline std::shared_ptr<const RobotModel> slide() {
  const std::string limit = "<limit lower='-2' upper='2' velocity='2' effort='1'/>";
  RobotDescription description;
  description.urdf_text = "<robot name='slide'><link name='base'/>" + robots::bar("cart") + robots::bar("arm") +
                          robots::bar("fore") + "<link name='tip'/>" +
                          robots::joint("s", "prismatic", "base", "cart", "0 0 0.2", "0 1 0", limit) +
                          robots::joint("a", "revolute", "cart", "arm", "0.5 0 0.2", "0 0 1", limit) +
                          robots::joint("m", "revolute", "arm", "fore", "1 0 0.2", "0 1 0",
                                        limit + "<mimic joint='a' multiplier='-0.5'/>") +
                          robots::joint("z", "prismatic", "fore", "tip", "1 0 0", "1 0 0", limit) + "</robot>";
  description.end_effector = "tip";
  return RobotModel::load(description);
}

/// The planar robot, each bar a row of spheres.
inline std::shared_ptr<const RobotModel> spheres() {
  const auto row = [](std::string link) {
    for (const std::string x : {"0.1", "0.3", "0.5", "0.7", "0.9"})
      link += "<collision><origin xyz='" + x + " 0 0'/><geometry><sphere radius='0.05'/></geometry></collision>";
    return link + "</link>";
  };
  const std::string limit = "<limit lower='-3' upper='3' velocity='2' effort='1'/>";
  RobotDescription description;
  description.urdf_text = "<robot name='planar'><link name='base'/>" + row("<link name='upper'>") +
                          row("<link name='lower'>") +
                          robots::joint("a", "revolute", "base", "upper", "0 0 0", "0 0 1", limit) +
                          robots::joint("b", "revolute", "upper", "lower", "1 0 0", "0 0 1", limit) + "</robot>";
  description.end_effector = "lower";
  return RobotModel::load(description);
}

/// A hollow L of triangles, 0.2 m long: its hull is much larger than itself.
inline Mesh angle_iron() {
  Mesh mesh;
  const double l = 0.2, t = 0.03;
  for (double y : {-0.1, 0.1})
    for (const auto& [x, z] : {std::pair{0.0, 0.0}, {l, 0.0}, {l, t}, {t, t}, {t, l}, {0.0, l}})
      mesh.vertices.emplace_back(x, y, z);
  for (int i = 0; i < 6; ++i) {
    const int j = (i + 1) % 6;
    mesh.triangles.push_back({i, j, j + 6});
    mesh.triangles.push_back({i, j + 6, i + 6});
  }
  for (int side : {0, 6})
    for (const auto& [a, b, c] : {std::array{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}})
      mesh.triangles.push_back({side + a, side + b, side + c});
  return mesh;
}

/// A closed surface with dents, of some hundreds of triangles: many are near whatever is beside it.
inline Mesh dented() {
  constexpr int rings = 14, sectors = 20;
  Mesh mesh;
  for (int i = 0; i <= rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      const double polar = M_PI * i / rings, around = 2 * M_PI * j / sectors;
      const double radius = 0.1 + 0.02 * std::sin(4 * polar) * std::cos(3 * around);
      mesh.vertices.emplace_back(radius * std::sin(polar) * std::cos(around),
                                 radius * std::sin(polar) * std::sin(around), radius * std::cos(polar));
    }
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < sectors; ++j) {
      const int here = i * sectors + j, next = i * sectors + (j + 1) % sectors;
      mesh.triangles.push_back({here, here + sectors, next});
      mesh.triangles.push_back({next, here + sectors, next + sectors});
    }
  return mesh;
}

inline Mesh hull_of(Mesh mesh) {
  mesh.convex = true;
  return mesh;
}

inline PointCloud sphere_cloud() {
  PointCloud cloud{{}, 0.02};
  for (int i = 0; i < 200; ++i) {
    const double z = -1.0 + 2.0 * i / 199, angle = 2.4 * i, r = std::sqrt(1 - z * z);
    cloud.points.emplace_back(0.08 * r * std::cos(angle), 0.08 * r * std::sin(angle), 0.08 * z);
  }
  return cloud;
}

/// One shape of every kind, about 0.1 to 0.2 m large.
inline std::vector<std::pair<std::string, Shape>> every_kind() {
  return {{"box", Box{{0.2, 0.15, 0.1}}},   {"sphere", Sphere{0.1}},   {"cylinder", Cylinder{0.06, 0.2}},
          {"capsule", Capsule{0.05, 0.15}}, {"cone", Cone{0.08, 0.2}}, {"mesh", angle_iron()},
          {"hull", hull_of(angle_iron())},  {"cloud", sphere_cloud()}};
}

/// Repeatable numbers without <random>'s distributions, which differ between standard libraries.
class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  double in(double low, double high) { return low + (high - low) * (engine_() / 4294967296.0); }
  std::size_t below(std::size_t n) { return engine_() % n; }
  Eigen::VectorXd configuration(const RobotModel& robot) {
    Eigen::VectorXd q(robot.dof());
    for (std::size_t i = 0; i < robot.dof(); ++i)
      q[i] = in(std::max(robot.joints()[i].lower, -M_PI), std::min(robot.joints()[i].upper, M_PI));
    return q;
  }
  Pose pose(double from, double to) {  // in a shell about the z axis
    const double angle = in(-M_PI, M_PI), r = in(from, to);
    return at(r * std::cos(angle), r * std::sin(angle), in(0.1, 0.9), in(-3, 3), in(-3, 3), in(-3, 3));
  }

 private:
  std::mt19937 engine_;
};

/// The names of the bodies in contact at q, as "a and b".
inline std::set<std::string> contacts_at(const Checker& checker, const Eigen::VectorXd& q,
                                         Checker::Workspace& workspace) {
  std::set<std::string> pairs;
  for (const Contact& contact : checker.contacts(q, workspace)) pairs.insert(contact.body_a + " and " + contact.body_b);
  return pairs;
}

/// The arm between two things of each kind, holding one of kind `held`.
inline Scene crowd(std::shared_ptr<const RobotModel> robot, unsigned seed, std::size_t held, const std::string& hand,
                   const std::vector<std::string>& touch = {}) {
  Dice dice(seed);
  Scene scene;
  scene.add_robot(robot, at(0.1, -0.2, 0.05, 0, 0, 0.3));
  const auto kinds = every_kind();
  for (std::size_t i = 0; i < 2 * kinds.size(); ++i)
    scene.add_object(kinds[i / 2].first + (i % 2 ? "_a" : "_b"), kinds[i / 2].second, dice.pose(0.45, 0.9),
                     i % 3 ? 0.0 : 0.01);
  if (held < kinds.size()) {
    scene.add_object("held", kinds[held].second, {});
    scene.attach_object("held", robot->name(), hand, touch, at(0, 0, 0.22));
  }
  return scene;
}

inline std::shared_ptr<const RobotModel> panda() {
  const char* data = std::getenv("SRMP_MBM_DIR");
  if (!data || !*data) return nullptr;
  RobotDescription description;
  description.urdf_path = std::string(data) + "/panda/panda.urdf";
  description.srdf_path = std::string(data) + "/panda/panda.srdf";
  description.group = "panda_arm";
  return RobotModel::load(description);
}

/// The package's own arm of meshes, and the Panda where its data is.
inline std::vector<std::shared_ptr<const RobotModel>> robots_of_meshes() {
  std::vector<std::shared_ptr<const RobotModel>> robots{RobotModel::load(mesh_arm::description())};
  if (auto robot = panda()) robots.push_back(std::move(robot));
  return robots;
}

/// The link that holds things.
inline std::string hand_of(const RobotModel& robot) { return robot.name() + "_hand"; }

}  // namespace worlds
