#include "srmp/planning/obstacles/moving_obstacles.hpp"

#include <algorithm>
#include <optional>

#include "srmp/planning/certificates/joint_certificates.hpp"
#include "srmp/planning/certified_timing.hpp"
#include "srmp/planning/obstacles/prioritised_in_time.hpp"
#include "srmp/planning/obstacles/timed_motion.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/search/graph.hpp"
#include "srmp/trajectory/certify.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

Trajectory stationary_at(const Trajectory& motion, Eigen::Index row) {
  return stationary(motion.joint_names, motion.positions.middleRows(row, 1), 0.0);
}

// --- the plan

class PlanAround {
 public:
  PlanAround(const PlanProblem& problem, const PlanTogether& plan_together, const Deadline& deadline,
             PlanStatistics& statistics, const WaitingOptions& options)
      : problem_(problem),
        options_(options),
        common_(common_options(problem.options)),
        obstacles_(problem.obstacles),
        plan_together_(plan_together),
        deadline_(deadline),
        statistics_(statistics) {
    for (const auto* robots : {&problem.robots, &problem.stationary})
      for (const RobotProblem& robot : *robots)
        waiting_.emplace(robot.robot, stationary(robot.placed->model->joint_names(), robot.start.transpose(), 0.0));
  }

  MultiTrajectory run() {
    {
      const PhaseTimer timer(deadline_, statistics_.verification_time_s);
      find_pairs();
      for (const auto& pair : pairs_) require_start(*pair);
    }
    if (refused_)
      prioritised().require_endpoints();
    else
      begin_together();
    if (refused_) {
      plan_prioritised();
    } else {
      certify();
      if (ends_late()) try_earlier();
    }
    return std::move(planned_);
  }

 private:
  /// A robot that is planned or stationary, and a moving obstacle that it can reach.
  struct Pair {
    Pair(std::string robot, std::string other, const Checker& checker, const Trajectory& motion,
         const Deadline& deadline)
        : robot(std::move(robot)),
          other(std::move(other)),
          its{{nullptr, &checker, false, &motion}},
          monitor(its, deadline) {}

    const std::string robot, other;
    const std::vector<MovingRobot> its;
    CollisionMonitor monitor;
  };

  [[noreturn]] void fail(Status status, const std::string& reason) const { throw PlanningError(status, reason); }

  void find_pairs() {
    std::vector<std::string> moving, holding;
    for (const RobotProblem& part : problem_.robots) moving.push_back(part.robot);
    for (const auto& [name, motion] : waiting_)
      if (std::find(moving.begin(), moving.end(), name) == moving.end()) holding.push_back(name);
    group_ = add_pairs(moving);
    if (!holding.empty()) stationary_group_ = add_pairs(holding);
  }

  /// The checkers of these robots and the moving obstacles.
  std::unique_ptr<const GroupCheckers> add_pairs(const std::vector<std::string>& robots) {
    std::vector<std::string> names = robots;
    for (const auto& [name, motion] : obstacles_) names.push_back(name);
    auto checkers = std::make_unique<const GroupCheckers>(
        problem_.scene, names, CheckerOptions{.mode = CheckMode::coal}, 1, make_checker, deadline_);
    for (std::size_t i = 0; i < robots.size(); ++i)
      for (std::size_t j = robots.size(); j < names.size(); ++j)
        if (const Checker* checker = checkers->pair(i, j))
          pairs_.push_back(std::make_unique<Pair>(names[i], names[j], *checker, obstacles_.at(names[j]), deadline_));
    return checkers;
  }

  // --- what no delay can help

