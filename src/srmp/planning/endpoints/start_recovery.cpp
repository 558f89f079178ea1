#include "srmp/planning/endpoints/start_recovery.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace srmp {

namespace {

constexpr double probe = 1e-3;      // joint step of the numeric gradients [rad or m]
constexpr double clearance = 1e-3;  // aimed at beyond contact [m]: closer than that, motions are hard to prove free
constexpr int longest_walk = 400;   // samples
constexpr int max_looks = 20'000;   // configurations looked at

using PairName = std::pair<std::string, std::string>;
using Depths = std::map<PairName, double>;  // of every pair in contact [m]

PairName name_of(const Contact& contact) { return {contact.body_a, contact.body_b}; }

/// What must fall: the sum of the depths, where a pair that merely touches counts too.
double sum_of(const Depths& depths) {
  double sum = 0.0;
  for (const auto& [pair, depth] : depths) sum += std::max(depth, 0.0) + recovery_tolerance;
  return sum;
}

/// The contact that is new or deeper than `least` by more than the tolerance; null when there is none.
const Contact* worse_than(const Depths& least, const std::vector<Contact>& contacts, double tolerance) {
  for (const Contact& contact : contacts) {
    const auto known = least.find(name_of(contact));
    if (known == least.end() || -contact.distance > known->second + tolerance) return &contact;
  }
  return nullptr;
}

/// The least depth that each pair still in contact has had so far.
Depths lessened(const Depths& least, const std::vector<Contact>& contacts) {
  Depths result;
  for (const Contact& contact : contacts) {
    const auto known = least.find(name_of(contact));
    result[name_of(contact)] = known == least.end() ? -contact.distance : std::min(known->second, -contact.distance);
  }
  return result;
}

/// Steps that sample the straight motion.
int steps_between(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  return std::max(1, static_cast<int>(std::ceil((b - a).cwiseAbs().maxCoeff() / recovery_step - 1e-6)));
}

class StartRecoverySearch {
 public:
  StartRecoverySearch(const Checker& checker, Checker::Workspace& workspace, const std::function<void()>& keep_going)
      : checker_(checker), robot_(checker.robot()), workspace_(workspace), keep_going_(keep_going) {}

  std::vector<Eigen::VectorXd> run(const Eigen::VectorXd& start) {
    add({start, lessened({}, look(start)), 0});
    while (!open_.empty() && looks_ < max_looks) {
      const std::size_t best = open_.begin()->second;
      open_.erase(open_.begin());
      for (const Eigen::VectorXd& direction : directions(nodes_[best])) {
        const std::optional<Node> next = walk(best, direction);
        if (!next) continue;
        add(*next);
        if (next->least.empty()) return path_to(nodes_.size() - 1);
      }
    }
    return {};
  }

 private:
  struct Node {
    Eigen::VectorXd q;
    Depths least;  // of all samples up to here; empty: free
    std::size_t parent;
  };

  void add(Node node) {
    open_.emplace(sum_of(node.least), nodes_.size());
    nodes_.push_back(std::move(node));
  }

  std::vector<Contact> look(const Eigen::VectorXd& q) {
    if (keep_going_) keep_going_();
    ++looks_;
    return checker_.contacts(q, workspace_);
  }

  std::vector<Eigen::VectorXd> directions(const Node& node) {
    std::vector<Eigen::VectorXd> result;
    const Eigen::MatrixXd gradients = depth_gradients(node);
    Eigen::VectorXd depths(gradients.rows());
    std::transform(node.least.begin(), node.least.end(), depths.data(), [](const auto& pair) { return pair.second; });
    const auto add_way_out = [&](const Eigen::MatrixXd& gradient, const Eigen::VectorXd& depth) {
      const Eigen::VectorXd step = way_out(node.q, gradient, depth);
      if (step.norm() > 0.0) result.emplace_back(step / step.cwiseAbs().maxCoeff());
    };
    add_way_out(gradients, depths);
    Eigen::Index deepest{};
    depths.maxCoeff(&deepest);
    if (depths.size() > 1) add_way_out(gradients.row(deepest), depths.segment(deepest, 1));
    for (Eigen::Index j = 0; j < node.q.size(); ++j)
      for (const double sign : {1.0, -1.0}) result.emplace_back(sign * Eigen::VectorXd::Unit(node.q.size(), j));
    return result;
  }

  /// One row a pair in contact: how its depth changes with each joint [m a rad or m].
  Eigen::MatrixXd depth_gradients(const Node& node) {
    Eigen::MatrixXd gradients = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(node.least.size()), node.q.size());
    for (Eigen::Index j = 0; j < node.q.size(); ++j)
      for (const double sign : {1.0, -1.0}) {
        const auto contacts = look(node.q + sign * probe * Eigen::VectorXd::Unit(node.q.size(), j));
        for (const Contact& contact : contacts)
          if (const auto pair = node.least.find(name_of(contact)); pair != node.least.end())
            gradients(std::distance(node.least.begin(), pair), j) -= sign * contact.distance / (2.0 * probe);
      }
    return gradients;
  }

