#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <vector>

#include "srmp/robot/urdf.hpp"

namespace srmp {

/// The moving joints of a URDF in Pinocchio. Keeps Pinocchio's headers out of everybody else's.
class KinematicTree {
 public:
  explicit KinematicTree(const Urdf& urdf);
  ~KinematicTree();

  /// Where a link hangs: rigidly on a moving joint (0: on the base).
  struct FixedPlacement {
    std::size_t joint{};
    Eigen::Isometry3d placement{Eigen::Isometry3d::Identity()};
  };
  /// A scalar joint's place in Pinocchio's configuration vector.
  struct Slot {
    std::size_t joint{};
    Eigen::Index q{};
    bool unit_circle{};  ///< continuous: cos and sin are stored
  };

  const FixedPlacement& mount(std::size_t urdf_link) const { return placements_[urdf_link]; }
  const Slot& slot(std::size_t urdf_joint) const { return slots_[urdf_joint]; }  ///< scalar joints only
  std::size_t joint_count() const;                                               ///< with the base as joint 0
  std::size_t parent(std::size_t joint) const;

  class Data;
  /// Gives it back to its tree, for the next make_data: to make one anew takes longer than many configurations.
  struct DataDeleter {
    void operator()(Data*) const;
  };
  using DataPtr = std::unique_ptr<Data, DataDeleter>;

  DataPtr make_data() const;  ///< at the neutral configuration; threads may call it at once
  static void set(Data& data, const Slot& slot, double value);
  /// Poses of all joints in the base frame, by joint; `poses` has joint_count() entries.
  void forward(Data& data, std::vector<Eigen::Isometry3d>& poses) const;

 private:
  struct Model;
  std::shared_ptr<Model> model_;  // its data may outlive this
  std::vector<FixedPlacement> placements_;
  std::vector<Slot> slots_;
};

}  // namespace srmp
