// Motions along poses: PlannerInterface::plan_linear and follow.
#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"
#include "srmp/facade/planner_impl.hpp"
#include "srmp/facade/poses_to_follow.hpp"

namespace srmp {

namespace {

constexpr CartesianTolerance greatest{0.1, 0.5};  // [m, rad]: what is planned are lines, not tubes

void require_tolerance(const char* name, double value, double most, const char* unit) {
  if (value > 0.0 && value <= most) return;
  throw InvalidArgument(std::string(name) + " is " + to_text(value) + "; it must be above 0 and at most " +
                        to_text(most) + " " + unit);
}

}  // namespace

PosesToFollow poses_to_follow(const PlacedRobot& robot, ConstVector start, const std::vector<Pose>& poses,
                              const CartesianOptions& options) {
  require_tolerance("max_deviation", options.max_deviation, greatest.position, "m");
  require_tolerance("max_rotation", options.max_rotation, greatest.rotation, "rad");
  const RobotModel& model = *robot.model;
  const std::string& link = model.link_names()[model.link_or_end_effector(options.link)];
  if (model.link_support(model.link_index(link)) == 0)
    throw InvalidArgument("link '" + link + "' of robot '" + model.name() +
                          "' cannot follow poses: no planned joint moves it");
  if (poses.empty()) throw InvalidArgument("there are no poses to follow; give at least one");
  std::vector<Pose> path{robot.base * model.compute_fk(start, link, robot.other_positions)};
  for (std::size_t i = 0; i < poses.size(); ++i)
    path.push_back(checked_pose(poses[i], "pose " + std::to_string(i) + " to follow"));
  CartesianPath followed(std::move(path));
  if (followed.length() > max_length)
    throw InvalidArgument("the path along the poses is " + to_text(followed.length()) + " m long" + length_rule());
  return {link, std::move(followed), {options.max_deviation, options.max_rotation}};
}

Trajectory PlannerInterface::plan_linear(const std::string& robot, ConstVector start, const Pose& goal,
                                         const CartesianOptions& options, const Interrupt& interrupt) {
  return follow(robot, start, {goal}, options, interrupt);
}

Trajectory PlannerInterface::follow(const std::string& robot, ConstVector start, const std::vector<Pose>& poses,
                                    const CartesianOptions& options, const Interrupt& interrupt) {
  Impl& impl = *impl_;
  const PlannerOptions& planner = planner_options({robot});
  const Deadline deadline(common_options(planner).time_limit, interrupt);
  require_planner_for_one(planner);
  impl.require_backend_keeps_clearance(planner);
  impl.require_state(robot, start);
  const PosesToFollow followed = poses_to_follow(*impl.placed(robot), start, poses, options);
  place_constraints(impl.scene, robot, options.constraints);  // throws
  const PlanRequest request{
      .robot = robot, .start = start, .goals = {GoalConstraint::any()}, .constraints = options.constraints};
  impl.request.reset();
  impl.result.reset();
  impl.statistics = {};
  const OwnedProblem owned = impl.make_checkers(deadline, [&] { return impl.problem_of(request, planner); });
  return follow_poses(*owned.problem, followed, deadline, impl.statistics);
}

}  // namespace srmp
