#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "srmp/core/placed_sphere.hpp"

namespace srmp {

class DistanceField;

// Plain data that a BatchChecker is made of: the actuated joints, spheres for each rigid body, obstacles. All frames
// and poses are relative to the robot's base; lengths in metres, angles in radians.

/// A joint of the kinematic tree that a planned joint moves. Its frame has the joint's axis as z.
struct BatchActuatedJoint {
  int parent{-1};  ///< index of the actuated joint that carries it, -1: the base; smaller than its own index
  Eigen::Isometry3d frame{Eigen::Isometry3d::Identity()};  ///< in the parent's frame, at value 0
  bool prismatic{false};
  int joint{};  ///< planned joint; value = ratio * q[joint] + offset
  double ratio{1.0};
  double offset{0.0};
  double max_travel{0.0};  ///< prismatic: bound on |value|
};

/// A rigid body covered by spheres, in the frame of the actuated joint that carries it.
struct BatchBody {
  int actuated_joint{-1};            ///< -1: fixed to the base
  PlacedSphere bound;                ///< contains the body
  std::vector<PlacedSphere> coarse;  ///< together contain the body
  bool exact{false};                 ///< the coarse spheres are the body (then no fine or inner spheres)
  std::vector<PlacedSphere> fine;    ///< together contain the body; may be empty
  std::vector<std::vector<std::uint32_t>> children;  ///< cover_children(coarse, fine); empty when fine is
  std::vector<PlacedSphere> inner;                   ///< inside the body
  bool hollow{false};   ///< what is wholly inside does not collide: inner spheres count only where that is excluded
  double padding{0.0};  ///< kept clear of obstacles
};

struct BatchObstacle {
  enum class Kind { sphere, box, cylinder, capsule, field } kind{};
  /// sphere: radius; box: edges; cylinder, capsule: radius, length; field: edges of the box around it, tight
  Eigen::Vector3d size{Eigen::Vector3d::Zero()};
  std::shared_ptr<const DistanceField> field{};
  Eigen::Vector3d field_center{Eigen::Vector3d::Zero()};  ///< the pose's origin in the field's frame
  bool connected{true};  ///< so that an object larger than a hollow body cannot be wholly inside
  Eigen::Isometry3d pose{Eigen::Isometry3d::Identity()};
  double padding{0.0};
  bool exact{true};  ///< false: the shape only contains the object, so a hit proves nothing
};

struct BatchSelfPair {
  int a{}, b{};  ///< bodies
  double padding{0.0};
  bool exact{true};  ///< false: a hit proves nothing
};

/// Bodies, and the actuated joints that carry them.
struct BatchRobot {
  std::size_t dof{};
  std::vector<BatchActuatedJoint> actuated_joints;
  std::vector<BatchBody> bodies;
};

/// Obstacles, and what may not touch what.
struct BatchPairs {
  std::vector<BatchObstacle> obstacles;
  std::vector<std::pair<int, int>> obstacle_pairs;  ///< (body, obstacle) to check
  std::vector<BatchSelfPair> self_pairs;
  /// Numbers of self pairs that BatchChecker::motion leaves out, of which most motions are decided without spheres.
  std::vector<int> deferred;
};

/// All that a BatchChecker checks.
struct BatchWorld : BatchRobot, BatchPairs {};

}  // namespace srmp
