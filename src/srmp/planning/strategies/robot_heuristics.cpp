#include "srmp/planning/strategies/robot_heuristics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string_view>

#include "srmp/planning/phase_timer.hpp"
#include "srmp/trajectory/path.hpp"

namespace srmp {

namespace {

using search::AnyHeuristic;

/// What distances_to_targets writes with distance_weights.
constexpr std::array<std::string_view, 4> measure_names{"joint_euclidean", "joint_proximal", "joint_distal",
                                                        "joint_sum"};

std::size_t measure_index(const std::string& name) {
  return static_cast<std::size_t>(std::find(measure_names.begin(), measure_names.end(), name) - measure_names.begin());
}

AnyHeuristic users(const std::string& name, const UserHeuristic& user, Lattice& lattice) {
  return [&lattice, &user, name, goals = stack_waypoints(lattice.targets())](std::span<const search::StateId> states,
                                                                             std::span<double> out) {
    std::fill(out.begin(), out.end(), 0.0);  // what goals have
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < states.size(); ++i)
      if (!lattice.is_goal(states[i])) others.push_back(i);
    if (others.empty()) return;
    RowMatrix rows(static_cast<Eigen::Index>(others.size()), goals.cols());
    for (std::size_t k = 0; k < others.size(); ++k)
      rows.row(static_cast<Eigen::Index>(k)) = lattice.configuration(states[others[k]]).transpose();
    const Eigen::VectorXd values = evaluate(name, user, rows, goals);
    for (std::size_t k = 0; k < others.size(); ++k) out[others[k]] = values[static_cast<Eigen::Index>(k)];
  };
}

}  // namespace

AnyHeuristic RobotHeuristics::make(const std::string& name, Lattice& lattice) {
  const UserHeuristics& known = context_.problem.heuristics;
  if (const auto user = known.find(name); user != known.end()) return users(name, user->second, lattice);
  if (name == "bfs") return bfs(lattice, context_.common.bfs_resolution);
  if (const auto cell = bfs_cell(name)) return bfs(lattice, *cell);
  if (name == "joint_euclidean")
    return [&lattice](search::StateId state) { return lattice.distance_to_targets(state); };
  return measure(name, lattice);
}

search::InadmissibleHeuristics RobotHeuristics::inadmissible_heuristics(Lattice& lattice) {
  constexpr std::size_t measures = measure_names.size();
  const std::string& name = context_.common.heuristic;
  const bool more = measure_index(name) == measures;
  const std::size_t count = measures + more;
  return {count, [&lattice, count, more, weights = distance_weights(context_.robot.dof()),
                  other = more ? make(name, lattice) : AnyHeuristic(), values = std::vector<double>()](
                     std::span<const search::StateId> states, std::span<double> out) mutable {
            for (std::size_t i = 0; i < states.size(); ++i)
              lattice.distances_to_targets(states[i], weights, out.subspan(i * count, measures));
            if (!more) return;
            values.resize(states.size());
            other.values(states, values);
            for (std::size_t i = 0; i < states.size(); ++i) out[i * count + measures] = values[i];
          }};
}

std::size_t RobotHeuristics::metrics() const { return context_.common.heuristic == measure_names.front() ? 2 : 1; }

AnyHeuristic RobotHeuristics::metric(std::size_t number, Lattice& lattice) const {
  const RowMatrix proximal = distance_weights(context_.robot.dof()).row(1);
  const double most = std::sqrt(static_cast<double>(context_.robot.dof()));  // a sum over joints, by the distance
  return [&lattice, number, most, weights = RowMatrix(proximal / proximal.maxCoeff())](search::StateId state) {
    std::array<double, 2> values{};
    lattice.distances_to_targets(state, weights, values);
    return number == 1 ? values.back() / most : values.front();
  };
}

bool RobotHeuristics::consistent(const std::string& name) const {
  const UserHeuristics& known = context_.problem.heuristics;
  const auto user = known.find(name);
  return user == known.end() ? name == "joint_euclidean" : user->second.consistent;
}

AnyHeuristic RobotHeuristics::measure(const std::string& name, Lattice& lattice) const {
  return [&lattice, weights = distance_weights(context_.robot.dof()), at = measure_index(name)](search::StateId state) {
    std::array<double, measure_names.size()> values{};
    lattice.distances_to_targets(state, weights, values);
    return values[at];
  };
}

AnyHeuristic RobotHeuristics::bfs(Lattice& lattice, double resolution) {
  const PhaseTimer timer(context_.deadline, context_.statistics.heuristic_time_s);
  const RobotModel& robot = context_.robot;
  const std::shared_ptr<RobotData> data(robot.make_data(context_.task.placed->other_positions).release(),
                                        RobotDataDeleter{});
  const std::size_t link = robot.link_index(robot.end_effector());
  const Pose base = context_.checks.checker().base();
  const auto end_effector = [&robot, data, link, base](const Eigen::VectorXd& q) -> Eigen::Vector3d {
    robot.forward(*data, q);
    return base * Eigen::Vector3d(robot.link_pose(*data, link).translation());
  };
  std::vector<Eigen::Vector3d> goals;
  double reach = end_effector_reach(end_effector, base.p);
  for (const Eigen::VectorXd& target : lattice.targets()) goals.push_back(end_effector(target));
  const auto grid = grid_around(base.p, reach, goals, resolution);
  // One radian moves the end_effector by at most about `reach`; places that walls cut off count as far away, not as
  // hopeless, because the grid knows only the end_effector.
  return [&lattice, end_effector, grid, reach](search::StateId state) {
    if (lattice.is_goal(state)) return 0.0;
    return std::min(grid->distance(end_effector(lattice.configuration(state))), 4.0 * reach) / reach;
  };
}

/// Lattices with the same goals share it.
std::shared_ptr<const TaskSpaceBfs> RobotHeuristics::grid_around(const Eigen::Vector3d& middle, double reach,
                                                                 const std::vector<Eigen::Vector3d>& goals,
                                                                 double resolution) {
  for (const Grid& known : grids_)
    if (known.resolution == resolution && known.goals == goals) return known.bfs;
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(reach);
  const auto bfs = std::make_shared<const TaskSpaceBfs>(context_.problem.scene, middle - half, middle + half, goals,
                                                        TaskSpaceBfs::Options{resolution, context_.common.bfs_radius},
                                                        context_.deadline);
  grids_.push_back({resolution, goals, bfs});
  context_.statistics.memory_bytes += bfs->memory();
  return bfs;
}

/// How far the end effector gets from the base, over a fixed sample of configurations.
double RobotHeuristics::end_effector_reach(const EndEffectorPosition& end_effector, const Eigen::Vector3d& base) const {
  double reach = (end_effector(start_) - base).norm();
  Eigen::VectorXd q = start_;
  for (int sample = 1; sample <= 128; ++sample) {
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      const Joint& joint = context_.robot.joints()[static_cast<std::size_t>(j)];
      const double low = std::max(joint.lower, -M_PI), high = std::min(joint.upper, M_PI);
      const double golden = std::sqrt(static_cast<double>(j) + 2.0) * sample;  // a Kronecker sequence
      q[j] = low + (high - low) * (golden - std::floor(golden));
    }
    reach = std::max(reach, (end_effector(q) - base).norm());
  }
  return 1.1 * reach;
}

}  // namespace srmp
