#pragma once

#include <string>
#include <vector>

#include "srmp/collision/joint_cells.hpp"
#include "srmp/robot/robot_model.hpp"
#include "srmp/search/cell_decomposition.hpp"

namespace srmp {

/// Looks for a proof that two configurations are not connected, in the space of a few joints: what moves with these
/// joints alone is in contact all around, wherever the other joints are. A path of the robot would be a path there.
class BarrierProof {
 public:
  /// The robot is that of the workspace's checker; both outlive this.
  BarrierProof(const RobotModel& robot, std::vector<std::size_t> joints, const Eigen::VectorXd& from,
               const Eigen::VectorXd& to, Checker::Workspace& workspace);

  /// Labels up to so many more cells.
  void run(std::size_t cells);
  const std::vector<std::size_t>& joints() const { return joints_.joints(); }
  std::size_t cells() const { return decomposition_.cells(); }
  bool finished() const { return outcome_ != search::CellDecomposition::Outcome::unfinished; }
  bool proved() const { return outcome_ == search::CellDecomposition::Outcome::no_path; }
  /// Once it is proved: a sentence.
  std::string reason();

 private:
  search::CellLabel label(const search::Cell& cell, std::size_t parent);

  const RobotModel& robot_;
  JointCells joints_;
  std::vector<JointCells::Pairs> near_;  // of each cell: pairs that may be in contact there
  const Eigen::VectorXd from_, to_;      // of the joints
  search::CellDecomposition decomposition_;
  search::CellDecomposition::Outcome outcome_{};
};

}  // namespace srmp
