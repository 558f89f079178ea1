#pragma once

#include <map>
#include <string>
#include <vector>

#include "srmp/collision/checker.hpp"

namespace srmp {

/// Where a robot is at each time: straight motions between configurations (continuous joints the short way), at rest
/// before the first and after the last.
struct TimedPath {
  std::vector<double> times;                    ///< [s], each after the one before
  std::vector<Eigen::VectorXd> configurations;  ///< as many, each (dof,) [rad or m]
};

/// Collision checking of one robot among others whose motions are known. Const, like Checker; the workspaces are
/// checker()'s. Motions are proved free between samples as Checker::is_motion_free proves them, everything in motion at
/// once.
class TimedChecker {
 public:
  /// `others`: by robot name; robots not named stand still. Throws InvalidArgument for unknown robots, times that do
  /// not grow, and configurations of the wrong size or with NaN.
  TimedChecker(const Scene& scene, const std::string& robot, std::map<std::string, TimedPath> others,
               const CheckerOptions& options = {});

  const Checker& checker() const { return checker_; }
  std::size_t dof() const { return checker_.robot().dof(); }  ///< of the robot alone
  /// A configuration of checker(): the robot at q, the others where they are at `time`.
  Eigen::VectorXd at(ConstVector q, double time) const;

  bool is_free(ConstVector q, double time, Checker::Workspace& workspace) const;
  /// The straight motion from a at time `from` to b at time `to` [s], from <= to, at constant speed.
  bool is_motion_free(ConstVector a, ConstVector b, double from, double to, Checker::Workspace& workspace) const;
  MotionCertificate certify_motion(ConstVector a, ConstVector b, double from, double to,
                                   Checker::Workspace& workspace) const;
  std::optional<Contact> nearest(ConstVector q, double time, Checker::Workspace& workspace) const;

 private:
  struct Other {
    std::shared_ptr<const RobotModel> model;
    TimedPath path;
    Eigen::VectorXd at(double time) const;
  };
  /// Calls part(a, b, from, to) for the parts of a motion during which every robot moves straight, shares of it as from
  /// and to; a and b are checker()'s configurations. Stops when one returns false.
  template <class Part>
  void for_each_straight_part(ConstVector a, ConstVector b, double from, double to, Part&& part) const;

  std::vector<Other> others_;
  Checker checker_;
};

}  // namespace srmp
