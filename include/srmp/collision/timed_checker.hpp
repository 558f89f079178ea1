#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "srmp/collision/checker.hpp"

namespace srmp {

/// Where a robot is at each time: straight motions between configurations (continuous joints go the short way); it is
/// stationary before the first and after the last.
struct TimedPath {
  std::vector<double> times;                    ///< [s], each after the one before
  std::vector<Eigen::VectorXd> configurations;  ///< as many, each (dof,) [rad or m]
};

/// Collision checking of one robot among others whose motions are known. Const, like Checker; the workspaces are
/// checker()'s. Motions are proved free between samples as Checker::is_motion_free proves them, all robots moving
/// simultaneously. Continuous joints go the short way.
class TimedChecker {
 public:
  /// `others`: by robot name; robots not named stand still. `factory`: makes checker(). Throws InvalidArgument for
  /// unknown robots, times that do not increase, and configurations of the wrong size or with NaN.
  TimedChecker(const Scene& scene, const std::string& robot, std::map<std::string, TimedPath> others,
               const CheckerOptions& options = {}, const CheckerFactory& factory = make_checker);

  /// Of all robots together: the robot's joints first, then those of the others in the order of their names.
  const Checker& checker() const { return *checker_; }
  std::size_t dof() const { return checker_->robot().dof(); }  ///< of the robot alone
  /// A configuration of checker(): the robot at q (dof() entries), the others where they are at `time` [s].
  Eigen::VectorXd at(ConstVector q, double time) const;

  // All of these throw InvalidArgument unless configurations have dof() finite entries, times are finite, and the
  // workspace is one of checker().

  /// Returns whether the robot at q (dof,) [rad or m] touches nothing at `time` [s].
  bool is_free(ConstVector q, double time, Checker::Workspace& workspace) const;
  /// The straight motion from a at time `from` to b at time `to` [s], at constant speed. Throws InvalidArgument unless
  /// from <= to.
  bool is_motion_free(ConstVector a, ConstVector b, double from, double to, Checker::Workspace& workspace) const;
  /// Checker::certify_motion of that motion.
  MotionCertificate certify_motion(ConstVector a, ConstVector b, double from, double to,
                                   Checker::Workspace& workspace) const;
  /// Checker::nearest at that time.
  std::optional<Contact> nearest(ConstVector q, double time, Checker::Workspace& workspace) const;

 private:
  struct Other {
    std::shared_ptr<const RobotModel> model;
    TimedPath path;
    Eigen::VectorXd at(double time) const;
  };
  /// Calls part(a, b, from, to) for the parts of a motion during which every robot moves straight: a and b are
  /// configurations of checker(), from and to fractions of the motion in [0, 1]. Stops when one returns false.
  template <class Part>
  void for_each_straight_part(ConstVector a, ConstVector b, double from, double to, Part&& part) const;

  std::vector<Other> others_;
  std::unique_ptr<const Checker> checker_;
};

}  // namespace srmp
