#include "srmp/planner/coupled_path.hpp"

#include <algorithm>

#include "srmp/trajectory/path.hpp"

namespace srmp {

double CoupledPath::length(std::size_t arm) const { return path_length(positions[arm]); }

double CoupledPath::length() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < positions.size(); ++i) sum += length(i);
  return sum;
}

CoupledPath coupled_path(const ArmWorld& world, const std::vector<multi::TimedPath>& paths) {
  CoupledPath coupled;
  std::vector<int> steps{0};
  for (const multi::TimedPath& path : paths)
    for (const multi::Move& move : path.moves) steps.push_back(move.start);
  std::sort(steps.begin(), steps.end());
  steps.erase(std::unique(steps.begin(), steps.end()), steps.end());
  coupled.steps.assign(steps.begin(), steps.end());
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const auto rows = static_cast<Eigen::Index>(steps.size());
    RowMatrix q;
    std::size_t at = 0;
    for (Eigen::Index row = 0; row < rows; ++row) {
      const int step = steps[static_cast<std::size_t>(row)];
      while (paths[i].moves[at].end <= step) ++at;
      const Eigen::VectorXd here = world.at(i, paths[i].moves[at], step);
      if (row == 0) q.resize(rows, here.size());
      q.row(row) = here.transpose();
      if (row > 0)
        q.row(row) = q.row(row - 1) + world.robot(i).difference(q.row(row - 1).transpose(), here).transpose();
    }
    coupled.positions.push_back(std::move(q));
  }
  return coupled;
}

namespace {

class Shortener {
 public:
  Shortener(CoupledPath& path, ArmWorld& world, const Deadline& deadline)
      : path_(path), world_(world), deadline_(deadline) {}

  void run() {
    for (int round = 0; round < 3 && !late(); ++round) {
      const double before = path_.length();
      straighten_all();
      if (path_.size() < 3) return;
      for (std::size_t arm = 0; arm < path_.positions.size(); ++arm) straighten(arm);
      drop_rows();
      if (path_.length() > 0.98 * before) return;
    }
  }

 private:
  bool late() const { return deadline_.stop_requested(); }

  Eigen::VectorXd at(std::size_t arm, std::size_t row) const {
    return path_.positions[arm].row(static_cast<Eigen::Index>(row)).transpose();
  }
  /// On the straight way between two rows.
  Eigen::VectorXd between(std::size_t arm, std::size_t a, std::size_t b, std::size_t row) const {
    const double share = (path_.steps[row] - path_.steps[a]) / (path_.steps[b] - path_.steps[a]);
    return at(arm, a) + share * (at(arm, b) - at(arm, a));
  }

  double length(std::size_t arm, std::size_t a, std::size_t b) const {
    double sum = 0.0;
    for (std::size_t row = a; row < b; ++row) sum += (at(arm, row + 1) - at(arm, row)).norm();
    return sum;
  }

  /// Is it worth asking, and free, for one arm to go straight between two rows?
  bool can_straighten(std::size_t arm, std::size_t a, std::size_t b) {
    if (late()) return false;
    const Eigen::VectorXd from = at(arm, a), to = at(arm, b);
    if (!short_way(arm, from, to) || !world_.is_free_alone(arm, from, to)) return false;
    for (std::size_t other = 0; other < path_.positions.size(); ++other) {
      if (other == arm || !world_.may_meet(arm, other)) continue;
      for (std::size_t row = a; row < b; ++row)
        if (!world_.are_apart(arm, between(arm, a, b, row), between(arm, a, b, row + 1), other, at(other, row),
                              at(other, row + 1)))
          return false;
    }
    return true;
  }

  /// Continuous joints that have been unwrapped by more than half a turn would go the other way round.
  bool short_way(std::size_t arm, const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
    return (world_.robot(arm).difference(from, to) - (to - from)).cwiseAbs().maxCoeff() < 1e-9;
  }

  /// From each row to the farthest that the arm can go straight to.
  void straighten(std::size_t arm) {
    const std::size_t last = path_.size() - 1;
    for (std::size_t a = 0; a < last && !late();) {
      std::size_t reached = a + 1, blocked = last + 1;
      if (a + 1 < last && worth(arm, a, last)) (can_straighten(arm, a, last) ? reached : blocked) = last;
      while (reached + 1 < blocked) {
        const std::size_t middle = reached + (blocked - reached) / 2;
        (can_straighten(arm, a, middle) ? reached : blocked) = middle;
      }
      for (std::size_t row = a + 1; row < reached; ++row) scratch_.push_back(between(arm, a, reached, row));
      for (std::size_t row = a + 1; row < reached; ++row)
        path_.positions[arm].row(static_cast<Eigen::Index>(row)) = scratch_[row - a - 1].transpose();
      scratch_.clear();
      a = reached;
    }
  }

  /// Is the part not straight and even already?
  bool worth(std::size_t arm, std::size_t a, std::size_t b) const {
    for (std::size_t row = a + 1; row < b; ++row)
      if ((at(arm, row) - between(arm, a, b, row)).cwiseAbs().maxCoeff() > 1e-9) return true;
    return false;
  }

  bool can_straighten_all(std::size_t a, std::size_t b) {
    for (std::size_t arm = 0; arm < path_.positions.size(); ++arm) {
      if (late()) return false;
      const Eigen::VectorXd from = at(arm, a), to = at(arm, b);
      if (!short_way(arm, from, to) || !world_.is_free_alone(arm, from, to)) return false;
    }
    for (std::size_t arm = 0; arm < path_.positions.size(); ++arm)
      for (std::size_t other = arm + 1; other < path_.positions.size(); ++other)
        if (!world_.are_apart(arm, at(arm, a), at(arm, b), other, at(other, a), at(other, b))) return false;
    return true;
  }

  /// Takes out the rows between those that all arms can go straight between.
  void straighten_all() {
    std::vector<std::size_t> kept{0};
    const std::size_t last = path_.size() - 1;
    for (std::size_t a = 0; a < last;) {
      std::size_t reached = a + 1, blocked = last + 1;
      if (a + 1 < last) (can_straighten_all(a, last) ? reached : blocked) = last;
      while (reached + 1 < blocked) {
        const std::size_t middle = reached + (blocked - reached) / 2;
        (can_straighten_all(a, middle) ? reached : blocked) = middle;
      }
      kept.push_back(reached);
      a = reached;
    }
    keep(kept);
  }

  /// Rows where no arm turns or changes its speed.
  void drop_rows() {
    std::vector<std::size_t> kept{0};
    for (std::size_t row = 1; row + 1 < path_.size(); ++row) {
      bool bend = false;
      for (std::size_t arm = 0; arm < path_.positions.size() && !bend; ++arm)
        bend = (at(arm, row) - between(arm, kept.back(), row + 1, row)).cwiseAbs().maxCoeff() > 1e-12;
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

  CoupledPath& path_;
  ArmWorld& world_;
  const Deadline& deadline_;
  std::vector<Eigen::VectorXd> scratch_;
};

}  // namespace

CoupledPath shortened(CoupledPath path, ArmWorld& world, const Deadline& deadline) {
  if (path.size() > 2) Shortener(path, world, deadline).run();
  return path;
}

}  // namespace srmp
