#include "srmp/planning/obstacles/moving_obstacles.hpp"

#include <algorithm>
#include <optional>

#include "srmp/planning/certificates/certify_together.hpp"
#include "srmp/planning/obstacles/prioritised_in_time.hpp"
#include "srmp/planning/obstacles/timed_motion.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/post_process.hpp"
#include "srmp/search/graph.hpp"
#include "srmp/trajectory/certify.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

constexpr double delay_step = 0.1;  // [s]
// A way round must arrive sooner by more than these: it takes longer ways, and the planner's.
constexpr double min_gain = 0.1;        // [s]
constexpr double min_gain_share = 0.1;  // of the time until all are there

Trajectory rest_at(const Trajectory& motion, Eigen::Index row) {
  return rest(motion.joint_names, motion.positions.middleRows(row, 1), 0.0);
}

// --- the plan

class PlanAround {
 public:
  PlanAround(const MultiRobotProblem& problem, const std::map<std::string, Eigen::VectorXd>& starts,
             const CommittedMotions& committed, const CheckerOptions& quick, const Deadline& deadline,
             PlanStatistics& statistics)
      : problem_(problem),
        common_(common_options(problem.options)),
        committed_(committed),
        quick_(quick),
        deadline_(deadline),
        statistics_(statistics) {
    for (const auto& [name, start] : starts) {
      const auto& joints = problem.scene.robot(name).model->joint_names();
      waiting_.emplace(name, rest(joints, start.transpose(), 0.0));
    }
  }

  MultiTrajectory run() {
    {
      const PhaseTimer timer(deadline_, statistics_.verification_time_s);
      find_pairs();
      for (const auto& pair : pairs_) require_start(*pair);
    }
    if (refused_)
      one_by_one().require_ends();
    else
      begin_together();
    if (refused_) {
      plan_one_by_one();
    } else {
      certify();
      if (late()) try_sooner();
    }
    return std::move(planned_);
  }

 private:
  /// A robot that is planned, or holds, and a committed one that it can meet.
  struct Pair {
    Pair(std::string robot, std::string other, const Checker& judge, const Trajectory& motion, const Deadline& deadline)
        : robot(std::move(robot)),
          other(std::move(other)),
          its{{nullptr, &judge, false, &motion}},
          watch(its, deadline) {}

    const std::string robot, other;
    const std::vector<MovingRobot> its;
    Watch watch;
  };

  [[noreturn]] void fail(Status status, const std::string& reason) const { throw PlanningError(status, reason); }

  void find_pairs() {
    std::vector<std::string> moving, holding;
    for (const MultiRobotPart& part : problem_.moving) moving.push_back(part.robot);
    for (const auto& [name, motion] : waiting_)
      if (std::find(moving.begin(), moving.end(), name) == moving.end()) holding.push_back(name);
    team_ = add_pairs(moving);
    if (!holding.empty()) held_ = add_pairs(holding);
  }

  /// The judges of these robots and the committed ones.
  std::unique_ptr<const GroupCheckers> add_pairs(const std::vector<std::string>& robots) {
    std::vector<std::string> names = robots;
    for (const auto& [name, motion] : committed_) names.push_back(name);
    auto judges = std::make_unique<const GroupCheckers>(problem_.scene, names, CheckerOptions{.mode = CheckMode::coal});
    for (std::size_t i = 0; i < robots.size(); ++i)
      for (std::size_t j = robots.size(); j < names.size(); ++j)
        if (const Checker* judge = judges->pair(i, j))
          pairs_.push_back(std::make_unique<Pair>(names[i], names[j], *judge, committed_.at(names[j]), deadline_));
    return judges;
  }

  // --- what no delay can help

  void require_start(Pair& pair) {
    const Trajectory &here = waiting_.at(pair.robot), &motion = committed_.at(pair.other);
    const auto stands_on_it = [&](const Trajectory& at, const std::string& does) -> std::optional<PlanningError> {
      const MotionProof proof = prove_collision_free(*pair.its.front().judge, here, at, {.gap_tolerance = 0.0});
      if (proof.free) return std::nullopt;
      return PlanningError(Status::start_invalid,
                           "the committed motion of '" + pair.other + "' " + does + " '" + pair.robot +
                               "' starts: " + bodies(pair, proof.body_a, proof.body_b) + " are in collision");
    };
    if (const auto error = stands_on_it(rest_at(motion, 0), "begins where")) throw *error;
    if (const auto error = stands_on_it(rest_at(motion, motion.positions.rows() - 1), "ends where")) {
      if (!moves(pair.robot)) throw *error;
      if (!refused_) refused_ = error;  // it may have left by then
    }
    if (moves(pair.robot)) return;
    if (const auto met = meets_waiting(pair))
      fail(Status::exhausted, "the committed motion of '" + pair.other + "' passes through '" + pair.robot +
                                  "', which holds: " + text(pair, *met));
  }

