#include "srmp/planning/endpoints/search_endpoints.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/lattice/primitives.hpp"

namespace srmp {

namespace {

/// Finds configurations on grids to which straight motions are free.
class Rounding {
 public:
  Rounding(RobotContext& context, const RoundingOptions& options) : context_(context), left_(options.max_checks) {
    for (const double cell : options.cells)
      cells_.push_back(lattice_step(context.robot.joints(), cell * M_PI / 180.0, cell * options.metres_per_degree));
  }

  Eigen::VectorXd near(const Eigen::VectorXd& q) {
    for (const Eigen::VectorXd& cell : cells_)
      if (auto rounded = near(q, cell)) return *std::move(rounded);
    return q;
  }

 private:
  /// The nearest corner of the cell around `q`, and those beside it.
  std::optional<Eigen::VectorXd> near(const Eigen::VectorXd& q, const Eigen::VectorXd& cell) {
    Eigen::VectorXd nearest = q, opposite = q;
    std::vector<std::pair<double, Eigen::Index>> joints;  // by how much farther the opposite side of the cell is
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      const double below = cell[j] * std::floor(q[j] / cell[j]), above = below + cell[j];
      const bool down = q[j] - below <= above - q[j];
      nearest[j] = within_limits(down ? below : above, within_limits(down ? above : below, q[j], j), j);
      opposite[j] = within_limits(down ? above : below, nearest[j], j);
      joints.emplace_back(std::abs(opposite[j] - q[j]) - std::abs(nearest[j] - q[j]), j);
    }
    if (is_free(q, nearest)) return nearest;
    std::sort(joints.begin(), joints.end());
    for (const auto& [farther, j] : joints) {
      Eigen::VectorXd corner = nearest;
      corner[j] = opposite[j];
      if (is_free(q, corner)) return corner;
    }
    return std::nullopt;
  }

  /// `value`, or `otherwise` where it is not well within the limits: at a limit no trajectory turns without touching
  /// it.
  double within_limits(double value, double otherwise, Eigen::Index j) const {
    const Joint& joint = context_.robot.joints()[static_cast<std::size_t>(j)];
    const double margin = 0.1 * cells_.back()[j];
    return joint.lower + margin <= value && value <= joint.upper - margin ? value : otherwise;
  }

  bool is_free(const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
    return left_-- > 0 && context_.checks.is_motion_free(from, to);
  }

  RobotContext& context_;
  std::vector<Eigen::VectorXd> cells_;
  int left_;  // checks
};

}  // namespace

std::optional<std::size_t> SearchEndpoints::target_number(const Eigen::VectorXd& target) const {
  const auto found = std::find(targets.begin(), targets.end(), target);
  return found == targets.end() ? std::nullopt : std::optional<std::size_t>(found - targets.begin());
}

RowMatrix SearchEndpoints::with_own_ends(const RowMatrix& rows, std::optional<std::size_t> target) const {
  const bool begins = path_start != start, ends = target && path_targets[*target] != targets[*target];
  RowMatrix whole(rows.rows() + begins + ends, rows.cols());
  whole.middleRows(begins, rows.rows()) = rows;
  whole.row(0) = path_start.transpose();  // a path from the goals may reach the start whole turns away
  if (ends) whole.bottomRows(1) = path_targets[*target].transpose();
  return whole;
}

double SearchEndpoints::length_of_ends(const RobotModel& robot, std::optional<std::size_t> target) const {
  const double begin = robot.difference(path_start, start).norm();
  return target ? begin + robot.difference(targets[*target], path_targets[*target]).norm() : begin;
}

SearchEndpoints exact_endpoints(const RobotEndpoints& endpoints) {
  return {endpoints, endpoints.start, endpoints.targets};
}

SearchEndpoints rounded_endpoints(RobotContext& context, const RobotEndpoints& endpoints,
                                  const RoundingOptions& options) {
  SearchEndpoints found = exact_endpoints(endpoints);
  Rounding rounding(context, options);
  found.start = rounding.near(endpoints.start);
  for (std::size_t i = 0; i < found.targets.size(); ++i) {
    Eigen::VectorXd target = rounding.near(endpoints.targets[i]);
    if (!found.target_number(target)) found.targets[i] = std::move(target);  // one target stands for one goal
  }
  return found.target_number(found.start) ? exact_endpoints(endpoints) : found;
}

}  // namespace srmp
