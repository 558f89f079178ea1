#include "srmp/planning/post_process.hpp"

#include <algorithm>

#include "srmp/planning/certificates/verify.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

class PostProcess {
 public:
  PostProcess(const SingleRobotProblem& problem, const std::vector<Eigen::VectorXd>& path, std::size_t escape,
              const Deadline& deadline, PlanStatistics& statistics)
      : problem_(problem),
        common_(common_options(problem.options)),
        limits_(scaled(problem.limits, common_)),
        path_(stack_waypoints(path)),
        escape_(escape),
        until_(std::max(deadline.remaining(), 0.0) + post::grace_period, [&] { return deadline.cancelled(); }),
        statistics_(statistics) {}

  Trajectory run() {
    for (double deviation = common_.blend_deviation;; deviation *= post::shrink) {
      if (deviation < post::min_deviation) deviation = 0.0;
      Trajectory trajectory = in_time(deviation);
      trajectory.robot = problem_.placed;
      if (!common_.certify) return trajectory;
      Certificate certificate = certified(trajectory);
      const bool rounded = deviation > 0.0 && common_.timing == "toppra";
      if (rounded && !certificate.proved_free() && !until_.stop_requested()) continue;
      if (!certificate.holds())
        throw Error("internal error: the trajectory found is wrong (" + certificate.faults.front().text +
                    "); nothing is returned. Please report this");
      trajectory.certificate = std::make_shared<const Certificate>(std::move(certificate));
      return trajectory;
    }
  }

 private:
  Trajectory in_time(double deviation) {
    const double start = until_.elapsed();
    Trajectory trajectory;
    if (common_.timing == "none") {
      trajectory = {problem_.checker.robot().joint_names(),
                    path_,
                    RowMatrix(0, path_.cols()),
                    RowMatrix(0, path_.cols()),
                    {},
                    path_};
    } else {
      const auto workspace = problem_.checker.make_workspace();
      TimingOptions options = timing_options(common_, deviation);
      options.reach = problem_.checker.reach();
      options.is_free = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
        return problem_.checker.is_motion_free(a, b, *workspace);
      };
      trajectory = time_parameterize(path_, problem_.checker.robot().joint_names(), limits_, options);
    }
    statistics_.timing_time_s += until_.elapsed() - start;
    return trajectory;
  }

  Certificate certified(const Trajectory& trajectory) {
    const double start = until_.elapsed();
    const bool timed = trajectory.timed();
    CertifyOptions options{.limits = timed, .jerk = common_.timing == "ruckig", .deadline = &until_};
    if (escape_ > 0) options.free_from = timed ? time_at(trajectory) : static_cast<double>(escape_);
    if (!judge_) judge_ = make_checker(problem_.scene, problem_.robot, {.mode = CheckMode::coal});
    Certificate certificate = timed ? certify(trajectory, *judge_, limits_, options)
                                    : certify(numbered(trajectory), *judge_, limits_, options);
    const Eigen::VectorXd end = trajectory.positions.bottomRows(1).transpose();
    certificate.goal_error = goal_error(problem_.goals, problem_.checker, end).error;
    certificate.bound = statistics_.bound;
    certificate.bound_graph = statistics_.bound_graph;
    statistics_.verification_time_s += until_.elapsed() - start;
    return certificate;
  }

  /// When the escape has come out: there is a stop.
  double time_at(const Trajectory& trajectory) const {
    Eigen::Index row{};
    (trajectory.positions.rowwise() - path_.row(static_cast<Eigen::Index>(escape_))).rowwise().norm().minCoeff(&row);
    return trajectory.times[row];
  }

  const SingleRobotProblem& problem_;
  const CommonOptions& common_;
  const MotionLimits limits_;
  const RowMatrix path_;
  const std::size_t escape_;
  const Deadline until_;
  std::unique_ptr<const Checker> judge_;  // has nothing in common with the checker that planned
  PlanStatistics& statistics_;
};

}  // namespace

void note_failure(const PlanningError& error, const Deadline& deadline, PlanStatistics& statistics) {
  statistics.status = error.status();
  statistics.reason = error.what();
  statistics.plan_time_s = statistics.total_time_s = deadline.elapsed();
}

TimingOptions timing_options(const CommonOptions& options, double deviation) {
  return {.method = options.timing == "ruckig" ? TimingMethod::ruckig : TimingMethod::toppra,
          .sample_period = options.sample_period,
          .blend_deviation = deviation};
}

Trajectory numbered(Trajectory trajectory) {
  const Eigen::Index rows = trajectory.positions.rows();
  if (!trajectory.timed()) trajectory.times = Eigen::VectorXd::LinSpaced(rows, 0.0, static_cast<double>(rows - 1));
  return trajectory;
}

MotionLimits scaled(MotionLimits limits, const CommonOptions& options) {
  limits.velocity *= options.velocity_scaling;
  limits.acceleration *= options.acceleration_scaling;
  limits.jerk *= options.acceleration_scaling;
  return limits;
}

Trajectory post_process(const SingleRobotProblem& problem, const std::vector<Eigen::VectorXd>& path, std::size_t escape,
                        const Deadline& deadline, PlanStatistics& statistics) {
  return PostProcess(problem, path, escape, deadline, statistics).run();
}

}  // namespace srmp
