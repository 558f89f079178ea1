#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "srmp/collision/batch/batch_data.hpp"
#include "srmp/collision/batch/batch_robot.hpp"
#include "srmp/collision/batch/kernel.hpp"
#include "srmp/core/simd_backend.hpp"

namespace srmp {

/// What a BatchChecker checks, in the kernel's form. Const once built.
struct BatchModel {
  /// Throws InvalidArgument for what BatchChecker refuses.
  BatchModel(std::shared_ptr<const BatchRobotModel> batch_robot, const BatchPairs& pairs, SimdBackend simd);

  /// As BatchChecker's constructor from another.
  BatchModel(const BatchModel& before, const BatchPairs& pairs, std::span<const int> known);

  std::shared_ptr<const BatchRobotModel> robot;
  SimdBackend backend{};
  batch::KernelFunction kernel{};

  std::vector<batch::KernelBody> bodies;  // of the robot, with their pairs
  std::vector<batch::KernelObstacle> obstacles;
  std::vector<int> pair_obstacles, pair_ids;
  std::vector<float> pair_boxes;
  std::vector<batch::KernelSelfPair> self_pairs;
  std::vector<char> not_deferred;  // by number of a pair, of obstacles and then of bodies; empty: none is deferred

  batch::KernelModel view() const {
    return {robot->nodes.data(),
            static_cast<int>(robot->nodes.size()),
            bodies.data(),
            static_cast<int>(bodies.size()),
            robot->stage_count,
            robot->spheres.data(),
            robot->coarse_count,
            robot->children.data(),
            robot->max_children,
            obstacles.data(),
            pair_obstacles.data(),
            pair_boxes.data(),
            static_cast<int>(pair_obstacles.size()),
            self_pairs.data(),
            static_cast<int>(self_pairs.size())};
  }

 private:
  void require_valid(const BatchPairs& pairs) const;
  void make_room(const BatchPairs& pairs);
  void add_obstacle(const BatchObstacle& obstacle);
  void add_all_pairs(const BatchPairs& pairs);
  void add_pairs(const BatchPairs& pairs);
  void add_self_pair(const BatchSelfPair& pair);

  using Box = std::array<float, 6>;  // lowest x, y, z, highest x, y, z
  void add_box(const BatchObstacle& obstacle, double margin);
  void add_pair_box(std::size_t in_body, const Box& box);

  // Of each obstacle: [m] how near the base it comes, with its padding, and the box around it, with a margin.
  std::vector<double> nearest_;
  std::vector<Box> boxes_;
};

}  // namespace srmp
