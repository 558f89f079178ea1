#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "srmp/collision/checker.hpp"
#include "srmp/core/deadline.hpp"
#include "srmp/trajectory/prove_collision_free.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace srmp {

inline constexpr double time_step = 0.05;  ///< [s] in which motions among others are searched for and looked at

/// When the robot is at rest for good [s]; 0 without times.
double arrival(const Trajectory& trajectory);

/// A robot that stays: the same row again and again, from time 0 to `duration` [s].
Trajectory rest(const std::vector<std::string>& joints, const RowMatrix& rows, double duration);

/// The motion, begun after `delay` [s]; until then it rests.
Trajectory delayed(const Trajectory& motion, double delay);

/// A robot that moves as is known; before and after it rests.
struct MovingRobot {
  const Checker* pair;       ///< quick: of the arm and this robot, and of nothing else
  const Checker* judge;      ///< the same by Coal alone
  bool stands_before_arm;    ///< its joints, in the configurations of both
  const Trajectory* motion;  ///< begins at time 0
};

/// When an arm touches another robot, or cannot be proved apart from it.
struct Meeting {
  double from{}, to{};         ///< [s]; of a touch an instant, until `extended`
  std::size_t other{};         ///< which of the others
  std::string body_a, body_b;  ///< as their judge names them
  bool touch{};
};

/// Holds motions of an arm against others, which are known. Counts its work, so that who has a budget can stop at the
/// same place each time; once the deadline passes, nothing is proved.
class Watch {
 public:
  /// References outlive this.
  Watch(const std::vector<MovingRobot>& others, const Deadline& deadline);

  /// A touch in [from, to], looked for every 50 ms: quicker to find one than a proof.
  std::optional<Meeting> look(const Trajectory& motion, double from, double to);
  /// None: the two are proved apart, between rows too, by Coal alone.
  std::optional<Meeting> prove(const Trajectory& motion);
  /// Looks until all are at rest, and proves where nothing was seen.
  std::optional<Meeting> find(const Trajectory& motion);
  /// The whole time, about this instant, during which the two touch.
  Meeting extended(const Trajectory& motion, Meeting touch);

  std::uint64_t looks() const { return looks_; }  ///< at configurations; a proof counts as 500

 private:
  bool is_free(const Trajectory& motion, std::size_t other, double time);
  Eigen::VectorXd both(const Trajectory& motion, std::size_t other, double time) const;
  double end(const Trajectory& motion, std::size_t other) const;

  const std::vector<MovingRobot>& others_;
  const Deadline& deadline_;
  std::vector<Checker::WorkspacePtr> workspaces_;  // of the judges
  std::uint64_t looks_{};
};

}  // namespace srmp
