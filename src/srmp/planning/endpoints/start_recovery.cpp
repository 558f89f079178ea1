#include "srmp/planning/endpoints/start_recovery.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "srmp/search/best_first.hpp"

namespace srmp {

namespace {

using PairName = std::pair<std::string, std::string>;
using Depths = std::map<PairName, double>;  // of every pair in contact [m]

PairName name_of(const Contact& contact) { return {contact.body_a, contact.body_b}; }

/// What must fall along a path; a pair that merely touches counts too.
double sum_of(const Depths& depths) {
  double sum = 0.0;
  for (const auto& [pair, depth] : depths) sum += std::max(depth, 0.0) + recovery_tolerance;
  return sum;
}

/// The contact that is new, or deeper than in `least` by more than the tolerance; null when there is none.
const Contact* violation_of(const Depths& least, const std::vector<Contact>& contacts, double tolerance) {
  for (const Contact& contact : contacts) {
    const auto known = least.find(name_of(contact));
    if (known == least.end() || -contact.distance > known->second + tolerance) return &contact;
  }
  return nullptr;
}

/// The least depth so far of each pair that is still in contact.
Depths updated(const Depths& least, const std::vector<Contact>& contacts) {
  Depths result;
  for (const Contact& contact : contacts) {
    const auto known = least.find(name_of(contact));
    result[name_of(contact)] = known == least.end() ? -contact.distance : std::min(known->second, -contact.distance);
  }
  return result;
}

/// Samples of a straight segment.
int samples_between(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return std::max(1, static_cast<int>(std::ceil((b - a).cwiseAbs().maxCoeff() / recovery_step - 1e-6)));
}

/// A search::BestFirstProblem ordered by the sum of depths. A free node has the least sum there can be, so the search
/// ends with the first that an expansion adds.
class StartRecoverySearch {
 public:
  struct Node {
    Eigen::VectorXd q;
    Depths least;  // of all samples up to here; empty: free
  };

  StartRecoverySearch(const Checker& checker, Checker::Workspace& workspace, const std::function<void()>& keep_going,
                      const StartRecoveryOptions& options)
      : checker_(checker), robot_(checker.robot()), workspace_(workspace), keep_going_(keep_going), options_(options) {}

  std::vector<Eigen::VectorXd> run(const Eigen::VectorXd& start) {
    add({start, updated({}, contacts_at(start))}, search::no_node);
    std::vector<Eigen::VectorXd> path;
    const search::BestFirstResult found = search_.run(*this, Deadline());
    if (found.status == Status::solved)
      for (const search::NodeId id : search_.path_to(found.goal)) path.push_back(search_[id].q);
    return path;
  }

  bool is_dominated(const Node&) const { return false; }
  bool is_valid(search::NodeId) const { return true; }
  void close(const Node&) const {}
  bool is_goal(const Node& node) const { return node.least.empty(); }
  bool may_expand(std::uint64_t) const { return checks_ < options_.max_checks; }

  void expand(search::NodeId id) {
    const Node from = search_[id];
    for (const Eigen::VectorXd& direction : directions(from)) {
      std::optional<Node> next = segment_end(from, direction);
      if (!next) continue;
      const bool is_free = next->least.empty();
      add(std::move(*next), id);
      if (is_free) return;
    }
  }

 private:
  void add(Node node, search::NodeId parent) {
    const double key = sum_of(node.least);
    search_.add(std::move(node), key, parent);
  }

  std::vector<Contact> contacts_at(const Eigen::VectorXd& q) {
    if (keep_going_) keep_going_();
    ++checks_;
    return checker_.contacts(q, workspace_);
  }

  std::vector<Eigen::VectorXd> directions(const Node& node) {
    std::vector<Eigen::VectorXd> result;
    const Eigen::MatrixXd gradients = depth_gradients(node);
    Eigen::VectorXd depths(gradients.rows());
    std::transform(node.least.begin(), node.least.end(), depths.data(), [](const auto& pair) { return pair.second; });
    const auto add_separating = [&](const Eigen::MatrixXd& gradient, const Eigen::VectorXd& depth) {
      const Eigen::VectorXd step = separating_step(node.q, gradient, depth);
      if (step.norm() > 0.0) result.emplace_back(step / step.cwiseAbs().maxCoeff());
    };
    add_separating(gradients, depths);
    Eigen::Index deepest{};
    depths.maxCoeff(&deepest);
    if (depths.size() > 1) add_separating(gradients.row(deepest), depths.segment(deepest, 1));
    for (Eigen::Index j = 0; j < node.q.size(); ++j)
      for (const double sign : {1.0, -1.0}) result.emplace_back(sign * Eigen::VectorXd::Unit(node.q.size(), j));
    return result;
  }

