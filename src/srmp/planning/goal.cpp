#include "srmp/planning/goal.hpp"

#include <algorithm>
#include <span>

#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"

namespace srmp {

std::string_view to_string(GoalType type) {
  switch (type) {
    case GoalType::joints: return "joints";
    case GoalType::pose: return "pose";
    case GoalType::position: return "position";
    case GoalType::hold: return "hold";
    case GoalType::any: return "any";
  }
  return "unknown";
}

GoalConstraint GoalConstraint::joints(const Eigen::VectorXd& q) { return {GoalType::joints, {q}}; }

namespace {

std::vector<std::string> only(const std::string& link) {
  return link.empty() ? std::vector<std::string>() : std::vector{link};
}

}  // namespace

GoalConstraint GoalConstraint::pose(const Pose& pose, const std::string& link) {
  const auto numbers = pose.to_list();
  GoalConstraint goal{GoalType::pose, {Eigen::Map<const Eigen::VectorXd>(numbers.data(), 7)}};
  goal.links = only(link);
  return goal;
}

GoalConstraint GoalConstraint::poses(const std::map<std::string, Pose>& of_links) {
  GoalConstraint goal{GoalType::pose, {Eigen::VectorXd(7 * std::ssize(of_links))}};
  for (const auto& [link, pose] : of_links) {
    const auto numbers = pose.to_list();
    goal.targets[0].segment<7>(7 * std::ssize(goal.links)) = Eigen::Map<const Eigen::VectorXd>(numbers.data(), 7);
    goal.links.push_back(link);
  }
  return goal;
}

GoalConstraint GoalConstraint::position(const Eigen::Vector3d& p, const std::string& link) {
  GoalConstraint goal{GoalType::position, {p}};
  goal.links = only(link);
  return goal;
}

GoalConstraint GoalConstraint::hold() { return {GoalType::hold, {}}; }
GoalConstraint GoalConstraint::any() { return {GoalType::any, {}}; }

namespace {

void require_links(const GoalConstraint& goal) {
  if (goal.links.empty()) return;
  if (goal.type != GoalType::pose && goal.type != GoalType::position)
    throw InvalidArgument("a goal of type '" + std::string(to_string(goal.type)) +
                          "' is for no link; only poses and positions are");
  for (auto link = goal.links.begin(); link != goal.links.end(); ++link) {
    if (link->empty()) throw InvalidArgument("a goal names a link '', which has no name");
    if (std::find(goal.links.begin(), link, *link) != link)
      throw InvalidArgument("a goal names the link '" + *link + "' twice");
  }
}

/// The numbers of a target for each link, whose size is right unless there is one.
Eigen::Index numbers_for_each(const GoalConstraint& goal, const Eigen::VectorXd& target) {
  if (goal.links.size() <= 1) return target.size();
  const Eigen::Index each = goal.type == GoalType::pose ? 7 : 3, all = each * std::ssize(goal.links);
  if (target.size() != all)
    throw InvalidArgument("a target for " + std::to_string(goal.links.size()) + " links is " + std::to_string(all) +
                          " numbers, " + std::to_string(each) + " for each, but got " + std::to_string(target.size()));
  return each;
}

void require_target(const GoalConstraint& goal, std::span<const double> numbers) {
  if (goal.type == GoalType::pose) return require_position(Pose::from_list(numbers).p, "goal pose position");
  require_finite(numbers, "goal " + std::string(to_string(goal.type)));
  if (goal.type != GoalType::position) return;
  if (numbers.size() != 3)
    throw InvalidArgument("a position goal is 3 numbers, x, y, z, but got " + std::to_string(numbers.size()));
  require_position(Eigen::Vector3d(numbers.data()), "goal position");
}

}  // namespace

void GoalConstraint::validate() const {
  require_links(*this);
  if (type == GoalType::hold || type == GoalType::any) {
    if (!targets.empty()) throw InvalidArgument("a goal of type '" + std::string(to_string(type)) + "' has no target");
    return;
  }
  if (targets.empty()) throw InvalidArgument("the goal has no target; give at least one");
  position_tolerance.validate("goal position_tolerance");
  rotation_tolerance.validate("goal rotation_tolerance");
  if (type != GoalType::joints && position_tolerance.axes.array().isInf().all() &&
      (type == GoalType::position || rotation_tolerance.axes.array().isInf().all()))
    throw InvalidArgument("the goal's tolerances leave every axis free; nothing is asked for");
  for (const Eigen::VectorXd& target : targets) {
    if (target.size() == 0) throw InvalidArgument("the goal has an empty target; a target is a row of numbers");
    const Eigen::Index each = numbers_for_each(*this, target);
    for (Eigen::Index i = 0; i < target.size(); i += each)
      require_target(*this, {target.data() + i, static_cast<std::size_t>(each)});
  }
}

}  // namespace srmp
