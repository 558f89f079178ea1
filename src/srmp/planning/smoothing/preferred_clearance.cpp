#include "srmp/planning/smoothing/preferred_clearance.hpp"

#include <array>

#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

/// Of PreferredClearance: finer levels and more halvings keep more of the clearance and check more motions.
struct PreferredClearanceOptions {
  std::array<double, 4> level_fractions{1.0, 0.5, 0.25, 0.125};  ///< of the preferred clearance
  int max_halvings{4};  ///< of a segment, until its parts keep a level or count as a part that does not
};
const PreferredClearanceOptions tuning;

/// Shortens a path by steps that keep a level, which take no clearance from whatever they replace, and then the parts
/// of it that do not keep the level by steps that keep the next one.
class LevelledShortcut {
 public:
  LevelledShortcut(PreferredClearance& preferred, const MotionFree& is_free, bool constrained, const Deadline& deadline,
                   const ShortcutOptions& options)
      : preferred_(preferred), is_free_(is_free), constrained_(constrained), deadline_(deadline), options_(options) {}

  RowMatrix run(const RowMatrix& path, std::size_t level) {
    if (level == preferred_.size() || path.rows() < 2) return shortcut(path, is_free_, deadline_, options_).waypoints;
    const MotionFree keeps = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
      return preferred_.keeps(level, a, b) && (!constrained_ || is_free_(a, b));
    };
    const RowMatrix first = shortcut(path, keeps, deadline_, options_).waypoints;
    const std::vector<Part> parts = parts_of(first, level);
    if (parts.size() == 1 && parts.front().kept) return first;
    RowMatrix result = first.topRows(1);
    for (const Part& part : parts) {
      const RowMatrix shorter =
          part.kept ? shortcut(part.path, keeps, deadline_, options_).waypoints : run(part.path, level + 1);
      const Eigen::Index before = result.rows();
      result.conservativeResize(before + shorter.rows() - 1, Eigen::NoChange);
      result.bottomRows(shorter.rows() - 1) = shorter.bottomRows(shorter.rows() - 1);
    }
    return unwrap_waypoints(result, options_.continuous);  // a part may go the other way round than before
  }

 private:
  /// Segments in a row that keep a level, or do not.
  struct Part {
    bool kept;
    RowMatrix path;
  };

  std::vector<Part> parts_of(const RowMatrix& path, std::size_t level) {
    std::vector<Part> parts;
    for (Eigen::Index i = 0; i + 1 < path.rows(); ++i) {
      begins_segment_ = true;
      split(path.row(i).transpose(), path.row(i + 1).transpose(), level, tuning.max_halvings, parts);
    }
    return parts;
  }

  void split(const Eigen::VectorXd& from, const Eigen::VectorXd& to, std::size_t level, int halvings,
             std::vector<Part>& parts) {
    const bool kept = preferred_.keeps(level, from, to);
    if (kept || halvings == 0) return add(kept, from, to, parts);
    const Eigen::VectorXd middle = 0.5 * (from + to);
    split(from, middle, level, halvings - 1, parts);
    split(middle, to, level, halvings - 1, parts);
  }

  /// Halves of one segment that both keep the level, or both do not, are one segment again.
  void add(bool kept, const Eigen::VectorXd& from, const Eigen::VectorXd& to, std::vector<Part>& parts) {
    const bool same = !parts.empty() && parts.back().kept == kept;
    if (!same) parts.push_back({kept, from.transpose()});
    RowMatrix& path = parts.back().path;
    if (!same || begins_segment_) path.conservativeResize(path.rows() + 1, Eigen::NoChange);
    path.bottomRows(1) = to.transpose();
    begins_segment_ = false;
  }

  PreferredClearance& preferred_;
  const MotionFree& is_free_;
  const bool constrained_;
  const Deadline& deadline_;
  const ShortcutOptions& options_;
  bool begins_segment_{true};
};

}  // namespace

PreferredClearance::PreferredClearance(const ProblemCheckers& checkers, const CommonOptions& options,
                                       const Deadline& deadline)
    : checkers_(checkers), deadline_(deadline) {
  for (const double fraction : tuning.level_fractions)
    if (const double clearance = fraction * options.preferred_clearance; clearance > options.clearance)
      levels_.push_back({clearance});
}

bool PreferredClearance::keeps(std::size_t level, const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  Level& at = levels_[level];
  if (!at.checker) {
    at.checker = &checkers_.with_clearance(at.clearance);
    at.workspace = at.checker->make_workspace();
    at.checker->stop_at(deadline_, *at.workspace);
  }
  return at.checker->is_motion_free(from, to, *at.workspace);
}

std::size_t PreferredClearance::level_of(const Eigen::VectorXd& from, const Eigen::VectorXd& to) {
  std::size_t level = 0;
  while (level < size() && !keeps(level, from, to)) ++level;
  return level;
}

RowMatrix shortcut_keeping_clearance(const RowMatrix& path, PreferredClearance& preferred, const MotionFree& is_free,
                                     bool constrained, const Deadline& deadline, const ShortcutOptions& options) {
  return LevelledShortcut(preferred, is_free, constrained, deadline, options).run(path, 0);
}

}  // namespace srmp
