#include "srmp/planner/multi_robot.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/collision/motion_proof.hpp"
#include "srmp/multi/conflict_search.hpp"
#include "srmp/planner/arm_world.hpp"
#include "srmp/planner/coupled_path.hpp"
#include "srmp/planner/phase_timer.hpp"
#include "srmp/planner/post_process.hpp"
#include "srmp/planner/single_robot.hpp"
#include "srmp/planner/verify.hpp"
#include "srmp/trajectory/parameterize.hpp"

namespace srmp {

namespace {

multi::ConflictSearchOptions search_options(const PlannerOptions& options) {
  multi::ConflictSearchOptions search;
  const auto weights = [&](const auto& o) {
    search.guide_weight = o.weight_low_level_heuristic;
    search.low_focal = o.low_level_focal_suboptimality;
    search.high_focal = o.high_level_focal_suboptimality;
  };
  if (const auto* ecbs = std::get_if<ECBS>(&options)) weights(*ecbs);
  if (const auto* xecbs = std::get_if<XECBS>(&options)) {
    weights(*xecbs);
    search.experience = search.priorities = true;
  }
  if (const auto* prioritised = std::get_if<Prioritised>(&options)) {
    search.guide_weight = prioritised->weight_low_level_heuristic;
    search.experience = search.priorities_only = true;
  }
  if (const auto* any = std::get_if<Auto>(&options)) {
    search.guide_weight = any->weight;
    search.low_focal = search.high_focal = 1.3;
    search.experience = search.priorities = true;
  }
  return search;
}

class MultiRobotPlan {
 public:
  MultiRobotPlan(const MultiRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics)
      : problem_(problem),
        common_(common_options(problem.options)),
        deadline_(deadline),
        statistics_(statistics),
        count_(problem.moving.size()) {}

  MultiTrajectory run() {
    find_tasks();
    require_apart(Status::start_invalid, "starts");
    require_goals_apart();
    find_paths();
    statistics_.plan_time_s = deadline_.elapsed();
    return post_process();
  }

 private:
  [[noreturn]] void fail(Status status, const std::string& reason) const { throw PlanningError(status, reason); }

  const std::string& name(std::size_t i) const { return problem_.moving[i].robot; }

  // --- each robot alone

  /// What every robot would do if it were alone.
  void find_tasks() {
    const Auto alone{.common = common_};
    options_alone_ = alone;
    auto& common = std::get<Auto>(options_alone_).common;
    common.escape_start = false;
    for (const MultiRobotPart& part : problem_.moving) tasks_.push_back(task(part));
  }

  ArmTask task(const MultiRobotPart& part) {
    const std::size_t i = tasks_.size();
    const Checker& checker = problem_.checkers.alone(i);
    const bool aside = part.goal.type == GoalType::aside;
    const std::vector<GoalConstraint> goals{aside ? GoalConstraint::joints(part.start) : part.goal};
    PlanStatistics alone;
    const SingleRobotProblem problem{problem_.scene, part.robot,          checker,     part.start, goals,
                                     options_alone_, problem_.heuristics, part.limits, {},         part.placed};
    const Deadline left(std::max(deadline_.remaining(), 1e-6), [this] { return deadline_.cancelled(); });
    try {
      RobotPath path = find_robot_path(problem, left, alone);
      add(alone);
      if (aside) return {path.start, {}, {}, true};
      return {path.start, std::move(path.targets), std::move(path.waypoints)};
    } catch (const PlanningError& error) {
      add(alone);
      fail(error.status(), "robot '" + part.robot + "': " + error.what());
    }
  }

  void add(const PlanStatistics& alone) {
    statistics_.ik_time_s += alone.ik_time_s;
    statistics_.heuristic_time_s += alone.heuristic_time_s;
    statistics_.search_time_s += alone.search_time_s;
    statistics_.shortcut_time_s += alone.shortcut_time_s;
    statistics_.expansions += alone.expansions;
    statistics_.generated += alone.generated;
    statistics_.edge_checks += alone.edge_checks;
    statistics_.states += alone.states;
    if (alone.note.empty()) return;
    statistics_.note += (statistics_.note.empty() ? "" : "; ") + alone.note;
  }

