#include "srmp/planning/strategies/joint_barriers.hpp"

#include <algorithm>

#include "srmp/collision/joint_barrier.hpp"
#include "srmp/core/error.hpp"
#include "srmp/planning/strategies/barrier_proof.hpp"

namespace srmp {

namespace {

/// Of proofs with several joints. A cell takes about as long as ten checks of motions.
struct ProofOptions {
  std::size_t max_joints{3};            ///< with more, the cells are too many
  std::size_t min_configurations{256};  ///< of both trees together, before they are compared
  std::size_t cells_at_once{100};       ///< with two joints; with three, whose cells take longer, a quarter of it
  double cells_per_check{0.05};         ///< of a motion, by whatever strategy
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
    reasons_.resize(endpoints.targets.size());
}

Attempt JointBarriers::attempt(const AttemptBudget& budget, const Deadline&) {
  if (budget.round > 0 && trees_) compare_trees();
  if (reasons_.empty()) return {};
  if (budget.round == 0) {
    for (std::size_t i = 0; i < reasons_.size(); ++i)
      if ((reasons_[i] = reason_of_one_joint(endpoints_.targets[i])).empty()) return {};
  } else {
    prove_further();
  }
  if (std::any_of(reasons_.begin(), reasons_.end(), [](const std::string& reason) { return reason.empty(); }))
    return {};
  return {.status = Status::exhausted, .reason = reasons_.front(), .of_all_paths = true};
}

/// "": there is no barrier.
std::string JointBarriers::reason_of_one_joint(const Eigen::VectorXd& target) {
  const auto barrier =
      find_joint_barrier(context_.checks.checker(), endpoints_.start, target, context_.checks.workspace());
  return barrier ? sentence(context_.robot, endpoints_.start, target, *barrier) : "";
}

/// Whenever they are twice as large as the last time.
void JointBarriers::compare_trees() {
  const search::ConfigurationTree &from_start = trees_->tree(false), &from_goals = trees_->tree(true);
  const std::size_t size = from_start.size() + from_goals.size();
  if (size < std::max(2 * compared_, proof_options.min_configurations)) return;
  if (compared_ == 0) sets_ = JointCells::sets_of_joints(proof_options.max_joints, context_.checks.workspace());
  compared_ = size;
  const auto overlap = [&](const JointSet& joints) {
    return search::ConfigurationTree::projections_overlap(from_start, from_goals, joints);
  };
  std::erase_if(sets_, overlap);
  std::erase_if(proofs_, [&](const auto& proof) { return overlap(proof->joints()); });
}

bool JointBarriers::may_label(std::size_t cells) const {
  const auto checks = static_cast<double>(context_.checks.motions() - checked_before_);
  return static_cast<double>(labelled_ + cells) <= proof_options.cells_per_check * checks;
}

/// Of the targets one after the other, in each space in turn.
void JointBarriers::prove_further() {
  while (!sets_.empty() && may_label(proof_options.cells_at_once)) {
    const auto target = std::find(reasons_.begin(), reasons_.end(), "");
    if (target == reasons_.end()) return;
    if (proofs_.empty()) {
      const Eigen::VectorXd& configuration = endpoints_.targets[static_cast<std::size_t>(target - reasons_.begin())];
      *target = reason_of_one_joint(configuration);
      if (!target->empty()) continue;
      begin_proofs(configuration);
    }
    for (const auto& proof : proofs_) {
      const std::size_t before = proof->cells();
      proof->run(proof_options.cells_at_once / (proof->joints().size() > 2 ? 4 : 1));
      labelled_ += proof->cells() - before;
      if (proof->proved()) *target = proof->reason();
      if (proof->finished()) break;
    }
    if (!target->empty()) proofs_.clear();
    std::erase_if(proofs_, [](const auto& proof) { return proof->finished(); });
    if (proofs_.empty() && target->empty()) sets_.clear();  // this target may be reached
  }
}

std::string JointBarriers::suspicion() const {
  if (compared_ == 0 || sets_.empty()) return "";
  std::vector<std::string> names;
  for (const std::size_t joint : sets_.front()) names.push_back(context_.robot.joints()[joint].name);
  return "; it may be joints " + quoted_list(names) +
         " that block the way: from the start and from the goals, the search came to different values of them";
}

void JointBarriers::begin_proofs(const Eigen::VectorXd& target) {
  for (const JointSet& joints : sets_)
    proofs_.push_back(
        std::make_unique<BarrierProof>(context_.robot, joints, endpoints_.start, target, context_.checks.workspace()));
}

}  // namespace srmp
