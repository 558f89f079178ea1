#include "srmp/planning/strategies/robot_sampling.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>

#include "srmp/search/graph.hpp"

namespace srmp {

namespace {

/// A box of configurations.
struct Region {
  Eigen::VectorXd lower, upper;

  void include(const Eigen::VectorXd& q) {
    lower = lower.cwiseMin(q);
    upper = upper.cwiseMax(q);
  }
};

Region joint_limits(const RobotModel& robot) {
  Region limits{Eigen::VectorXd(robot.dof()), Eigen::VectorXd(robot.dof())};
  for (std::size_t i = 0; i < robot.dof(); ++i) {
    limits.lower[static_cast<Eigen::Index>(i)] = robot.joints()[i].lower;
    limits.upper[static_cast<Eigen::Index>(i)] = robot.joints()[i].upper;
  }
  return limits;
}

/// Of the region, wider by `margin` on each side, within the limits.
Eigen::VectorXd sample(const Region& region, double margin, const Region& limits, search::RandomSequence& random) {
  Eigen::VectorXd q(region.lower.size());
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    const double lower = std::max(limits.lower[k], region.lower[k] - margin);
    const double upper = std::min(limits.upper[k], region.upper[k] + margin);
    q[k] = lower + (upper - lower) * random.next();
  }
  return q;
}

/// RrtSpace::sample of rrt_space.
class Samples {
 public:
  Samples(const RobotModel& robot, const search::RrtSpace& space, const RobotSamplingOptions& options)
      : options_(options), start_(space.starts.front()), limits_(joint_limits(robot)), around_{start_, start_} {
    for (Eigen::VectorXd end : space.goals) {
      motions_.push_back(robot.difference(start_, end));
      for (Eigen::Index k = 0; k < end.size(); ++k)
        if (space.wraps[static_cast<std::size_t>(k)]) end[k] = start_[k] + motions_.back()[k];
      around_.include(end);
    }
  }

  Eigen::VectorXd operator()(search::RandomSequence& random) {
    Eigen::VectorXd q = draw(random);
    for (int draws = 1; !is_on_short_path(q) && draws < options_.informed_draws; ++draws) q = draw(random);
    ++taken_;
    return q;
  }

 private:
  Eigen::VectorXd draw(search::RandomSequence& random) {
    const bool far = random.next() < options_.far_fraction;
    const Eigen::VectorXd q = sample(around_, far ? options_.far_margin : near_margin(), limits_, random);
    if (taken_ >= options_.direct_samples || motions_.empty()) return q;
    const auto number = static_cast<std::size_t>(random.next() * static_cast<double>(motions_.size()));
    const Eigen::VectorXd between = start_ + random.next() * motions_[number];
    return between + options_.direct_distance * (q - between);
  }

  double near_margin() const {
    const double grown = std::min(1.0, static_cast<double>(taken_) / static_cast<double>(options_.growing_samples));
    return options_.first_margin + grown * (options_.near_margin - options_.first_margin);
  }

  /// Is there a goal to which a path through q may be no longer than max_length?
  bool is_on_short_path(const Eigen::VectorXd& q) const {
    if (options_.max_length == search::infinity || motions_.empty()) return true;
    const Eigen::VectorXd from_start = q - start_;
    return std::ranges::any_of(motions_, [&](const Eigen::VectorXd& motion) {
      return from_start.norm() + (motion - from_start).norm() <= options_.max_length;
    });
  }

  RobotSamplingOptions options_;
  Eigen::VectorXd start_;
  Region limits_, around_;                // the straight motions
  std::vector<Eigen::VectorXd> motions_;  // to the goals
  std::size_t taken_{};
};

/// RrtSpace::advance of add_tool_directions.
class ToolDirections {
 public:
  ToolDirections(const RobotModel& robot, ConstVector other_positions, double step, double max_change)
      : robot_(robot),
        data_(robot.make_data(other_positions).release(), RobotDataDeleter{}),
        step_(step),
        max_change_(max_change),
        jacobian_(6, static_cast<Eigen::Index>(robot.dof())) {
    for (const std::string& link : robot.end_links()) links_.push_back(robot.link_index(link));
  }

  static constexpr std::size_t per_link = 6;
  std::size_t size() const { return per_link * links_.size(); }

  /// False where the joints cannot do it, or end.
  bool operator()(Eigen::VectorXd& q, std::size_t direction) {
    robot_.forward(*data_, q);
    const std::size_t link = links_[direction / per_link], axis = direction % per_link / 2;
    robot_.jacobian(*data_, link, jacobian_);
    const Eigen::Matrix3d axes = robot_.link_pose(*data_, link).linear();
    Eigen::Vector<double, 6> twist = Eigen::Vector<double, 6>::Zero();
    twist.head<3>() = (direction % 2 == 0 ? -step_ : step_) * axes.col(static_cast<Eigen::Index>(axis));
    Eigen::Matrix<double, 6, 6> normal = jacobian_ * jacobian_.transpose();
    normal.diagonal().array() += damping;
    const Eigen::VectorXd change = jacobian_.transpose() * normal.ldlt().solve(twist);
    const bool moves = (jacobian_.topRows<3>() * change).dot(twist.head<3>()) > 0.5 * step_ * step_;
    if (!moves || change.norm() > max_change_) return false;
    q += change;
    return !robot_.limit_violation(q);
  }

 private:
  static constexpr double damping = 1e-4;

  const RobotModel& robot_;
  std::shared_ptr<RobotData> data_;
  double step_;
  double max_change_;  // over all joints
  Eigen::MatrixXd jacobian_;
  std::vector<std::size_t> links_;
};

}  // namespace

search::RrtSpace rrt_space(const RobotModel& robot, const Eigen::VectorXd& start, std::vector<Eigen::VectorXd> goals,
                           const RobotSamplingOptions& options) {
  search::RrtSpace space;
  space.starts = {start};
  space.goals = std::move(goals);
  space.max_step = options.max_step;
  for (const Joint& joint : robot.joints()) space.wraps.push_back(joint.kind == JointKind::continuous);
  space.sample = Samples(robot, space, options);
  return space;
}

void add_tool_directions(search::RrtSpace& space, const RobotModel& robot, ConstVector other_positions, double step) {
  ToolDirections directions(robot, other_positions, step, space.max_step);
  space.directions = directions.size();
  space.advance = std::move(directions);
}

}  // namespace srmp