  /// What two robots touch with at two configurations; "" = nothing.
  std::string contact(std::size_t i, const Eigen::VectorXd& a, std::size_t j, const Eigen::VectorXd& b) const {
    const Checker* checker = problem_.checkers.pair(i, j);
    if (!checker) return "";
    Eigen::VectorXd both(a.size() + b.size());
    both << a, b;
    const auto workspace = checker->make_workspace();
    if (checker->is_free(both, *workspace)) return "";
    const auto contacts = checker->contacts(both, *workspace);
    return "'" + name(i) + "' and '" + name(j) + "' are in collision" +
           (contacts.empty() ? "" : ": " + contacts.front().describe());
  }

  void require_apart(Status status, const std::string& what) const {
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t j = i + 1; j < count_; ++j)
        if (const std::string why = contact(i, tasks_[i].start, j, tasks_[j].start); !why.empty())
          fail(status, "the " + what + " are invalid: " + why);
  }

  /// Two robots none of whose goal configurations go together.
  void require_goals_apart() const {
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t j = i + 1; j < count_; ++j) {
        if (tasks_[i].anywhere || tasks_[j].anywhere) continue;
        std::string first;
        bool together = false;
        for (const Eigen::VectorXd& a : tasks_[i].targets)
          for (const Eigen::VectorXd& b : tasks_[j].targets) {
            if (together) continue;
            const std::string why = contact(i, a, j, b);
            together = why.empty();
            if (first.empty()) first = why;
          }
        if (!together) fail(Status::goal_invalid, "the goals cannot be reached together: at them " + first);
      }
  }

  // --- all of them

  void find_paths() {
    const multi::ConflictSearchOptions options = search_options(problem_.options);
    world_ = std::make_unique<ArmWorld>(
        problem_.checkers, tasks_, ArmWorld::Options{common_.resolution * M_PI / 180.0, common_.prismatic_resolution});
    multi::ConflictSearchResult found;
    {
      const PhaseTimer timer(deadline_, statistics_.search_time_s);
      found = multi::conflict_search(*world_, options, deadline_);
    }
    count(found);
    require_solved(found);
    const PhaseTimer timer(deadline_, statistics_.shortcut_time_s);
    path_ = coupled_path(*world_, found.paths);
    statistics_.search_cost_rad = path_.length();
    if (common_.shortcut) path_ = shortened(std::move(path_), *world_, deadline_);
    statistics_.path_cost_rad = path_.length();
    for (std::size_t i = 0; i < count_; ++i) statistics_.robot_cost_rad[name(i)] = path_.length(i);
    prove(found);
  }

  void count(const multi::ConflictSearchResult& found) {
    statistics_.expansions += found.statistics.low.expansions;
    statistics_.generated += found.statistics.low.generated;
    statistics_.tree_nodes = found.statistics.tree_nodes;
    statistics_.states += world_->states();
    statistics_.edge_checks += found.statistics.low.evaluations + world_->pair_checks();
  }

  void require_solved(const multi::ConflictSearchResult& found) const {
    const std::string work = std::to_string(found.statistics.tree_nodes) + " nodes of the constraint tree, " +
                             std::to_string(found.statistics.low.expansions) + " states expanded";
    switch (found.status) {
      case Status::solved: return;
      case Status::cancelled: fail(found.status, "the plan was cancelled during the search (" + work + ")");
      case Status::exhausted:
        fail(found.status, "the robots' lattices of " + to_text(common_.resolution) +
                               " degrees hold no paths on which they do not meet (" + work +
                               "); a finer resolution may hold some");
      default:
        fail(Status::timed_out,
             "no paths within the time limit of " + to_text(common_.time_limit) + " s (" + work + ")");
    }
  }

  void prove(const multi::ConflictSearchResult& found) {
    const double cost = std::min(statistics_.path_cost_rad, found.cost);
    const bool proved = !std::holds_alternative<Prioritised>(problem_.options);
    statistics_.bound = !proved               ? search::infinity
                        : cost <= found.lower ? 1.0
                        : found.lower > 0.0   ? cost / found.lower
                                              : search::infinity;
    statistics_.bound_graph = "the robots' lattices of " + to_text(common_.resolution) + " degrees, in steps of " +
                              to_text(world_->step_time()) + " s";
    statistics_.solutions.push_back(
        {deadline_.elapsed(), statistics_.path_cost_rad, statistics_.bound, statistics_.bound_graph});
  }

  // --- time and proof

