#include "srmp/trajectory/path.hpp"

#include <cmath>
#include <numbers>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"

namespace srmp {

namespace {

constexpr double collinear = 1e-12;  // of the line's length
constexpr double max_position =
    1e6;  // [rad or m] of a waypoint: beyond, a double has too few digits left for its speed

/// Do rows first+1 … last-1 lie on the line from row `first` to row `last`, in this order?
bool on_one_line(ConstRows waypoints, Eigen::Index first, Eigen::Index last) {
  const Eigen::RowVectorXd start = waypoints.row(first);
  const Eigen::RowVectorXd line = waypoints.row(last) - start;
  const double length = line.norm();
  if (!(length > 0.0)) return false;
  double previous = 0.0;
  for (Eigen::Index i = first + 1; i < last; ++i) {
    const Eigen::RowVectorXd offset = waypoints.row(i) - start;
    const double along = offset.dot(line) / (length * length);
    if (along < previous || along > 1.0) return false;
    if ((offset - along * line).norm() > collinear * length) return false;
    previous = along;
  }
  return true;
}

std::string joint_label(std::span<const std::string> names, Eigen::Index j) {
  return static_cast<std::size_t>(j) < names.size() ? names[static_cast<std::size_t>(j)] : "joint " + std::to_string(j);
}

void require_flags(ConstRows waypoints, const std::vector<bool>& continuous) {
  if (!continuous.empty() && static_cast<Eigen::Index>(continuous.size()) != waypoints.cols())
    throw InvalidArgument("waypoints have " + std::to_string(waypoints.cols()) + " joints, but " +
                          std::to_string(continuous.size()) + " flags say which are continuous");
}

}  // namespace

double path_length(ConstRows waypoints) {
  double length = 0.0;
  for (Eigen::Index i = 1; i < waypoints.rows(); ++i) length += (waypoints.row(i) - waypoints.row(i - 1)).norm();
  return length;
}

RowMatrix stack_waypoints(std::span<const Eigen::VectorXd> waypoints) {
  RowMatrix rows(static_cast<Eigen::Index>(waypoints.size()), waypoints.empty() ? 0 : waypoints[0].size());
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    if (waypoints[i].size() != rows.cols())
      throw InvalidArgument("waypoint " + std::to_string(i) + " has " + std::to_string(waypoints[i].size()) +
                            " entries, the first one has " + std::to_string(rows.cols()));
    rows.row(static_cast<Eigen::Index>(i)) = waypoints[i].transpose();
  }
  return rows;
}

std::vector<Eigen::VectorXd> unstack_waypoints(ConstRows waypoints) {
  std::vector<Eigen::VectorXd> result;
  result.reserve(static_cast<std::size_t>(waypoints.rows()));
  for (Eigen::Index i = 0; i < waypoints.rows(); ++i) result.emplace_back(waypoints.row(i).transpose());
  return result;
}

RowMatrix without_redundant_waypoints(ConstRows waypoints) {
  std::vector<Eigen::Index> distinct;  // without equal successive rows
  for (Eigen::Index i = 0; i < waypoints.rows(); ++i)
    if (distinct.empty() || waypoints.row(i) != waypoints.row(distinct.back())) distinct.push_back(i);
  const RowMatrix path = waypoints(distinct, Eigen::all);

  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < path.rows(); ++i) {
    interruption_point();
    const bool end = i == 0 || i + 1 == path.rows();
    // Compared with the whole run since the last kept one, so that small errors cannot add up.
    if (end || !on_one_line(path, kept.back(), i + 1)) kept.push_back(i);
  }
  return path(kept, Eigen::all);
}

RowMatrix unwrap_waypoints(ConstRows waypoints, const std::vector<bool>& continuous) {
  require_flags(waypoints, continuous);
  RowMatrix result = waypoints;
  for (Eigen::Index j = 0; j < static_cast<Eigen::Index>(continuous.size()); ++j) {
    if (!continuous[static_cast<std::size_t>(j)]) continue;
    for (Eigen::Index i = 1; i < result.rows(); ++i) {
      const double turns = std::nearbyint((result(i, j) - result(i - 1, j)) / (2 * std::numbers::pi));
      result(i, j) -= turns * 2 * std::numbers::pi;
    }
  }
  return result;
}

void require_waypoints(ConstRows waypoints, std::span<const std::string> joint_names) {
  if (waypoints.rows() == 0) throw InvalidArgument("a path needs at least one waypoint, but got none");
  if (waypoints.cols() == 0) throw InvalidArgument("a path needs at least one joint, but its waypoints are empty");
  if (static_cast<std::size_t>(waypoints.cols()) != joint_names.size())
    throw InvalidArgument("waypoints have " + std::to_string(waypoints.cols()) + " entries, but there are " +
                          std::to_string(joint_names.size()) + " joint names");
  for (Eigen::Index i = 0; i < waypoints.rows(); ++i) {
    const Eigen::VectorXd row = waypoints.row(i);
    require_finite({row.data(), static_cast<std::size_t>(row.size())}, "waypoint " + std::to_string(i), joint_names);
    Eigen::Index j{};
    if (row.cwiseAbs().maxCoeff(&j) > max_position)
      throw InvalidArgument("waypoint " + std::to_string(i) + ": " + joint_label(joint_names, j) + " is " +
                            to_text(row[j]) + "; it must be from " + to_text(-max_position) + " to " +
                            to_text(max_position) + " rad or m");
  }
}

void require_short_way(ConstRows waypoints, const std::vector<bool>& continuous,
                       std::span<const std::string> joint_names) {
  require_flags(waypoints, continuous);
  for (Eigen::Index j = 0; j < static_cast<Eigen::Index>(continuous.size()); ++j) {
    if (!continuous[static_cast<std::size_t>(j)]) continue;
    for (Eigen::Index i = 1; i < waypoints.rows(); ++i) {
      const double step = waypoints(i, j) - waypoints(i - 1, j);
      if (std::abs(step) <= std::numbers::pi + 1e-9) continue;
      throw InvalidArgument(joint_label(joint_names, j) + ": the continuous joint moves by " + to_text(step) +
                            " rad from waypoint " + std::to_string(i - 1) + " to " + std::to_string(i) +
                            "; at most half a turn is allowed, unwrap the waypoints first");
    }
  }
}

}  // namespace srmp
