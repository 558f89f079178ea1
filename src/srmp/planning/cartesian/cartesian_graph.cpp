#include "srmp/planning/cartesian/cartesian_graph.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/planning/validity.hpp"
#include "srmp/robot/inverse_kinematics.hpp"

namespace srmp {

namespace {

constexpr double smallest_cost = 1e-9;  // of an edge [rad or m]
constexpr double large_step = 0.3;      // [rad or m]: near singularities

/// [m] to tenths of a millimetre.
std::string rounded(double length) { return to_text(std::round(1e4 * length) / 1e4); }

}  // namespace

CartesianGraph::CartesianGraph(RobotContext& context, const Eigen::VectorXd& start, const CartesianPath& path,
                               const CartesianGraphOptions& options)
    : context_(context),
      path_(path),
      options_(options),
      deviation_(context.robot, context.checks.checker().other_positions(), options.link, path, options.tolerance,
                 context.deadline),
      data_(context.robot.make_data(context.checks.checker().other_positions())),
      table_(context.robot.dof() + 1 + options.close_ends) {
  std::uint64_t moving = 0;  // planned joints that move the link
  for (std::size_t k = 0; k < context.robot.actuated_joints().size(); ++k)
    if (context.robot.link_support(options.link) >> k & 1)
      moving |= std::uint64_t{1} << context.robot.actuated_joints()[k].joint;
  for (std::size_t j = 0; j < context.robot.dof(); ++j)
    if (moving >> j & 1) moving_joints_.push_back(static_cast<Eigen::Index>(j));
  add_layers(options);
  if (options.close_ends) close_.emplace(context.problem.checkers, context.deadline);
  insert(0, start, !close_ || close_->is_clear(start) ? Part::clear : Part::withdrawal);
}

void CartesianGraph::add_layers(const CartesianGraphOptions& options) {
  layers_.push_back({path_.pose(0, 0.0), 0, 0.0});
  for (std::size_t i = 0; i < path_.segments(); ++i) {
    const double finest = std::max(path_.length(i) / options.step, path_.angle(i) / options.turn);
    const auto steps = static_cast<int>(std::ceil(std::max(finest, 1.0) - 1e-9));
    for (int k = 1; k <= steps; ++k) {
      const double fraction = static_cast<double>(k) / steps;
      layers_.push_back({path_.pose(i, fraction), i, layers_.front().passed});
      layers_.back().passed = layers_[layers_.size() - 2].passed + path_.length(i) / steps;
    }
  }
  to_end_.assign(layers_.size(), 0.0);
  for (std::size_t k = layers_.size() - 1; k-- > 0;) {
    const Pose step = layers_[k].pose.inverse() * layers_[k + 1].pose;
    const double turn = 2.0 * std::atan2(step.q.vec().norm(), std::abs(step.q.w()));
    const double length = std::max(step.p.norm() - 4e-5, 0.0);  // both ends miss their poses
    const double angle = std::max(turn - 4e-4, 0.0);
    to_end_[k] = to_end_[k + 1] + std::max(length / deviation_.max_travel(), angle / deviation_.max_turn());
  }
}

IkOptions CartesianGraph::ik_options() const {
  IkOptions options;
  options.other_positions = context_.checks.checker().other_positions();
  if (close_) {  // the rule near the ends is about micrometres
    options.position_tolerance = 1e-7;
    options.rotation_tolerance = 1e-6;
  }
  return options;
}

std::vector<Eigen::VectorXd> CartesianGraph::at_layer(std::size_t layer, const Eigen::VectorXd& reference,
                                                      int seeds) const {
  IkOptions options = ik_options();
  options.max_solutions = options.seeds = seeds;
  return inverse_kinematics(context_.robot, layers_[layer].pose, reference, options,
                            context_.robot.link_names()[options_.link], context_.deadline);
}

std::vector<std::optional<Eigen::VectorXd>> CartesianGraph::near_at_layer(
    std::size_t layer, const std::vector<Eigen::VectorXd>& references) const {
  IkOptions options = ik_options();
  options.max_iterations = options_.ik_iterations;
  return inverse_kinematics_from(context_.robot, layers_[layer].pose, references, options,
                                 context_.robot.link_names()[options_.link]);
}

search::StateId CartesianGraph::insert(std::size_t layer, Eigen::VectorXd q, Part part) {
  std::vector<std::int32_t> key{static_cast<std::int32_t>(layer)};
  if (close_) key.push_back(static_cast<std::int32_t>(part));
  const double cell = options_.redundancy_step / 2.0;
  for (std::size_t j = 0; j < context_.robot.dof(); ++j) {
    double value = q[static_cast<Eigen::Index>(j)];
    if (context_.robot.joints()[j].kind == JointKind::continuous) value = std::remainder(value, 2.0 * M_PI);
    key.push_back(static_cast<std::int32_t>(std::lround(value / cell)));
  }
  const search::StateId id = table_.insert(key);
  if (id == states_.size()) states_.push_back({layer, std::move(q), part});
  return id;
}

Eigen::MatrixXd CartesianGraph::redundancy(const Eigen::VectorXd& q) {
  const auto moving = static_cast<Eigen::Index>(moving_joints_.size());
  if (moving <= 6) return Eigen::MatrixXd(q.size(), 0);
  Eigen::MatrixXd jacobian(6, q.size()), transposed(moving, 6);
  context_.robot.forward(*data_, q);
  context_.robot.jacobian(*data_, options_.link, jacobian);
  for (Eigen::Index i = 0; i < moving; ++i)
    transposed.row(i) = jacobian.col(moving_joints_[static_cast<std::size_t>(i)]).transpose();
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(transposed);
  const Eigen::MatrixXd orthogonal =
      qr.householderQ() * Eigen::MatrixXd::Identity(moving, moving).rightCols(moving - 6);
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(q.size(), moving - 6);
  for (Eigen::Index i = 0; i < moving; ++i)
    directions.row(moving_joints_[static_cast<std::size_t>(i)]) = orthogonal.row(i);
  return directions;
}

void CartesianGraph::successors(search::StateId state, std::vector<search::Successor>& out) {
  const State from = states_[state];  // a copy: states are added
  farthest_ = std::max(farthest_, from.layer);
  const std::size_t first = out.size();
  const auto add = [&](std::size_t layer, const std::optional<Eigen::VectorXd>& found) {
    if (!found) return;
    const std::optional<Part> part = part_behind(from.part, *found);
    if (!part) return;
    const search::StateId to = insert(layer, *found, *part);
    // More than 0 where it is at the next pose already.
    const double cost = std::max(context_.robot.difference(from.q, states_[to].q).norm(), smallest_cost);
    const bool known = to == state || std::any_of(out.begin() + static_cast<std::ptrdiff_t>(first), out.end(),
                                                  [&](const search::Successor& s) { return s.state == to; });
    if (!known) out.push_back({to, cost});
  };
  const bool last = from.layer + 1 == layers_.size();
  if (last) return;
  const Eigen::MatrixXd directions = redundancy(from.q);
  std::vector<Eigen::VectorXd> references;  // beside it, then itself
  for (Eigen::Index i = 0; i < directions.cols(); ++i)
    for (const double side : {options_.redundancy_step, -options_.redundancy_step})
      references.emplace_back(from.q + side * directions.col(i));
  const auto beside = near_at_layer(from.layer, references);
  references.push_back(from.q);
  const auto next = near_at_layer(from.layer + 1, references);
  add(from.layer + 1, next.back());
  for (std::size_t i = 0; i < beside.size(); ++i) {
    add(from.layer + 1, next[i]);
    add(from.layer, beside[i]);
  }
}

void CartesianGraph::evaluate(std::span<const search::Edge> edges, std::span<double> costs) {
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const State &from = states_[edges[i].from], &to = states_[edges[i].to];
    const bool keeps = deviation_.keeps(from.q, to.q, layers_[to.layer].segment);
    costs[i] = keeps && is_motion_free(from, to) ? edges[i].cost : search::infinity;
  }
}