  /// One row a pair in contact: how its depth changes with each joint [m per rad or m].
  Eigen::MatrixXd depth_gradients(const Node& node) {
    Eigen::MatrixXd gradients = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(node.least.size()), node.q.size());
    const double step = options_.gradient_step;
    for (Eigen::Index j = 0; j < node.q.size(); ++j)
      for (const double sign : {1.0, -1.0}) {
        const auto contacts = contacts_at(node.q + sign * step * Eigen::VectorXd::Unit(node.q.size(), j));
        for (const Contact& contact : contacts)
          if (const auto pair = node.least.find(name_of(contact)); pair != node.least.end())
            gradients(std::distance(node.least.begin(), pair), j) -= sign * contact.distance / (2.0 * step);
      }
    return gradients;
  }

  /// The shortest step that separates the pairs to first order, without joints that are at their limits; zero when
  /// there is none.
  Eigen::VectorXd separating_step(const Eigen::VectorXd& q, Eigen::MatrixXd gradients,
                                  const Eigen::VectorXd& depths) const {
    const Eigen::VectorXd required = -(depths.array() + options_.clearance);
    for (Eigen::Index attempt = 0; attempt <= q.size(); ++attempt) {
      Eigen::MatrixXd normal = gradients * gradients.transpose();
      normal.diagonal().array() += options_.damping;
      const Eigen::VectorXd step = gradients.transpose() * normal.ldlt().solve(required);
      bool within_limits = true;
      for (Eigen::Index j = 0; j < q.size(); ++j) {
        const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
        const double next = q[j] + std::copysign(recovery_step, step[j]);
        if (step[j] == 0.0 || (next >= joint.lower && next <= joint.upper)) continue;
        gradients.col(j).setZero();  // the other joints must do it
        within_limits = false;
      }
      if (within_limits) return step;
    }
    return Eigen::VectorXd::Zero(q.size());
  }

  /// The end of the segment in this direction, as far as the rule allows and the sum of depths falls; none: not even a
  /// step.
  std::optional<Node> segment_end(const Node& from, const Eigen::VectorXd& direction) {
    Node at = from;
    int steps = 0;
    while (steps < options_.max_segment_samples && checks_ < options_.max_checks && !at.least.empty()) {
      const Eigen::VectorXd q = from.q + (steps + 1) * recovery_step * direction;
      if (robot_.limit_violation(q)) break;
      const std::vector<Contact> contacts = contacts_at(q);
      if (violation_of(at.least, contacts, options_.tolerance_fraction * recovery_tolerance)) break;
      Depths least = updated(at.least, contacts);
      if (sum_of(least) >= sum_of(at.least) - 1e-9) break;
      at.q = q;
      at.least = std::move(least);
      ++steps;
    }
    if (steps == 0) return std::nullopt;
    if (at.least.empty()) {
      const double gain = sum_of(from.least) / steps;
      const double required = std::ceil(options_.clearance / std::max(gain, 1e-6));
      at.q += free_steps(at.q, direction, required) * recovery_step * direction;
    }
    return at;
  }

  /// How many more steps to go in free space: `required`, or half of those there is room for.
  int free_steps(const Eigen::VectorXd& q, const Eigen::VectorXd& direction, double required) {
    const int max_steps = static_cast<int>(std::min<double>(required, options_.max_segment_samples));
    for (int k = 1; k <= max_steps; ++k) {
      const Eigen::VectorXd next = q + k * recovery_step * direction;
      if (robot_.limit_violation(next) || !contacts_at(next).empty()) return (k - 1) / 2;
    }
    return max_steps;
  }

  const Checker& checker_;
  const RobotModel& robot_;
  Checker::Workspace& workspace_;
  const std::function<void()>& keep_going_;
  const StartRecoveryOptions& options_;
  search::BestFirstSearch<Node, double> search_;
  int checks_{0};
};

}  // namespace

std::vector<Eigen::VectorXd> find_start_recovery(const Checker& checker, const Eigen::VectorXd& start,
                                                 Checker::Workspace& workspace, const std::function<void()>& keep_going,
                                                 const StartRecoveryOptions& options) {
  return StartRecoverySearch(checker, workspace, keep_going, options).run(start);
}

std::optional<Contact> contact_rule_violation(const Checker& checker, const std::vector<Eigen::VectorXd>& path,
                                              Checker::Workspace& workspace) {
  std::vector<Contact> contacts = checker.contacts(path.front(), workspace);
  Depths least = updated({}, contacts);
  for (std::size_t i = 1; i < path.size(); ++i) {
    const int samples = samples_between(path[i - 1], path[i]);
    for (int k = 1; k <= samples; ++k) {
      const Eigen::VectorXd q = path[i - 1] + (path[i] - path[i - 1]) * (static_cast<double>(k) / samples);
      contacts = checker.contacts(q, workspace);
      if (const Contact* worse = violation_of(least, contacts, recovery_tolerance)) return *worse;
      least = updated(least, contacts);
    }
  }
  return std::nullopt;
}

std::string recovery_violation(const Checker& checker, const std::vector<Eigen::VectorXd>& path,
                               Checker::Workspace& workspace) {
  if (const auto worse = contact_rule_violation(checker, path, workspace)) return worse->describe();
  const std::vector<Contact> contacts = checker.contacts(path.back(), workspace);
  return contacts.empty() ? "" : contacts.front().describe();
}

}  // namespace srmp
