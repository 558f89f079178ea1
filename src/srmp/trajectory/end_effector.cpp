// Where the end effector goes: the part of Trajectory that needs forward kinematics.
#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

namespace {

constexpr double time_step = 0.01;   // [s] between the points of a length
constexpr double joint_step = 0.01;  // [rad or m] the same, of a path without times
constexpr double max_points = 1e7;

const PlacedRobot& require_known(const PlacedRobot* robot) {
  if (!robot || !robot->model)
    throw InvalidArgument(
        "trajectory: it does not know its robot (only a plan does, until it is pickled or written); name a planner and "
        "a robot");
  return *robot;
}

/// For each planned joint of the robot, its column in the trajectory.
std::vector<Eigen::Index> columns_of(const RobotModel& robot, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (std::ranges::find(robot.joint_names(), name) == robot.joint_names().end())
      throw InvalidArgument("trajectory: it moves '" + name + "', which is no planned joint of robot '" + robot.name() +
                            "'" + did_you_mean(name, robot.joint_names()));
  std::vector<Eigen::Index> columns;
  for (const std::string& name : robot.joint_names()) {
    const auto found = std::ranges::find(names, name);
    if (found == names.end())
      throw InvalidArgument("trajectory: it does not say where '" + name + "' of robot '" + robot.name() + "' is");
    columns.push_back(found - names.begin());
  }
  return columns;
}

/// Forward kinematics of the origin of a link, in the world.
class LinkOrigin {
 public:
  LinkOrigin(const Trajectory& trajectory, const PlacedRobot& robot, const std::string& link)
      : robot_(require_known(&robot)),
        columns_(columns_of(*robot.model, trajectory.joint_names)),
        link_(robot.model->link_index(link.empty() ? robot.model->end_effector() : link)),
        data_(robot.model->make_data(robot.other_positions)) {}

  Eigen::Vector3d operator()(const Eigen::VectorXd& position) {
    robot_.model->forward(*data_, position(columns_));
    return robot_.base * Eigen::Vector3d(robot_.model->link_pose(*data_, link_).translation());
  }

 private:
  const PlacedRobot& robot_;
  std::vector<Eigen::Index> columns_;
  std::size_t link_;
  RobotDataPtr data_;
};

/// Steps from row i to the next.
double steps(const Trajectory& t, Eigen::Index i) {
  const double size = t.timed() ? (t.times[i + 1] - t.times[i]) / time_step
                                : (t.positions.row(i + 1) - t.positions.row(i)).cwiseAbs().maxCoeff() / joint_step;
  return std::max(1.0, std::ceil(size));
}

Eigen::VectorXd position_at(const Trajectory& t, Eigen::Index i, double fraction) {
  if (t.timed()) return t.sample(t.times[i] + fraction * (t.times[i + 1] - t.times[i]));
  return (t.positions.row(i) + fraction * (t.positions.row(i + 1) - t.positions.row(i))).transpose();
}

}  // namespace

RowMatrix Trajectory::end_effector_path(const PlacedRobot& of, const std::string& link) const {
  validate();
  LinkOrigin origin(*this, of, link);
  RowMatrix path(positions.rows(), 3);
  for (Eigen::Index i = 0; i < path.rows(); ++i) path.row(i) = origin(positions.row(i).transpose()).transpose();
  return path;
}

double Trajectory::end_effector_length(const PlacedRobot& of, const std::string& link) const {
  validate();
  LinkOrigin origin(*this, of, link);
  double points = 0.0;
  for (Eigen::Index i = 0; i + 1 < positions.rows(); ++i) points += steps(*this, i);
  if (!(points < max_points))
    throw InvalidArgument(
        "trajectory: it would take more than ten million points to follow the end effector along "
        "this motion of " +
        to_text(duration()) + " s; ask for slices of it");
  double length = 0.0;
  Eigen::Vector3d last = origin(positions.row(0).transpose());
  for (Eigen::Index i = 0; i + 1 < positions.rows(); ++i) {
    const double count = steps(*this, i);
    for (double k = 1.0; k <= count; k += 1.0) {
      const Eigen::Vector3d next = origin(position_at(*this, i, k / count));
      length += (next - last).norm();
      last = next;
    }
  }
  return length;
}

RowMatrix Trajectory::end_effector_path(const std::string& link) const {
  return end_effector_path(require_known(robot.get()), link);
}
double Trajectory::end_effector_length(const std::string& link) const {
  return end_effector_length(require_known(robot.get()), link);
}

}  // namespace srmp
