#include "srmp/planning/strategies/joint_barriers.hpp"

#include <algorithm>
#include <utility>

#include "srmp/collision/joint_barrier.hpp"
#include "srmp/core/error.hpp"
#include "srmp/planning/strategies/barrier_proof.hpp"

namespace srmp {

namespace {

/// Of proofs with several joints.
struct ProofOptions {
  std::size_t max_joints{3};            ///< with more, the cells are too many
  std::size_t min_configurations{256};  ///< of both trees together, before they are compared
  std::size_t cells_at_once{100};       ///< with two joints; with three, whose cells take longer, a quarter of it
  double cells_per_check{0.1};          ///< of a motion, by whatever strategy; a cell takes as long as some ten checks
};
const ProofOptions proof_options;

std::string sentence(const RobotModel& robot, const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                     const JointBarrier& barrier) {
  const auto j = static_cast<Eigen::Index>(barrier.joint);
  return "there is no path: joint '" + robot.joints()[barrier.joint].name + "' cannot get from " + to_text(from[j]) +
         " to " + to_text(to[j]) + ", because at " + to_text(barrier.position) + " " + barrier.contact.describe() +
         " wherever the other joints are";
}

}  // namespace

JointBarriers::JointBarriers(RobotContext& context, const RobotEndpoints& endpoints, const search::RrtConnect* trees)
    : context_(context), endpoints_(endpoints), trees_(trees), checked_before_(context.checks.motions()) {
  const auto is_configuration = [](const GoalConstraint& goal) { return goal.type == GoalType::joints; };
  if (std::all_of(context.task.goals.begin(), context.task.goals.end(), is_configuration))
    targets_ = endpoints.targets.size();
}

Attempt JointBarriers::attempt(const AttemptBudget& budget, const Deadline& deadline) {
  if (budget.round > 0 && trees_) compare_trees();
  if (targets_ == 0) return {};
  if (budget.round == 0) {
    find_barriers_of_one_joint();
  } else {
    prove_further(deadline);
  }
  if (reasons_.size() < targets_) return {};
  const std::string from = endpoints_.recovery.empty() ? "" : "; it would begin where the start was recovered to";
  return {.status = Status::exhausted, .reason = reasons_.front() + from, .of_all_paths = true};
}

/// Of the targets one after the other, up to the first that has none.
void JointBarriers::find_barriers_of_one_joint() {
  while (reasons_.size() < targets_) {
    const Eigen::VectorXd& target = endpoints_.targets[reasons_.size()];
    const auto barrier =
        find_joint_barrier(context_.checks.checker(), endpoints_.start, target, context_.checks.workspace());
    if (!barrier) return;
    reasons_.push_back(sentence(context_.robot, endpoints_.start, target, *barrier));
  }
}

/// Whenever they are twice as large as the last time.
void JointBarriers::compare_trees() {
  const search::ConfigurationTree &from_start = trees_->tree(false), &from_goals = trees_->tree(true);
  const std::size_t size = from_start.size() + from_goals.size();
  if (size < std::max(2 * compared_, proof_options.min_configurations)) return;
  if (compared_ == 0)
    for (auto& joints : JointCells::sets_of_joints(proof_options.max_joints, context_.checks.workspace()))
      sets_.push_back({.joints = std::move(joints)});
  compared_ = size;
  for (JointSet& set : sets_)
    set.overlap = search::ConfigurationTree::projections_overlap(from_start, from_goals, set.joints);
}

bool JointBarriers::may_work(std::size_t cells) const {
  const auto checks = static_cast<double>(context_.checks.motions() - checked_before_);
  return static_cast<double>(work_ + cells) <= proof_options.cells_per_check * checks;
}

/// For the targets one after the other.
void JointBarriers::prove_further(const Deadline& deadline) {
  std::string reason;
  while (reasons_.size() < targets_ && may_work(proof_options.cells_at_once) && !deadline.stop_requested() &&
         try_each_set(endpoints_.targets[reasons_.size()], reason)) {
    if (reason.empty()) continue;
    reasons_.push_back(std::exchange(reason, ""));
    for (JointSet& set : sets_) set.failed = false;
    find_barriers_of_one_joint();
  }
}

/// Some cells in the space of each set. False: there is none that may prove anything.
bool JointBarriers::try_each_set(const Eigen::VectorXd& target, std::string& reason) {
  bool tried = false;
  for (JointSet& set : sets_) {
    if (set.overlap || set.failed) continue;
    if (!set.proof)
      set.proof =
          std::make_unique<BarrierProof>(context_.robot, set.joints, endpoints_.start, context_.checks.workspace());
    const std::size_t before = set.proof->work();
    const auto outcome = set.proof->run(target, proof_options.cells_at_once / (set.joints.size() > 2 ? 4 : 1));
    work_ += set.proof->work() - before;
    tried = true;
    set.failed = outcome == BarrierProof::Outcome::unproved;
    if (outcome != BarrierProof::Outcome::no_path) continue;
    reason = set.proof->reason(target);
    break;
  }
  return tried;
}

std::string JointBarriers::suspicion() const {
  const auto set = std::find_if(sets_.begin(), sets_.end(), [](const JointSet& s) { return !s.overlap && !s.failed; });
  if (set == sets_.end()) return "";
  std::vector<std::string> names;
  for (const std::size_t joint : set->joints) names.push_back(context_.robot.joints()[joint].name);
  return "; it may be joints " + quoted_list(names) +
         " that block the way: from the start and from the goals, the search came to different values of them";
}

}  // namespace srmp
