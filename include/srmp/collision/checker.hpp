#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "srmp/core/deadline.hpp"
#include "srmp/core/placed_sphere.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

class BatchRobotStore;
class CoverStore;
class PairTableStore;
namespace detail {
class RobotGroup;
}

/// What a body of a contact is.
enum class BodyKind { link, object, attached_object };

/// Two bodies in contact, or the nearest two.
struct Contact {
  std::string body_a;       ///< "link" of the planned robot, or an object attached to it
  std::string body_b;       ///< object, link of the same robot, or "robot/link" of another
  double distance{};        ///< [m], less the padding; negative: how deep the two, with their padding, overlap
  Eigen::Vector3d point_a;  ///< on body_a, world frame [m]
  Eigen::Vector3d point_b;  ///< on body_b, world frame [m]
  double padding{};         ///< of the pair [m]
  BodyKind kind_a{};        ///< what body_a is
  BodyKind kind_b{};        ///< what body_b is

  /// "link 'panda_link5' and object 'shelf' overlap by 12.3 mm".
  std::string describe() const;
};

/// Which layers of the library's own checker decide.
enum class CheckMode {
  exact,  ///< spheres around and inside the bodies decide most checks, 16 configurations at a time; Coal the rest
  conservative,  ///< spheres alone decide motions and are_free: never free wrongly, but what they cannot prove is not
                 ///< free
  coal,          ///< Coal alone
};

/// Options of a checker.
struct CheckerOptions {
  CheckMode mode{CheckMode::exact};      ///< how motions are decided
  std::shared_ptr<CoverStore> covers{};  ///< where spheres are looked up; nullptr: a store of the checker's own
  /// Only covers of robots that take milliseconds to compute: what spheres alone decide is then the same whether or not
  /// better ones are known.
  bool quick_covers{};
  std::vector<std::string> other_robots{};     ///< robots that move too: their joints follow in a configuration
  std::vector<std::string> excluded_robots{};  ///< robots left out, with all that they hold
  bool other_robots_only{};  ///< only what the robot and `other_robots` do to each other is a collision
  /// Bodies that come closer than this to each other collide [m, >= 0]: links of one robot and what it holds too, and
  /// beyond the padding of those that have one. Of two links that are built closer to each other, so that they are in
  /// at least half of the robot's configurations (by 32 samples), only contact counts.
  double clearance{};
  /// Where tables of pairs of links are looked up (not by CheckMode::coal); nullptr: nowhere.
  std::shared_ptr<PairTableStore> pair_tables{};
  /// Where robots are looked up as checks of batches need them, so that a changed scene costs less; nullptr: nowhere.
  std::shared_ptr<BatchRobotStore> batch_robots{};
};

/// What a thread's checks did so far: counts.
struct CheckStatistics {
  std::uint64_t configurations{};      ///< kinematics computed, one at a time
  std::uint64_t states{};              ///< configurations checked: is_free, and rows of are_free
  std::uint64_t motions{};             ///< motions checked: is_motion_free and certify_motion
  std::uint64_t states_by_spheres{};   ///< of the states, decided by spheres alone
  std::uint64_t motions_by_spheres{};  ///< of the motions, decided by spheres alone
  std::uint64_t blocks{};              ///< of up to 16 configurations under spheres
  std::uint64_t undecided{};           ///< pairs, over a part of a motion, that spheres left to Coal
  std::uint64_t by_tables{};           ///< pairs, over a motion or a part of it, that their tables decided
  std::uint64_t narrow_phase{};        ///< pairs that Coal decided
};

/// The one with the smaller distance.
inline std::optional<Contact> nearer(std::optional<Contact> a, std::optional<Contact> b) {
  return !a || (b && b->distance < a->distance) ? b : a;
}

/// Proof that a motion is free, or a contact on it, or the first part of it that could not be proved.
struct MotionCertificate {
  bool proved{};               ///< the whole motion is proved free
  double from{}, to{};         ///< part of the motion, 0..1, that could not be proved; from = to: a contact there
  std::string body_a, body_b;  ///< the pair there, named as in Contact
};

/// Thrown by the queries of Checker; see Checker::stop_at.
struct MotionCheckStopped : std::exception {
  /// The sentence of the exception.
  const char* what() const noexcept override { return "the deadline passed during a collision check"; }
};

/// How Checker::are_free decides.
struct StateQuery {
  /// What spheres cannot prove free counts as not free, as in CheckMode::conservative: quick, and never free wrongly.
  /// CheckMode::coal and backends without spheres decide exactly.
  bool spheres_only{false};
};

/// What is known of a motion, and how Checker::is_motion_free decides.
struct MotionQuery {
  bool start_is_free{false};  ///< is_free(a) is known: pairs that the motion does not move need not be checked
  bool spheres_only{false};   ///< as StateQuery::spheres_only
};

