#pragma once

#include <memory>
#include <string>
#include <vector>

#include "srmp/heuristic/task_space_bfs.hpp"
#include "srmp/lattice/lattice.hpp"
#include "srmp/planning/robot_context.hpp"
#include "srmp/search/alternating_search.hpp"

namespace srmp {

/// Makes the heuristics of one plan by their names: built_in_heuristics() and the user's.
class RobotHeuristics {
 public:
  /// Both outlive it and its heuristics.
  RobotHeuristics(RobotContext& context, const Eigen::VectorXd& start) : context_(context), start_(start) {}

  /// The lattice outlives it.
  search::AnyHeuristic make(const std::string& name, Lattice& lattice);
  /// The distance to the goal by four measures: straight; with the joints near the base counting for more; with those
  /// near the hand; and the sum over the joints; and what the options ask for, unless it is one of them. Where one
  /// leads into a corner, another leads out.
  search::InadmissibleHeuristics inadmissible_heuristics(Lattice& lattice);
  /// How many consistent heuristics take the place of joint_euclidean in searches of several lattices: the sum over the
  /// joints, divided by the root of their number, and the distance in which the joints near the base count for more;
  /// both are never above the distance. 1 where the options ask for another heuristic.
  std::size_t metrics() const;
  /// One of them. The lattice outlives it.
  search::AnyHeuristic metric(std::size_t number, Lattice& lattice) const;
  /// Do bounds that a search reports with this heuristic hold?
  bool consistent(const std::string& name) const;

 private:
  struct Grid {
    double resolution;
    std::vector<Eigen::Vector3d> goals;
    std::shared_ptr<const TaskSpaceBfs> bfs;
  };
  /// Where the end effector is, world frame.
  using EndEffectorPosition = std::function<Eigen::Vector3d(const Eigen::VectorXd& q)>;

  search::AnyHeuristic measure(const std::string& name, Lattice& lattice) const;
  search::AnyHeuristic bfs(Lattice& lattice, double resolution);
  std::shared_ptr<const TaskSpaceBfs> grid_around(const Eigen::Vector3d& middle, double reach,
                                                  const std::vector<Eigen::Vector3d>& goals, double resolution);
  double end_effector_reach(const EndEffectorPosition& end_effector, const Eigen::Vector3d& base) const;

  RobotContext& context_;
  const Eigen::VectorXd& start_;
  std::vector<Grid> grids_;
};

}  // namespace srmp
