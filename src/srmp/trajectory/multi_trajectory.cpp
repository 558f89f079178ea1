#include "srmp/trajectory/multi_trajectory.hpp"

#include <algorithm>
#include <vector>

#include "srmp/core/error.hpp"

namespace srmp {

double MultiTrajectory::duration() const {
  double longest = 0.0;
  for (const auto& [name, trajectory] : robots) longest = std::max(longest, trajectory.duration());
  return longest;
}

const Trajectory& MultiTrajectory::at(const std::string& robot) const {
  if (const auto found = robots.find(robot); found != robots.end()) return found->second;
  std::vector<std::string> known;
  for (const auto& [name, trajectory] : robots) known.push_back(name);
  throw InvalidArgument("there is no trajectory of robot '" + robot + "'" + did_you_mean(robot, known));
}

namespace {

/// Copies the state of one robot at `time`, or its row of this number where there are no times.
void copy_row(const Trajectory& from, double time, Eigen::Index row, Eigen::Index first, Trajectory& to) {
  const auto columns = static_cast<Eigen::Index>(from.dof());
  if (!from.timed()) {
    to.positions.row(row).segment(first, columns) = from.positions.row(std::min(row, from.positions.rows() - 1));
    return;
  }
  if (to.velocities.rows() == 0) {  // straight between rows
    to.positions.row(row).segment(first, columns) = from.sample(time).transpose();
    return;
  }
  const bool ended = time > from.times[from.times.size() - 1];
  const MotionState state = from.state(time);
  to.positions.row(row).segment(first, columns) = state.position.transpose();
  if (ended) return;
  to.velocities.row(row).segment(first, columns) = state.velocity.transpose();
  to.accelerations.row(row).segment(first, columns) = state.acceleration.transpose();
}

}  // namespace

Trajectory MultiTrajectory::merged() const {
  if (robots.empty()) throw InvalidArgument("there is no robot to merge the trajectories of");
  const bool timed = robots.begin()->second.timed();
  std::vector<double> times;
  Eigen::Index rows = 0, columns = 0;
  const std::string *smooth = nullptr, *straight = nullptr;  // robots that move
  Trajectory merged;
  for (const auto& [name, trajectory] : robots) {
    if (trajectory.timed() != timed) throw InvalidArgument("some of the trajectories have times and others have not");
    times.insert(times.end(), trajectory.times.begin(), trajectory.times.end());
    if (trajectory.size() > 1) (trajectory.velocities.rows() > 0 ? smooth : straight) = &name;
    rows = std::max(rows, trajectory.positions.rows());
    columns += trajectory.positions.cols();
    for (const std::string& joint : trajectory.joint_names) merged.joint_names.push_back(name + "/" + joint);
  }
  if (timed && smooth && straight)
    throw InvalidArgument("the trajectory of '" + *smooth + "' has velocities, but that of '" + *straight +
                          "' has none: one motion has them or not");
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  if (timed) rows = static_cast<Eigen::Index>(times.size());
  merged.times = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  merged.positions = RowMatrix::Zero(rows, columns);
  merged.velocities = merged.accelerations = RowMatrix::Zero(timed && !straight ? rows : 0, columns);
  Eigen::Index first = 0;
  for (const auto& [name, trajectory] : robots) {
    for (Eigen::Index row = 0; row < rows; ++row)
      copy_row(trajectory, timed ? times[static_cast<std::size_t>(row)] : 0.0, row, first, merged);
    first += trajectory.positions.cols();
  }
  return merged;
}

}  // namespace srmp
