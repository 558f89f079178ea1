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
/// or of two or three joints together (BarrierProof), with a part of the work of all strategies, where the trees of
/// RRT-Connect come to different places in the space of these joints.
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
  using JointSet = std::vector<std::size_t>;

  std::string reason_of_one_joint(const Eigen::VectorXd& target);
  void compare_trees();
  void prove_further();
  bool may_label(std::size_t cells) const;
  void begin_proofs(const Eigen::VectorXd& target);

  RobotContext& context_;
  const RobotEndpoints& endpoints_;
  const search::RrtConnect* trees_;
  const std::uint64_t checked_before_;
  std::vector<std::string> reasons_;                   // by target, why it cannot be reached; "": not known
  std::size_t compared_{};                             // configurations of the trees that were
  std::vector<JointSet> sets_;                         // in whose space the trees come to different places
  std::vector<std::unique_ptr<BarrierProof>> proofs_;  // of the first target without a reason, in these spaces
  std::size_t labelled_{};                             // cells
};

}  // namespace srmp
