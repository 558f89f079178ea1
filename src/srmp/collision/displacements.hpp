#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "srmp/collision/scene_model.hpp"
#include "srmp/collision/sweep.hpp"

namespace srmp::detail {

/// Where a moving body is, found when it is first needed.
struct Place {
  std::uint64_t number{};  ///< of the placement that it is of; not 0 where it is known
  Eigen::Isometry3d pose;
  Eigen::Vector3d center;  // of its bounding sphere
};

/// How far the joints of a motion move the bodies and their envelopes from where they are. Once warm, nothing is
/// allocated.
class Displacements {
 public:
  /// The model outlives this.
  explicit Displacements(const SceneModel& model);

  /// The actuated joints that the motion moves.
  std::uint64_t active() const { return active_; }

  /// A straight motion, by delta.
  void start_straight(const Eigen::VectorXd& delta);
  /// Any motion, in which the actuated joints of `active` may move; limit() says how far.
  void start_any(std::uint64_t active);
  /// Joint j moves by `change[j]` at most: by s * linear[j] for an s in [-1, 1] that is the same for all joints, and by
  /// `rest[j]` at most besides.
  void limit(std::span<const double> change, std::span<const double> linear, std::span<const double> rest);
  /// The bodies are where `data` has them.
  void place(const RobotGroup::Data& data);

  /// By how far the body, which is at `place`, can move while the actuated joints of `support` move through
  /// `half_width` of the motion; with a unit vector, along it.
  double of(std::size_t body, const Place& place, std::uint64_t support, double half_width,
            const Eigen::Vector3d* direction);
  /// The same of the centre of the body's bounding sphere, and so of that sphere, which turning does not move.
  double of_center(std::size_t body, const Place& place, std::uint64_t support, double half_width,
                   const Eigen::Vector3d* direction);
  /// The same of a part of the body along a unit vector: of the convex hull of these points, which are where `place`
  /// has them.
  double of(std::size_t body, const Place& place, std::uint64_t support, double half_width,
            const Eigen::Vector3d& direction, std::span<const Eigen::Vector3d> part);
  /// The same of a point in the body's bounding sphere, `offset` away from its centre, over all of the motion.
  double of_point(std::size_t body, const Place& place, std::uint64_t support, const Eigen::Vector3d& offset,
                  const Eigen::Vector3d* direction);

  /// How points of the body's core move along a unit vector.
  DirectedMotion along(std::size_t body, const Place& place, std::uint64_t support, double half_width,
                       const Eigen::Vector3d& direction);

 private:
  /// Of a joint and a body, here.
  struct Arm {
    Eigen::Vector3d across;  // the axis times the vector from it to the centre of the body
    double center_reach{};   // how far the centre is from the axis
    double reach{};          // the farthest that a point of the body's core may be from the axis
  };
  /// What a joint and the deeper ones of its chain add up to.
  struct Step {
    std::uint64_t support{};                                              // these joints
    Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), turn = velocity;  // of the centre, over half of the motion
    double center_rest{}, rest{};
    Sweep center_sweep, sweep;  // of the centre; of all of the body
  };
  /// The steps of a body's chain that are known.
  struct Chain {
    std::uint64_t placement{};  // Place::number of what is known
    double half_width{-1.0};
    std::uint64_t arms{};           // known, by joint
    std::uint32_t steps{}, next{};  // how many; where in active_list_ to go on
  };

  const Step& sum(std::size_t body, const Place& place, std::uint64_t support, double half_width);
  void add_joint(std::size_t joint, const Arm* arm, double half_width, Step& step) const;
  const Arm& arm(std::size_t body, const Place& place, std::size_t joint);
  Chain& chain(std::size_t body, const Place& place);

  const SceneModel& model_;
  const std::size_t joints_;  // actuated
  std::uint64_t active_{};
  std::vector<std::size_t> active_list_;  // the same, the deepest first
  std::vector<double> speed_;             // of each actuated joint, at most [rad or m over the whole motion]
  std::vector<double> linear_, rest_;     // of it: what is linear [rad or m], and the rest, as in limit()
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> axes_;  // of active joints, here
  std::vector<Arm> arms_;                                          // [body * joints + joint]
  std::vector<Step> steps_;                                        // [body * (joints + 1) + number], from none on
  std::vector<Chain> chains_;                                      // by body
};

}  // namespace srmp::detail
