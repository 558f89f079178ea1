#include "srmp/planner/single_robot.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "srmp/heuristic/task_space_bfs.hpp"
#include "srmp/io/primitives.hpp"
#include "srmp/lattice/lattice.hpp"
#include "srmp/search/ara.hpp"
#include "srmp/search/astar.hpp"
#include "srmp/search/mha.hpp"
#include "srmp/search/portfolio.hpp"
#include "srmp/search/wpase.hpp"
#include "srmp/trajectory/parameterize.hpp"
#include "srmp/trajectory/shortcut.hpp"

namespace srmp {

namespace {

constexpr double start_mercy = 1e-6;        // a start outside a limit by no more is moved onto it [rad or m]
constexpr double verification_step = 0.02;  // largest joint step between the samples of the final re-check [rad or m]

using StateHeuristic = std::function<double(search::StateId)>;

/// Adds the time from construction to destruction.
class PhaseTimer {
 public:
  PhaseTimer(const Deadline& clock, double& total) : clock_(clock), total_(total), start_(clock.elapsed()) {}
  ~PhaseTimer() { total_ += clock_.elapsed() - start_; }

 private:
  const Deadline& clock_;
  double& total_;
  double start_;
};

/// A configuration that meets a goal.
struct Target {
  Eigen::VectorXd q;
  int goal_index;
};

class SingleRobotPlan {
 public:
  SingleRobotPlan(const SingleRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics)
      : problem_(problem),
        common_(common_options(problem.options)),
        robot_(problem.checker.robot()),
        deadline_(deadline),
        statistics_(statistics) {
    const auto* parallel = std::get_if<WPASE>(&problem.options);
    for (int i = 0; i < (parallel ? parallel->num_threads : 1); ++i)
      workers_.push_back({problem.checker.make_workspace()});
  }

  Trajectory run() {
    check_start();
    find_targets();
    choose_direction();
    std::vector<Eigen::VectorXd> path = find_path();
    if (common_.shortcut) path = shortened(path);
    statistics_.path_cost_rad = length(path);
    collect_check_statistics();
    statistics_.plan_time_s = deadline_.elapsed();
    Trajectory trajectory = timed(path);
    verify(path);
    return trajectory;
  }

  /// Sums what the workers' checks did; also called when a plan fails half-way.
  void collect_check_statistics() {
    statistics_.edge_checks = statistics_.configurations = statistics_.narrow_phase = 0;
    statistics_.edges_free_by_balls = statistics_.edges_colliding_by_balls = 0;
    statistics_.edges_free_by_coal = statistics_.edges_colliding_by_coal = 0;
    for (const Worker& worker : workers_) {
      const CheckStatistics& checks = problem_.checker.statistics(*worker.workspace);
      const std::uint64_t colliding_by_balls = checks.motions_by_balls - worker.free_by_balls;
      statistics_.edge_checks += checks.motions;
      statistics_.edges_free_by_balls += worker.free_by_balls;
      statistics_.edges_colliding_by_balls += colliding_by_balls;
      statistics_.edges_free_by_coal += worker.free - worker.free_by_balls;
      statistics_.edges_colliding_by_coal += checks.motions - worker.free - colliding_by_balls;
      statistics_.configurations += checks.configurations;
      statistics_.narrow_phase += checks.narrow_phase;
    }
  }

 private:
  /// A thread's scratch memory, and how many of the motions that it checked were free.
  struct Worker {
    Checker::WorkspacePtr workspace;
    std::uint64_t free{};
    std::uint64_t free_by_balls{};
  };

  Checker::Workspace& workspace(std::size_t worker = 0) { return *workers_[worker].workspace; }

  /// `a` is known to be free.
  bool is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b, std::size_t worker = 0) {
    Worker& w = workers_[worker];
    const CheckStatistics& checks = problem_.checker.statistics(*w.workspace);
    const std::uint64_t by_balls = checks.motions_by_balls;
    if (!problem_.checker.is_motion_free(a, b, *w.workspace, true)) return false;
    ++w.free;
    w.free_by_balls += checks.motions_by_balls - by_balls;
    return true;
  }

  [[noreturn]] void fail(Status status, const std::string& reason) const { throw PlanningError(status, reason); }

  void stop_if_late(const std::string& phase) const {
    if (deadline_.cancelled()) fail(Status::cancelled, "the plan was cancelled during " + phase);
    if (deadline_.expired())
      fail(Status::timed_out, "the time limit of " + to_text(common_.time_limit) + " s passed during " + phase);
  }

