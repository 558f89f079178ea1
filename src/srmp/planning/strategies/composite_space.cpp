#include "srmp/planning/strategies/composite_space.hpp"

#include <algorithm>

namespace srmp {

namespace {

/// Combinations of the robots' goals: more find a goal that is easier to reach, and take longer to search.
constexpr std::size_t max_targets = 16;

}  // namespace

CompositeSpace::CompositeSpace(MultiRobotWorld& world, std::vector<std::size_t> robots, Others others)
    : world_(world), robots_(std::move(robots)), others_(std::move(others)) {
  add_joints();
  for (std::size_t i = 0; i < size(); ++i) part(start_, i) = task(i).start;
  add_targets(0, start_);
}

CompositeSpace::CompositeSpace(MultiRobotWorld& world, std::vector<std::size_t> robots,
                               const std::vector<Eigen::VectorXd>& starts, const std::vector<Eigen::VectorXd>& goals,
                               Others others)
    : world_(world), robots_(std::move(robots)), others_(std::move(others)) {
  add_joints();
  targets_ = {start_};
  for (std::size_t i = 0; i < size(); ++i) {
    part(start_, i) = starts[i];
    part(targets_.front(), i) = goals[i];
  }
}

void CompositeSpace::add_joints() {
  for (const std::size_t robot : robots_) {
    const std::vector<Joint>& joints = world_.model(robot).joints();
    first_.push_back(std::ssize(joints_));
    joints_.insert(joints_.end(), joints.begin(), joints.end());
  }
  first_.push_back(std::ssize(joints_));
  start_.resize(std::ssize(joints_));
}

/// The first goals of each robot first.
void CompositeSpace::add_targets(std::size_t i, Eigen::VectorXd q) {
  if (targets_.size() >= max_targets) return;
  if (i == size()) {
    targets_.push_back(std::move(q));
    return;
  }
  const std::vector<Eigen::VectorXd> choices =
      task(i).anywhere ? std::vector<Eigen::VectorXd>{task(i).start} : task(i).targets;
  const Eigen::VectorXd& all = q;
  for (const Eigen::VectorXd& choice : choices) {
    part(q, i) = choice;
    bool free = true;
    for (std::size_t k = 0; k < i && free; ++k)
      free = world_.are_collision_free(robots_[k], part(all, k), part(all, k), robots_[i], choice, choice);
    if (free) add_targets(i + 1, q);
  }
}

bool CompositeSpace::is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  constexpr MotionQuery start_is_free{.start_is_free = true};
  std::vector<char> moves(size());
  for (std::size_t i = 0; i < size(); ++i) {
    moves[i] = part(a, i) != part(b, i);
    if (moves[i] && !world_.is_free_for_one(robots_[i], part(a, i), part(b, i))) return false;
  }
  for (std::size_t i = 0; i < size(); ++i)
    for (std::size_t k = i + 1; k < size(); ++k)
      if ((moves[i] || moves[k]) && !world_.are_collision_free(robots_[i], part(a, i), part(b, i), robots_[k],
                                                               part(a, k), part(b, k), start_is_free))
        return false;
  for (std::size_t i = 0; i < size(); ++i)
    for (const Standing& other : others_)
      if (moves[i] &&
          !world_.are_collision_free(robots_[i], part(a, i), part(b, i), other.robot, other.q, other.q, start_is_free))
        return false;
  return true;
}

bool CompositeSpace::is_free_of_others(const Eigen::VectorXd& q) const {
  for (std::size_t i = 0; i < size(); ++i)
    for (const Standing& other : others_)
      if (!world_.are_collision_free(robots_[i], part(q, i), part(q, i), other.robot, other.q, other.q)) return false;
  return true;
}

JointPath CompositeSpace::path(const std::vector<Eigen::VectorXd>& rows) const {
  std::vector<std::vector<Eigen::VectorXd>> paths(size());
  for (std::size_t i = 0; i < size(); ++i)
    for (const Eigen::VectorXd& row : rows) paths[i].push_back(part(row, i));
  return joint_path(world_, robots_, paths);
}

std::vector<Eigen::VectorXd> CompositeSpace::configurations(const JointPath& path) const {
  constexpr int parts = 4;           // of a motion between rows
  std::vector<std::size_t> numbers;  // of the robots in the path
  for (const std::size_t robot : robots_)
    numbers.push_back(static_cast<std::size_t>(std::ranges::find(path.robots, robot) - path.robots.begin()));
  std::vector<Eigen::VectorXd> found;
  const auto add = [&](double step) {
    Eigen::VectorXd& q = found.emplace_back(first_.back());
    for (std::size_t i = 0; i < robots_.size(); ++i) part(q, i) = position_at(path, numbers[i], step);
  };
  add(path.steps.front());
  for (std::size_t row = 1; row < path.size(); ++row) {
    const double from = path.steps[row - 1], to = path.steps[row];
    for (int k = 1; k < parts; ++k) add(from + (to - from) * k / parts);
    add(to);
  }
  return found;
}

}  // namespace srmp