/// Collision checking of one robot of a scene. The interface of a collision backend: the public functions check their
/// arguments and call the private virtuals, which compute. The library's own backend comes from make_checker; whoever
/// has another one derives from this class, overrides the virtuals, and runs the laws below against it
/// (tests/collision/checker_conformance.hpp).
///
/// A checker is built for a scene as it is and does not change. Threads share it, each with a Workspace of its own.
///
/// A configuration has dof() entries [rad, prismatic joints m]: the joints of the robot and then, in the order of their
/// names in the options, those of CheckerOptions::other_robots. Robots that are named in neither place stand where
/// Scene::set_qpos put them. Only what the robot itself (or what it holds) touches is a collision, not what the other
/// robots do among themselves. Joint limits are not checked.
///
/// Bodies collide when they touch (are within 1 µm of each other) or come within the sum of their paddings; links of
/// one robot and what it holds have no padding towards each other. CheckerOptions::clearance is added to the padding of
/// each pair, theirs too. Two bodies that never move relative to each other
/// (the base on its table, an object in the gripper) are checked once, without padding, and collide only when they
/// overlap by more than `touching_tolerance`: things may stand on things.
///
/// A motion is the straight line in joint space; continuous joints go the short way. It is called free only when it is
/// *proved* free, between samples too. The library's backend proves it by conservative advancement (Schwarzer, Saha,
/// Latombe, "Exact collision checking of robot paths", 2004): at a sample every pair must be farther apart than the two
/// can move before the next proved sample, by bounds from the kinematic tree. A pair that can be neither proved free
/// nor shown in contact above `motion_floor` of motion counts as not free.
///
/// Laws of every backend, which the conformance suite tests:
/// - A result depends on the arguments alone, never on earlier queries or on which workspace is used.
/// - contacts(q) is empty exactly where is_free(q), and nearest(q) is then farther apart than 0; elsewhere nearest(q)
/// is
///   the first of contacts(q).
/// - are_free says what is_free says of each row (in CheckMode::conservative, and with StateQuery::spheres_only: never
///   more).
/// - find_colliding says true only where is_free says no.
/// - A motion that is_motion_free or certify_motion call free has no configuration, however finely sampled, where
///   is_free says no.
/// - Between free configurations the distance of nearest changes by at most twice the sum of reach() times the joint
///   differences.
class Checker {
 public:
  static constexpr double touching_tolerance = 1e-5;  ///< [m]
  static constexpr double motion_floor = 2e-5;        ///< [m]; motions are not subdivided below this

  /// Scratch memory and statistics of one thread. Backends derive from it what they need.
  class Workspace {
   public:
    Workspace() = default;
    Workspace(const Workspace&) = delete;
    Workspace& operator=(const Workspace&) = delete;
    virtual ~Workspace() = default;

    CheckStatistics statistics;         ///< the public functions count `states` and `motions`; backends the rest
    const Deadline* deadline{nullptr};  ///< of Checker::stop_at; null: none

   private:
    friend class Checker;
    const Checker* owner_{nullptr};
  };
  /// Owns the scratch memory of one thread.
  using WorkspacePtr = std::unique_ptr<Workspace>;

  Checker(const Checker&) = delete;
  Checker& operator=(const Checker&) = delete;
  virtual ~Checker();

  /// Throws InvalidArgument unless this checker made the workspace.
  void require_own(const Workspace& workspace) const;

  const RobotModel& robot() const;  ///< the planned robot
  std::size_t dof() const;          ///< of a configuration: joints of the robot and of CheckerOptions::other_robots
  const Pose& base() const;         ///< of the robot, in the world
  const Eigen::VectorXd& other_positions() const;       ///< where the robot's joints that are not planned stand
  CheckMode mode() const { return mode_; }              ///< of the options
  double clearance_kept() const { return clearance_; }  ///< CheckerOptions::clearance [m]
  /// (dof,): how far a unit of each joint moves any point of the robots, or of what they hold, at most, wherever the
  /// joints stand within their limits [m/rad; prismatic joints 1].
  Eigen::VectorXd reach() const { return do_reach(); }
  /// Contains every point of the robot and of what it holds (the other robots are left out), wherever the joints stand
  /// within their limits; padding included. World frame.
  PlacedSphere range() const { return do_range(); }

  /// For one thread and this checker.
  WorkspacePtr make_workspace() const;

  // All queries throw InvalidArgument unless configurations have dof() finite entries and the workspace is of this
  // checker's make_workspace.

  /// Returns whether the robot at q (dof,) [rad or m] touches nothing. Limits are not checked. Throws InvalidArgument
  /// unless q has dof() finite entries.
  bool is_free(ConstVector q, Workspace& workspace) const;
  /// The straight motion from a to b, both ends included.
  bool is_motion_free(ConstVector a, ConstVector b, Workspace& workspace, const MotionQuery& query = {}) const;

  /// is_free of each row of q (n x dof); `free` has n entries. Throws InvalidArgument as is_free does, naming the row,
  /// and unless the sizes agree.
  void are_free(ConstRows q, std::span<bool> free, Workspace& workspace, const StateQuery& query = {}) const;

  /// Which rows of q (n x dof) are seen to be in contact with little work; `colliding` has n entries, false where that
  /// is not known. How many are seen may depend on what the workspace checked before. Throws InvalidArgument as
  /// are_free does.
  void find_colliding(ConstRows q, std::span<bool> colliding, Workspace& workspace) const;