  /// Why q cannot be an end of a path, or "".
  std::string invalidity(const Eigen::VectorXd& q) {
    if (const auto violation = robot_.limit_violation(q)) return *violation;
    if (problem_.checker.is_free(q, workspace())) return "";
    const std::vector<Contact> contacts = problem_.checker.contacts(q, workspace());
    return contacts.empty() ? "it is in collision" : contacts.front().describe();
  }

  void check_start() {
    robot_.require_configuration(problem_.start, "start of '" + problem_.robot + "'");
    start_ = robot_.clamped(problem_.start, start_mercy);
    if (start_ != problem_.start)
      statistics_.note = "the start was moved onto a joint limit that it missed by at most 1e-6";
    if (const std::string why = invalidity(start_); !why.empty())
      fail(Status::start_invalid, "the start is invalid: " + why);
  }

  void find_targets() {
    const PhaseTimer timer(deadline_, statistics_.ik_time_s);
    int index = 0;
    std::string first_reason;
    for (const GoalConstraint& goal : problem_.goals)
      for (const Eigen::VectorXd& target : goal.targets) {
        std::string why;
        for (Eigen::VectorXd& q : configurations(goal, target, why)) {
          const std::string invalid = invalidity(q);
          if (invalid.empty())
            targets_.push_back({std::move(q), index});
          else if (why.empty())
            why = invalid;
          stop_if_late("the search for goal configurations");
        }
        if (first_reason.empty()) first_reason = why;
        ++index;
        stop_if_late("the search for goal configurations");
      }
    if (targets_.empty())
      fail(Status::goal_invalid,
           (index == 1 ? "the goal is invalid: " : "all goals are invalid, the first because ") + first_reason);
  }

  std::vector<Eigen::VectorXd> configurations(const GoalConstraint& goal, const Eigen::VectorXd& target,
                                              std::string& why) {
    if (goal.type == GoalType::joints) return {robot_.clamped(target, start_mercy)};
    const bool position_only = goal.type == GoalType::position;
    const Pose world = position_only ? Pose{target, Eigen::Quaterniond::Identity()}
                                     : Pose::from_list({target.data(), static_cast<std::size_t>(target.size())});
    const Pose in_base = problem_.checker.base().inverse() * world;
    IkOptions options;
    options.max_solutions = common_.ik_solutions;
    options.position_tolerance = goal.position_tolerance.tightened(options.position_tolerance.axes[0]);
    options.rotation_tolerance = position_only ? AxisTolerance(search::infinity)
                                               : goal.rotation_tolerance.tightened(options.rotation_tolerance.axes[0]);
    auto found = inverse_kinematics(robot_, in_base, start_, options, "", deadline_);
    if (found.empty()) {  // nothing meets it exactly: whatever is within the tolerances
      options.position_tolerance = goal.position_tolerance;
      if (!position_only) options.rotation_tolerance = goal.rotation_tolerance;
      found = inverse_kinematics(robot_, in_base, start_, options, "", deadline_);
    }
    if (found.empty())
      why = "no configuration within the joint limits brings '" + robot_.end_effector() + "' to [" +
            to_text(target[0]) + ", " + to_text(target[1]) + ", " + to_text(target[2]) + "] (" +
            std::to_string(options.seeds) + " seeds tried)";
    return found;
  }

  double length(const std::vector<Eigen::VectorXd>& path) const {
    double sum = 0.0;
    for (std::size_t i = 1; i < path.size(); ++i) sum += robot_.difference(path[i - 1], path[i]).norm();
    return sum;
  }

  /// `scale`: of the resolution asked for. Short moves near the ends help a lattice that is alone; beside finer
  /// lattices they only crowd it.
  Lattice make_lattice(bool backward, double scale = 1.0, bool alone = true) {
    Eigen::VectorXd step(static_cast<Eigen::Index>(robot_.dof()));
    for (std::size_t j = 0; j < robot_.dof(); ++j)
      step[static_cast<Eigen::Index>(j)] = robot_.joints()[j].kind == JointKind::prismatic
                                               ? common_.prismatic_resolution
                                               : common_.resolution * M_PI / 180.0;
    step *= scale;
    Lattice::Options options;
    options.primitives = common_.mprim_path.empty() ? default_primitives(robot_.joints(), step)
                                                    : io::read_primitives(common_.mprim_path, robot_.joints());
    if (!alone)
      std::erase_if(options.primitives.families,
                    [](const PrimitiveFamily& family) { return family.use == PrimitiveUse::near; });
    std::vector<Eigen::VectorXd> goals;
    for (const Target& target : targets_) goals.push_back(target.q);
    std::vector<Eigen::VectorXd> anchors{start_};
    if (backward) anchors.swap(goals);
    return Lattice(
        robot_, std::move(anchors), std::move(goals), std::move(options),
        [this](std::size_t worker, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
          return is_motion_free(a, b, worker);
        },
        workers_.size());
  }