  bool moves(const std::string& robot) const {
    return std::any_of(problem_.moving.begin(), problem_.moving.end(),
                       [&](const MultiRobotPart& part) { return part.robot == robot; });
  }

  /// Of a link of the robot, or an object that it holds.
  std::string full_name(const std::string& robot, const std::string& body) const {
    const auto& links = problem_.scene.robot(robot).model->link_names();
    return std::find(links.begin(), links.end(), body) == links.end() ? body : robot + "/" + body;
  }

  std::string bodies(const Pair& pair, const std::string& a, const std::string& b) const {
    return "'" + full_name(pair.robot, a) + "' and '" + b + "'";
  }

  std::string text(const Pair& pair, const Meeting& met) const {
    return bodies(pair, met.body_a, met.body_b) + (met.touch ? " touch" : " cannot be proved apart") + " at " +
           to_text(met.from) + " s";
  }

  /// A robot that rests all the while.
  std::optional<Meeting> meets_waiting(Pair& pair) {
    const auto met = pair.watch.prove(waiting_.at(pair.robot));
    stop_if_late();
    return met;
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
      planned_ = plan_multi_robot(problem_, deadline_, statistics_);
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
    for (const auto& [name, motion] : committed_) latest = std::max(latest, end_of(motion));
    std::optional<Encounter> waiting;
    for (int i = 0;; ++i) {
      const double delay = std::min(i * delay_step, latest);
      const auto met = first_meeting(delay);
      if (!met) return delay;
      if (i == 0) waiting = first_while_waiting();
      const double next = std::min((i + 1) * delay_step, latest);
      if (delay < latest && (!waiting || next <= waiting->time)) continue;
      if (waiting)
        fail(Status::exhausted,
             "a committed motion passes through where a robot waits, and it cannot leave in time: " + waiting->text);
      fail(Status::exhausted,
           "no time to begin suits the committed motions: begun after " + to_text(delay) + " s, " + met->text);
    }
  }

  struct Encounter {
    double time;  // [s]
    std::string text;
  };

  /// With all motions begun after `delay`, until when nobody meets those that wait.
  std::optional<Encounter> first_meeting(double delay) {
    std::map<std::string, Trajectory> moved;
    for (const auto& [name, motion] : planned_.robots) moved.emplace(name, delayed(motion, delay));
    const auto first = [&](const auto& met_by) -> std::optional<Encounter> {
      for (const auto& pair : pairs_) {
        if (!moved.contains(pair->robot)) continue;
        const std::optional<Meeting> met = met_by(pair->watch, moved.at(pair->robot));
        stop_if_late();
        if (met) return Encounter{met->from, text(*pair, *met)};
      }
      return std::nullopt;
    };
    const auto seen = first([&](Watch& watch, const Trajectory& motion) {
      return watch.look(motion, delay, std::numeric_limits<double>::infinity());
    });
    return seen ? seen : first([](Watch& watch, const Trajectory& motion) { return watch.prove(motion); });
  }

  /// Later than that nothing may begin.
  std::optional<Encounter> first_while_waiting() {
    std::optional<Encounter> first;
    for (const auto& pair : pairs_)
      if (moves(pair->robot))
        if (const auto met = meets_waiting(*pair); met && (!first || met->from < first->time))
          first = {met->from, text(*pair, *met)};
    return first;
  }

  void begin_after(double delay, Trajectory& trajectory) {
    const bool goes = (trajectory.positions.rowwise() - trajectory.positions.row(0)).cwiseAbs().maxCoeff() > 0.0;
    trajectory = delayed(trajectory, delay);
    if (goes) statistics_.flow_time_s += delay;
    statistics_.makespan_s = std::max(statistics_.makespan_s, end_of(trajectory));
  }

  // --- each by itself

  double gain() const { return std::max(min_gain, min_gain_share * statistics_.makespan_s); }

  /// Would the motions be over much sooner if they could begin at once?
  bool late() const {
    double soonest = 0.0;
    for (const auto& [name, motion] : undelayed_) soonest = std::max(soonest, end_of(motion));
    return soonest < statistics_.makespan_s - gain();
  }

  PrioritisedInTime& one_by_one() {
    if (!one_by_one_)
      one_by_one_ = std::make_unique<PrioritisedInTime>(problem_, committed_, *team_, quick_, deadline_, statistics_);
    return *one_by_one_;
  }

  void plan_one_by_one() {
    auto found = one_by_one().plan(undelayed_);
    if (!found) {
      stop_if_late();
      throw *refused_;
    }
    take(std::move(*found));
    certify();
  }