  /// The shortest step that takes the pairs apart, to first order and where there is one; joints stay within limits.
  Eigen::VectorXd way_out(const Eigen::VectorXd& q, Eigen::MatrixXd gradients, const Eigen::VectorXd& depths) const {
    const Eigen::VectorXd wanted = -(depths.array() + clearance);
    for (Eigen::Index tries = 0; tries <= q.size(); ++tries) {
      Eigen::MatrixXd normal = gradients * gradients.transpose();
      normal.diagonal().array() += 1e-6;
      const Eigen::VectorXd step = gradients.transpose() * normal.ldlt().solve(wanted);
      bool inside = true;
      for (Eigen::Index j = 0; j < q.size(); ++j) {
        const Joint& joint = robot_.joints()[static_cast<std::size_t>(j)];
        const double next = q[j] + std::copysign(recovery_step, step[j]);
        if (step[j] == 0.0 || (next >= joint.lower && next <= joint.upper)) continue;
        gradients.col(j).setZero();  // it stands at a limit: the others must do it
        inside = false;
      }
      if (inside) return step;
    }
    return Eigen::VectorXd::Zero(q.size());
  }

  /// As far as the rule allows and the sum of the depths falls; none: not a step.
  std::optional<Node> walk(std::size_t from, const Eigen::VectorXd& direction) {
    const Eigen::VectorXd begin = nodes_[from].q;
    Node at{begin, nodes_[from].least, from};
    int steps = 0;
    while (steps < longest_walk && looks_ < max_looks && !at.least.empty()) {
      const Eigen::VectorXd q = begin + (steps + 1) * recovery_step * direction;
      if (robot_.limit_violation(q)) break;
      const std::vector<Contact> contacts = look(q);
      if (worse_than(at.least, contacts, 0.25 * recovery_tolerance)) break;  // a margin for what lies between
      Depths least = lessened(at.least, contacts);
      if (sum_of(least) >= sum_of(at.least) - 1e-9) break;
      at.q = q;
      at.least = std::move(least);
      ++steps;
    }
    if (steps == 0) return std::nullopt;
    if (at.least.empty()) {
      const double gain = sum_of(nodes_[from].least) / steps;
      at.q += room_beyond(at.q, direction, std::ceil(clearance / std::max(gain, 1e-6))) * recovery_step * direction;
    }
    return at;
  }

  /// How many more steps to go in free space: `wanted`, or half-way to what stands in the way.
  int room_beyond(const Eigen::VectorXd& q, const Eigen::VectorXd& direction, double wanted) {
    const int most = static_cast<int>(std::min<double>(wanted, longest_walk));
    for (int k = 1; k <= most; ++k) {
      const Eigen::VectorXd next = q + k * recovery_step * direction;
      if (robot_.limit_violation(next) || !look(next).empty()) return (k - 1) / 2;
    }
    return most;
  }

  std::vector<Eigen::VectorXd> path_to(std::size_t node) const {
    std::vector<Eigen::VectorXd> path{nodes_[node].q};
    for (; node != 0; node = nodes_[node].parent) path.push_back(nodes_[nodes_[node].parent].q);
    std::reverse(path.begin(), path.end());
    return path;
  }

  const Checker& checker_;
  const RobotModel& robot_;
  Checker::Workspace& workspace_;
  const std::function<void()>& keep_going_;
  std::vector<Node> nodes_;
  std::set<std::pair<double, std::size_t>> open_;  // sum of depths, number of the node
  int looks_{0};
};

}  // namespace

std::vector<Eigen::VectorXd> find_start_recovery(const Checker& checker, const Eigen::VectorXd& start,
                                                 Checker::Workspace& workspace,
                                                 const std::function<void()>& keep_going) {
  return StartRecoverySearch(checker, workspace, keep_going).run(start);
}

std::string recovery_violation(const Checker& checker, const std::vector<Eigen::VectorXd>& path,
                               Checker::Workspace& workspace) {
  std::vector<Contact> contacts = checker.contacts(path.front(), workspace);
  Depths least = lessened({}, contacts);
  for (std::size_t i = 1; i < path.size(); ++i) {
    const int steps = steps_between(path[i - 1], path[i]);
    for (int k = 1; k <= steps; ++k) {
      contacts = checker.contacts(path[i - 1] + (path[i] - path[i - 1]) * (static_cast<double>(k) / steps), workspace);
      if (const Contact* worse = worse_than(least, contacts, recovery_tolerance)) return worse->describe();
      least = lessened(least, contacts);
    }
  }
  return contacts.empty() ? "" : contacts.front().describe();
}

}  // namespace srmp
