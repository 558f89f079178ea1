#include "srmp/planner/single_robot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string_view>

#include "srmp/heuristic/task_space_bfs.hpp"
#include "srmp/io/primitives.hpp"
#include "srmp/lattice/lattice.hpp"
#include "srmp/planner/escape.hpp"
#include "srmp/planner/ik_snap.hpp"
#include "srmp/planner/phase_timer.hpp"
#include "srmp/planner/post_process.hpp"
#include "srmp/planner/robot_trees.hpp"
#include "srmp/search/ara.hpp"
#include "srmp/search/astar.hpp"
#include "srmp/search/mha.hpp"
#include "srmp/search/portfolio.hpp"
#include "srmp/search/wpase.hpp"
#include "srmp/trajectory/shortcut.hpp"

namespace srmp {

namespace {

constexpr double start_mercy = 1e-6;  // a start outside a limit by no more is moved onto it [rad or m]

using search::AnyHeuristic;

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
    for (const Worker& worker : workers_) problem.checker.stop_at(deadline, *worker.workspace);
  }

  Trajectory run() {
    check_start();
    find_targets();
    find_path();
    collect_check_statistics();
    statistics_.plan_time_s = deadline_.elapsed();
    if (!escape_.empty()) best_.insert(best_.begin(), escape_.begin(), escape_.end() - 1);
    verify_escape();
    return post_process(problem_, best_, escape_.empty() ? 0 : escape_.size() - 1, deadline_, statistics_);
  }

  RobotPath find() {
    check_start();
    find_targets();
    find_path();
    collect_check_statistics();
    RobotPath found{start_, {}, {}, best_};
    for (const Target& target : targets_) {
      found.targets.push_back(target.q);
      found.goal_indices.push_back(target.goal_index);
    }
    return found;
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
    bool stopped{};  // a check, by the deadline
  };

  Checker::Workspace& workspace(std::size_t worker = 0) { return *workers_[worker].workspace; }