  void require_start(Pair& pair) {
    const Trajectory &here = waiting_.at(pair.robot), &motion = obstacles_.at(pair.other);
    const auto stands_on_it = [&](const Trajectory& at, const std::string& does) -> std::optional<PlanningError> {
      const MotionProof proof = prove_collision_free(*pair.its.front().exact_checker, here, at, {.gap_tolerance = 1.0});
      if (proof.free) return std::nullopt;
      return PlanningError(Status::start_invalid,
                           "the committed motion of '" + pair.other + "' " + does + " '" + pair.robot +
                               "' starts: " + bodies(pair, proof.body_a, proof.body_b) + " are in collision");
    };
    if (const auto error = stands_on_it(stationary_at(motion, 0), "begins where")) throw *error;
    if (const auto error = stands_on_it(stationary_at(motion, motion.positions.rows() - 1), "ends where")) {
      if (!moves(pair.robot)) throw *error;
      if (!refused_) refused_ = error;  // it may have left by then
    }
    if (moves(pair.robot)) return;
    if (const auto collision = collision_while_waiting(pair))
      fail(Status::exhausted, "the committed motion of '" + pair.other + "' passes through '" + pair.robot +
                                  "', which holds: " + text(pair, *collision));
  }

  bool moves(const std::string& robot) const {
    return std::any_of(problem_.robots.begin(), problem_.robots.end(),
                       [&](const RobotProblem& part) { return part.robot == robot; });
  }

  /// The name of a link of the robot, or of an object attached to it.
  std::string full_name(const std::string& robot, const std::string& body) const {
    const auto& links = problem_.scene.robot(robot).model->link_names();
    return std::find(links.begin(), links.end(), body) == links.end() ? body : robot + "/" + body;
  }

  std::string bodies(const Pair& pair, const std::string& a, const std::string& b) const {
    return std::string("'").append(full_name(pair.robot, a)) + "' and '" + b + "'";
  }

  std::string text(const Pair& pair, const CollisionInterval& collision) const {
    return bodies(pair, collision.body_a, collision.body_b) +
           (collision.contact ? " touch" : " cannot be proved apart") + " at " + to_text(collision.from) + " s";
  }

  /// A robot that rests all the while.
  std::optional<CollisionInterval> collision_while_waiting(Pair& pair) {
    const auto collision = pair.monitor.prove(waiting_.at(pair.robot));
    stop_if_late();
    return collision;
  }

  void stop_if_late() const {
    if (deadline_.cancelled()) fail(Status::cancelled, "the plan was cancelled while the others' motions were awaited");
    if (deadline_.expired())
      fail(Status::timed_out, "no motions that suit the committed ones were found within the time limit of " +
                                  to_text(common_.time_limit) + " s");
  }

  // --- all motions begun together

  /// Leaves why not in `refused_`.
  void begin_together() {
    try {
      planned_ = plan_together_();
      undelayed_ = planned_.robots;
      const PhaseTimer timer(deadline_, statistics_.verification_time_s);
      const double delay = first_delay();
      for (auto& [name, trajectory] : planned_.robots) begin_after(delay, trajectory);
    } catch (const PlanningError& error) {
      if (error.status() != Status::exhausted || deadline_.stop_requested()) throw;
      refused_ = error;
    }
  }

  double first_delay() {
    double latest = 0.0;
    for (const auto& [name, motion] : obstacles_) latest = std::max(latest, end_of(motion));
    std::optional<Collision> waiting;
    for (int i = 0;; ++i) {
      const double delay = std::min(i * options_.delay_step, latest);
      const auto collision = first_collision_after(delay);
      if (!collision) return delay;
      if (i == 0) waiting = first_while_waiting();
      const double next = std::min((i + 1) * options_.delay_step, latest);
      if (delay < latest && (!waiting || next <= waiting->time)) continue;
      if (waiting)
        fail(Status::exhausted,
             "a committed motion passes through where a robot waits, and it cannot leave in time: " + waiting->text);
      fail(Status::exhausted,
           "no time to begin suits the committed motions: begun after " + to_text(delay) + " s, " + collision->text);
    }
  }

  struct Collision {
    double time;  // [s]
    std::string text;
  };

