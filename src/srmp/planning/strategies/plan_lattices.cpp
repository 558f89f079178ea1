#include "srmp/planning/strategies/plan_lattices.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/io/primitives.hpp"
#include "srmp/planning/endpoints/ik_goal_connection.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

PlanLattices::PlanLattices(PlanContext& context, const Endpoints& ends) : context_(context), ends_(ends) {
  const PhaseTimer timer(context.deadline, context.statistics.ik_time_s);
  if (context.common.ik_goal_connection)
    goal_connection_ = make_ik_goal_connection(*context.problem.placed, context.problem.goals, step());
}

Lattice PlanLattices::plain(bool backward) {
  const std::vector<Joint>& joints = context_.robot.joints();
  return make(backward, own_primitives() ? read_primitives() : default_primitives(joints, step(), pairs()));
}

Lattice PlanLattices::rich(bool backward, double scale) {
  const std::vector<Joint>& joints = context_.robot.joints();
  return make(backward, own_primitives() ? read_primitives() : rich_primitives(joints, step(scale), pairs()));
}

std::string PlanLattices::describe(bool backward, double scale) const {
  const std::string end = backward ? "the goals" : "the start";
  if (own_primitives()) return "the lattice of '" + context_.common.mprim_path + "' from " + end;
  return "the lattice of " + to_text(resolution(scale)) + " degrees from " + end;
}

FoundPath PlanLattices::path_of(const search::Result& result, const Lattice& lattice, bool backward,
                                double scale) const {
  FoundPath found{lattice.configurations(result.path), 0, result.cost, result.cost / result.bound,
                  describe(backward, scale)};
  const search::StateId goal = backward ? result.path.front() : result.path.back();
  const ConnectedGoal* snapped = lattice.connected_goal(goal);
  found.goal_index = snapped ? snapped->goal : ends_.goal_indices[backward ? goal : goal - lattice.root_count()];
  if (!backward) return found;
  std::reverse(found.waypoints.begin(), found.waypoints.end());
  found.waypoints =
      unstack_waypoints(unwrap_waypoints(stack_waypoints(found.waypoints), context_.problem.limits.continuous));
  return found;
}

Lattice PlanLattices::make(bool backward, PrimitiveSet primitives) {
  std::vector<Eigen::VectorXd> roots{ends_.start}, goals = ends_.targets;
  if (backward) roots.swap(goals);
  return Lattice(
      context_.robot, std::move(roots), std::move(goals),
      {.primitives = std::move(primitives), .goal_connection = backward ? GoalConnection{} : goal_connection_},
      [&checks = context_.checks](std::size_t worker, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
        return checks.is_motion_free(a, b, worker);
      },
      context_.checks.workers());
}

PrimitiveSet PlanLattices::read_primitives() const {
  return io::read_primitives(context_.common.mprim_path, context_.robot.joints());
}

const std::vector<JointPair>& PlanLattices::pairs() {
  if (!pairs_) pairs_ = parallel_pairs(context_.robot);
  return *pairs_;
}

Eigen::VectorXd PlanLattices::step(double scale) const {
  return lattice_step(context_.robot.joints(), resolution(scale) * M_PI / 180.0,
                      scale * context_.common.prismatic_resolution);
}

/// [degrees]; coarser than asked for, but no more than a quarter turn: no step may take the other way round.
double PlanLattices::resolution(double scale) const {
  const double asked = context_.common.resolution;
  return std::min(scale * asked, std::max(asked, 90.0));
}

}  // namespace srmp