  /// `a` is known to be free.
  bool is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b, std::size_t worker = 0) {
    Worker& w = workers_[worker];
    const CheckStatistics& checks = problem_.checker.statistics(*w.workspace);
    const std::uint64_t by_balls = checks.motions_by_balls;
    try {
      if (!problem_.checker.is_motion_free(a, b, *w.workspace, true)) return false;
    } catch (const MotionCheckStopped&) {
      if (workers_.size() == 1) throw;
      w.stopped = true;  // threads must not throw
      return false;
    }
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
    if (const std::string why = invalidity(start_); !why.empty()) {
      if (!common_.escape_start || robot_.limit_violation(start_))
        fail(Status::start_invalid, "the start is invalid: " + why);
      escape(why);
    }
  }

  /// From a start in collision to a free one, from which the plan is made.
  void escape(const std::string& why) {
    escape_ = find_escape(problem_.checker, start_, workspace(), [this] { stop_if_late("the escape from the start"); });
    if (escape_.empty())
      fail(Status::start_invalid, "the start is invalid: " + why +
                                      ", and no way out was found along which no pair gets deeper into contact and no "
                                      "other comes into contact");
    start_ = escape_.back();
    statistics_.escape_waypoints = static_cast<int>(escape_.size()) - 1;
    statistics_.escape_cost_rad = length(escape_);
    statistics_.note += (statistics_.note.empty() ? "" : "; ") +
                        ("the start was in collision (" + why + "): the trajectory begins with the way out of it");
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
    if (common_.ik_snap) goal_snap_ = make_ik_snap(*problem_.placed, problem_.goals, lattice_step());
    if (targets_.empty())
      fail(Status::goal_invalid,
           (index == 1 ? "the goal is invalid: " : "all goals are invalid, the first because ") + first_reason);
  }

  std::vector<Eigen::VectorXd> configurations(const GoalConstraint& goal, const Eigen::VectorXd& target,
                                              std::string& why) {
    if (goal.type == GoalType::joints) return {robot_.clamped(target, start_mercy)};
    auto [in_base, options] = ik_goal(goal, target, *problem_.placed);
    options.max_solutions = common_.ik_solutions;
    auto found = inverse_kinematics(robot_, in_base, start_, options, "", deadline_);
    if (found.empty()) {  // nothing meets it exactly: whatever is within the tolerances
      options.position_tolerance = goal.position_tolerance;
      if (goal.type == GoalType::pose) options.rotation_tolerance = goal.rotation_tolerance;
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

  Eigen::VectorXd lattice_step(double scale = 1.0) const {
    return srmp::lattice_step(robot_.joints(), scaled_resolution(scale) * M_PI / 180.0,
                              scale * common_.prismatic_resolution);
  }

  /// [degrees]; coarser than asked for, but no more than a quarter turn: no step may take the other way round.
  double scaled_resolution(double scale) const {
    return std::min(scale * common_.resolution, std::max(common_.resolution, 90.0));
  }

  bool own_primitives() const { return !common_.mprim_path.empty(); }

  PrimitiveSet make_primitives() const {
    return own_primitives() ? io::read_primitives(common_.mprim_path, robot_.joints())
                            : default_primitives(robot_.joints(), lattice_step(), parallel_pairs(robot_));
  }

  std::vector<Eigen::VectorXd> target_configurations() const {
    std::vector<Eigen::VectorXd> goals;
    for (const Target& target : targets_) goals.push_back(target.q);
    return goals;
  }

  Lattice make_lattice(bool backward, PrimitiveSet primitives) {
    std::vector<Eigen::VectorXd> goals = target_configurations(), anchors{start_};
    if (backward) anchors.swap(goals);
    return Lattice(
        robot_, std::move(anchors), std::move(goals),
        {.primitives = std::move(primitives), .goal_snap = backward ? GoalSnap{} : goal_snap_},
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

  AnyHeuristic make_heuristic(const std::string& name, Lattice& lattice) {
    if (const auto user = problem_.heuristics.find(name); user != problem_.heuristics.end())
      return user_heuristic(name, user->second, lattice);
    if (name == "bfs") return bfs_heuristic(lattice, common_.bfs_resolution);
    if (const auto cell = bfs_cell(name)) return bfs_heuristic(lattice, *cell);
    if (name == "joint_euclidean")
      return [&lattice](search::StateId state) { return lattice.distance_to_targets(state); };
    const auto measure = std::find(measure_names.begin(), measure_names.end(), name) - measure_names.begin();
    return [&lattice, weights = measure_weights(robot_.dof()),
            at = static_cast<std::size_t>(measure)](search::StateId state) {
      std::array<double, measure_names.size()> values{};
      lattice.measure_to_targets(state, weights, values);
      return values[at];
    };
  }

  /// What measure_to_targets writes with measure_weights.
  static constexpr std::array<std::string_view, 4> measure_names{"joint_euclidean", "joint_base", "joint_hand",
                                                                 "joint_sum"};

  AnyHeuristic user_heuristic(const std::string& name, const UserHeuristic& user, Lattice& lattice) const {
    return [&lattice, &user, name, goals = to_rows(lattice.targets())](std::span<const search::StateId> states,
                                                                       std::span<double> out) {
      std::fill(out.begin(), out.end(), 0.0);  // what goals have
      std::vector<std::size_t> asked;
      for (std::size_t i = 0; i < states.size(); ++i)
        if (!lattice.is_goal(states[i])) asked.push_back(i);
      if (asked.empty()) return;
      RowMatrix rows(static_cast<Eigen::Index>(asked.size()), goals.cols());
      for (std::size_t k = 0; k < asked.size(); ++k)
        rows.row(static_cast<Eigen::Index>(k)) = lattice.configuration(states[asked[k]]).transpose();
      const Eigen::VectorXd values = ask(name, user, rows, goals);
      for (std::size_t k = 0; k < asked.size(); ++k) out[asked[k]] = values[static_cast<Eigen::Index>(k)];
    };
  }

  /// Do bounds that a search reports with this heuristic hold?
  bool consistent(const std::string& name) const {
    const auto user = problem_.heuristics.find(name);
    return user == problem_.heuristics.end() ? name == "joint_euclidean" : user->second.consistent;
  }

  AnyHeuristic bfs_heuristic(Lattice& lattice, double resolution) {
    const PhaseTimer timer(deadline_, statistics_.heuristic_time_s);
    const std::shared_ptr<RobotData> data(robot_.make_data(problem_.placed->other_positions).release(),
                                          RobotDataDeleter{});
    const std::size_t link = robot_.link_index(robot_.end_effector());
    const Pose base = problem_.checker.base();
    const auto tip = [this, data, link, base](const Eigen::VectorXd& q) -> Eigen::Vector3d {
      robot_.forward(*data, q);
      return base * Eigen::Vector3d(robot_.link_pose(*data, link).translation());
    };
    std::vector<Eigen::Vector3d> goals;
    double reach = tip_reach(tip, base.p);
    for (const Eigen::VectorXd& target : lattice.targets()) goals.push_back(tip(target));
    const auto grid = grid_around(base.p, reach, goals, resolution);
    // One radian moves the tip by at most about `reach`; places that walls cut off count as far away, not as hopeless,
    // because the grid knows only the tip.
    return [&lattice, tip, grid, reach](search::StateId state) {
      if (lattice.is_goal(state)) return 0.0;
      return std::min(grid->distance(tip(lattice.configuration(state))), 4.0 * reach) / reach;
    };
  }

  /// Lattices with the same goals share it.
  std::shared_ptr<const TaskSpaceBfs> grid_around(const Eigen::Vector3d& middle, double reach,
                                                  const std::vector<Eigen::Vector3d>& goals, double resolution) {
    for (const Grid& known : grids_)
      if (known.resolution == resolution && known.goals == goals) return known.bfs;
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(reach);
    const auto bfs =
        std::make_shared<const TaskSpaceBfs>(problem_.scene, middle - half, middle + half, goals,
                                             TaskSpaceBfs::Options{resolution, common_.bfs_radius}, deadline_);
    grids_.push_back({resolution, goals, bfs});
    statistics_.memory_bytes += bfs->memory();
    return bfs;
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
    const AnyHeuristic anchor = make_heuristic(common_.heuristic, lattice);
    stop_if_late("the construction of the heuristic");
    const double shortening = statistics_.shortcut_time_s;
    search::Result result;
    {
      const PhaseTimer timer(deadline_, statistics_.search_time_s);
      const auto starts = lattice.starts();
      result = std::visit([&](const auto& options) { return run_search(lattice, starts, anchor, options); },
                          problem_.options);
    }
    statistics_.search_time_s -= statistics_.shortcut_time_s - shortening;  // ARA* shortens each path as it comes
    return result;
  }

  using Starts = std::vector<search::StateId>;

  search::Result run_search(Lattice& lattice, const Starts& starts, const AnyHeuristic& h, const AStar&) {
    return search::weighted_astar(lattice, starts, h, {.weight = 1.0}, deadline_);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const AnyHeuristic& h, const WAStar& options) {
    return search::weighted_astar(lattice, starts, h, {.weight = options.weight}, deadline_);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const AnyHeuristic& h, const ARAStar& options) {
    search::AraOptions ara;
    ara.initial_weight = std::max(options.weight, options.final_weight);
    ara.weight_delta = options.weight_delta;
    ara.final_weight = options.final_weight;
    ara.on_solution = [&](const search::Result& better) { return take(found_in(better, lattice, backward_)); };
    return search::ara_star(lattice, starts, h, ara, deadline_);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const AnyHeuristic& h, const MHAStar& options) {
    std::vector<search::InadmissibleHeuristic> others;
    for (const std::string& name : options.inadmissible_heuristics) others.push_back(make_heuristic(name, lattice));
    return search::mha_star(lattice, starts, h, others, {.w1 = options.w1, .w2 = options.w2}, deadline_);
  }
  search::Result run_search(Lattice& lattice, const Starts& starts, const AnyHeuristic& h, const WPASE& options) {
    return search::wpase(lattice, starts, h,
                         {.weight = options.weight, .batch_size = static_cast<std::size_t>(options.batch_size)},
                         deadline_);
  }
  /// The planners for many robots.
  template <class Multi>
  search::Result run_search(Lattice&, const Starts&, const AnyHeuristic&, const Multi&) {
    throw NotSupported(planner_id(problem_.options) +
                       " plans for many robots, with plan_multi; make_planner another planner, such as 'wAstar', for "
                       "plan");
  }

  search::Result run_search(Lattice&, const Starts&, const AnyHeuristic&, const Auto&) {
    throw Error("internal error: 'auto' searches more than one lattice");
  }

  void find_path() {
    try {
      search_for_path();
    } catch (const MotionCheckStopped&) {
      improving_until_ = nullptr;
      if (best_.empty()) stop_if_late("a check of a motion");
    }
  }

  void search_for_path() {
    if (const auto* options = std::get_if<Auto>(&problem_.options)) return find_path_in_turns(*options);
    choose_direction();
    Lattice lattice = make_lattice(backward_, make_primitives());
    const search::Result result = search(lattice);
    for (const Worker& worker : workers_)
      if (worker.stopped) throw MotionCheckStopped();
    statistics_.states = lattice.size();
    statistics_.memory_bytes += lattice.memory() + result.statistics.memory;
    count(result.statistics);
    require_solved(result);
    if (best_.empty()) take(found_in(result, lattice, backward_));  // ARA* has handed in its own
  }

  /// A path as a search found it, from start to goal.
  struct Found {
    std::vector<Eigen::VectorXd> path;
    int goal_index{};
    double cost{};
    double lower{};  // no path of the lattice costs less
    std::string graph;
  };

  Found found_in(const search::Result& result, const Lattice& lattice, bool backward) const {
    Found found{lattice.configurations(result.path), 0, result.cost, 0.0, describe(backward)};
    if (consistent(common_.heuristic) || std::holds_alternative<Auto>(problem_.options))
      found.lower = result.cost / result.bound;
    const search::StateId goal_state = backward ? result.path.front() : result.path.back();
    const SnapGoal* snapped = lattice.snapped_goal(goal_state);
    found.goal_index =
        snapped ? snapped->goal : targets_[backward ? goal_state : goal_state - lattice.anchor_count()].goal_index;
    if (backward) found.path = unwrapped({found.path.rbegin(), found.path.rend()});
    return found;
  }

  std::string describe(bool backward, double scale = 1.0) const {
    const std::string end = backward ? "the goals" : "the start";
    if (own_primitives()) return "the lattice of '" + common_.mprim_path + "' from " + end;
    return "the lattice of " + to_text(scaled_resolution(scale)) + " degrees from " + end;
  }

  void count(const search::Statistics& work) {
    statistics_.expansions += work.expansions;
    statistics_.generated += work.generated;
  }

  /// Shortens a path and keeps it when it is the shortest so far. False: the user wants no better one.
  bool take(Found found, const ShortcutOptions& effort = {}) {
    if (common_.shortcut) found.path = shortened(found.path, effort);
    const double cost = length(found.path);
    if (best_.empty() || cost < statistics_.path_cost_rad) {
      best_ = std::move(found.path);
      statistics_.path_cost_rad = cost;
      statistics_.goal_index = found.goal_index;
    }
    statistics_.search_cost_rad =
        statistics_.solutions.empty() ? found.cost : std::min(statistics_.search_cost_rad, found.cost);
    return prove(found.lower, found.graph);
  }

  /// No path of `graph` costs less than `lower`. Tells of the best path if it or its bound is news.
  bool prove(double lower, const std::string& graph) {
    if (statistics_.bound_graph.empty() || lower > lower_ * (1.0 + 1e-9)) {
      lower_ = lower;
      statistics_.bound_graph = graph;
    }
    const double cost = std::min(statistics_.path_cost_rad, statistics_.search_cost_rad);
    statistics_.bound = cost <= lower_ ? 1.0 : lower_ > 0.0 ? cost / lower_ : search::infinity;
    const Solution now{deadline_.elapsed(), statistics_.path_cost_rad, statistics_.bound, statistics_.bound_graph};
    std::vector<Solution>& known = statistics_.solutions;
    if (!known.empty() && now.cost_rad >= known.back().cost_rad && now.bound >= known.back().bound) return true;
    known.push_back(now);
    return !problem_.on_solution || problem_.on_solution(now, to_rows(best_));
  }

  // --- the planner `auto`

  static constexpr double scales[] = {3.0, 1.5, 0.75, 0.4};  // of the resolution asked for
  /// The first path is wanted soon: what a tenth of the checks can save.
  static ShortcutOptions quick() {
    return {.min_gain = 1e-2, .max_rounds = 2, .halvings = 3, .pull_gain = 1e-2, .cut_gain = 1.0, .continuous = {}};
  }

  /// One search of the portfolio and what it needs to live.
  struct Member {
    std::unique_ptr<Lattice> lattice;  // it cannot move
    AnyHeuristic anchor;
    bool backward;
    double scale;
  };

  /// Two trees beside the lattices of the portfolio. They prove nothing, but the straight line is a bound for all.
  class GrowingTrees {
   public:
    GrowingTrees(SingleRobotPlan& plan, double weight)
        : plan_(plan), longest_(weight * plan.direct_), before_(plan.motions_checked()), trees_(space()) {}
    ~GrowingTrees() {
      plan_.statistics_.expansions += trees_.attempts();
      plan_.statistics_.memory_bytes += trees_.memory();
    }

    /// Grows until seven eighths of all motions checked so far, and the first ones, are theirs.
    std::optional<Found> grow() {
      std::optional<std::vector<Eigen::VectorXd>> way;
      while (!done_ && !way && !plan_.deadline_.stop_requested() &&
             8 * checked_ < 8 * head_start + 7 * (plan_.motions_checked() - before_)) {
        const std::uint64_t before = plan_.motions_checked();
        way = trees_.grow(trees_.attempts() + turn, plan_.deadline_);
        checked_ += std::max(turn, plan_.motions_checked() - before);  // an attempt may check none
      }
      if (!way) return std::nullopt;
      done_ = true;
      Found found{plan_.unwrapped(*way), plan_.goal_index_of(way->back()), plan_.length(*way), plan_.direct_,
                  "every path"};
      return found.cost <= longest_ ? std::optional(std::move(found)) : std::nullopt;
    }

   private:
    static constexpr std::uint64_t turn = 16;         // attempts between two looks at the share
    static constexpr std::uint64_t head_start = 128;  // motions

    search::TreeSpace space() const {
      search::TreeSpace space = tree_space(plan_.robot_, plan_.start_, plan_.target_configurations());
      space.is_motion_free = [this](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
        return plan_.is_motion_free(a, b);
      };
      return space;
    }

    SingleRobotPlan& plan_;
    const double longest_;
    const std::uint64_t before_;
    std::uint64_t checked_{};
    search::TwoTrees trees_;
    bool done_{};
  };

  std::uint64_t motions_checked() { return problem_.checker.statistics(workspace()).motions; }

  int goal_index_of(const Eigen::VectorXd& q) const {
    return std::find_if(targets_.begin(), targets_.end(), [&](const Target& target) { return target.q == q; })
        ->goal_index;
  }

  void find_path_in_turns(const Auto& options) {
    direct_ = search::infinity;
    for (const Target& target : targets_) direct_ = std::min(direct_, robot_.difference(start_, target.q).norm());
    lower_ = direct_;
    statistics_.bound_graph = "every path";
    GrowingTrees trees(*this, options.weight);
    std::optional<Found> grown;
    search::PortfolioOptions turns{.weight = options.weight};
    if (common_.direction == "auto" && common_.heuristic == CommonOptions().heuristic && !own_primitives())
      turns.before_round = [&] { return (grown = trees.grow()).has_value(); };
    const search::PortfolioResult found = search_in_turns(search::infinity, 1.0, turns, deadline_);
    if (!grown) require_solved(found.result);
    Found first = grown ? *std::move(grown) : found_by(found);
    if (take(first, quick()) && options.improve_time > 0.0) improve(std::move(first), options);
    improving_until_ = nullptr;
  }

  Found found_by(const search::PortfolioResult& found) const {
    const Member& winner = members_[found.winner];
    Found answer = found_in(found.result, *winner.lattice, winner.backward);
    answer.graph = describe(winner.backward, winner.scale);
    return answer;
  }

  /// Better and better paths. Each round searches only where a path could be shorter than the best by a good part of
  /// what it is longer than the straight line (Gammell, Srinivasa, Barfoot 2014, "Informed RRT*"); a lattice exhausted
  /// there proves its optimum longer. When no round finds any, the next rounds have more time, in finer lattices.
  void improve(Found first, const Auto& options) {
    const Deadline until(std::min(options.improve_time, deadline_.remaining()),
                         [this] { return deadline_.cancelled(); });
    improving_until_ = &until;
    if (!take(std::move(first))) return;  // now with all the care that shortening can take
    double finer = 1.0;
    for (std::uint64_t expansions = 64;; expansions *= 4, finer *= 0.87)
      for (const double share : {0.5, 0.75, 0.9, 1.0})
        while (true) {
          if (good_enough(options) || until.stop_requested()) return;
          const double before = statistics_.path_cost_rad, limit = direct_ + share * (before - direct_);
          const auto found = search_in_turns(limit, finer, {.max_expansions = expansions}, until);
          if (!prove_exhausted(found, limit)) return;
          if (found.result.status == Status::solved && !take(found_by(found))) return;
          const auto& exhausted = found.exhausted;
          if (own_primitives() && share == 1.0 && std::count(exhausted.begin(), exhausted.end(), 0) == 0)
            return;  // there is no finer lattice to turn to
          if (statistics_.path_cost_rad >= before) break;
        }
  }

  /// A shortened path may well be shorter than all of a lattice, so a bound of 1 there is no reason to stop.
  bool good_enough(const Auto& options) const {
    if (options.final_weight > 1.0 && statistics_.bound <= options.final_weight) return true;
    return statistics_.path_cost_rad <= direct_ * (1.0 + 1e-9);
  }

  /// False: the user wants no better path.
  bool prove_exhausted(const search::PortfolioResult& found, double limit) {
    for (std::size_t i = 0; i < members_.size(); ++i)
      if (found.exhausted[i] && !prove(limit, describe(members_[i].backward, members_[i].scale))) return false;
    return true;
  }

  /// Searches whose states lie on paths no longer than `limit`, all lattices `finer` times the usual scale.
  search::PortfolioResult search_in_turns(double limit, double finer, const search::PortfolioOptions& options,
                                          const Deadline& deadline) {
    members_.clear();
    const std::vector<double> all{std::begin(scales), std::end(scales)};
    for (const double scale : own_primitives() ? std::vector<double>{1.0} : all)
      for (const bool back : {true, false})
        if (common_.direction == "auto" || back == (common_.direction == "backward"))
          members_.push_back({nullptr, {}, back, finer * scale});
    const auto make = [&](std::size_t i) { return make_member(members_[i], limit); };
    const PhaseTimer timer(deadline_, statistics_.search_time_s);
    auto found = search::portfolio<Lattice, AnyHeuristic>(members_.size(), make, options, deadline);
    count(found.result.statistics);
    std::uint64_t memory = found.result.statistics.memory;
    for (const Member& member : members_)
      if (member.lattice) {
        statistics_.states += member.lattice->size();
        memory += member.lattice->memory();
      }
    statistics_.memory_bytes = std::max(statistics_.memory_bytes, memory);
    return found;
  }

  search::PortfolioMember<Lattice, AnyHeuristic> make_member(Member& member, double limit) {
    if (!pairs_) pairs_ = parallel_pairs(robot_);
    member.lattice.reset(new Lattice(make_lattice(
        member.backward,
        own_primitives() ? make_primitives() : rich_primitives(robot_.joints(), lattice_step(member.scale), *pairs_))));
    Lattice& lattice = *member.lattice;
    member.anchor = [&lattice, limit](search::StateId s) {
      const double ahead = lattice.distance_to_targets(s);
      if (limit == search::infinity || ahead + lattice.distance_from_anchors(s) < limit + 1e-9) return ahead;
      return search::infinity;
    };
    return {&lattice, lattice.starts(), &member.anchor, make_guides(lattice)};
  }

  /// The distance to the goal by four measures: straight; with the joints near the base counting for more; with those
  /// near the hand; and the sum over the joints; and what the user asks for, unless it is one of them. Where one leads
  /// into a corner, another leads out.
  search::Guides make_guides(Lattice& lattice) {
    constexpr std::size_t measures = measure_names.size();
    const bool more = std::find(measure_names.begin(), measure_names.end(), common_.heuristic) == measure_names.end();
    const std::size_t count = measures + more;
    return {count,
            [&lattice, count, more, weights = measure_weights(robot_.dof()),
             other = more ? make_heuristic(common_.heuristic, lattice) : AnyHeuristic(),
             values = std::vector<double>()](std::span<const search::StateId> states, std::span<double> out) mutable {
              for (std::size_t i = 0; i < states.size(); ++i)
                lattice.measure_to_targets(states[i], weights, out.subspan(i * count, measures));
              if (!more) return;
              values.resize(states.size());
              other.values(states, values);
              for (std::size_t i = 0; i < states.size(); ++i) out[i * count + measures] = values[i];
            }};
  }

  // ---

  /// Continuous joints go on from waypoint to waypoint by the short way.
  std::vector<Eigen::VectorXd> unwrapped(std::vector<Eigen::VectorXd> path) const {
    for (std::size_t i = 1; i < path.size(); ++i) {
      const Eigen::VectorXd next = path[i - 1] + robot_.difference(path[i - 1], path[i]);
      for (std::size_t k = 0; k < robot_.dof(); ++k)
        if (const auto at = static_cast<Eigen::Index>(k); robot_.joints()[k].kind == JointKind::continuous)
          path[i][at] = next[at];
    }
    return path;
  }

  void require_solved(const search::Result& result) const {
    const std::string work = std::to_string(result.statistics.expansions) + " states expanded, " +
                             std::to_string(result.statistics.evaluations) + " edges checked";
    switch (result.status) {
      case Status::solved: return;
      case Status::exhausted:
        fail(result.status,
             (members_.size() > 1 ? "none of the " + std::to_string(members_.size()) + " lattices holds a"
                                  : describe(backward_) + " holds no") +
                 " path: every state that can be reached was expanded (" + work +
                 "); a finer resolution or other motion primitives may hold one");
      case Status::cancelled: fail(result.status, "the plan was cancelled during the search (" + work + ")");
      default:
        fail(Status::timed_out,
             "no path within the time limit of " + to_text(common_.time_limit) + " s (" + work + ")");
    }
  }

  std::vector<Eigen::VectorXd> shortened(const std::vector<Eigen::VectorXd>& path, ShortcutOptions options) {
    const PhaseTimer timer(deadline_, statistics_.shortcut_time_s);
    const auto is_free = [this](const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return is_motion_free(a, b); };
    options.continuous = problem_.limits.continuous;
    RowMatrix shorter;
    try {
      shorter = shortcut(to_rows(path), is_free, improving_until_ ? *improving_until_ : deadline_, options).waypoints;
    } catch (const MotionCheckStopped&) {
      return path;
    }
    std::vector<Eigen::VectorXd> result;
    for (Eigen::Index i = 0; i < shorter.rows(); ++i) result.emplace_back(shorter.row(i).transpose());
    return result;
  }

  RowMatrix to_rows(const std::vector<Eigen::VectorXd>& path) const {
    RowMatrix rows(static_cast<Eigen::Index>(path.size()), static_cast<Eigen::Index>(robot_.dof()));
    for (std::size_t i = 0; i < path.size(); ++i) rows.row(static_cast<Eigen::Index>(i)) = path[i].transpose();
    return rows;
  }

  void verify_escape() {
    if (escape_.empty()) return;
    const PhaseTimer timer(deadline_, statistics_.verification_time_s);
    const std::string why = escape_violation(problem_.checker, escape_, *problem_.checker.make_workspace());
    if (!why.empty())
      throw Error("internal error: the way out of the start does not lead out (" + why +
                  "); nothing is returned. Please report this");
  }

  const SingleRobotProblem& problem_;
  const CommonOptions& common_;
  const RobotModel& robot_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::vector<Worker> workers_;
  Eigen::VectorXd start_;                // free: the end of escape_, if there is one
  std::vector<Eigen::VectorXd> escape_;  // from a start in collision; empty: the start is free
  std::vector<Target> targets_;
  GoalSnap goal_snap_;
  bool backward_{false};
  std::vector<Eigen::VectorXd> best_;  // path so far
  double lower_{0.0};                  // no path of statistics_.bound_graph costs less
  const Deadline* improving_until_{nullptr};
  double direct_{0.0};  // straight to the nearest goal: no path at all is shorter
  std::vector<Member> members_;
  std::optional<std::vector<JointPair>> pairs_;  // once asked for
  struct Grid {
    double resolution;
    std::vector<Eigen::Vector3d> goals;
    std::shared_ptr<const TaskSpaceBfs> bfs;
  };
  std::vector<Grid> grids_;
};

}  // namespace

RobotPath find_robot_path(const SingleRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics) {
  return SingleRobotPlan(problem, deadline, statistics).find();
}

Trajectory plan_single_robot(const SingleRobotProblem& problem, const Deadline& deadline, PlanStatistics& statistics) {
  SingleRobotPlan plan(problem, deadline, statistics);
  try {
    Trajectory trajectory = plan.run();
    statistics.status = Status::solved;
    statistics.total_time_s = deadline.elapsed();
    return trajectory;
  } catch (const PlanningError& error) {
    plan.collect_check_statistics();
    note_failure(error, deadline, statistics);
    throw;
  }
}

}  // namespace srmp
