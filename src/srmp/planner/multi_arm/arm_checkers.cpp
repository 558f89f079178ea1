#include "srmp/planner/multi_arm/arm_checkers.hpp"

namespace srmp {

RowMatrix side_by_side(const RowMatrix& arm, const RowMatrix& other, bool other_first) {
  RowMatrix both(arm.rows(), arm.cols() + other.cols());
  both << (other_first ? other : arm), (other_first ? arm : other);
  return both;
}

ArmCheckers::ArmCheckers(const Scene& scene, std::vector<std::string> robots, const CheckerOptions& options)
    : names_(std::move(robots)) {
  std::vector<Ball> ranges;
  for (const std::string& name : names_) {
    CheckerOptions alone = options;
    for (const std::string& other : names_)
      if (other != name) alone.absent.push_back(other);
    alone_.push_back(std::make_unique<const Checker>(scene, name, alone));
    ranges.push_back(alone_.back()->range());
  }
  for (std::size_t i = 0; i < size(); ++i)
    for (std::size_t j = i + 1; j < size(); ++j) {
      if ((ranges[i].center - ranges[j].center).norm() > ranges[i].radius + ranges[j].radius) continue;
      CheckerOptions both = options;
      both.companions = {names_[j]};
      both.companions_only = true;
      pairs_.emplace(std::pair(i, j), std::make_unique<const Checker>(scene, names_[i], both));
    }
}

}  // namespace srmp
