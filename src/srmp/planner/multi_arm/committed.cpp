#include "srmp/planner/multi_arm/committed.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <set>

#include "srmp/planner/multi_arm/plan_in_time.hpp"
#include "srmp/planner/multi_arm/timed_motion.hpp"
#include "srmp/planner/phase_timer.hpp"
#include "srmp/planner/post_process.hpp"
#include "srmp/planner/verify.hpp"
#include "srmp/search/graph.hpp"
#include "srmp/trajectory/certify.hpp"
#include "srmp/trajectory/prove_apart.hpp"

namespace srmp {

namespace {

constexpr double delay_step = 0.1;  // [s]
// A way round must arrive sooner by more than these: it takes longer ways, and the planner's.
constexpr double least_gain = 0.1;        // [s]
constexpr double least_gain_share = 0.1;  // of the time until all are there

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
      for (const Pair& pair : pairs_) require_start(pair);
    }
    begin_together();
    if (!refused_ && !late()) return certified();
    in_time_ = std::make_unique<const ArmCheckers>(problem_.scene, team_->names(), quick_);
    if (auto found = one_by_one(refused_ ? search::infinity : statistics_.makespan_s - gain()))
      take(std::move(*found));
    else if (refused_)
      throw *refused_;
    return certified();
  }

 private:
  /// A robot that is planned, or holds, and a committed one that it can meet.
  struct Pair {
    std::string robot, other;
    const Checker* judge;
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
  std::unique_ptr<const ArmCheckers> add_pairs(const std::vector<std::string>& robots) {
    std::vector<std::string> names = robots;
    for (const auto& [name, motion] : committed_) names.push_back(name);
    auto judges = std::make_unique<const ArmCheckers>(problem_.scene, names, CheckerOptions{.mode = CheckMode::coal});
    for (std::size_t i = 0; i < robots.size(); ++i)
      for (std::size_t j = robots.size(); j < names.size(); ++j)
        if (const Checker* judge = judges->pair(i, j)) pairs_.push_back({names[i], names[j], judge});
    return judges;
  }

  // --- what no delay can help

  void require_start(const Pair& pair) {
    const Trajectory &here = waiting_.at(pair.robot), &motion = committed_.at(pair.other);
    const auto stands_on_it = [&](const Trajectory& at, const std::string& does) -> std::optional<PlanningError> {
      const MotionProof proof = prove_apart(*pair.judge, here, at, {.tightness = 0.0});
      if (proof.free) return std::nullopt;
      return PlanningError(Status::start_invalid, "the committed motion of '" + pair.other + "' " + does + " '" +
                                                      pair.robot + "' starts: " + touching(pair, proof));
    };
    if (const auto error = stands_on_it(rest_at(motion, 0), "begins where")) throw *error;
    if (const auto error = stands_on_it(rest_at(motion, motion.positions.rows() - 1), "ends where")) {
      if (!moves(pair.robot)) throw *error;
      if (!refused_) refused_ = error;  // it may have left by then
    }
    if (moves(pair.robot)) return;
    if (const auto when = meets_waiting(pair))
      fail(Status::exhausted, "the committed motion of '" + pair.other + "' passes through '" + pair.robot +
                                  "', which holds: " + when->text);
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

  std::string touching(const Pair& pair, const MotionProof& proof) const {
    return "'" + full_name(pair.robot, proof.body_a) + "' and '" + proof.body_b + "' are in collision";
  }

  struct Meeting {
    double time;
    std::string text;
  };

  /// Of a proof that failed.
  Meeting meeting(const Pair& pair, const MotionProof& proof) const {
    const bool touch = !proof.free;
    const double time = touch ? proof.time : proof.unproved.front().from;
    const std::string& a = touch ? proof.body_a : proof.unproved.front().body_a;
    const std::string& b = touch ? proof.body_b : proof.unproved.front().body_b;
    return {time, "'" + full_name(pair.robot, a) + "' and '" + b + "' " + (touch ? "touch" : "cannot be proved apart") +
                      " at " + to_text(time) + " s"};
  }

  /// A robot that rests all the while.
  std::optional<Meeting> meets_waiting(const Pair& pair) const {
    const MotionProof proof = prove(pair, waiting_.at(pair.robot), {.tightness = 0.0, .deadline = &deadline_});
    if (proof.free && proof.unproved.empty()) return std::nullopt;
    return meeting(pair, proof);
  }

  MotionProof prove(const Pair& pair, const Trajectory& motion, const ProofOptions& options) const {
    MotionProof proof = prove_apart(*pair.judge, motion, committed_.at(pair.other), options);
    stop_if_late();
    return proof;
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
    if (refused_) return;
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
    std::optional<Meeting> waiting;
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

  /// With all motions begun after `delay`, until when nobody meets those that wait.
  std::optional<Meeting> first_meeting(double delay) const {
    std::map<std::string, Trajectory> moved;
    for (const auto& [name, motion] : planned_.robots) moved.emplace(name, delayed(motion, delay));
    for (const Pair& pair : pairs_) {
      if (!moved.contains(pair.robot)) continue;
      const auto workspace = pair.judge->make_workspace();
      const Trajectory &motion = moved.at(pair.robot), &other = committed_.at(pair.other);
      const double end = std::max(end_of(motion), end_of(other));
      stop_if_late();
      if (const auto time = look(motion, {nullptr, pair.judge, false, &other}, delay, end, *workspace))
        return meeting_at(pair, motion, *time);
    }
    for (const Pair& pair : pairs_) {
      if (!moved.contains(pair.robot)) continue;
      const MotionProof proof = prove(pair, moved.at(pair.robot), {.tightness = 0.0, .deadline = &deadline_});
      if (!proof.free || !proof.unproved.empty()) return meeting(pair, proof);
    }
    return std::nullopt;
  }

  Meeting meeting_at(const Pair& pair, const Trajectory& motion, double time) const {
    const Trajectory& other = committed_.at(pair.other);
    Eigen::VectorXd both(motion.positions.cols() + other.positions.cols());
    both << motion.sample(time), other.sample(time);
    const auto contacts = pair.judge->contacts(both, *pair.judge->make_workspace());
    MotionProof proof{.free = false, .time = time};
    if (!contacts.empty()) {
      proof.body_a = contacts.front().body_a;
      proof.body_b = contacts.front().body_b;
    }
    return meeting(pair, proof);
  }

  /// Later than that nothing may begin.
  std::optional<Meeting> first_while_waiting() const {
    std::optional<Meeting> first;
    for (const Pair& pair : pairs_)
      if (moves(pair.robot))
        if (const auto met = meets_waiting(pair); met && (!first || met->time < first->time)) first = met;
    return first;
  }

  void begin_after(double delay, Trajectory& trajectory) {
    const bool goes = (trajectory.positions.rowwise() - trajectory.positions.row(0)).cwiseAbs().maxCoeff() > 0.0;
    trajectory = delayed(trajectory, delay);
    if (goes) statistics_.flow_time_s += delay;
    statistics_.makespan_s = std::max(statistics_.makespan_s, end_of(trajectory));
  }

  // --- each by itself

  double gain() const { return std::max(least_gain, least_gain_share * statistics_.makespan_s); }

  /// Would the motions be over much sooner if they could begin at once?
  bool late() const {
    double soonest = 0.0;
    for (const auto& [name, motion] : undelayed_) soonest = std::max(soonest, end_of(motion));
    return soonest < statistics_.makespan_s - gain();
  }

  using Motions = std::map<std::string, Trajectory>;

  /// One robot after the other, each around the committed motions and those of the robots before it; one that finds no
  /// motion is put first, until an order comes again (priorities: Erdmann, Lozano-Pérez 1987).
  std::optional<Motions> one_by_one(double before) {
    std::vector<std::size_t> order(problem_.moving.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::set<std::vector<std::size_t>> tried;
    while (tried.insert(order).second) {
      Motions found;
      const auto stuck =
          std::find_if_not(order.begin(), order.end(), [&](std::size_t i) { return plan_one(i, before, found); });
      if (stuck == order.end()) return found;
      if (deadline_.stop_requested()) break;
      std::rotate(order.begin(), stuck, std::next(stuck));
    }
    if (refused_) stop_if_late();
    return std::nullopt;
  }

  /// Adds the robot's motion to `done`; false: none was found that arrives sooner than `before` [s].
  bool plan_one(std::size_t i, double before, Motions& done) {
    const MultiRobotPart& part = problem_.moving[i];
    const std::vector<MovingRobot> others = others_of(i, done);
    if (const auto at_once = undelayed_.find(part.robot); at_once != undelayed_.end() &&
                                                          end_of(at_once->second) < before &&
                                                          !when_met(at_once->second, others, deadline_)) {
      done.emplace(part.robot, at_once->second);
      return true;
    }
    const auto task = task_of(i, others);
    if (!task) return false;
    const PhaseTimer timer(deadline_, statistics_.search_time_s);
    TimedAnswer answer = plan_in_time(*task, before, deadline_);
    statistics_.expansions += answer.expansions;
    if (answer.status != Status::solved) return false;
    answer.motion.robot = part.placed;
    done.emplace(part.robot, std::move(answer.motion));
    return true;
  }

  std::vector<MovingRobot> others_of(std::size_t i, const Motions& done) const {
    std::vector<MovingRobot> others;
    for (std::size_t j = 0; j < team_->size(); ++j) {
      const std::string& name = team_->names()[j];
      const Trajectory* motion = nullptr;
      if (const auto committed = committed_.find(name); committed != committed_.end())
        motion = &committed->second;
      else if (const auto planned = done.find(name); planned != done.end())
        motion = &planned->second;
      if (!motion || !team_->may_meet(i, j)) continue;
      const auto [a, b] = std::minmax(i, j);
      others.push_back({in_time_->pair(a, b), team_->pair(a, b), j < i, motion});
    }
    return others;
  }

  /// Its way among what stands still leads the search; of the robots that move none stands anywhere. None: there is no
  /// such way, though motions are known.
  std::optional<TimedTask> task_of(std::size_t i, const std::vector<MovingRobot>& others) const {
    const MultiRobotPart& part = problem_.moving[i];
    const Checker& checker = in_time_->alone(i);
    TimedTask task{checker, team_->alone(i), others, part.start, {}, {}, scaled(part.limits, common_), {}};
    try {
      RobotPath path = path_alone(part, checker);
      task.start = std::move(path.start);
      if (part.goal.type != GoalType::aside) {
        task.targets = std::move(path.targets);
        task.way = std::move(path.waypoints);
        if (const auto known = undelayed_.find(part.robot); known != undelayed_.end()) {
          const Eigen::VectorXd end = known->second.positions.bottomRows(1).transpose();
          if (std::find(task.targets.begin(), task.targets.end(), end) == task.targets.end())
            task.targets.push_back(end);
        }
      }
    } catch (const PlanningError& error) {
      if (!refused_) return std::nullopt;
      fail(error.status(), "robot '" + part.robot + "': " + error.what());
    }
    task.in_time = [this, &checker, limits = task.limits](const RowMatrix& rows) {
      const auto workspace = checker.make_workspace();
      TimingOptions timing = timing_options(common_, common_.blend_deviation);
      timing.reach = checker.reach();
      timing.is_free = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
        return checker.is_free(a, *workspace) && checker.is_motion_free(a, b, *workspace, true);
      };
      return time_parameterize(rows, checker.robot().joint_names(), limits, timing);
    };
    return task;
  }

  RobotPath path_alone(const MultiRobotPart& part, const Checker& checker) const {
    const bool aside = part.goal.type == GoalType::aside;
    const std::vector<GoalConstraint> goals{aside ? GoalConstraint::joints(part.start) : part.goal};
    Auto alone{.common = common_};
    alone.common.escape_start = false;
    const PlannerOptions options = alone;
    PlanStatistics statistics;
    const Deadline left(std::max(deadline_.remaining(), 1e-6), [this] { return deadline_.cancelled(); });
    return find_robot_path({problem_.scene,
                            part.robot,
                            checker,
                            part.start,
                            goals,
                            options,
                            problem_.heuristics,
                            part.limits,
                            {},
                            part.placed},
                           left, statistics);
  }

  void take(Motions found) {
    planned_.robots = std::move(found);
    statistics_.status = Status::solved;
    statistics_.reason.clear();
    statistics_.path_cost_rad = statistics_.makespan_s = statistics_.flow_time_s = 0.0;
    for (const auto& [name, motion] : planned_.robots) {
      double length = 0.0;
      for (Eigen::Index k = 1; k < motion.waypoints.rows(); ++k)
        length += (motion.waypoints.row(k) - motion.waypoints.row(k - 1)).norm();
      statistics_.path_cost_rad += statistics_.robot_cost_rad[name] = length;
      statistics_.makespan_s = std::max(statistics_.makespan_s, end_of(motion));
      statistics_.flow_time_s += end_of(motion);
    }
    statistics_.search_cost_rad = statistics_.path_cost_rad;
    statistics_.bound = search::infinity;
    statistics_.bound_graph.clear();
    statistics_.plan_time_s = deadline_.elapsed();
    statistics_.solutions = {{deadline_.elapsed(), statistics_.path_cost_rad, statistics_.bound, {}}};
  }

  // --- proof

  MultiTrajectory certified() {
    const PhaseTimer timer(deadline_, statistics_.verification_time_s);
    if (common_.certify) certify_all();
    return std::move(planned_);
  }

  /// By judges that know no robot standing where a committed motion ends.
  void certify_all() {
    const Deadline until(std::max(deadline_.remaining(), 0.0) + post::mercy, [this] { return deadline_.cancelled(); });
    std::map<std::string, Certificate> certificates;
    for (std::size_t i = 0; i < problem_.moving.size(); ++i) {
      const MultiRobotPart& part = problem_.moving[i];
      const Trajectory& trajectory = planned_.at(part.robot);
      Certificate certificate = certify(trajectory, team_->alone(i), scaled(part.limits, common_),
                                        {.jerk = common_.timing == "ruckig", .deadline = &until});
      if (part.goal.type != GoalType::aside)
        certificate.goal_error =
            goal_miss({part.goal}, team_->alone(i), trajectory.positions.bottomRows(1).transpose()).error;
      certificate.bound = statistics_.bound;
      certificate.bound_graph = statistics_.bound_graph;
      certificates.emplace(part.robot, std::move(certificate));
    }
    for (std::size_t i = 0; i < team_->size(); ++i)
      for (std::size_t j = i + 1; j < team_->size(); ++j) certify_pair(i, j, certificates, until);
    for (auto& [name, certificate] : certificates) {
      if (!certificate.holds())
        throw Error("internal error: the trajectory found for '" + name + "' is wrong (" +
                    certificate.faults.front().text + "); nothing is returned. Please report this");
      planned_.robots.at(name).certificate = std::make_shared<const Certificate>(std::move(certificate));
    }
  }

  void certify_pair(std::size_t i, std::size_t j, std::map<std::string, Certificate>& certificates,
                    const Deadline& until) const {
    const std::string &a = team_->names()[i], &b = team_->names()[j];
    const Checker* judge = team_->pair(i, j);
    if (!judge || committed_.contains(a)) return;
    const bool other = committed_.contains(b);
    const MotionProof proof =
        prove_apart(*judge, planned_.at(a), other ? committed_.at(b) : planned_.at(b), {0.5, &until});
    add_proof(certificates.at(a), proof);
    if (!other) add_proof(certificates.at(b), seen_from_companion(proof, *judge, b));
  }

  const MultiRobotProblem& problem_;
  const CommonOptions& common_;
  const CommittedMotions& committed_;
  const CheckerOptions& quick_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::map<std::string, Trajectory> waiting_;  // at the starts
  std::unique_ptr<const ArmCheckers> team_, held_;
  std::vector<Pair> pairs_;
  std::optional<PlanningError> refused_;  // motions begun together
  MultiTrajectory planned_;
  std::map<std::string, Trajectory> undelayed_;  // as they were planned, begun together
  std::unique_ptr<const ArmCheckers> in_time_;   // the team by quick checkers
};

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
    const Checker checker(scene, name, {.mode = CheckMode::coal});
    const Certificate certificate =
        certify(motion, checker, default_limits(model), {.limits = false, .collisions = false, .at_rest = false});
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
    note_failure(error, deadline, statistics);
    throw;
  }
}

}  // namespace srmp
