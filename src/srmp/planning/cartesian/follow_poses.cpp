#include "srmp/planning/cartesian/follow_poses.hpp"

#include "srmp/core/error.hpp"
#include "srmp/planning/cartesian/cartesian_graph.hpp"
#include "srmp/planning/certificates/joint_certificates.hpp"
#include "srmp/planning/certified_timing.hpp"
#include "srmp/planning/endpoints/close_motions.hpp"
#include "srmp/planning/endpoints/endpoints.hpp"
#include "srmp/planning/endpoints/goal_configurations.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/solution_record.hpp"
#include "srmp/search/astar.hpp"

namespace srmp {

namespace {

/// What finding a path along poses trades.
struct FollowTuning {
  std::vector<double> steps{0.02, 0.01, 0.005};    ///< [m] between poses, one search each: coarse ones are quicker
  std::vector<double> close_steps{0.005, 0.0025};  ///< [m] where an end surely is closer than the clearance
  double turn_of_step{3.5};                        ///< [rad/m]: poses are no farther apart in rotation
  /// Before poses are searched that cannot be reached at all: most paths are found within fewer. That search takes as
  /// long as some expansions for each layer.
  std::uint64_t first_expansions{500}, first_of_layer{4};
  /// Beyond these, for each layer of a graph whose ends may be closer than the clearance: motions near such ends take
  /// long to check, and where none leads on, the robot's redundancy has many.
  std::uint64_t close_expansions{5};
  double weight{15.0};   ///< of the heuristic: much of it follows the nearest configurations
  double fraction{0.5};  ///< of the tolerance that the straight segments may use; rounded corners have the rest
  double closer{0.25};   ///< poses along less than this fraction of the tolerance: only the first is searched for
  /// Of the tolerance: how far corners may be rounded, one after the other until the motion keeps to the poses.
  std::vector<double> corners{0.5, 0.1, 0.02, 0.0};
};
const FollowTuning tuning;

class FollowPoses {
 public:
  FollowPoses(const PlanProblem& problem, const PosesToFollow& poses, const Deadline& deadline,
              PlanStatistics& statistics)
      : problem_(problem),
        poses_(poses),
        deadline_(deadline),
        statistics_(statistics),
        context_(problem, problem.robots.front(), problem.options, problem.checkers.planning.alone(0), deadline,
                 statistics),
        in_base_(poses.path.thinned(fraction_of(tuning.closer, poses.tolerance))
                     .seen_from(problem.robots.front().placed->base)) {}

  Trajectory run() {
    RowMatrix waypoints = path_before_deadline();
    statistics_.plan_time_s = deadline_.elapsed();
    for (const double fraction : tuning.corners) {
      Trajectory motion = in_time(waypoints, fraction * poses_.tolerance.position);
      const CartesianDeviation deviation = deviation_of(motion);
      if (!keeps(deviation)) continue;
      if (motion.certificate) {
        Certificate certificate = *motion.certificate;
        certificate.cartesian_deviation = deviation;
        motion.certificate = std::make_shared<const Certificate>(std::move(certificate));
      }
      return motion;
    }
    throw Error("internal error: the motion along the poses leaves them; nothing is returned. Please report this");
  }

 private:
  RowMatrix path_before_deadline() {
    try {
      return path();
    } catch (const MotionCheckStopped&) {
      context_.stop_if_late("the search along the poses");
      throw;
    }
  }

  RowMatrix path() {
    const RobotEndpoints endpoints = find_endpoints(context_, true);
    if (endpoints.recovery_segments() > 0)
      throw PlanningError(Status::start_invalid,
                          "the start is in collision; a motion along poses does not begin with a way out of it");
    require_last_pose(endpoints.start);
    find_close_ends(endpoints.start);
    std::string reason;
    for (const double step : steps()) {
      CartesianGraph graph(context_, endpoints.start, in_base_, graph_options(step));
      const search::Result result = search_in(graph);
      if (result.status == Status::solved) {
        RowMatrix found = waypoints(graph, result);
        reason = close_ends_violation(graph, result, found);
        if (!reason.empty()) continue;
        record(result, step);
        return found;
      }
      if (deadline_.stop_requested()) throw_stopped(graph);
      reason = graph.unreachable_pose();
      if (!reason.empty()) break;
      reason = graph.obstruction();
    }
    throw PlanningError(Status::exhausted, reason);
  }

