#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "srmp/io/moveit_frames.h"
#include "srmp/moveit_session.hpp"
#include "srmp/planner_interface.hpp"
#include "srmp/robot/srdf.hpp"
#include "srmp/robot/urdf.hpp"

namespace srmp {

/// A request that is refused, with MoveIt's error code. The text is a sentence.
class MoveItRefusal : public Error {
 public:
  MoveItRefusal(MoveItErrorCode code, const std::string& sentence) : Error(sentence), code(code) {}
  MoveItErrorCode code;  ///< never success
};

/// Runs `convert`; what it refuses is refused with the code `invalid` where it is wrong, and `unsupported` where it is
/// not supported. The sentence begins with `what`.
template <class Convert>
auto refused_with(MoveItErrorCode invalid, MoveItErrorCode unsupported, const std::string& what, Convert&& convert) {
  try {
    return convert();
  } catch (const InvalidArgument& error) {
    throw MoveItRefusal(invalid, what + error.what());
  } catch (const NotSupported& error) {
    throw MoveItRefusal(unsupported, what + error.what());
  }
}

/// MoveIt's robot model, read once: what requests name in it.
struct MoveItModel {
  explicit MoveItModel(MoveItRobot robot);

  /// Throws MoveItRefusal, with the nearest name, for a group that does not exist or cannot be used.
  const SrdfGroup& group(const std::string& name) const;
  /// The link for whose poses a group plans: `link` where that is not rigidly joined to the group's last link, but
  /// moves with the group.
  std::string end_effector(const SrdfGroup& group, const std::string& link) const;
  /// The names of the group's joints.
  std::vector<std::string> joints_of(const SrdfGroup& group) const;
  /// For each of these groups, the links that its joints move.
  std::map<std::string, std::set<std::string>> moved_links(const std::vector<std::string>& groups) const;
  /// No link is moved by two of these groups, which can be planned as robots of their own.
  bool move_apart(const std::vector<std::string>& groups) const;
  /// The movable joints between the root and a link.
  std::vector<std::size_t> support(const std::string& link) const;

  MoveItRobot robot;
  std::string urdf_text;  ///< with the limits of robot.bounds
  Urdf urdf;
  Srdf srdf;
};

/// One planning group in its scene: a robot whose planned joints are the group's, or, for a group of several arms, a
/// robot for each.
class MoveItGroup {
 public:
  /// `arms`: names of the groups that become robots of their own; empty: the whole group is one robot. Throws FileError
  /// and InvalidArgument for a robot that cannot be loaded.
  MoveItGroup(const MoveItModel& model, const SrdfGroup& group, const std::string& end_effector,
              const std::vector<std::string>& arms);

  /// Brings the scene up to date. Returns what had no effect, as sentences. Throws MoveItRefusal, and then the scene
  /// stays.
  std::vector<std::string> update(const io::SceneFile& target);
  /// Plans; throws MoveItRefusal, PlanningError and InvalidArgument.
  Trajectory plan(const io::RequestFile& request, const OptionMap& options, const PlannerInterface::Interrupt& stop);
  /// Of the last plan.
  const PlanStatistics& statistics() const { return planner_.get_planning_stats(); }
  /// Which code says why the last plan had no trajectory.
  MoveItErrorCode code_of(const PlanningError& error) const;

 private:
  struct Arm {
    std::string robot;                          ///< its name in the planner
    Eigen::VectorXd start{};                    ///< of the last request
    std::vector<GoalConstraint> goals{};        ///< of the last request
    std::vector<PathConstraint> constraints{};  ///< of the last request
  };

  void add_robot(const MoveItModel& model, RobotDescription description);
  void allow_between(const MoveItModel& model);
  std::vector<std::string> planned_joints() const;
  void place_arms(const io::SceneFile& target, Scene& scene) const;
  Eigen::VectorXd start_of(const std::string& robot) const;
  io::RequestFile part_of(const io::RequestFile& request, const Arm& arm, const io::FrameLookup& frames) const;
  void read_goals(const io::RequestFile& request);
  void read_path_constraints(const io::RequestFile& request, const io::FrameLookup& frames, Arm& arm) const;
  Eigen::VectorXd start_velocity_of(const io::RequestFile& request) const;
  Trajectory plan_one(const io::RequestFile& request, const PlannerInterface::Interrupt& stop);
  bool breaks_path_constraints(const Arm& arm, const Eigen::VectorXd& q) const;
  MoveItErrorCode goal_failure_at(const Arm& arm, const Eigen::VectorXd& q) const;
  void limit_speed(const io::RequestFile& request);
  MoveItErrorCode goal_failure(const Arm& arm) const;

  PlannerInterface planner_;
  std::vector<Arm> arms_;                                        ///< at least one
  io::SceneFile held_;                                           ///< what the scene was made of
  std::vector<std::string> notes_;                               ///< what of it had no effect
  bool in_motion_{false};                                        ///< the last request's start
  std::map<std::pair<std::string, std::string>, bool> between_;  ///< contact that the SRDF allows between arms
};

}  // namespace srmp
