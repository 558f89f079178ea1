#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "srmp/robot/robot_model.hpp"

namespace srmp {

/// The configurations, the nearest to `reference` first; of equally near ones, that which came first.
std::vector<Eigen::VectorXd> nearest_first(const RobotModel& robot, ConstVector reference,
                                           std::vector<Eigen::VectorXd> configurations);

/// Configurations of a robot, such as solutions of inverse kinematics, no two of which are close to each other.
class DistinctConfigurations {
 public:
  /// Close: no joint differs by `distance` [rad or m] or more.
  DistinctConfigurations(const RobotModel& robot, double distance) : robot_(robot), distance_(distance) {}

  bool has_one_close_to(const Eigen::VectorXd& q) const;
  void add(Eigen::VectorXd q) { found_.push_back(std::move(q)); }
  std::size_t size() const { return found_.size(); }
  /// All of them, the nearest to `reference` first; leaves none.
  std::vector<Eigen::VectorXd> take_nearest_first(ConstVector reference);

 private:
  const RobotModel& robot_;
  double distance_;
  std::vector<Eigen::VectorXd> found_;
};

}  // namespace srmp