  /// With path constraints: refuses a last pose at which every configuration that is found breaks one.
  void require_last_pose(const Eigen::VectorXd& start) {
    if (!context_.task.constraints) return;
    const GoalConstraint goal = GoalConstraint::pose(poses_.path.end(), link());
    std::string unreachable, why;
    for (const Eigen::VectorXd& q :
         goal_configurations(*context_.task.placed, context_.task.constraints.get(), goal, goal.targets.front(), start,
                             context_.common.ik_solutions, deadline_, unreachable)) {
      const std::string broken = context_.checks.constraints()->violation(q);
      if (broken.empty()) return;
      if (why.empty()) why = broken;
    }
    context_.stop_if_late("the search for configurations at the last pose");
    if (!why.empty()) throw PlanningError(Status::goal_invalid, "the goal is invalid: " + why);
  }

  /// Whether the path begins closer to something than the clearance, and whether it may or must end so, by some
  /// configurations that put the link at the last pose.
  void find_close_ends(const Eigen::VectorXd& start) {
    if (context_.common.clearance == 0.0) return;
    close_.emplace(problem_.checkers, deadline_);
    const bool starts_close = !close_->is_clear(start);
    IkOptions options{.seeds = CartesianGraphOptions{}.many_seeds};
    options.max_solutions = options.seeds;
    options.other_positions = context_.checks.checker().other_positions();
    std::size_t clear = 0, close = 0;
    for (const Eigen::VectorXd& q :
         inverse_kinematics(context_.robot, in_base_.end(), start, options, link(), deadline_))
      if (close_->is_clear(q))
        ++clear;
      else if (close_->is_free(q))
        ++close;
    has_close_ends_ = starts_close || close > 0;
    surely_close_ = starts_close || (close > 0 && clear == 0);
  }

  /// Between poses, one search each.
  std::vector<double> steps() const {
    if (surely_close_) return tuning.close_steps;
    std::vector<double> steps = tuning.steps;
    if (has_close_ends_) steps.push_back(tuning.close_steps.back());
    return steps;
  }

  /// By which pair the path breaks the rule for ends that are closer than the clearance (CloseMotions), which its edges
  /// keep each by itself; "": it keeps it.
  std::string close_ends_violation(const CartesianGraph& graph, const search::Result& result, const RowMatrix& rows) {
    if (!has_close_ends_) return "";
    std::vector<Eigen::VectorXd> begin, end;
    const auto row = [&](std::size_t i) -> Eigen::VectorXd {
      return rows.row(static_cast<Eigen::Index>(i)).transpose();
    };
    for (std::size_t i = 0; begin.empty() || !graph.is_clear(result.path[i - 1]); ++i) begin.push_back(row(i));
    for (std::size_t i = result.path.size(); end.empty() || !graph.is_clear(result.path[i]);) end.push_back(row(--i));
    const std::string why = close_->approach(begin);
    return why.empty() ? close_->approach(end) : why;
  }

  [[noreturn]] void throw_stopped(CartesianGraph& graph) const {
    const std::string states = " (" + std::to_string(statistics_.expansions) + " states expanded)";
    if (deadline_.cancelled())
      throw PlanningError(Status::cancelled, "the plan was cancelled during the search along the poses" + states);
    throw PlanningError(Status::timed_out, "no path within the time limit of " + to_text(context_.common.time_limit) +
                                               " s" + states + ": " + graph.reached());
  }

  CartesianGraphOptions graph_options(double step) const {
    return {.link = context_.robot.link_index(link()),
            .tolerance = fraction_of(tuning.fraction, poses_.tolerance),
            .step = step,
            .turn = tuning.turn_of_step * step,
            .close_ends = has_close_ends_};
  }

  const std::string& link() const { return poses_.link.empty() ? context_.robot.end_effector() : poses_.link; }