  MultiTrajectory post_process() {
    const Deadline until(std::max(deadline_.remaining(), 0.0) + mercy, [this] { return deadline_.cancelled(); });
    for (double deviation = common_.blend_deviation;; deviation *= shrink) {
      if (deviation < least_deviation) deviation = 0.0;
      MultiTrajectory result = in_time(deviation);
      set_times(result);
      if (!common_.certify) return result;
      std::vector<Certificate> certificates = certified(result, until);
      const auto all = [&](auto&& holds) { return std::all_of(certificates.begin(), certificates.end(), holds); };
      const bool proved = all([](const Certificate& c) { return c.proved_free(); });
      const bool rounded = deviation > 0.0 && common_.timing == "toppra";
      if (rounded && !proved && !until.stop_requested()) continue;
      for (std::size_t i = 0; i < count_; ++i) {
        if (!certificates[i].holds())
          throw Error("internal error: the trajectory found for '" + name(i) + "' is wrong (" +
                      certificates[i].faults.front().text + "); nothing is returned. Please report this");
        result.robots.at(name(i)).certificate = std::make_shared<const Certificate>(std::move(certificates[i]));
      }
      return result;
    }
  }

  Trajectory all_in_time(double deviation) {
    const PhaseTimer timer(deadline_, statistics_.timing_time_s);
    std::vector<std::string> names;
    MotionLimits limits;
    Eigen::VectorXd reach;
    for (std::size_t i = 0; i < count_; ++i) {
      const MotionLimits own = scaled(problem_.moving[i].limits, common_);
      for (const std::string& joint : problem_.checkers.alone(i).robot().joint_names())
        names.push_back(name(i) + "/" + joint);
      append(limits.velocity, own.velocity);
      append(limits.acceleration, own.acceleration);
      append(limits.jerk, own.jerk);
      append(reach, problem_.checkers.alone(i).reach());
      limits.continuous.insert(limits.continuous.end(), own.continuous.begin(), own.continuous.end());
    }
    RowMatrix waypoints(static_cast<Eigen::Index>(path_.size()), limits.velocity.size());
    Eigen::Index first = 0;
    for (const RowMatrix& q : path_.positions) {
      waypoints.middleCols(first, q.cols()) = q;
      first += q.cols();
    }
    if (common_.timing == "none")
      return {names, waypoints, RowMatrix(0, waypoints.cols()), RowMatrix(0, waypoints.cols()), {}, waypoints};
    TimingOptions options{.method = common_.timing == "ruckig" ? TimingMethod::ruckig : TimingMethod::toppra,
                          .sample_period = common_.sample_period,
                          .blend_deviation = deviation};
    options.reach = reach;
    options.is_free = [this](const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return is_motion_free(a, b); };
    return time_parameterize(waypoints, names, limits, options);
  }

  static void append(Eigen::VectorXd& to, const Eigen::VectorXd& more) {
    to.conservativeResize(to.size() + more.size());
    to.tail(more.size()) = more;
  }