  /// A search out of a narrow place is easier than one into it: "auto" starts at the end with less clearance.
  void choose_direction() {
    backward_ = common_.direction == "backward";
    if (common_.direction != "auto") return;
    double at_goals = search::infinity;
    for (const Target& target : targets_) at_goals = std::min(at_goals, clearance(target.q));
    backward_ = at_goals < clearance(start_);
  }

  double clearance(const Eigen::VectorXd& q) {
    stop_if_late("the choice of a direction");
    const auto pair = problem_.checker.nearest(q, workspace());
    return pair ? pair->distance : search::infinity;
  }

  StateHeuristic make_heuristic(const std::string& name, Lattice& lattice) {
    if (name == "bfs") return bfs_heuristic(lattice);
    return [&lattice](search::StateId state) { return lattice.distance_to_targets(state); };
  }

  StateHeuristic bfs_heuristic(Lattice& lattice) {
    const PhaseTimer timer(deadline_, statistics_.heuristic_time_s);
    const std::shared_ptr<RobotData> data(robot_.make_data().release(), RobotDataDeleter{});
    const std::size_t link = robot_.link_index(robot_.end_effector());
    const Pose base = problem_.checker.base();
    const auto tip = [this, data, link, base](const Eigen::VectorXd& q) -> Eigen::Vector3d {
      robot_.forward(*data, q);
      return base * Eigen::Vector3d(robot_.link_pose(*data, link).translation());
    };
    std::vector<Eigen::Vector3d> goals;
    double reach = tip_reach(tip, base.p);
    for (const Eigen::VectorXd& target : lattice.targets()) goals.push_back(tip(target));
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(reach);
    const auto grid = std::make_shared<const TaskSpaceBfs>(
        problem_.scene, base.p - half, base.p + half, goals,
        TaskSpaceBfs::Options{common_.bfs_resolution, common_.bfs_radius}, deadline_);
    statistics_.memory_bytes += grid->memory();
    // One radian moves the tip by at most about `reach`; places that walls cut off count as far away, not as hopeless,
    // because the grid knows only the tip.
    return [&lattice, tip, grid, reach](search::StateId state) {
      if (lattice.is_goal(state)) return 0.0;
      return std::min(grid->distance(tip(lattice.configuration(state))), 4.0 * reach) / reach;
    };
  }

  /// How far the end effector gets from the base, over a fixed sample of configurations.
  double tip_reach(const std::function<Eigen::Vector3d(const Eigen::VectorXd&)>& tip,
                   const Eigen::Vector3d& base) const {
    double reach = (tip(start_) - base).norm();
    Eigen::VectorXd q = start_;
    for (int sample = 1; sample <= 128; ++sample) {
      for (Eigen::Index j = 0; j < q.size(); ++j) {
        const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
        const double low = std::max(joint.lower, -M_PI), high = std::min(joint.upper, M_PI);
        const double golden = std::sqrt(static_cast<double>(j) + 2.0) * sample;  // a Kronecker sequence
        q[j] = low + (high - low) * (golden - std::floor(golden));
      }
      reach = std::max(reach, (tip(q) - base).norm());
    }
    return 1.1 * reach;
  }

  search::Result search(Lattice& lattice) {
    const StateHeuristic anchor = make_heuristic(common_.heuristic, lattice);
    stop_if_late("the construction of the heuristic");
    const PhaseTimer timer(deadline_, statistics_.search_time_s);
    const auto starts = lattice.starts();
    search::Result result =
        std::visit([&](const auto& options) { return run_search(lattice, starts, anchor, options); }, problem_.options);
    if (common_.heuristic != "joint_euclidean")
      result.bound = search::infinity;  // only a consistent one proves anything
    return result;
  }

  using Starts = std::vector<search::StateId>;