  /// Proves the straight motion from a to b free, independently of is_motion_free where the backend can: the library's
  /// own uses Coal's distances alone (collision/motion_proof.hpp).
  MotionCertificate certify_motion(ConstVector a, ConstVector b, Workspace& workspace) const;

  /// Every pair in contact at q, deepest first; empty when free. Pairs are of bodies: a link with several geometries
  /// is named once.
  std::vector<Contact> contacts(ConstVector q, Workspace& workspace) const;
  /// The nearest pair (padding counts as part of a body); nullopt when the robot has nothing to collide with. Pairs
  /// that never move relative to each other count only while in collision; see nearest_fixed().
  std::optional<Contact> nearest(ConstVector q, Workspace& workspace) const;
  /// The distance of nearest(q) [m] without its points, which take long among clouds and meshes; infinity when the
  /// robot has nothing to collide with.
  double clearance(ConstVector q, Workspace& workspace) const;
  /// The nearest pair of a link that no planned joint moves (or what it holds) and an object or another robot, wherever
  /// the joints stand: the base above the floor. Without padding. Two that stand on each other, within
  /// touching_tolerance, do not count; nullopt when there are no others. Backends may leave this to its default,
  /// nullopt.
  std::optional<Contact> nearest_fixed() const { return do_nearest_fixed(); }

  /// From now on the queries throw MotionCheckStopped where they take long and the deadline has passed. (Bodies that
  /// slide past each other within micrometres take tenths of a second, and so may the clearance among dense clouds and
  /// meshes.) What computes the points of contacts, and of the nearest pair once it is known, is not interrupted. Only
  /// Deadline::expired is called, so several workspaces may share a deadline. It must outlive the workspace, or the
  /// next call of this function.
  void stop_at(const Deadline& deadline, Workspace& workspace) const;

  /// The counts of this workspace's checks.
  const CheckStatistics& statistics(const Workspace& workspace) const { return workspace.statistics; }

 protected:
  /// Reads the robot, and CheckerOptions::other_robots, from the scene, which need not outlive this. Throws
  /// InvalidArgument for unknown robots (with the nearest name), for one named twice, for more than 64 actuated joints
  /// together, and for a clearance below 0 or not finite.
  Checker(const Scene& scene, const std::string& robot, const CheckerOptions& options);

  /// The kinematics of the robots; for backends inside the library.
  const detail::RobotGroup& group() const;

 private:
  // What a backend overrides. Arguments are checked already: configurations have dof() finite entries, spans have as
  // many entries as there are rows, and the workspace is one of do_make_workspace.

  virtual bool do_is_free(ConstVector q, Workspace& workspace) const = 0;
  virtual std::vector<Contact> do_contacts(ConstVector q, Workspace& workspace) const = 0;
  virtual std::optional<Contact> do_nearest(ConstVector q, Workspace& workspace) const = 0;

  /// Default: the distance of do_nearest.
  virtual double do_clearance(ConstVector q, Workspace& workspace) const;
  /// Default: nullopt.
  virtual std::optional<Contact> do_nearest_fixed() const;
  /// Default: a Workspace without scratch memory.
  virtual WorkspacePtr do_make_workspace() const;
  /// Default: do_is_free, row by row.
  virtual void do_are_free(ConstRows q, std::span<bool> free, Workspace& workspace, const StateQuery& query) const;
  /// `colliding` is false. Default: none is known.
  virtual void do_find_colliding(ConstRows q, std::span<bool> colliding, Workspace& workspace) const;
  /// Default: whether do_certify_motion proves it.
  virtual bool do_is_motion_free(ConstVector a, ConstVector b, Workspace& workspace, const MotionQuery& query) const;
  /// Default: conservative advancement on do_nearest and do_reach. Sound for every backend, and slow.
  virtual MotionCertificate do_certify_motion(ConstVector a, ConstVector b, Workspace& workspace) const;
  /// Defaults: from the kinematic tree, and from the bounding spheres of the links' collision geometry and of attached
  /// objects.
  virtual Eigen::VectorXd do_reach() const;
  virtual PlacedSphere do_range() const;

  void require_motion(ConstVector a, ConstVector b, const Workspace& workspace) const;
  void require_rows(ConstRows q, std::size_t results, const char* function, const Workspace& workspace) const;

  struct Robots;
  std::unique_ptr<const Robots> robots_;
  CheckMode mode_;
  double clearance_;
};

/// Makes a checker of a robot of a scene. A collision backend is plugged in as one of these.
using CheckerFactory = std::function<std::unique_ptr<const Checker>(const Scene& scene, const std::string& robot,
                                                                    const CheckerOptions& options)>;

/// The library's own checker of a robot of the scene: Coal, behind batches of spheres (CheckMode). Throws
/// InvalidArgument with the nearest name for an unknown robot.
std::unique_ptr<const Checker> make_checker(const Scene& scene, const std::string& robot,
                                            const CheckerOptions& options = {});

}  // namespace srmp