std::optional<CartesianGraph::Part> CartesianGraph::part_behind(Part before, const Eigen::VectorXd& q) {
  if (!close_) return Part::clear;
  const bool clear = close_->is_clear(q);
  if (before == Part::approach && clear) return std::nullopt;
  if (clear) return Part::clear;
  return before == Part::withdrawal ? Part::withdrawal : Part::approach;
}

bool CartesianGraph::is_motion_free(const State& from, const State& to) {
  if (from.part == Part::clear && to.part == Part::clear) return context_.checks.is_motion_free(from.q, to.q);
  if (!context_.checks.keeps_rules(from.q, to.q)) return false;
  return to.part == Part::approach ? close_->withdraws(to.q, from.q) : close_->withdraws(from.q, to.q);
}

std::size_t CartesianGraph::memory() const {
  const std::size_t configuration = context_.robot.dof() * sizeof(double);
  return table_.memory() + states_.capacity() * sizeof(State) + states_.size() * configuration;
}

std::string CartesianGraph::obstruction() {
  // At the end of the path only a state that still withdraws from the start is no goal.
  const bool at_end = farthest_ + 1 == layers_.size();
  const auto state = std::find_if(states_.begin(), states_.end(), [&](const State& s) {
    return s.layer == farthest_ && (!at_end || s.part == Part::withdrawal);
  });
  return place_of(farthest_, "came ") + "; there, " + obstruction_behind(*state);
}

