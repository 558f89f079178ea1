#include "srmp/planning/smoothing/joint_shortcut.hpp"

#include <algorithm>

#include "srmp/trajectory/path.hpp"
#include "srmp/trajectory/skip_waypoints.hpp"

namespace srmp {

namespace {

class JointShortcutter {
 public:
  JointShortcutter(JointPath& path, MultiRobotWorld& world, const Deadline& deadline,
                   const JointShortcutOptions& options)
      : path_(path), world_(world), deadline_(deadline), options_(options) {}

  void tighten() {
    for (std::size_t robot = 0; robot < path_.positions.size(); ++robot) tighten(robot);
  }

  void run() {
    for (int round = 0; round < options_.max_rounds && !stopped(); ++round) {
      const double before = path_.length();
      straighten_all();
      if (path_.size() < 3) return;
      for (std::size_t robot = 0; robot < path_.positions.size(); ++robot) straighten(robot);
      drop_rows();
      if (path_.length() > (1.0 - options_.min_gain) * before) return;
    }
  }

 private:
  struct Collision {
    std::size_t robot, other, row;
  };

  std::size_t number(std::size_t robot) const { return path_.robots[robot]; }
  bool stopped() const { return deadline_.stop_requested(); }

  Eigen::VectorXd at(std::size_t robot, std::size_t row) const {
    return path_.positions[robot].row(static_cast<Eigen::Index>(row)).transpose();
  }
  /// On the straight motion between two rows.
  Eigen::VectorXd between(std::size_t robot, std::size_t a, std::size_t b, std::size_t row) const {
    const double fraction = (path_.steps[row] - path_.steps[a]) / (path_.steps[b] - path_.steps[a]);
    return at(robot, a) + fraction * (at(robot, b) - at(robot, a));
  }

  /// Is it short enough to be tried, and free, for one robot to go straight between two rows?
  bool can_straighten(std::size_t robot, std::size_t a, std::size_t b) {
    if (stopped()) return false;
    const Eigen::VectorXd from = at(robot, a), to = at(robot, b);
    if (!short_way(robot, from, to) || !world_.is_free_for_one(number(robot), from, to)) return false;
    return is_free_of_others(robot, a, b, [&](std::size_t row) { return between(robot, a, b, row); });
  }

  /// Does the robot collide with none of the others as they move, when it is at `place(row)` in each row?
  template <class Place>
  bool is_free_of_others(std::size_t robot, std::size_t a, std::size_t b, Place&& place) {
    const auto is_free_of = [&](std::size_t other, std::size_t row) {
      return world_.are_collision_free(number(robot), place(row), place(row + 1), number(other), at(other, row),
                                       at(other, row + 1), {.start_is_free = true});
    };
    const Collision& last = last_collision_;  // a motion that differs little collides there too
    if (last.robot == robot && a <= last.row && last.row < b && !is_free_of(last.other, last.row)) return false;
    for (std::size_t other = 0; other < path_.positions.size(); ++other) {
      if (other == robot || !world_.may_conflict(number(robot), number(other))) continue;
      for (std::size_t row = a; row < b; ++row) {
        if (is_free_of(other, row)) continue;
        last_collision_ = {robot, other, row};
        return false;
      }
    }
    return true;
  }

  /// Continuous joints that have been unwrapped by more than half a turn would go the other way round.
  bool short_way(std::size_t robot, const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
    return (world_.model(number(robot)).difference(from, to) - (to - from)).cwiseAbs().maxCoeff() < 1e-9;
  }

  /// From each row to the farthest that the robot can go straight to.
  void straighten(std::size_t robot) {
    const std::size_t last = path_.size() - 1;
    for (std::size_t a = 0; a < last && !stopped();) {
      const std::size_t reached = farthest_waypoint(a, last, [&](std::size_t b) { return can_straighten(robot, a, b); },
                                                    {.last_first = !is_straight(robot, a, last)});
      for (std::size_t row = a + 1; row < reached; ++row) scratch_.push_back(between(robot, a, reached, row));
      for (std::size_t row = a + 1; row < reached; ++row)
        path_.positions[robot].row(static_cast<Eigen::Index>(row)) = scratch_[row - a - 1].transpose();
      scratch_.clear();
      a = reached;
    }
  }

  void tighten(std::size_t robot) {
    const std::size_t last = path_.size() - 1;
    for (std::size_t part = last; part >= 2; part = part > 2 ? (part + 1) / 2 : 1)
      for (std::size_t a = 0; a < last && !stopped(); a += part / 2) tighten(robot, a, std::min(a + part, last));
  }

