#pragma once

// Internal: the objects of MoveIt's files in a scene.

#include <string>
#include <vector>

#include "srmp/io/moveit_frames.h"

namespace srmp::io {

/// Carries out the operations of collision objects. The scene may be half changed when one throws InvalidArgument or
/// NotSupported, so it should be a copy.
class ObjectUpdate {
 public:
  ObjectUpdate(Scene& scene, const FrameLookup& frames) : scene_(scene), frames_(frames) {}

  /// An object of the world.
  void apply(const CollisionObject& object);
  /// An object of a robot state.
  void apply(const AttachedObject& attached);
  /// Removes the objects of earlier files, attached ones too.
  void remove_all();

  /// The objects that are the shapes of this id, or the object of this name alone; none if there is neither.
  std::vector<std::string> shapes_of(const std::string& id) const;

 private:
  bool is_attached(const std::string& id) const;
  void add(const CollisionObject& object, const Pose& frame);
  void append(const CollisionObject& object);
  void move(const CollisionObject& object);
  void remove(const std::string& id);
  std::string add_shape(const CollisionObject& object, const PlacedShape& shape, const Pose& frame,
                        const ObjectGroup& group);
  void attach(const AttachedObject& attached);
  void attach_existing(const AttachedObject& attached);
  void detach(const AttachedObject& attached);
  std::vector<std::string> require_shapes(const std::string& id, const std::string& what) const;

  Scene& scene_;
  const FrameLookup& frames_;
};

}  // namespace srmp::io