std::string CartesianGraph::place_of(std::size_t layer, const std::string& verb) const {
  const std::string how_far = path_.length() > 0.0
                                  ? rounded(layers_[layer].passed) + " m of " + rounded(path_.length()) + " m"
                                  : std::to_string(layer) + " of " + std::to_string(layers_.size() - 1) + " steps";
  return "'" + context_.robot.link_names()[options_.link] + "' " + verb + how_far + " along its path";
}

std::string CartesianGraph::obstruction_behind(const State& state) {
  const std::size_t next = state.layer + 1;
  if (next == layers_.size()) return close_->closeness(state.q) + ", and it ends before that is kept";
  const std::optional<Eigen::VectorXd> near = near_at_layer(next, {state.q}).front();
  if (!near)
    return at_layer(next, state.q, options_.many_seeds).empty()
               ? "no configuration within the joint limits puts it at the next pose"
               : "no configuration near the one before puts it at the next pose: a joint limit or a singularity is in "
                 "the way";
  const std::string why = invalidity_behind(state, *near);
  if (!why.empty()) return why;
  const double moved = context_.robot.difference(state.q, *near).norm();
  if (moved > large_step)
    return "the joints would have to move by " + rounded(moved) + " rad (m) in one step: a singularity is in the way";
  if (deviation_.keeps(state.q, *near, layers_[next].segment)) return "the search ended before it went on";
  return "the shortest joint-space motion to the next pose, of " + rounded(moved) +
         " rad (m), leaves the path by more than half of max_deviation or max_rotation";
}

std::string CartesianGraph::invalidity_behind(const State& state, const Eigen::VectorXd& q) {
  std::string why = context_.checks.constraints() ? context_.checks.constraints()->violation(q) : "";
  if (why.empty() && state.part == Part::withdrawal) why = close_->approach({state.q, q});
  if (why.empty() && state.part == Part::approach) why = close_->closeness(state.q);
  if (why.empty() && state.part == Part::clear)
    why = invalidity(context_.checks.checker(), q, context_.checks.workspace());
  if (!why.empty()) return why;
  const std::optional<Part> part = part_behind(state.part, q);
  if (part && is_motion_free(state, {state.layer + 1, q, *part})) return "";
  ConstraintChecker* constraints = context_.checks.constraints();
  if (constraints && !constraints->keeps(state.q, q, constraint_fractions.motions))
    return "the motion to the next pose is not proved to keep the path constraints";
  return context_.common.clearance > 0.0 ? "the motion to the next pose does not keep the clearance"
                                         : "the motion to the next pose is in collision";
}

std::string CartesianGraph::unreachable_pose() {
  for (std::size_t layer = farthest_ + 1; layer < layers_.size(); ++layer) {
    context_.stop_if_late("the search along the poses");
    if (invalidity_at(layer, options_.few_seeds).empty()) continue;
    const std::string why = invalidity_at(layer, options_.many_seeds);
    if (!why.empty()) return place_of(layer, "cannot be ") + ": " + why;
  }
  return "";
}

std::string CartesianGraph::invalidity_at(std::size_t layer, int seeds) {
  std::string why = "no configuration within the joint limits puts it there";
  for (const Eigen::VectorXd& q : at_layer(layer, states_.front().q, seeds)) {
    why = invalidity_at(q);
    if (why.empty()) break;
  }
  return why;
}

std::string CartesianGraph::invalidity_at(const Eigen::VectorXd& q) {
  const std::string broken = context_.checks.constraints() ? context_.checks.constraints()->violation(q) : "";
  if (!broken.empty() || (close_ && close_->is_free(q))) return broken;
  return invalidity(context_.checks.checker(), q, context_.checks.workspace());
}

}  // namespace srmp