  /// Of all robots.
  bool is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    Eigen::Index first = 0;
    std::vector<Eigen::VectorXd> from, to;
    for (const RowMatrix& q : path_.positions) {
      from.emplace_back(a.segment(first, q.cols()));
      to.emplace_back(b.segment(first, q.cols()));
      first += q.cols();
    }
    for (std::size_t i = 0; i < count_; ++i) {
      const auto& alone = problem_.checkers.alone(i);
      if (!alone.is_motion_free(from[i], to[i], *alone.make_workspace())) return false;
    }
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t j = i + 1; j < count_; ++j)
        if (!world_->are_apart(i, from[i], to[i], j, from[j], to[j])) return false;
    return true;
  }

  MultiTrajectory in_time(double deviation) {
    const Trajectory all = all_in_time(deviation);
    MultiTrajectory result;
    Eigen::Index first = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const Eigen::Index columns = path_.positions[i].cols();
      const auto part = [&](const RowMatrix& of) -> RowMatrix { return of.middleCols(first, columns); };
      Trajectory one{problem_.checkers.alone(i).robot().joint_names(),
                     part(all.positions),
                     part(all.velocities),
                     part(all.accelerations),
                     all.times,
                     part(all.waypoints)};
      one.robot = problem_.moving[i].placed;
      result.robots.emplace(name(i), std::move(one));
      first += columns;
    }
    return result;
  }

  void set_times(const MultiTrajectory& result) {
    statistics_.makespan_s = result.duration();
    statistics_.flow_time_s = 0.0;
    for (const auto& [robot, trajectory] : result.robots) statistics_.flow_time_s += arrival(trajectory);
  }

  /// When the robot is at rest for good.
  static double arrival(const Trajectory& trajectory) {
    if (!trajectory.timed()) return 0.0;
    Eigen::Index row = trajectory.positions.rows() - 1;
    while (row > 0 && trajectory.positions.row(row - 1) == trajectory.positions.row(row)) --row;
    return trajectory.times[row];
  }

  std::vector<Certificate> certified(const MultiTrajectory& result, const Deadline& until) {
    const PhaseTimer timer(deadline_, statistics_.verification_time_s);
    std::vector<Certificate> certificates;
    std::vector<Trajectory> timed;
    for (std::size_t i = 0; i < count_; ++i) {
      const MultiRobotPart& part = problem_.moving[i];
      Trajectory trajectory = result.robots.at(name(i));
      CertifyOptions options{.limits = trajectory.timed(), .jerk = common_.timing == "ruckig", .deadline = &until};
      if (!trajectory.timed())
        trajectory.times = Eigen::VectorXd::LinSpaced(trajectory.positions.rows(), 0.0,
                                                      static_cast<double>(trajectory.positions.rows() - 1));
      Certificate certificate = certify(trajectory, problem_.judges.alone(i), scaled(part.limits, common_), options);
      if (part.goal.type != GoalType::aside)
        certificate.goal_error =
            goal_miss({part.goal}, problem_.judges.alone(i), trajectory.positions.bottomRows(1).transpose()).error;
      certificate.bound = statistics_.bound;
      certificate.bound_graph = statistics_.bound_graph;
      certificates.push_back(std::move(certificate));
      timed.push_back(std::move(trajectory));
    }
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t j = i + 1; j < count_; ++j)
        if (const Checker* judge = problem_.judges.pair(i, j))
          certify_pair(*judge, i, timed[i], certificates[i], j, timed[j], certificates[j], until);
    return certificates;
  }

  void certify_pair(const Checker& judge, std::size_t i, const Trajectory& a, Certificate& of_a, std::size_t j,
                    const Trajectory& b, Certificate& of_b, const Deadline& until) {
    const auto side_by_side = [](const RowMatrix& left, const RowMatrix& right) {
      RowMatrix both(left.rows(), left.cols() + right.cols());
      both << left, right;
      return both;
    };
    const RowMatrix positions = side_by_side(a.positions, b.positions),
                    velocities = side_by_side(a.velocities, b.velocities);
    const auto workspace = judge.make_workspace();
    MotionProof proof = prove_motion(judge, {a.times, positions, velocities}, *workspace, {0.5, &until});
    add_proof(of_a, proof);
    // As the other one names the bodies.
    const auto swap = [&](std::string& mine, std::string& other) {
      const std::string prefix = name(j) + "/";
      if (other.starts_with(prefix)) other.erase(0, prefix.size());
      const auto& links = problem_.checkers.alone(i).robot().link_names();
      if (std::find(links.begin(), links.end(), mine) != links.end()) mine = name(i) + "/" + mine;
      std::swap(mine, other);
    };
    swap(proof.body_a, proof.body_b);
    for (MotionProof::Part& part : proof.unproved) swap(part.body_a, part.body_b);
    add_proof(of_b, proof);
  }

  static constexpr double mercy = 0.010;  // as in post_process.cpp
  static constexpr double shrink = 0.25;
  static constexpr double least_deviation = 1e-4;  // [m]

  const MultiRobotProblem& problem_;
  const CommonOptions& common_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::size_t count_;
  PlannerOptions options_alone_;
  std::vector<ArmTask> tasks_;
  std::unique_ptr<ArmWorld> world_;
  CoupledPath path_;
};

}  // namespace

MultiTrajectory plan_multi_robot(const MultiRobotProblem& problem, const Deadline& deadline,
                                 PlanStatistics& statistics) {
  MultiRobotPlan plan(problem, deadline, statistics);
  try {
    MultiTrajectory result = plan.run();
    statistics.status = Status::solved;
    statistics.total_time_s = deadline.elapsed();
    return result;
  } catch (const PlanningError& error) {
    statistics.status = error.status();
    statistics.reason = error.what();
    statistics.plan_time_s = statistics.total_time_s = deadline.elapsed();
    throw;
  }
}

}  // namespace srmp
