#include "srmp/planning/strategies/rrt_connect.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/stopping.hpp"
#include "srmp/planning/strategies/robot_sampling.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

/// In narrow places fewer checks find shorter paths with long steps and direct samples.
RobotSamplingOptions sampling(double max_length) {
  return {.max_step = 0.8, .first_margin = M_PI / 4, .direct_samples = 60, .max_length = max_length};
}

}  // namespace

RrtConnectStrategy::RrtConnectStrategy(RobotContext& context, const SearchEndpoints& endpoints, double direct,
                                       const RrtConnectBudget& budget)
    : context_(context),
      endpoints_(endpoints),
      direct_(direct),
      budget_(budget),
      checked_before_(context.checks.motions()),
      trees_(space(), budget.seed) {}

RrtConnectStrategy::~RrtConnectStrategy() {
  context_.statistics.samples += trees_.attempts();
  context_.statistics.memory_bytes += trees_.memory();
}

Attempt RrtConnectStrategy::attempt(const AttemptBudget& budget, const Deadline& deadline) {
  std::optional<std::vector<Eigen::VectorXd>> path;
  const std::uint64_t first = trees_.attempts();
  while (!done_ && !path && !deadline.stop_requested() && has_budget(trees_.attempts() - first)) {
    const std::uint64_t before = context_.checks.motions();
    path = trees_.grow(trees_.attempts() + budget_.attempts_per_check, deadline);
    checked_ += std::max(budget_.attempts_per_check, context_.checks.motions() - before);  // an attempt may check none
  }
  if (!path) return not_found(deadline);
  done_ = true;
  Attempt result{.status = Status::solved};
  const std::size_t target = endpoints_.target_number(path->back()).value();
  const RowMatrix whole = endpoints_.with_own_ends(stack_waypoints(*path), target);
  result.found = {.path = path_of_one(unwrap_waypoints(whole, context_.task.limits.continuous)),
                  .goal_index = endpoints_.goal_indices[target],
                  .cost = context_.length(unstack_waypoints(whole)),
                  .lower = direct_,
                  .graph = every_path,
                  .found_by = "RRT-Connect"};
  return result.found.cost <= budget.max_cost ? result : not_found(deadline);
}

bool RrtConnectStrategy::has_budget(std::uint64_t attempts) const {
  if (budget_.alone) return attempts < budget_.attempts_alone;
  const auto all = static_cast<double>(context_.checks.motions() - checked_before_);
  return static_cast<double>(checked_) < static_cast<double>(budget_.first_checks) + budget_.fraction * all;
}

Attempt RrtConnectStrategy::not_found(const Deadline& deadline) const {
  Attempt result{.status = stop_status(deadline).value_or(Status::timed_out), .lower = direct_};
  if (budget_.alone && deadline.stop_requested())
    result.reason = context_.no_path_sentence({.status = result.status, .path = {}, .statistics = work()}, "",
                                              "configurations sampled");
  return result;
}

search::Statistics RrtConnectStrategy::work() const {
  return {.expansions = context_.statistics.samples + trees_.attempts(), .evaluations = context_.checks.motions()};
}

search::RrtSpace RrtConnectStrategy::space() const {
  search::RrtSpace space =
      rrt_space(context_.robot, endpoints_.start, endpoints_.targets, sampling(budget_.max_length));
  space.is_motion_free = [this](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return context_.checks.is_motion_free(a, b);
  };
  if (!context_.checks.has_rules()) {
    space.find_colliding = [this](const RowMatrix& ends, std::span<bool> colliding) {
      context_.checks.find_colliding(ends, colliding);
    };
    space.on_colliding = [this] { context_.checks.count_colliding(); };
  }
  if (ConstraintChecker* constraints = context_.checks.constraints()) {
    space.max_step = std::min(space.max_step, constraints->constraints().step());
    space.project = [constraints](Eigen::VectorXd& q) {
      return constraints->project(q, constraint_fractions.configurations);
    };
  } else if (!budget_.alone) {
    add_tool_directions(space, context_.robot, context_.task.placed->other_positions);
  }
  return space;
}

}  // namespace srmp
