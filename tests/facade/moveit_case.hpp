#pragma once

#include <functional>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "srmp/moveit_session.hpp"
#include "support/files.hpp"

/// A scene and a request for MoveItSession, and what to change in them.
namespace moveit_case {

using namespace srmp;

using Code = MoveItErrorCode;

inline std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline MoveItRobot arm_robot() {
  return {text_of(SRMP_SOURCE_DIR "/python/srmp/data/arm7.urdf"),
          text_of(SRMP_SOURCE_DIR "/python/srmp/data/arm7.srdf"),
          {},
          {}};
}

inline const std::map<std::string, double> ready{
    {"arm7_joint1", 0.0}, {"arm7_joint2", 0.0},      {"arm7_joint3", 0.0}, {"arm7_joint4", M_PI / 2},
    {"arm7_joint5", 0.0}, {"arm7_joint6", M_PI / 2}, {"arm7_joint7", 0.0}};

/// A tetrahedron around the origin, with faces about `size` [m] from it.
inline Mesh tetrahedron(double size) {
  return {{{size, size, size}, {size, -size, -size}, {-size, size, -size}, {-size, -size, size}},
          {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}};
}

/// A scene, a request in it that has an answer, and a session to ask.
struct Case {
  io::SceneFile scene;
  io::RequestFile request;

  Case() {
    scene.robot_state.joints = ready;
    request.group_name = "arm";
    io::GoalAlternative goal;
    for (const auto& [joint, position] : ready) goal.joints.push_back({joint, position, 1e-3, 1e-3});
    goal.joints[0].position = 0.8;
    request.goals = {goal};
  }

  /// A goal for the hand, in reach: its pose in the world at the joint goal.
  void ask_for_pose() {
    request.goals[0].joints.clear();
    io::PositionConstraint position{.link = "arm7_hand", .frame = ""};
    position.regions.push_back({Sphere{0.005}, Pose{{0.28, 0.28, 0.5}}});
    request.goals[0].positions = {position};
  }
  io::PositionConstraint& position() { return request.goals[0].positions.at(0); }
  io::JointConstraint& joint(std::size_t index) { return request.goals[0].joints.at(index); }

  io::CollisionObject& add_box(const std::string& id, const Eigen::Vector3d& at, const Eigen::Vector3d& size) {
    io::CollisionObject box;
    box.id = id;
    box.pose.p = at;
    box.shapes = {{Box{size}, {}}};
    scene.objects.push_back(box);
    return scene.objects.back();
  }
  io::AttachedObject& attach(const std::string& id, const std::string& link) {
    io::AttachedObject attached;
    attached.link = link;
    attached.object.id = id;
    attached.object.frame = link;
    attached.object.shapes = {{Box{{0.02, 0.02, 0.1}}, {}}};
    attached.object.pose.p = {0, 0, 0.06};
    attached.touch_links = {"arm7_hand", "arm7_flange", "arm7_palm_mount", "arm7_wrist"};
    request.start_state.attached.push_back(attached);
    request.start_state.is_diff = true;
    return request.start_state.attached.back();
  }
  /// Held in the scene's robot state, around the hand.
  void attach_to_scene(const std::string& id, const Eigen::Vector3d& size) {
    io::AttachedObject attached;
    attached.link = attached.object.frame = "arm7_hand";
    attached.object.id = id;
    attached.object.shapes = {{Box{size}, {}}};
    scene.robot_state.attached.push_back(attached);
  }
  io::OrientationConstraint& keep_orientation(const Eigen::Vector3d& tolerance) {
    io::OrientationConstraint orientation;
    orientation.link = "arm7_hand";
    orientation.orientation = Eigen::Quaterniond(0, 0, 1, 0);
    orientation.tolerance = tolerance;
    request.path_constraints.orientations.push_back(orientation);
    return request.path_constraints.orientations.back();
  }
  /// Around a point between start and goal.
  io::PositionConstraint& keep_position(const Shape& region) {
    io::PositionConstraint position{.link = "arm7_hand", .frame = ""};
    position.regions.push_back({region, Pose{{0.3, 0.13, 0.45}}});
    request.path_constraints.positions.push_back(position);
    return request.path_constraints.positions.back();
  }
  const Eigen::Vector3d at_start{0.33, 0.0, 0.45};  ///< about where the hand is

  void ask_for_orientation(double length) {
    request.goals[0].joints.clear();
    io::OrientationConstraint orientation;
    orientation.link = "arm7_hand";
    orientation.orientation = Eigen::Quaterniond(0, length, 0, 0);
    orientation.tolerance.setConstant(0.01);
    request.goals[0].orientations = {orientation};
  }
};

struct Row {
  const char* field;
  std::function<void(Case&)> change;
  Code code;
  const char* fragment = "";
};

inline const double not_finite = std::numeric_limits<double>::quiet_NaN();

}  // namespace moveit_case