  search::Result run_search(Lattice& lattice, const Starts& starts, const StateHeuristic& h, const AStar&) {
    return search::weighted_astar(lattice, starts, h, {.weight = 1.0}, deadline_);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const StateHeuristic& h, const WAStar& options) {
    return search::weighted_astar(lattice, starts, h, {.weight = options.weight}, deadline_);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const StateHeuristic& h, const ARAStar& options) {
    search::AraOptions ara;
    ara.initial_weight = std::max(options.weight, options.final_weight);
    ara.weight_delta = options.weight_delta;
    ara.final_weight = options.final_weight;
    return search::ara_star(lattice, starts, h, ara, deadline_);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const StateHeuristic& h, const MHAStar& options) {
    std::vector<search::InadmissibleHeuristic> others;
    for (const std::string& name : options.inadmissible_heuristics) others.push_back(make_heuristic(name, lattice));
    return search::mha_star(lattice, starts, h, others, {.w1 = options.w1, .w2 = options.w2}, deadline_);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const StateHeuristic& h, const WPASE& options) {
    return search::wpase(lattice, starts, h,
                         {.weight = options.weight, .batch_size = static_cast<std::size_t>(options.batch_size)},
                         deadline_);
  }
  search::Result run_search(Lattice&, const Starts&, const StateHeuristic&, const XECBS&) {
    throw NotSupported(
        "xECBS plans for many robots, with plan_multi; make_planner another planner, such as 'wAstar', for plan");
  }

  search::Result run_search(Lattice&, const Starts&, const StateHeuristic&, const Auto&) {
    throw Error("internal error: 'auto' searches more than one lattice");
  }

  std::vector<Eigen::VectorXd> find_path() {
    if (const auto* options = std::get_if<Auto>(&problem_.options)) return find_path_in_turns(*options);
    Lattice lattice = make_lattice(backward_);
    const search::Result result = search(lattice);
    statistics_.states = lattice.size();
    statistics_.memory_bytes += lattice.memory();
    return path_of(result, lattice);
  }

  /// The planner `auto`. Without a say in it, both directions; a lattice of primitives from a file has one resolution.
  std::vector<Eigen::VectorXd> find_path_in_turns(const Auto& options) {
    using Member = search::PortfolioMember<Lattice, StateHeuristic>;
    std::vector<std::unique_ptr<Lattice>> lattices;
    std::vector<std::unique_ptr<StateHeuristic>> heuristics;
    std::vector<char> backward;
    std::vector<Member> members;
    const bool built_in = common_.mprim_path.empty();
    const std::vector<double> scales = built_in ? std::vector<double>{1.5, 0.75, 0.4} : std::vector<double>{1.0};
    for (const double scale : scales)
      for (const bool back : {backward_, !backward_}) {
        if (back != backward_ && common_.direction != "auto") continue;
        lattices.emplace_back(new Lattice(make_lattice(back, scale, !built_in)));  // it cannot move
        heuristics.push_back(std::make_unique<StateHeuristic>(make_heuristic(common_.heuristic, *lattices.back())));
        backward.push_back(back);
        members.push_back({lattices.back().get(), lattices.back()->starts(), heuristics.back().get()});
      }
    stop_if_late("the construction of the heuristic");
    search::PortfolioResult found;
    {
      const PhaseTimer timer(deadline_, statistics_.search_time_s);
      found = search::portfolio<Lattice, StateHeuristic>(members, {.weight = options.weight}, deadline_);
    }
    if (common_.heuristic != "joint_euclidean") found.result.bound = search::infinity;
    for (const auto& lattice : lattices) {
      statistics_.states += lattice->size();
      statistics_.memory_bytes += lattice->memory();
    }
    backward_ = backward[found.winner];
    return path_of(found.result, *lattices[found.winner]);
  }

  /// Of a search in a lattice that is backward_ or not.
  std::vector<Eigen::VectorXd> path_of(const search::Result& result, const Lattice& lattice) {
    statistics_.expansions = result.statistics.expansions;
    statistics_.generated = result.statistics.generated;
    statistics_.memory_bytes += result.statistics.memory;
    require_solved(result);
    std::vector<Eigen::VectorXd> path = lattice.configurations(result.path);
    const search::StateId goal_state = backward_ ? result.path.front() : result.path.back();
    statistics_.goal_index = targets_[backward_ ? goal_state : goal_state - lattice.anchor_count()].goal_index;
    statistics_.bound = result.bound;
    statistics_.search_cost_rad = result.cost;
    if (backward_) path = reversed(path);
    return path;
  }

  /// From start to goal, continuous joints unwrapped from the start on.
  std::vector<Eigen::VectorXd> reversed(const std::vector<Eigen::VectorXd>& path) const {
    std::vector<Eigen::VectorXd> result{start_};
    for (std::size_t i = path.size() - 1; i-- > 0;)
      result.push_back(result.back() + robot_.difference(result.back(), path[i]));
    return result;
  }

