#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "srmp/robot/urdf.hpp"

namespace srmp {

/// The kinematic tree of a URDF in Pinocchio. Other headers do not include Pinocchio's.
class KinematicTree {
 public:
  /// Throws FileError when Pinocchio rejects the robot.
  explicit KinematicTree(const Urdf& urdf);
  ~KinematicTree();

  /// The pose of a link in the frame of the joint that it is rigidly attached to.
  struct FixedPlacement {
    std::size_t joint{};  ///< 0: the base
    Eigen::Isometry3d placement{Eigen::Isometry3d::Identity()};
  };
  /// The entry of Pinocchio's configuration vector that belongs to a joint with one degree of freedom.
  struct Slot {
    std::size_t joint{};
    Eigen::Index q{};
    bool unit_circle{};  ///< a continuous joint, which has two entries: cosine and sine
  };

  const FixedPlacement& fixed_placement(std::size_t urdf_link) const { return placements_[urdf_link]; }
  const Slot& slot(std::size_t urdf_joint) const {
    return slots_[urdf_joint];
  }  ///< joints with one degree of freedom only
  std::size_t joint_count() const;  ///< with the base as joint 0
  /// The parent of a joint of the tree; it has a smaller index.
  std::size_t parent(std::size_t joint) const;

  class Data;
  /// Returns the data to the tree, for the next make_data: allocating new data takes longer than the kinematics of many
  /// configurations.
  struct DataDeleter {
    void operator()(Data*) const;
  };
  using DataPtr = std::unique_ptr<Data, DataDeleter>;

  DataPtr make_data() const;  ///< at the neutral configuration; thread-safe
  /// Sets the position [rad or m] of one joint.
  static void set(Data& data, const Slot& slot, double value);
  /// The same in a configuration vector of Pinocchio's.
  static void set(Eigen::VectorXd& q, const Slot& slot, double value);
  /// Computes the poses of all joints in the base frame, by joint; `poses` has joint_count() entries.
  void forward(Data& data, std::vector<Eigen::Isometry3d>& poses) const;
  /// The same of some joints, parents before children, where nothing before them has moved since.
  void forward(Data& data, std::vector<Eigen::Isometry3d>& poses, std::span<const std::size_t> joints) const;

 private:
  struct Model;
  std::shared_ptr<Model> model_;  // shared with the data, which may outlive the tree
  std::vector<FixedPlacement> placements_;
  std::vector<Slot> slots_;
};

}  // namespace srmp
