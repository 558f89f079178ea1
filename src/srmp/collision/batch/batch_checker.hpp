#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "srmp/collision/batch/batch_data.hpp"
#include "srmp/core/simd_backend.hpp"

namespace srmp {

struct BatchModel;
struct BatchRobotModel;

enum class CollisionStatus { free, colliding, undecided };

/// A pair that the spheres could not decide, over part of a motion (half = 0: at one configuration).
struct UndecidedPair {
  double t{};     ///< middle of the part, 0..1 on the motion; for check_block the index of the configuration
  double half{};  ///< half its length
  bool self{};
  int pair{};  ///< index into BatchWorld::self_pairs when self, else into obstacle_pairs
};

struct BatchStatistics {
  std::uint64_t blocks{};  ///< kernel calls of up to 16 configurations
  std::uint64_t motions{};
  std::uint64_t motions_free{}, motions_colliding{}, motions_undecided{};  ///< not proved (proves_free): undecided
};

struct BlockOptions {
  /// Only which configurations are free matters; which of the two bits another one has, and which of its pairs
  /// undecided() lists, is then arbitrary (but deterministic).
  bool proofs_only{false};
};

/// Checks 16 configurations at a time in float32, with sound rounding: what it calls free is free, what it calls
/// colliding collides, and the pairs that it leaves undecided are listed. All instruction sets give the same bits.
///
/// "Free" for a motion holds between samples: a sample stands for an interval around it, and a pair is proved free
/// there when its distance exceeds what both bodies can move within the interval. That bound is summed over the joints
/// between the two, from the distal to the proximal: each turns what it carries, at its distance from the axis plus
/// what the joints before it moved it already. Where that does not suffice, the velocities at the sample count, towards
/// each other only, and a bound of how far paths bend; fine spheres are first separated by planes.
///
/// Const; threads share it, each with a Workspace of its own.
class BatchChecker {
 public:
  /// Throws InvalidArgument for indices out of range, non-finite numbers and more than 4 million pairs.
  explicit BatchChecker(const BatchWorld& world, SimdBackend backend = default_simd_backend());
  /// Of a robot that others may share.
  BatchChecker(std::shared_ptr<const BatchRobotModel> robot, const BatchPairs& pairs,
               SimdBackend backend = default_simd_backend());
  /// As `before`, with other obstacles and pairs, whose numbers must be in range. `known` has a number for each
  /// obstacle: that of the same obstacle before, or -1. Throws as above for obstacles that are new and for too many
  /// pairs.
  BatchChecker(const BatchChecker& before, const BatchPairs& pairs, std::span<const int> known);
  ~BatchChecker();
  BatchChecker(BatchChecker&&) noexcept;

  class Workspace;
  struct WorkspaceDeleter {
    void operator()(Workspace*) const;
  };
  using WorkspacePtr = std::unique_ptr<Workspace, WorkspaceDeleter>;
  WorkspacePtr make_workspace() const;

  static constexpr int block = 16;

  /// The result for each configuration of a block, bit i for number i; neither bit: free.
  struct Lanes {
    std::uint16_t colliding{}, undecided{};
  };
  /// Checks up to 16 configurations, each dof() long, one after the other.
  Lanes check_block(std::span<const double> configurations, Workspace& workspace,
                    const BlockOptions& options = {}) const;
  /// Which of such configurations collide where the last motions that did not pass were stopped, bit i for number i.
  std::uint16_t find_likely_hits(std::span<const double> configurations, Workspace& workspace) const;

  /// Checks the straight motion from a by `difference` (joint space) in one block: 16 equal intervals. Without deferred
  /// pairs.
  CollisionStatus motion_block(std::span<const double> a, std::span<const double> difference,
                               Workspace& workspace) const;

  /// Checks it in as many blocks as it takes: intervals are so short that no point moves more than about `step` [m]
  /// within half of one; undecided intervals are subdivided into four, up to `refinements` times. The lanes of a block
  /// are spread over the motion. Without deferred pairs.
  struct MotionOptions {
    double step{0.02};
    int refinements{2};
    int max_blocks{256};  ///< after these, what is open stays undecided
  };
  CollisionStatus motion(std::span<const double> a, std::span<const double> difference, Workspace& workspace,
                         const MotionOptions& options) const;
  /// The same with these self pairs alone.
  CollisionStatus motion_of_pairs(std::span<const double> a, std::span<const double> difference, Workspace& workspace,
                                  const MotionOptions& options, std::span<const int> self_pairs) const;

  /// Is the motion proved free, by the same intervals, with all pairs? Ends at the first one that cannot be, without
  /// finding out whether it is undecided or collides. After max_blocks an interval is subdivided once at most, whereas
  /// motion() ends with its current level: only there one of the two may prove what the other does not.
  bool proves_free(std::span<const double> a, std::span<const double> difference, Workspace& workspace,
                   const MotionOptions& options) const;

  /// The undecided pairs of the last call; in order of (t, pair).
  const std::vector<UndecidedPair>& undecided(const Workspace& workspace) const;
  const BatchStatistics& statistics(const Workspace& workspace) const;

  std::size_t dof() const;
  SimdBackend backend() const;
  /// Bound on the float error of any distance that a result relies on [m].
  double error_bound() const;

  /// Pose of actuated joint k at q as the kernel computes it (float32), for tests.
  Eigen::Isometry3d actuated_joint_pose(std::span<const double> q, std::size_t k, Workspace& workspace) const;

 private:
  std::size_t set_block(std::span<const double> configurations, Workspace& workspace) const;
  void begin_motion(std::span<const double> a, std::span<const double> difference, Workspace& workspace,
                    const MotionOptions& options) const;
  CollisionStatus check_levels(Workspace& workspace, const MotionOptions& options, bool only_open) const;

  std::unique_ptr<const BatchModel> impl_;
};

}  // namespace srmp