  void require_solved(const search::Result& result) const {
    const std::string work = std::to_string(result.statistics.expansions) + " states expanded, " +
                             std::to_string(result.statistics.evaluations) + " edges checked";
    switch (result.status) {
      case Status::solved: return;
      case Status::exhausted:
        fail(result.status, "the lattice of " + to_text(common_.resolution) +
                                " degrees holds no path: every state that can be reached was expanded (" + work +
                                "); a finer resolution or other motion primitives may hold one");
      case Status::cancelled: fail(result.status, "the plan was cancelled during the search (" + work + ")");
      default:
        fail(Status::timed_out,
             "no path within the time limit of " + to_text(common_.time_limit) + " s (" + work + ")");
    }
  }

  std::vector<Eigen::VectorXd> shortened(const std::vector<Eigen::VectorXd>& path) {
    const PhaseTimer timer(deadline_, statistics_.shortcut_time_s);
    const auto is_free = [this](const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return is_motion_free(a, b); };
    ShortcutOptions options;
    options.continuous = continuous_joints();
    const RowMatrix shorter = shortcut(to_rows(path), is_free, deadline_, options).waypoints;
    std::vector<Eigen::VectorXd> result;
    for (Eigen::Index i = 0; i < shorter.rows(); ++i) result.emplace_back(shorter.row(i).transpose());
    return result;
  }

  std::vector<bool> continuous_joints() const {
    std::vector<bool> result;
    for (const Joint& joint : robot_.joints()) result.push_back(joint.kind == JointKind::continuous);
    return result;
  }

  RowMatrix to_rows(const std::vector<Eigen::VectorXd>& path) const {
    RowMatrix rows(static_cast<Eigen::Index>(path.size()), static_cast<Eigen::Index>(robot_.dof()));
    for (std::size_t i = 0; i < path.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = path[i].transpose();
    return rows;
  }

  Trajectory timed(const std::vector<Eigen::VectorXd>& path) {
    const PhaseTimer timer(deadline_, statistics_.timing_time_s);
    Eigen::VectorXd velocity(static_cast<Eigen::Index>(robot_.dof()));
    for (std::size_t j = 0; j < robot_.dof(); ++j)
      velocity[static_cast<Eigen::Index>(j)] = robot_.joints()[j].max_velocity;
    MotionLimits limits = default_limits(velocity);
    limits.velocity *= common_.velocity_scaling;
    limits.acceleration *= common_.acceleration_scaling;
    limits.jerk *= common_.acceleration_scaling;
    limits.continuous = continuous_joints();
    return time_parameterize(to_rows(path), robot_.joint_names(), limits, common_.sample_period);
  }

  /// The last word, by other code than the search's: every sample of the path, at most verification_step apart, is
  /// checked as a single state in a fresh workspace.
  void verify(const std::vector<Eigen::VectorXd>& path) {
    const PhaseTimer timer(deadline_, statistics_.verification_time_s);
    const auto fresh = problem_.checker.make_workspace();
    for (std::size_t i = 1; i < path.size(); ++i) {
      const Eigen::VectorXd step = path[i] - path[i - 1];
      const int pieces = std::max(1, static_cast<int>(std::ceil(step.cwiseAbs().maxCoeff() / verification_step)));
      for (int k = 0; k <= pieces; ++k) {
        const Eigen::VectorXd q = path[i - 1] + step * (static_cast<double>(k) / pieces);
        if (!problem_.checker.is_free(q, *fresh))
          throw Error("internal error: the path found is in collision (" + invalidity(q) +
                      "); nothing is returned. Please report this");
      }
    }
  }

  const SingleRobotProblem& problem_;
  const CommonOptions& common_;
  const RobotModel& robot_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::vector<Worker> workers_;
  Eigen::VectorXd start_;
  std::vector<Target> targets_;
  bool backward_{false};
};

}  // namespace

Trajectory plan_single_robot(const SingleRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics) {
  SingleRobotPlan plan(problem, deadline, statistics);
  try {
    Trajectory trajectory = plan.run();
    statistics.status = Status::solved;
    statistics.total_time_s = deadline.elapsed();
    return trajectory;
  } catch (const PlanningError& error) {
    plan.collect_check_statistics();
    statistics.status = error.status();
    statistics.reason = error.what();
    statistics.plan_time_s = statistics.total_time_s = deadline.elapsed();
    throw;
  }
}

}  // namespace srmp
