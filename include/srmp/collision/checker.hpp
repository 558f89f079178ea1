#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/core/placed_sphere.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

class CoverStore;
class PairTableStore;

enum class BodyKind { link, object, attached_object };

/// Two bodies in contact, or the nearest two.
struct Contact {
  std::string body_a;       ///< "link" of the planned robot, or an object attached to it
  std::string body_b;       ///< object, link of the same robot, or "robot/link" of another
  double distance{};        ///< [m], less the padding; negative: how deep the two, with their padding, overlap
  Eigen::Vector3d point_a;  ///< on body_a, world frame [m]
  Eigen::Vector3d point_b;  ///< on body_b, world frame [m]
  double padding{};         ///< of the pair [m]
  BodyKind kind_a{};
  BodyKind kind_b{};

  /// "link 'panda_link5' and object 'shelf' overlap by 12.3 mm".
  std::string describe() const;
};

/// How motions are decided.
enum class CheckMode {
  exact,         ///< spheres around and inside the bodies answer most of it, 16 configurations at a time; Coal the rest
  conservative,  ///< spheres alone: never free wrongly, but what they cannot prove counts as not free
  coal,          ///< Coal alone
};

struct CheckerOptions {
  CheckMode mode{CheckMode::exact};
  std::shared_ptr<CoverStore> covers{};        ///< where spheres are looked up; nullptr: a store of the checker's own
  std::vector<std::string> other_robots{};     ///< other robots that move too
  std::vector<std::string> excluded_robots{};  ///< robots left out, with all that they hold
  bool other_robots_only{};  ///< only what the robot and its companions do to each other is a collision
  /// Where tables of pairs of links are looked up (not by CheckMode::coal); nullptr: nowhere.
  std::shared_ptr<PairTableStore> pair_tables{};
};

/// What a thread's checks did so far.
struct CheckStatistics {
  std::uint64_t configurations{};      ///< kinematics computed, one at a time
  std::uint64_t states{};              ///< configurations asked about
  std::uint64_t motions{};             ///< is_motion_free calls
  std::uint64_t states_by_spheres{};   ///< of the states, decided by spheres alone (are_free)
  std::uint64_t motions_by_spheres{};  ///< of the motions, decided by spheres alone
  std::uint64_t blocks{};              ///< of 16 configurations under spheres
  std::uint64_t undecided{};           ///< pairs, over a part of a motion, that spheres left to Coal
  std::uint64_t by_tables{};           ///< of those, decided by the pair's table
  std::uint64_t narrow_phase{};        ///< pairs that Coal decided
};

/// Proof that a motion is free, or a contact on it, or the first part of it that could not be proved.
struct MotionCertificate {
  bool proved{};
  double from{}, to{};         ///< part of the motion, 0..1, that could not be proved; from = to: a contact there
  std::string body_a, body_b;  ///< the pair there, named as in Contact
};

/// See Checker::stop_at.
struct MotionCheckStopped : std::exception {
  const char* what() const noexcept override { return "the deadline passed during a check of a motion"; }
};

/// How Checker::are_free decides.
struct StateQuery {
  /// What spheres cannot prove free counts as not free, as in CheckMode::conservative: quick, and never free wrongly.
  /// CheckMode::coal has no spheres, and decides exactly.
  bool spheres_only{false};
};

/// What is known of a motion, and how Checker::is_motion_free decides.
struct MotionQuery {
  bool start_is_free{false};  ///< is_free(a) is known: pairs that the motion leaves alone need not be checked
  bool spheres_only{false};   ///< as StateQuery::spheres_only
};