  /// The first collision when all motions begin after `delay`, during which the robots wait at their starts.
  std::optional<Collision> first_collision_after(double delay) {
    std::map<std::string, Trajectory> moved;
    for (const auto& [name, motion] : planned_.robots) moved.emplace(name, delayed(motion, delay));
    const auto first = [&](const auto& collision_of) -> std::optional<Collision> {
      for (const auto& pair : pairs_) {
        if (!moved.contains(pair->robot)) continue;
        const std::optional<CollisionInterval> collision = collision_of(pair->monitor, moved.at(pair->robot));
        stop_if_late();
        if (collision) return Collision{collision->from, text(*pair, *collision)};
      }
      return std::nullopt;
    };
    const auto seen = first([&](CollisionMonitor& monitor, const Trajectory& motion) {
      return monitor.find_collision_at_samples(motion, delay, std::numeric_limits<double>::infinity());
    });
    return seen ? seen
                : first([](CollisionMonitor& monitor, const Trajectory& motion) { return monitor.prove(motion); });
  }

  /// Later than that nothing may begin.
  std::optional<Collision> first_while_waiting() {
    std::optional<Collision> first;
    for (const auto& pair : pairs_)
      if (moves(pair->robot))
        if (const auto collision = collision_while_waiting(*pair);
            collision && (!first || collision->from < first->time))
          first = {collision->from, text(*pair, *collision)};
    return first;
  }

  void begin_after(double delay, Trajectory& trajectory) {
    const bool goes = (trajectory.positions.rowwise() - trajectory.positions.row(0)).cwiseAbs().maxCoeff() > 0.0;
    trajectory = delayed(trajectory, delay);
    if (goes) statistics_.flow_time_s += delay;
    statistics_.makespan_s = std::max(statistics_.makespan_s, end_of(trajectory));
  }

  // --- each by itself

  double gain() const { return std::max(options_.min_gain, options_.min_gain_fraction * statistics_.makespan_s); }

  /// Would the motions end much earlier if they could begin at once?
  bool ends_late() const {
    double soonest = 0.0;
    for (const auto& [name, motion] : undelayed_) soonest = std::max(soonest, end_of(motion));
    return soonest < statistics_.makespan_s - gain();
  }

  PrioritisedInTime& prioritised() {
    if (!prioritised_) prioritised_ = std::make_unique<PrioritisedInTime>(problem_, *group_, deadline_, statistics_);
    return *prioritised_;
  }

  void plan_prioritised() {
    auto found = prioritised().plan(undelayed_);
    if (!found) {
      stop_if_late();
      throw *refused_;
    }
    take(std::move(*found));
    certify();
  }

  /// Motions that wait are there already, and proved: no others may cost them that, so they stay unless the others are
  /// proved within the time limit too.
  void try_earlier() {
    if (deadline_.stop_requested()) return;
    auto found = prioritised().plan_earlier(undelayed_, statistics_.makespan_s - gain());
    statistics_.plan_time_s = deadline_.elapsed();
    if (!found) return;
    MultiTrajectory proved = std::move(planned_);
    PlanStatistics statistics = statistics_;
    take(std::move(*found));
    try {
      certify();
      if (!deadline_.stop_requested()) return;
    } catch (const PlanningError&) {  // the deadline passed
    }
    planned_ = std::move(proved);
    statistics_ = std::move(statistics);
  }

  void take(PrioritisedInTime::Motions found) {
    planned_.robots = std::move(found);
    statistics_.status = Status::solved;
    statistics_.reason.clear();
    statistics_.found_by = "safe-interval path planning";
    statistics_.path_cost_rad = statistics_.makespan_s = statistics_.flow_time_s = 0.0;
    for (const auto& [name, motion] : planned_.robots) {
      statistics_.path_cost_rad += statistics_.robot_cost_rad[name] = path_length(motion.waypoints);
      statistics_.makespan_s = std::max(statistics_.makespan_s, end_of(motion));
      statistics_.flow_time_s += arrival_time(motion);
    }
    statistics_.search_cost_rad = statistics_.path_cost_rad;
    statistics_.bound = search::infinity;
    statistics_.bound_graph.clear();
    statistics_.solutions = {{deadline_.elapsed(), statistics_.path_cost_rad, statistics_.bound, {}}};
  }

  // --- proof

