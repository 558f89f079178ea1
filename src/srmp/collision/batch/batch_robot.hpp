#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "srmp/collision/batch/batch_data.hpp"
#include "srmp/collision/batch/kernel.hpp"

namespace srmp {

/// A BatchRobot in the kernel's form, with bounds on the kernel's float errors. Const once built; models of several
/// scenes share it.
struct BatchRobotModel {
  /// Throws InvalidArgument for indices out of range and non-finite numbers.
  explicit BatchRobotModel(const BatchRobot& robot);

  std::size_t dof{};
  std::vector<BatchActuatedJoint> actuated_joints;
  std::vector<batch::KernelNode> nodes;
  std::vector<batch::KernelBody> bodies;  // without their pairs
  std::vector<batch::KernelSphere> spheres;
  std::vector<batch::KernelChild> children;
  int stage_count{}, coarse_count{}, max_children{};
  bool exact{true};      // the coarse spheres of every body are the body
  double error_bound{};  // of any distance that a result relies on [m]

  std::vector<double> actuated_reach;  // [m per rad, or 1] how far anything that the joint moves can be from its axis
  std::vector<double> body_reach;      // [m] how far from the base any point of the body can be, with its padding
  double reach{};                      // [m] the same of all bodies, without padding

 private:
  void make_room(const BatchRobot& robot);
  void add_nodes(const BatchRobot& robot);
  void add_body(const BatchBody& body);
  void add_fine_and_inner_spheres(const BatchBody& body, batch::KernelBody& kernel);
  void add_reach(const BatchBody& body, double radius);
  double body_error(const BatchBody& body) const;

  // Of each node: bounds on rotation error (operator norm), position error and distance from the base.
  std::vector<double> rotation_error_, position_error_, node_reach_;
};

/// The robots of checkers made before, by what they were made of: a robot in a scene that changed is not made again.
/// Threads share the store.
class BatchRobotStore {
 public:
  /// All that a BatchRobot depends on.
  struct Key {
    std::vector<std::shared_ptr<const void>> parts;  ///< by identity
    std::vector<double> numbers;
    bool operator==(const Key&) const = default;
  };
  using Ptr = std::shared_ptr<const BatchRobotModel>;

  /// The one under this key, or what `make` returns.
  Ptr get(Key key, const std::function<BatchRobot()>& make);
  /// The scene has changed: with the next call of `get`, those go that were last asked for before the change before.
  void scene_changed();

 private:
  struct Known {
    Key key;
    Ptr robot;
    std::uint64_t asked_for{};  // the number of changes then
  };
  Ptr find(const Key& key);  // the caller has the lock

  std::mutex mutex_;
  std::vector<Known> known_;
  std::uint64_t changes_{};
  bool changed_{};
};

}  // namespace srmp