/// Exact collision checking of one robot of a scene with Coal. Built once per snapshot; const, shared by threads, each
/// with a Workspace of its own. Other robots stand where set_qpos put them, but for `companions`: a configuration holds
/// their joints too, after those of the robot, in the order of their names in the options. Only what the robot itself
/// (or what it holds) touches is a collision, not what companions do elsewhere. Bodies collide when they touch (are
/// within 1 µm of each other) or come within the sum of their paddings; links of one robot and what it holds have no
/// padding towards each other.
///
/// Two bodies that never move relative to each other (the base on its table, an object in the hand) are judged once,
/// without padding, and only what overlaps by more than `touching_tolerance` is a collision: things may stand on
/// things.
///
/// An answer depends on the arguments alone, never on earlier queries or the workspace.
///
/// A motion is the straight line in joint space (continuous joints by the short way). It is called free only when it
/// is *proved* free, between samples too: at a sample every pair must be farther apart than the two can move before
/// the next proved sample (conservative advancement: Schwarzer, Saha, Latombe, "Exact collision checking of robot
/// paths", 2004; motion bounds from the kinematic tree). A pair that can be neither proved free nor shown in contact
/// above 20 µm of motion counts as not free.
class Checker {
 public:
  static constexpr double touching_tolerance = 1e-5;  ///< [m]
  static constexpr double motion_floor = 2e-5;        ///< [m]; motions are not divided below this

  class Workspace;
  struct WorkspaceDeleter {
    void operator()(Workspace*) const;
  };
  using WorkspacePtr = std::unique_ptr<Workspace, WorkspaceDeleter>;

  Checker(const Scene& scene, const std::string& robot, const CheckerOptions& options = {});
  ~Checker();

  const RobotModel& robot() const;
  std::size_t dof() const;  ///< of a configuration: the robot's and its companions'
  const Pose& base() const;
  const Eigen::VectorXd& other_positions() const;  ///< where the robot's joints that are not planned stand
  CheckMode mode() const;
  /// dof entries: how far a unit of each joint moves any point of the robots, or of what they hold, at most, wherever
  /// the joints stand within their limits [m/rad; prismatic joints 1].
  Eigen::VectorXd reach() const;
  /// Holds every point of the robot and of what it holds, companions left out, wherever the joints stand within their
  /// limits; padding included. World frame.
  PlacedSphere range() const;
  WorkspacePtr make_workspace() const;

  /// Limits are not looked at. All of these throw InvalidArgument unless configurations have dof() finite entries.
  bool is_free(ConstVector q, Workspace& workspace) const;
  /// The straight motion from a to b, both ends included.
  bool is_motion_free(ConstVector a, ConstVector b, Workspace& workspace, const MotionQuery& query = {}) const;

  /// is_free of each row, 16 at a time; `free` has as many entries as q has rows. Throws InvalidArgument as is_free
  /// does, naming the row.
  void are_free(ConstRows q, std::span<bool> free, Workspace& workspace, const StateQuery& query = {}) const;

  /// Proves a motion free by Coal's distances alone: an independent check of is_motion_free (motion_proof.hpp).
  MotionCertificate certify_motion(ConstVector a, ConstVector b, Workspace& workspace) const;

  /// Every pair in contact at q, deepest first; empty when free. Pairs are of bodies: a link with several geometries
  /// is named once.
  std::vector<Contact> contacts(ConstVector q, Workspace& workspace) const;
  /// The nearest pair (padding counts as part of a body); nullopt when the robot has nothing to collide with. Pairs
  /// that never move relative to each other count only while in collision.
  std::optional<Contact> nearest(ConstVector q, Workspace& workspace) const;

  /// From now on is_motion_free throws MotionCheckStopped where a motion takes long and the deadline has passed.
  /// (Bodies that slide past each other within micrometres take tenths of a second.) The deadline must outlive the
  /// workspace.
  void stop_at(const Deadline& deadline, Workspace& workspace) const;

  const CheckStatistics& statistics(const Workspace& workspace) const;

  struct Impl;  ///< for the files of this directory

 private:
  std::unique_ptr<const Impl> impl_;
};

/// The library's checker of a robot of the scene. Throws InvalidArgument with the nearest name for an unknown robot.
std::unique_ptr<const Checker> make_checker(const Scene& scene, const std::string& robot,
                                            const CheckerOptions& options = {});

}  // namespace srmp