  /// Motions that wait are there already, and proved: no others may cost them that, so there must be time to prove
  /// those too.
  void try_sooner() {
    const Deadline until(std::max(deadline_.remaining() - proving_s_, 0.0), [this] { return deadline_.cancelled(); });
    if (until.stop_requested()) return;
    auto found = one_by_one().plan_sooner(undelayed_, statistics_.makespan_s - gain(), until);
    statistics_.plan_time_s = deadline_.elapsed();
    if (!found) return;
    MultiTrajectory proved = std::move(planned_);
    PlanStatistics statistics = statistics_;
    take(std::move(*found));
    certify();
    if (!deadline_.stop_requested()) return;
    planned_ = std::move(proved);
    statistics_ = std::move(statistics);
  }

  void take(PrioritisedInTime::Motions found) {
    planned_.robots = std::move(found);
    statistics_.status = Status::solved;
    statistics_.reason.clear();
    statistics_.path_cost_rad = statistics_.makespan_s = statistics_.flow_time_s = 0.0;
    for (const auto& [name, motion] : planned_.robots) {
      statistics_.path_cost_rad += statistics_.robot_cost_rad[name] = path_length(motion.waypoints);
      statistics_.makespan_s = std::max(statistics_.makespan_s, end_of(motion));
      statistics_.flow_time_s += arrival(motion);
    }
    statistics_.search_cost_rad = statistics_.path_cost_rad;
    statistics_.bound = search::infinity;
    statistics_.bound_graph.clear();
    statistics_.solutions = {{deadline_.elapsed(), statistics_.path_cost_rad, statistics_.bound, {}}};
  }

  // --- proof

  /// By judges that know no robot standing where a committed motion ends.
  void certify() {
    statistics_.plan_time_s = deadline_.elapsed();
    if (!common_.certify) return;
    const double start = deadline_.elapsed();
    const PhaseTimer timer(deadline_, statistics_.verification_time_s);
    const Deadline until(std::max(deadline_.remaining(), 0.0) + post::grace_period,
                         [this] { return deadline_.cancelled(); });
    const std::size_t count = problem_.moving.size();
    std::vector<MovingPart> moving;
    for (std::size_t i = 0; i < team_->size(); ++i) {
      const std::string& name = team_->names()[i];
      if (i < count)
        moving.push_back({i, &problem_.moving[i], planned_.at(name)});
      else
        moving.push_back({i, nullptr, committed_.at(name)});
    }
    std::vector<Certificate> certificates = certify_together(*team_, moving, common_, until);
    for (std::size_t i = 0; i < count; ++i) {
      const std::string& name = team_->names()[i];
      seal(planned_.robots.at(name), std::move(certificates[i]), name, statistics_);
    }
    proving_s_ = deadline_.elapsed() - start;
  }

  const MultiRobotProblem& problem_;
  const CommonOptions& common_;
  const CommittedMotions& committed_;
  const CheckerOptions& quick_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::map<std::string, Trajectory> waiting_;  // at the starts
  std::unique_ptr<const GroupCheckers> team_, held_;
  std::vector<std::unique_ptr<Pair>> pairs_;
  std::optional<PlanningError> refused_;  // motions begun together
  MultiTrajectory planned_;
  std::map<std::string, Trajectory> undelayed_;    // as they were planned, begun together
  double proving_s_{};                             // what the last certificates took
  std::unique_ptr<PrioritisedInTime> one_by_one_;  // if it comes to that
};

/// Costs of motions that were found, but are not returned.
void forget_motions(PlanStatistics& statistics) {
  statistics.path_cost_rad = statistics.search_cost_rad = statistics.bound = 0.0;
  statistics.makespan_s = statistics.flow_time_s = 0.0;
  statistics.bound_graph.clear();
  statistics.solutions.clear();
  for (auto& [robot, cost] : statistics.robot_cost_rad) cost = 0.0;
}

}  // namespace

void stand_at_ends(Scene& scene, const std::map<std::string, Eigen::VectorXd>& starts,
                   const CommittedMotions& committed, const CommonOptions& options) {
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

MultiTrajectory plan_around(const MultiRobotProblem& problem, const std::map<std::string, Eigen::VectorXd>& starts,
                            const CommittedMotions& committed, const CheckerOptions& quick, const Deadline& deadline,
                            PlanStatistics& statistics) {
  try {
    MultiTrajectory result = PlanAround(problem, starts, committed, quick, deadline, statistics).run();
    statistics.total_time_s = deadline.elapsed();
    return result;
  } catch (const PlanningError& error) {
    forget_motions(statistics);
    note_failure(error, deadline, statistics);
    throw;
  }
}

}  // namespace srmp
