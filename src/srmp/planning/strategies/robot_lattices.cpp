#include "srmp/planning/strategies/robot_lattices.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/io/primitives.hpp"
#include "srmp/planning/endpoints/ik_goal_connection.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/trace_recorders.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

RobotLattices::RobotLattices(RobotContext& context, const SearchEndpoints& endpoints)
    : context_(context), endpoints_(endpoints), heuristics_(context, endpoints.start) {
  const PhaseTimer timer(context.deadline, context.statistics.ik_time_s);
  if (context.common.ik_goal_connection)
    goal_connection_ = make_ik_goal_connection(*context.task.placed, context.task.goals, step());
}

Lattice RobotLattices::plain(SearchFrom from) {
  const std::vector<Joint>& joints = context_.robot.joints();
  return make({.from = from}, own_primitives() ? read_primitives() : default_primitives(joints, step(), pairs()));
}

Lattice RobotLattices::lattice(const LatticeChoice& choice) {
  const std::vector<Joint>& joints = context_.robot.joints();
  return make(choice, own_primitives() ? read_primitives() : rich_primitives(joints, step(choice.scale), pairs()));
}

Lattice RobotLattices::multi_resolution(SearchFrom from) {
  if (own_primitives()) return make({.from = from}, read_primitives());
  if (context_.task.constraints) return lattice({from, finest_scale});
  const std::vector<Joint>& joints = context_.robot.joints();
  PrimitiveSet finest = rich_primitives(joints, step(finest_scale), pairs());
  const Eigen::VectorXd whole = finest.families.front().moves.front();  // on the grid, all joints at once
  std::vector<Lattice::CoarseLevel> coarser;
  for (const double factor : {2.0, 4.0, 8.0}) {
    Eigen::VectorXd step = factor * whole;
    if (factor * resolution(finest_scale) > std::max(context_.common.resolution, 90.0)) break;
    coarser.push_back({step, rich_primitives(joints, step, pairs())});
  }
  return make({from, finest_scale}, std::move(finest), std::move(coarser));
}

std::string RobotLattices::describe(const LatticeChoice& choice) const {
  const std::string end = choice.from_goals() ? "the goals" : "the start";
  if (own_primitives()) return "the lattice of '" + context_.common.mprim_path + "' from " + end;
  return "the lattice of " + to_text(resolution(choice.scale)) + " degrees" +
         (context_.task.constraints ? ", projected onto the constraints, from " : " from ") + end;
}

FoundPath RobotLattices::path_of(const search::Result& result, const Lattice& lattice,
                                 const LatticeChoice& choice) const {
  std::vector<Eigen::VectorXd> waypoints = lattice.configurations(result.path);
  const search::StateId goal = choice.from_goals() ? result.path.front() : result.path.back();
  const ConnectedGoal* connected = lattice.connected_goal(goal);
  if (choice.from_goals()) std::reverse(waypoints.begin(), waypoints.end());
  std::optional<std::size_t> target;
  if (!connected) target = choice.from_goals() ? goal : lattice.target_of(goal);
  RowMatrix rows = endpoints_.with_own_ends(stack_waypoints(waypoints), target);
  rows = unwrap_waypoints(rows, context_.task.limits.continuous);  // own ends, and paths from the goals
  const bool one_end = endpoints_.targets.size() == 1 && (choice.from_goals() || !goal_connection_);
  const double ends = endpoints_.length_of_ends(context_.robot, target);
  const double of_every_path = one_end ? ends : endpoints_.length_of_ends(context_.robot, std::nullopt);
  const std::string graph = describe(choice);
  return {.path = path_of_one(std::move(rows)),
          .goal_index = target ? endpoints_.goal_indices[*target] : connected->goal,
          .cost = result.cost + ends,
          .lower = result.cost / result.bound + of_every_path,
          .graph = graph,
          .found_by = graph};
}

LatticePortfolioOptions RobotLattices::portfolio_options(double weight, double finer, double max_length,
                                                         std::uint64_t max_expansions) const {
  LatticePortfolioOptions options{.weight = weight, .max_length = max_length, .max_expansions = max_expansions};
  if (own_primitives()) options.scales = {1.0};
  for (double& scale : options.scales) scale = finer * scale;
  const std::string& direction = context_.common.direction;
  if (direction != "auto") options.ends = {direction == "backward" ? SearchFrom::goals : SearchFrom::start};
  return options;
}

void RobotLattices::count(const LatticePortfolio& searches) {
  const search::Statistics work = searches.statistics();
  context_.count(work);
  context_.statistics.states += searches.states();
  context_.statistics.memory_bytes = std::max(context_.statistics.memory_bytes, work.memory);
}

Lattice RobotLattices::make(const LatticeChoice& choice, PrimitiveSet primitives,
                            std::vector<Lattice::CoarseLevel> coarser) {
  std::vector<Eigen::VectorXd> roots{endpoints_.start}, goals = endpoints_.targets;
  if (choice.from_goals()) roots.swap(goals);
  const bool alone = context_.problem.robots.size() == 1;  // threads plan several robots, in no order
  return Lattice(
      context_.robot, std::move(roots), std::move(goals),
      {.primitives = std::move(primitives),
       .goal_connection = choice.from_goals() ? GoalConnection{} : goal_connection_,
       .coarser = std::move(coarser),
       .projection = projection(),
       .observer = alone ? lattice_recorder(context_.task.robot, describe(choice)) : LatticeObserver{}},
      [&checks = context_.checks](std::size_t worker, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
        return checks.is_motion_free(a, b, worker);
      },
      context_.checks.workers());
}

/// Cells have half the size of steps, however coarse the lattice: what is projected lies between its states.
Lattice::Projection RobotLattices::projection() const {
  ConstraintChecker* constraints = context_.checks.constraints();
  if (!constraints) return {};
  return {[constraints](Eigen::VectorXd& q) { return constraints->project(q, constraint_fractions.configurations); },
          0.5 * step()};
}

PrimitiveSet RobotLattices::read_primitives() const {
  return io::read_primitives(context_.common.mprim_path, context_.robot.joints());
}

const std::vector<JointPair>& RobotLattices::pairs() {
  if (!pairs_) pairs_ = parallel_pairs(context_.robot);
  return *pairs_;
}

Eigen::VectorXd RobotLattices::step(double scale) const {
  return lattice_step(context_.robot.joints(), resolution(scale) * M_PI / 180.0,
                      scale * context_.common.prismatic_resolution);
}

/// [degrees]; `scale` times the option, but no more than a quarter turn: no step may take the other way round.
double RobotLattices::resolution(double scale) const {
  const double option = context_.common.resolution;
  return std::min(scale * option, std::max(option, 90.0));
}

}  // namespace srmp
