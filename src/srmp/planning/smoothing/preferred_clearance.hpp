#pragma once

#include <vector>

#include "srmp/planning/problem.hpp"
#include "srmp/trajectory/shortcut.hpp"

namespace srmp {

/// Levels of clearance of one robot, which shortening and rounding its path should not give away: the preferred
/// clearance (CommonOptions::preferred_clearance), a half, a quarter and an eighth of it, as far as they are above the
/// clearance that is required. Level 0 is the highest; level size() is what the problem's own checkers require.
class PreferredClearance {
 public:
  /// References outlive it. Checks throw MotionCheckStopped as Checker::stop_at says.
  PreferredClearance(const ProblemCheckers& checkers, const CommonOptions& options, const Deadline& deadline);

  std::size_t size() const { return levels_.size(); }
  /// Does the straight motion keep the clearance of a level below size()?
  bool keeps(std::size_t level, const Eigen::VectorXd& from, const Eigen::VectorXd& to);
  /// The highest level of which that is proved; the motion keeps the required clearance.
  std::size_t level_of(const Eigen::VectorXd& from, const Eigen::VectorXd& to);

 private:
  struct Level {
    double clearance{};                 // [m]
    const Checker* checker{};           // null: not needed yet
    Checker::WorkspacePtr workspace{};  // of the checker
  };

  const ProblemCheckers& checkers_;
  const Deadline& deadline_;
  std::vector<Level> levels_;
};

/// `shortcut`, each of whose steps keeps at least the highest level that all of what it replaces kept. `is_free`: of
/// the required clearance and of path constraints, one of which there is if `constrained`.
RowMatrix shortcut_keeping_clearance(const RowMatrix& path, PreferredClearance& preferred, const MotionFree& is_free,
                                     bool constrained, const Deadline& deadline, const ShortcutOptions& options);

}  // namespace srmp
