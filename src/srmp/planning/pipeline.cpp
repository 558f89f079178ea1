#include "srmp/planning/pipeline.hpp"

#include "srmp/planning/certified_timing.hpp"
#include "srmp/planning/endpoints/joint_endpoints.hpp"
#include "srmp/planning/endpoints/start_in_motion.hpp"
#include "srmp/planning/joint_paths.hpp"
#include "srmp/planning/obstacles/moving_obstacles.hpp"
#include "srmp/planning/options/registry.hpp"
#include "srmp/planning/stationary_robots.hpp"
#include "srmp/planning/strategies/path_alone.hpp"

namespace srmp {

namespace {

class Pipeline {
 public:
  Pipeline(const PlanProblem& problem, const Deadline& deadline, PlanStatistics& statistics)
      : problem_(problem),
        deadline_(deadline),
        statistics_(statistics),
        work_(static_cast<std::size_t>(num_threads(problem.options)), statistics),
        one_robot_(problem.is_for_one()) {}

  MultiTrajectory run() {
    require_stationary_starts(problem_);
    MultiTrajectory motions =
        problem_.obstacles.empty()
            ? plan_together()
            : plan_among_obstacles(problem_, [this] { return plan_together(); }, deadline_, statistics_);
    add_stationary_robots(problem_, motions, deadline_, statistics_);
    return motions;
  }

 private:
  /// All robots begin at time 0, and what stands still is all there is.
  MultiTrajectory plan_together() {
    if (problem_.robots.front().start_in_motion) return plan_in_motion();
    std::vector<RobotPath> alone = paths_alone();
    require_joint_endpoints(problem_.checkers.planning, endpoints_of(alone));
    const std::size_t collision_segments = alone.front().endpoints.collision_segments();
    JointPaths paths = joint_paths(std::move(alone));
    statistics_.plan_time_s = deadline_.elapsed();
    return certified_timing(problem_, std::move(paths), collision_segments, work_, deadline_, statistics_);
  }

  /// One robot, which is in motion at its start: of some paths that turn towards the one that was found, the fastest.
  MultiTrajectory plan_in_motion() {
    LeadOutOfMotion lead(problem_, deadline_);
    lead.require_free();
    const RobotPath path = path_of_one_robot();
    statistics_.plan_time_s = deadline_.elapsed();
    MultiTrajectory best;
    for (RowMatrix& waypoints : lead.followed_by(path.waypoints)) {
      JointPaths paths;
      paths.smoothed.push_back(path_of_one(std::move(waypoints)));
      try {
        MultiTrajectory motion = certified_timing(problem_, std::move(paths), 0, work_, deadline_, statistics_);
        if (best.robots.empty() || motion.duration() < best.duration()) best = std::move(motion);
      } catch (const PlanningError& error) {
        if (best.robots.empty() || error.status() != Status::timed_out) throw;
      }
      if (deadline_.stop_requested()) break;
    }
    statistics_.makespan_s = statistics_.flow_time_s = best.duration();
    return best;
  }

  /// Endpoints of each robot, and its path if the others were not there.
  std::vector<RobotPath> paths_alone() {
    std::vector<RobotPath> paths(problem_.robots.size());
    if (one_robot_) {
      paths.front() = path_of_one_robot();
      return paths;
    }
    work_.run(paths.size(), deadline_, [&](std::size_t i, const Deadline& deadline, PlanStatistics& statistics) {
      paths[i] =
          find_path_alone(problem_, problem_.robots[i], problem_.checkers.planning.alone(i), deadline, statistics);
    });
    return paths;
  }

  /// By the planner that the options name.
  RobotPath path_of_one_robot() {
    RobotContext context(problem_, problem_.robots.front(), problem_.options, problem_.checkers.planning.alone(0),
                         deadline_, statistics_);
    try {
      RobotPath path = find_robot_path(context);
      verify_recovery(context, path.endpoints);
      return path;
    } catch (const PlanningError&) {
      context.checks.write(statistics_);
      throw;
    }
  }

  static std::vector<const RobotEndpoints*> endpoints_of(const std::vector<RobotPath>& paths) {
    std::vector<const RobotEndpoints*> endpoints;
    for (const RobotPath& path : paths) endpoints.push_back(&path.endpoints);
    return endpoints;
  }

  JointPaths joint_paths(std::vector<RobotPath> alone) {
    if (!one_robot_) return find_joint_paths(problem_, std::move(alone), work_, deadline_, statistics_);
    const RobotPath& path = alone.front();
    const auto lead = static_cast<Eigen::Index>(path.endpoints.recovery_segments());
    RowMatrix waypoints(lead + path.waypoints.rows(), path.waypoints.cols());
    for (Eigen::Index row = 0; row < lead; ++row)
      waypoints.row(row) = path.endpoints.recovery[static_cast<std::size_t>(row)].transpose();
    waypoints.bottomRows(path.waypoints.rows()) = path.waypoints;
    JointPaths paths;
    paths.smoothed.push_back(path_of_one(std::move(waypoints)));
    const auto cost = statistics_.robot_cost_rad.find(problem_.robots.front().robot);  // of requests for many
    if (cost != statistics_.robot_cost_rad.end()) cost->second = statistics_.path_cost_rad;
    return paths;
  }

  const PlanProblem& problem_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  ParallelWork work_;
  const bool one_robot_;
};

}  // namespace

MultiTrajectory run_pipeline(const PlanProblem& problem, const Deadline& deadline, PlanStatistics& statistics) {
  try {
    MultiTrajectory motions = Pipeline(problem, deadline, statistics).run();
    statistics.status = Status::solved;
    statistics.reason.clear();
    statistics.total_time_s = deadline.elapsed();
    return motions;
  } catch (const PlanningError& error) {
    if (!problem.obstacles.empty()) forget_motions(statistics);
    record_failure(error, deadline, statistics);
    throw;
  }
}

void record_failure(const PlanningError& error, const Deadline& deadline, PlanStatistics& statistics) {
  statistics.status = error.status();
  statistics.reason = error.what();
  statistics.plan_time_s = statistics.total_time_s = deadline.elapsed();
}

}  // namespace srmp