  search::Result search_in(CartesianGraph& graph) {
    const PhaseTimer timer(deadline_, statistics_.search_time_s);
    const auto heuristic = [&](search::StateId state) { return graph.distance_to_end(state); };
    const std::vector<search::StateId> starts{0};
    search::WeightedAstar search(graph, starts, heuristic, {.weight = tuning.weight});
    std::optional<Status> stop;
    try {
      stop = search.improve(deadline_, tuning.first_expansions + tuning.first_of_layer * graph.layers());
      if (!stop && !search.finished() && graph.unreachable_pose().empty())
        stop =
            search.improve(deadline_, has_close_ends_ ? tuning.close_expansions * graph.layers() : search::unlimited);
    } catch (const MotionCheckStopped&) {
      stop = Status::timed_out;
    }
    search::Result result = search.result(stop);
    context_.count(result.statistics);
    context_.checks.write(statistics_);
    statistics_.states += graph.size();
    statistics_.memory_bytes =
        std::max<std::uint64_t>(statistics_.memory_bytes, graph.memory() + result.statistics.memory);
    return result;
  }

  RowMatrix waypoints(const CartesianGraph& graph, const search::Result& result) const {
    RowMatrix rows(static_cast<Eigen::Index>(result.path.size()), static_cast<Eigen::Index>(context_.robot.dof()));
    rows.row(0) = graph.configuration(result.path.front()).transpose();
    for (Eigen::Index i = 1; i < rows.rows(); ++i)
      rows.row(i) = rows.row(i - 1) + context_.robot
                                          .difference(rows.row(i - 1).transpose(),
                                                      graph.configuration(result.path[static_cast<std::size_t>(i)]))
                                          .transpose();
    return rows;
  }

  void record(const search::Result& result, double step) {
    statistics_.path_cost_rad = statistics_.search_cost_rad = result.cost;
    statistics_.bound_graph = "configurations every " + to_text(1e3 * step) + " mm along the poses";
    statistics_.found_by = "search along the poses";
    record_solution(statistics_, result.cost / result.bound, deadline_);
  }

  Trajectory in_time(const RowMatrix& waypoints, double corner) {
    PlannerOptions options = problem_.options;
    std::visit([&](auto& typed) { typed.common.blend_deviation = std::min(typed.common.blend_deviation, corner); },
               options);
    const PlanProblem problem{problem_.scene, problem_.robots, problem_.checkers, options, problem_.heuristics};
    JointPaths paths;
    paths.smoothed.push_back(path_of_one(waypoints));
    paths.close_ends = has_close_ends_;
    ParallelWork work(1, statistics_);
    MultiTrajectory motions = certified_timing(problem, std::move(paths), 0, work, deadline_, statistics_);
    return std::move(motions.robots.begin()->second);
  }

  CartesianDeviation deviation_of(const Trajectory& motion) {
    const PhaseTimer timer(deadline_, statistics_.verification_time_s);
    const Deadline until = with_grace_period(deadline_);
    return prove_cartesian_deviation(motion.timed() ? motion : with_times(motion), *problem_.robots.front().placed,
                                     poses_.link, poses_.path, poses_.tolerance, until);
  }

  bool keeps(const CartesianDeviation& deviation) const {
    return is_within(deviation.position, deviation.rotation, poses_.tolerance);
  }

  const PlanProblem& problem_;
  const PosesToFollow& poses_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  RobotContext context_;
  const CartesianPath in_base_;
  std::optional<CloseMotions> close_;                 // with a clearance
  bool has_close_ends_{false}, surely_close_{false};  // may an end be closer than the clearance, must one be?
};

}  // namespace

Trajectory follow_poses(const PlanProblem& problem, const PosesToFollow& poses, const Deadline& deadline,
                        PlanStatistics& statistics) {
  try {
    Trajectory motion = FollowPoses(problem, poses, deadline, statistics).run();
    statistics.status = Status::solved;
    statistics.total_time_s = deadline.elapsed();
    return motion;
  } catch (const PlanningError& error) {
    record_failure(error, deadline, statistics);
    throw;
  }
}

}  // namespace srmp
