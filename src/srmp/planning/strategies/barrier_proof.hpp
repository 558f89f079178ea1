#pragma once

#include <cstddef>
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
  using Outcome = search::CellDecomposition::Outcome;

  /// The robot is that of the workspace's checker; both outlive this.
  BarrierProof(const RobotModel& robot, std::vector<std::size_t> joints, const Eigen::VectorXd& from,
               Checker::Workspace& workspace);

  /// Labels up to so many more cells. What was labelled for one target is known for others.
  Outcome run(const Eigen::VectorXd& to, std::size_t cells);
  std::size_t cells() const { return decomposition_.cells(); }
  /// How much was done, as the number of cells whose labels would have taken as long.
  std::size_t work() const { return cells() + decomposition_.visits() / visits_per_label; }
  /// If the last outcome is no_path: a sentence.
  std::string reason(const Eigen::VectorXd& to);

 private:
  static constexpr std::size_t visits_per_label = 256;

  search::CellLabel label(const search::Cell& cell, std::size_t parent);

  const RobotModel& robot_;
  JointCells joints_;
  const Eigen::VectorXd from_;           // of the joints
  std::vector<JointCells::Pairs> near_;  // of each cell: pairs that may be in contact there
  search::CellDecomposition decomposition_;
};

}  // namespace srmp
