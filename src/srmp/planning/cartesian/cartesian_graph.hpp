#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "srmp/lattice/state_table.hpp"
#include "srmp/planning/endpoints/close_motions.hpp"
#include "srmp/planning/robot_context.hpp"
#include "srmp/robot/inverse_kinematics.hpp"
#include "srmp/search/graph.hpp"
#include "srmp/trajectory/cartesian_deviation.hpp"

namespace srmp {

/// Along which path a link moves in a CartesianGraph, and how finely.
struct CartesianGraphOptions {
  std::size_t link{};
  CartesianTolerance tolerance{};  ///< that every motion keeps, between its ends too
  double step{0.02};               ///< [m] between layers, at most
  double turn{0.07};               ///< [rad] between layers, at most
  /// [rad, prismatic joints m]: how far the joints move, in sum, in one step of the redundancy.
  double redundancy_step{0.06};
  /// Of inverse kinematics from a configuration of the layer before, which is near: more find a few more, for more
  /// time.
  int ik_iterations{20};
  /// Seeds of inverse kinematics that finds out whether a pose can be reached at all: a few, and many where these find
  /// nothing. More miss fewer configurations, for more time.
  int few_seeds{4}, many_seeds{64};
  /// Whether the path may begin and end closer to something than CommonOptions::clearance, which is above 0.
  bool close_ends{};
};

/// The graph of a robot's configurations along a Cartesian path: layer k holds configurations that put the link at the
/// k-th of close poses on the path. From each, edges lead to the configuration of the next layer that is nearest, to
/// those beside it along each direction in which the joints can move while the link stays (the null space of its
/// Jacobian), and to neighbours along these directions in the same layer. An edge is a straight joint-space motion that
/// is free and on which the link keeps to the path. Configurations of a layer that are closer than half a step of the
/// redundancy are one state. With path constraints, every edge is proved to keep them.
///
/// With close ends there are states besides that do not keep the clearance: those that withdraw from the start, and
/// those that approach the end (CloseMotions). The former lead on to the others, the latter only to each other.
/// Models search::Graph.
class CartesianGraph {
 public:
  /// `start` is free, or only close where ends may be, and puts the link at the first pose of the path, which is in the
  /// robot's base frame. Context and path outlive this.
  CartesianGraph(RobotContext& context, const Eigen::VectorXd& start, const CartesianPath& path,
                 const CartesianGraphOptions& options);

  // --- search::Graph
  void successors(search::StateId state, std::vector<search::Successor>& out);
  void evaluate(std::span<const search::Edge> edges, std::span<double> costs);
  bool is_goal(search::StateId state) const {
    return states_[state].layer + 1 == layers_.size() && states_[state].part != Part::withdrawal;
  }

  /// No path from the state to the last layer is shorter: a consistent heuristic.
  double distance_to_end(search::StateId state) const { return to_end_[states_[state].layer]; }
  const Eigen::VectorXd& configuration(search::StateId state) const { return states_[state].q; }
  /// Whether the clearance is kept there.
  bool is_clear(search::StateId state) const { return states_[state].part == Part::clear; }
  std::size_t size() const { return states_.size(); }
  std::size_t layers() const { return layers_.size(); }
  std::size_t memory() const;

  /// How far along the path the search came, as a sentence without a full stop.
  std::string reached() const { return place_of(farthest_, "came "); }
  /// Of a search without a path: how far along the path it came, and why no farther, as a sentence.
  std::string obstruction();
  /// Why no path can lead to the end, as a sentence: the first pose, behind those that the search reached, at which no
  /// configuration that inverse kinematics finds from many seeds is valid; "": there is none.
  std::string unreachable_pose();

 private:
  struct Layer {
    Pose pose;
    std::size_t segment;  // that ends there, or on which it is
    double passed;        // [m] of the path up to there
  };
  /// Of the path: where the clearance is kept, and before and after.
  enum class Part { clear, withdrawal, approach };
  struct State {
    std::size_t layer;
    Eigen::VectorXd q;
    Part part;
  };

  void add_layers(const CartesianGraphOptions& options);
  IkOptions ik_options() const;
  /// Configurations that put the link at the layer's pose.
  std::vector<Eigen::VectorXd> at_layer(std::size_t layer, const Eigen::VectorXd& reference, int seeds) const;
  /// The same, one near each reference, if there is one.
  std::vector<std::optional<Eigen::VectorXd>> near_at_layer(std::size_t layer,
                                                            const std::vector<Eigen::VectorXd>& references) const;
  search::StateId insert(std::size_t layer, Eigen::VectorXd q, Part part);
  /// Of a configuration behind a state of the part; none: no path leads there.
  std::optional<Part> part_behind(Part before, const Eigen::VectorXd& q);
  bool is_motion_free(const State& from, const State& to);
  /// Directions of unit length in which joints that move the link can move while it stays (dof, n).
  Eigen::MatrixXd redundancy(const Eigen::VectorXd& q);
  std::string obstruction_behind(const State& state);
  std::string invalidity_behind(const State& state, const Eigen::VectorXd& q);
  /// Why no path can pass q; "": one may.
  std::string invalidity_at(const Eigen::VectorXd& q);
  /// "'hand' came 0.1 m of 0.4 m along its path"
  std::string place_of(std::size_t layer, const std::string& verb) const;
  /// Why none of some configurations at the layer is valid; "": one is.
  std::string invalidity_at(std::size_t layer, int seeds);

  RobotContext& context_;
  const CartesianPath& path_;
  const CartesianGraphOptions options_;
  CartesianDeviationProof deviation_;
  RobotDataPtr data_;
  std::optional<CloseMotions> close_;  // where ends may be
  std::vector<Layer> layers_;
  std::vector<double> to_end_;  // of each layer
  std::vector<Eigen::Index> moving_joints_;
  StateTable table_;
  std::vector<State> states_;
  std::size_t farthest_{0};  // of the states that were expanded, which can be reached
};

}  // namespace srmp
