#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <string>

#include "srmp/collision/checker.hpp"
#include "srmp/collision/narrow_phase.hpp"
#include "srmp/geometry/distance_field.hpp"
#include "srmp/scene/geometry_parts.hpp"
#include "srmp/scene/shape_geometry.hpp"

// The bodies that a SceneChecker knows (bodies.hpp). All poses are in the base frame of the first robot of a group.
namespace srmp::detail {

struct Body {
  std::string name;
  BodyKind kind{};
  std::shared_ptr<const coal::CollisionGeometry> geometry;
  GeometryParts parts;
  std::shared_ptr<const DistanceField> field;  // of an object, or of a link that no planned joint moves
  Bounds bounds;
  Core core;
  double padding{};
  int robot{-1};            // of the group: whose link it is, or whose link holds it; -1: none of them
  std::uint64_t support{};  // actuated joints of the group that move it
  std::string scene_name;   // as the scene resolves it
  std::size_t source{};     // geometry index of a link; link index of an object that a moving link holds
  /// The geometry, or a convex solid around it; null when there are only the geometry's primitives.
  const coal::CollisionGeometry* solid{};

  bool is_solid() const { return !parts.bvh; }
};

/// Moved by the group's joints: a geometry of a robot, or an object that a link holds.
struct MovingBody : Body {
  Eigen::Isometry3d in_link;  // of an attached object
  bool attached() const { return kind == BodyKind::attached_object; }
};

struct FixedBody : Body {
  Eigen::Isometry3d pose;
  Eigen::Vector3d center;  // of the bounding sphere
};

}  // namespace srmp::detail