  /// By bisection, if there is much to gain.
  void tighten(std::size_t robot, std::size_t a, std::size_t b) {
    if (b < a + 2) return;
    RowMatrix& rows = path_.positions[robot];
    const auto first = static_cast<Eigen::Index>(a + 1), count = static_cast<Eigen::Index>(b - a - 1);
    const RowMatrix bent = rows.middleRows(first, count);
    if (path_length(rows.middleRows(first - 1, count + 2)) - (at(robot, b) - at(robot, a)).norm() < options_.min_detour)
      return;
    RowMatrix straight = bent;
    for (std::size_t row = a + 1; row < b; ++row)
      straight.row(static_cast<Eigen::Index>(row - a - 1)) = between(robot, a, b, row).transpose();
    RowMatrix best = bent;
    double left = 1.0;
    for (const double less : {0.5, 0.25, 0.125}) {
      rows.middleRows(first, count) = straight + (left - less) * (bent - straight);
      if (!is_free(robot, a, b)) continue;
      best = rows.middleRows(first, count);
      left -= less;
    }
    rows.middleRows(first, count) = best;
  }

  bool is_free(std::size_t robot, std::size_t a, std::size_t b) {
    for (std::size_t row = a; row < b; ++row)
      if (stopped() || !world_.is_free_for_one(number(robot), at(robot, row), at(robot, row + 1))) return false;
    return is_free_of_others(robot, a, b, [&](std::size_t row) { return at(robot, row); });
  }

  /// Is the part straight and even already?
  bool is_straight(std::size_t robot, std::size_t a, std::size_t b) const {
    for (std::size_t row = a + 1; row < b; ++row)
      if ((at(robot, row) - between(robot, a, b, row)).cwiseAbs().maxCoeff() > 1e-9) return false;
    return true;
  }

  bool can_straighten_all(std::size_t a, std::size_t b) {
    for (std::size_t robot = 0; robot < path_.positions.size(); ++robot) {
      if (stopped()) return false;
      const Eigen::VectorXd from = at(robot, a), to = at(robot, b);
      if (!short_way(robot, from, to) || !world_.is_free_for_one(number(robot), from, to)) return false;
    }
    for (std::size_t robot = 0; robot < path_.positions.size(); ++robot)
      for (std::size_t other = robot + 1; other < path_.positions.size(); ++other)
        if (!world_.are_collision_free(number(robot), at(robot, a), at(robot, b), number(other), at(other, a),
                                       at(other, b), {.start_is_free = true}))
          return false;
    return true;
  }

  /// Takes out the rows between those that all robots can go straight between.
  void straighten_all() {
    keep(skip_waypoints(path_.size() - 1, [&](std::size_t a, std::size_t b) { return can_straighten_all(a, b); }));
  }

  /// Rows where no robot turns or changes its speed.
  void drop_rows() {
    std::vector<std::size_t> kept{0};
    for (std::size_t row = 1; row + 1 < path_.size(); ++row) {
      bool bend = false;
      for (std::size_t robot = 0; robot < path_.positions.size() && !bend; ++robot)
        bend = (at(robot, row) - between(robot, kept.back(), row + 1, row)).cwiseAbs().maxCoeff() > 1e-12;
      if (bend) kept.push_back(row);
    }
    kept.push_back(path_.size() - 1);
    keep(kept);
  }

  void keep(const std::vector<std::size_t>& rows) {
    std::vector<double> steps;
    for (const std::size_t row : rows) steps.push_back(path_.steps[row]);
    for (RowMatrix& q : path_.positions) {
      RowMatrix kept(static_cast<Eigen::Index>(rows.size()), q.cols());
      for (std::size_t i = 0; i < rows.size(); ++i)
        kept.row(static_cast<Eigen::Index>(i)) = q.row(static_cast<Eigen::Index>(rows[i]));
      q = std::move(kept);
    }
    path_.steps = std::move(steps);
  }

  JointPath& path_;
  MultiRobotWorld& world_;
  const Deadline& deadline_;
  const JointShortcutOptions options_;
  std::vector<Eigen::VectorXd> scratch_;
  Collision last_collision_{path_.robots.size(), 0, 0};  // of no robot yet
};

}  // namespace

JointPath shortened(JointPath path, MultiRobotWorld& world, const Deadline& deadline,
                    const JointShortcutOptions& options) {
  if (path.size() > 2) JointShortcutter(path, world, deadline, options).run();
  return path;
}

JointPath tightened(JointPath path, MultiRobotWorld& world, const Deadline& deadline,
                    const JointShortcutOptions& options) {
  if (path.size() > 2) JointShortcutter(path, world, deadline, options).tighten();
  return path;
}

}  // namespace srmp
