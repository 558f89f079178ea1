#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "srmp/planning/endpoints/endpoints.hpp"
#include "srmp/planning/robot_context.hpp"
#include "srmp/planning/strategies/barrier_proof.hpp"
#include "srmp/planning/strategies/strategy.hpp"
#include "srmp/search/rrt_connect.hpp"

namespace srmp {

/// Finds no path, but proves that there is none where each goal is a configuration (inverse kinematics may know more
/// ends of a path than the endpoints do) and behind a barrier: of one joint (find_joint_barrier), in the first round;
/// or of two or three joints together (BarrierProof), with a part of the work of all strategies, where the
/// projections of the trees of RRT-Connect onto these joints do not overlap.
class JointBarriers : public Strategy {
 public:
  /// References outlive this. `trees` from the start and from the goals; null: there are none, and no proofs of several
  /// joints.
  JointBarriers(RobotContext& context, const RobotEndpoints& endpoints, const search::RrtConnect* trees = nullptr);

  Attempt attempt(const AttemptBudget& budget, const Deadline& deadline) override;
  bool can_exhaust() const override { return false; }
  /// What may block the way, as the end of a sentence, where that is not proved; "": nothing is known.
  std::string suspicion() const;

 private:
  /// In whose space a proof may be found.
  struct JointSet {
    std::vector<std::size_t> joints;
    bool overlap{};  // do the trees, there?
    std::unique_ptr<BarrierProof> proof{};
    bool failed{};  // of the target at hand
  };

  void find_barriers_of_one_joint();
  void compare_trees();
  bool may_work(std::size_t cells) const;
  void prove_further(const Deadline& deadline);
  bool try_each_set(const Eigen::VectorXd& target, std::string& reason);

  RobotContext& context_;
  const RobotEndpoints& endpoints_;
  const search::RrtConnect* trees_;
  const std::uint64_t checked_before_;
  std::vector<std::string> reasons_;  // of targets that cannot be reached, the first ones
  std::size_t targets_{};             // that need a reason; 0: none is of use
  std::size_t compared_{};            // configurations of the trees that were
  std::vector<JointSet> sets_;
  std::size_t work_{};  // of the proofs, in cells
};

}  // namespace srmp
