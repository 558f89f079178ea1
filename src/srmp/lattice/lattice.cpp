#include "srmp/lattice/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

constexpr std::int32_t turn = 3'600'000;    // grid units in 360 degrees
constexpr std::int32_t target_anchor = -1;  // first key entry of targets: on nobody's grid
constexpr double limit_tolerance = 1e-9;

double shortest(double difference) { return std::remainder(difference, 2.0 * std::numbers::pi); }

}  // namespace

Lattice::Lattice(const RobotModel& robot, std::vector<Eigen::VectorXd> anchors, std::vector<Eigen::VectorXd> targets,
                 Options options, MotionValidator validator, std::size_t workers)
    : joints_(robot.joints()),
      anchors_(std::move(anchors)),
      targets_(std::move(targets)),
      near_distance_(options.primitives.near_distance),
      snap_distance_(options.snap_distance),
      validator_(std::move(validator)),
      table_(robot.dof() + 1),
      scratch_key_(robot.dof() + 1, 0),
      q_(static_cast<Eigen::Index>(robot.dof())),
      ends_(workers, {q_, q_}),
      workers_(workers) {
  for (const Joint& joint : joints_) unit_.push_back(grid_unit(joint));
  for (const PrimitiveFamily& family : options.primitives.families) {
    Family& added = families_.emplace_back(Family{family.use, {}});
    for (const Eigen::VectorXd& delta : family.moves) {
      Move move{{}, 0.0};
      for (std::size_t j = 0; j < joints_.size(); ++j) {
        move.steps.push_back(static_cast<std::int32_t>(std::lround(delta[static_cast<Eigen::Index>(j)] / unit_[j])));
        move.cost += std::pow(move.steps[j] * unit_[j], 2);
      }
      move.cost = std::sqrt(move.cost);
      if (move.cost == 0.0)
        throw InvalidArgument("motion primitive family '" + family.name + "' has a move of zero length");
      added.moves.push_back(std::move(move));
    }
  }
  for (std::size_t i = 0; i < anchors_.size(); ++i) {
    scratch_key_[0] = static_cast<std::int32_t>(i);
    table_.insert(scratch_key_);
  }
  scratch_key_[0] = target_anchor;
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    scratch_key_[1] = static_cast<std::int32_t>(i);
    table_.insert(scratch_key_);
  }
}

std::vector<search::StateId> Lattice::starts() const {
  std::vector<search::StateId> ids;
  for (std::size_t i = 0; i < anchors_.size(); ++i) ids.push_back(static_cast<search::StateId>(i));
  return ids;
}

void Lattice::read_configuration(search::StateId state, Eigen::VectorXd& q) const {
  if (is_goal(state)) {
    q = targets_[state - anchor_count()];
    return;
  }
  const auto key = table_.key(state);
  const Eigen::VectorXd& anchor = anchors_[static_cast<std::size_t>(key[0])];
  for (std::size_t j = 0; j < joints_.size(); ++j)
    q[static_cast<Eigen::Index>(j)] = anchor[static_cast<Eigen::Index>(j)] + key[j + 1] * unit_[j];
}

Eigen::VectorXd Lattice::configuration(search::StateId state) const {
  Eigen::VectorXd q(static_cast<Eigen::Index>(joints_.size()));
  read_configuration(state, q);
  return q;
}

double Lattice::distance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  double squared = 0.0;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    const double difference = b[i] - a[i];
    const double d = joints_[j].kind == JointKind::continuous ? shortest(difference) : difference;
    squared += d * d;
  }
  return std::sqrt(squared);
}

double Lattice::distance_to_targets(search::StateId state) const {
  if (is_goal(state)) return 0.0;
  read_configuration(state, q_);
  double least = search::infinity;
  for (const Eigen::VectorXd& target : targets_) least = std::min(least, distance(q_, target));
  return least;
}

bool Lattice::apply(search::StateId state, const Move& move) {
  const auto key = table_.key(state);
  const Eigen::VectorXd& anchor = anchors_[static_cast<std::size_t>(key[0])];
  scratch_key_[0] = key[0];
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    std::int32_t coordinate = key[j + 1] + move.steps[j];
    if (joints_[j].kind == JointKind::continuous) {
      coordinate = (coordinate % turn + turn + turn / 2) % turn - turn / 2;
    } else if (move.steps[j] != 0) {
      const double value = anchor[static_cast<Eigen::Index>(j)] + coordinate * unit_[j];
      if (value < joints_[j].lower - limit_tolerance || value > joints_[j].upper + limit_tolerance) return false;
    }
    scratch_key_[j + 1] = coordinate;
  }
  return true;
}

void Lattice::add_moves(search::StateId state, const Family& family, std::vector<search::Successor>& out) {
  for (const Move& move : family.moves)
    if (apply(state, move)) {
      const search::StateId next = table_.insert(scratch_key_);
      if (next != state) out.push_back({next, move.cost});
    }
}

void Lattice::successors(search::StateId state, std::vector<search::Successor>& out) {
  if (is_goal(state)) return;  // a target is an end, and on nobody's grid
  read_configuration(state, q_);
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    const double cost = distance(q_, targets_[t]);
    if (cost <= snap_distance_)
      out.push_back({static_cast<search::StateId>(anchor_count() + t), std::max(cost, 1e-12)});
  }
  const bool near = near_an_end(q_);
  for (const Family& family : families_)
    if (family.use == PrimitiveUse::always || (family.use == PrimitiveUse::near) == near) add_moves(state, family, out);
}

bool Lattice::near_an_end(const Eigen::VectorXd& q) const {
  const auto close = [&](const Eigen::VectorXd& end) { return distance(q, end) <= near_distance_; };
  return std::any_of(targets_.begin(), targets_.end(), close) || std::any_of(anchors_.begin(), anchors_.end(), close);
}

void Lattice::evaluate(std::span<const search::Edge> edges, std::span<double> costs) {
  workers_.run(edges.size(), [&](std::size_t worker, std::size_t i) {
    auto& [from, to] = ends_[worker];
    read_configuration(edges[i].from, from);
    read_configuration(edges[i].to, to);
    costs[i] = validator_(worker, from, to) ? edges[i].cost : search::infinity;
  });
}

std::vector<Eigen::VectorXd> Lattice::configurations(std::span<const search::StateId> path) const {
  std::vector<Eigen::VectorXd> result;
  for (const search::StateId state : path) {
    Eigen::VectorXd q = configuration(state);
    if (!result.empty()) {
      for (std::size_t j = 0; j < joints_.size(); ++j) {
        const auto i = static_cast<Eigen::Index>(j);
        if (joints_[j].kind == JointKind::continuous) q[i] = result.back()[i] + shortest(q[i] - result.back()[i]);
      }
    }
    result.push_back(std::move(q));
  }
  return result;
}

}  // namespace srmp
