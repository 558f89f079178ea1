#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "srmp/collision/batch/batch_robot.hpp"
#include "srmp/cover/geometry_cover.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp::detail {

struct Bodies;
struct FixedBody;
struct FixedChanges;
class RobotGroup;

/// Returns the cover of a link's geometry, not null.
using CoverOf = std::function<std::shared_ptr<const GeometryCover>(const coal::CollisionGeometry& shape)>;

/// Lists of numbers in contiguous memory.
struct NumberLists {
  std::vector<std::uint32_t> numbers;
  std::vector<std::uint32_t> ends;  ///< of each list, in `numbers`

  std::span<const std::uint32_t> operator[](std::size_t i) const {
    const std::size_t first = i == 0 ? 0 : ends[i - 1];
    return {numbers.data() + first, ends[i] - first};
  }
};

/// The world of a BatchChecker that checks before Coal does, and the pairs of Bodies that its pairs stand for.
struct BatchScene {
  std::shared_ptr<const BatchRobotModel> robot;
  BatchPairs pairs;
  /// By index of BatchPairs::obstacle_pairs and self_pairs: the pairs of Bodies that each stands for, increasing.
  NumberLists obstacle_pairs, self_pairs;

  /// What a body of Bodies is in the batch: the number of an obstacle, or of a body of the robot.
  struct Part {
    bool is_obstacle{};
    int number{};
  };
  std::vector<int> body_of_moving;   ///< of each moving body, its number in the robot
  std::vector<Part> part_of_fixed;   ///< of each fixed body
  std::vector<int> geometry_counts;  ///< of each body of the robot

  /// Follows what became of Bodies::fixed, where it was objects that changed. Returns the number before of each
  /// obstacle that is the same, -1 for those that are not.
  std::vector<int> follow(const Bodies& bodies, const FixedChanges& changes);
  /// Fills in the pairs, from all else.
  void make_pairs(const Bodies& bodies);
};

/// The geometries of one link become one body; so do links that do not move, fixed to the base, and attached objects.
/// Objects that are boxes, spheres, cylinders or capsules become obstacles as they are; others are represented by their
/// distance fields. Robots are looked up in `known` and kept there.
BatchScene make_batch_scene(const Bodies& bodies, const RobotGroup& group, const CoverOf& cover_of,
                            BatchRobotStore& known);

/// A fixed body as an obstacle; `clearance` [m] is added to its padding.
BatchObstacle as_obstacle(const FixedBody& body, double clearance);

}  // namespace srmp::detail
