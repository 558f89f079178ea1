#include "srmp/planning/joint_path.hpp"

#include <algorithm>
#include <tuple>

#include "srmp/trajectory/path.hpp"

namespace srmp {

double JointPath::length(std::size_t i) const { return path_length(positions[i]); }

double JointPath::length() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < positions.size(); ++i) sum += length(i);
  return sum;
}

JointPath path_of_one(RowMatrix positions) {
  JointPath path{{0}, {}, {}};
  for (Eigen::Index row = 0; row < positions.rows(); ++row) path.steps.push_back(static_cast<double>(row));
  path.positions.push_back(std::move(positions));
  return path;
}

JointPath reversed(JointPath path) {
  for (RowMatrix& q : path.positions) q = q.colwise().reverse().eval();
  const double last = path.steps.back();
  std::ranges::reverse(path.steps);
  for (double& step : path.steps) step = last - step;
  return path;
}

Eigen::VectorXd position_at(const JointPath& path, std::size_t i, double step) {
  const RowMatrix& q = path.positions[i];
  const auto next = std::upper_bound(path.steps.begin(), path.steps.end(), step);
  if (next == path.steps.end()) return q.bottomRows(1).transpose();
  const auto row = static_cast<Eigen::Index>(next - path.steps.begin());
  const double from = path.steps[static_cast<std::size_t>(row - 1)];
  return (q.row(row - 1) + (step - from) / (*next - from) * (q.row(row) - q.row(row - 1))).transpose();
}

std::vector<double> all_steps(const std::vector<const JointPath*>& paths) {
  std::vector<double> steps;
  for (const JointPath* path : paths) steps.insert(steps.end(), path->steps.begin(), path->steps.end());
  std::sort(steps.begin(), steps.end());
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  return steps;
}

JointPath side_by_side(const std::vector<const JointPath*>& paths) {
  JointPath all{{}, all_steps(paths), {}};
  std::vector<std::tuple<std::size_t, const JointPath*, std::size_t>> robots;
  for (const JointPath* path : paths)
    for (std::size_t i = 0; i < path->robots.size(); ++i) robots.emplace_back(path->robots[i], path, i);
  std::sort(robots.begin(), robots.end());
  for (const auto& [robot, path, i] : robots) {
    RowMatrix q(static_cast<Eigen::Index>(all.size()), path->positions[i].cols());
    for (std::size_t row = 0; row < all.size(); ++row)
      q.row(static_cast<Eigen::Index>(row)) = position_at(*path, i, all.steps[row]).transpose();
    all.robots.push_back(robot);
    all.positions.push_back(std::move(q));
  }
  return all;
}

}  // namespace srmp