  /// By checkers in which no obstacle stands where its motion ends.
  void certify() {
    statistics_.plan_time_s = deadline_.elapsed();
    if (!common_.certify) return;
    const PhaseTimer timer(deadline_, statistics_.verification_time_s);
    const Deadline until = with_grace_period(deadline_);
    const std::size_t count = problem_.robots.size();
    std::vector<RobotMotion> moving;
    for (std::size_t i = 0; i < group_->size(); ++i) {
      const std::string& name = group_->names()[i];
      if (i < count)
        moving.push_back({i, &problem_.robots[i], planned_.at(name)});
      else
        moving.push_back({i, nullptr, obstacles_.at(name)});
    }
    std::vector<Certificate> certificates = joint_certificates(*group_, nullptr, moving, common_, until);
    for (std::size_t i = 0; i < count; ++i) {
      const std::string& name = group_->names()[i];
      attach_certificate(planned_.robots.at(name), std::move(certificates[i]), name, statistics_);
    }
  }

  const PlanProblem& problem_;
  const WaitingOptions options_;
  const CommonOptions& common_;
  const std::map<std::string, Trajectory>& obstacles_;
  const PlanTogether& plan_together_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::map<std::string, Trajectory> waiting_;  // at the starts
  std::unique_ptr<const GroupCheckers> group_, stationary_group_;
  std::vector<std::unique_ptr<Pair>> pairs_;
  std::optional<PlanningError> refused_;  // motions begun together
  MultiTrajectory planned_;
  std::map<std::string, Trajectory> undelayed_;     // as they were planned, begun together
  std::unique_ptr<PrioritisedInTime> prioritised_;  // if it comes to that
};

}  // namespace

void forget_motions(PlanStatistics& statistics) {
  statistics.path_cost_rad = statistics.search_cost_rad = statistics.bound = 0.0;
  statistics.makespan_s = statistics.flow_time_s = 0.0;
  statistics.bound_graph.clear();
  statistics.found_by.clear();
  statistics.solutions.clear();
  for (auto& [robot, cost] : statistics.robot_cost_rad) cost = 0.0;
}

void stand_at_ends(Scene& scene, const std::map<std::string, Eigen::VectorXd>& starts,
                   const std::map<std::string, Trajectory>& committed, const CommonOptions& options) {
  if (!committed.empty() && options.timing == "none")
    throw InvalidArgument(
        "obstacles ask for motions in time, but the planner's timing is 'none'; use 'toppra' or 'ruckig'");
  for (const auto& [name, motion] : committed) {
    const RobotModel& model = *scene.robot(name).model;
    if (starts.contains(name))
      throw InvalidArgument("robot '" + name +
                            "' has a start and is an obstacle too; it is either planned or committed");
    const auto require = [&](bool fine, const std::string& why) {
      if (!fine) throw InvalidArgument("obstacle '" + name + "': " + why);
    };
    try {
      motion.validate();
    } catch (const InvalidArgument& error) {
      require(false, error.what());
    }
    require(motion.timed(), "the trajectory has no times; a committed motion must say where it is when");
    require(motion.times[0] == 0.0,
            "the trajectory begins at " + to_text(motion.times[0]) + " s; all motions begin together at time 0");
    const auto checker = make_checker(scene, name, {.mode = CheckMode::coal});
    const Certificate certificate =
        certify(motion, *checker, default_limits(model), {.limits = false, .collisions = false, .at_rest = false});
    if (!certificate.holds()) require(false, certificate.faults.front().text);
  }
  for (const auto& [name, motion] : committed) {
    const Eigen::VectorXd end = motion.positions.bottomRows(1).transpose();
    scene.set_qpos(name, scene.robot(name).model->clamped(end, std::numeric_limits<double>::infinity()));
  }
}

MultiTrajectory plan_among_obstacles(const PlanProblem& problem, const PlanTogether& plan_together,
                                     const Deadline& deadline, PlanStatistics& statistics,
                                     const WaitingOptions& waiting) {
  return PlanAround(problem, plan_together, deadline, statistics, waiting).run();
}

}  // namespace srmp
