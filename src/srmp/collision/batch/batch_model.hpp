#pragma once

#include <vector>

#include "srmp/collision/batch/batch_data.hpp"
#include "srmp/collision/batch/kernel.hpp"
#include "srmp/collision/batch/simd_backend.hpp"

namespace srmp {

/// The world of a BatchChecker in the kernel's form, with bounds on the kernel's float errors. Const once built.
struct BatchModel {
  /// Throws InvalidArgument for what BatchChecker refuses.
  BatchModel(const BatchWorld& batch_world, SimdBackend simd);

  BatchWorld world;
  SimdBackend backend{};
  batch::KernelFunction kernel{};
  double error_bound{};  // of any distance that a result relies on [m]

  std::vector<batch::KernelNode> nodes;
  std::vector<batch::KernelBody> bodies;
  std::vector<batch::KernelSphere> spheres;
  std::vector<int> children;
  std::vector<batch::KernelObstacle> obstacles;
  std::vector<int> pair_obstacles, pair_ids;
  std::vector<batch::KernelSelfPair> self_pairs;
  int stage_count{}, coarse_count{}, max_children{};
  std::vector<double> actuated_reach;  // [m per rad, or 1] how far anything that the joint moves can be from its axis

  // Of each node: bounds on rotation error (operator norm), position error and distance from the base.
  std::vector<double> rotation_error, position_error, node_reach;
  double robot_reach{};  // bound on the distance of any body's point from the base

  batch::KernelModel view() const {
    return {nodes.data(),          static_cast<int>(nodes.size()),
            bodies.data(),         static_cast<int>(bodies.size()),
            stage_count,           spheres.data(),
            coarse_count,          children.data(),
            max_children,          obstacles.data(),
            pair_obstacles.data(), static_cast<int>(pair_obstacles.size()),
            self_pairs.data(),     static_cast<int>(self_pairs.size())};
  }

  void require_valid() const;
  void add_nodes();
  void add_bodies();
  void add_fine_and_inner_spheres(std::size_t body);
  void add_obstacles();
  void add_pairs();
  void add_self_pairs();
  void add_reach();
  double body_error(const BatchBody& body) const;
  static bool is_sphere(const BatchBody& body);
  bool reachable(const BatchBody& body, const BatchObstacle& obstacle) const;
};

}  // namespace srmp
