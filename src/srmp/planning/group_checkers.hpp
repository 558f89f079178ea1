#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "srmp/collision/checker.hpp"

namespace srmp {

/// Rows of an arm and of another robot, as many, as a checker of both has them: the other's joints stand first or last.
RowMatrix side_by_side(const RowMatrix& arm, const RowMatrix& other, bool other_first);

/// Checkers for robots that move together: each alone in the scene, the others left out; and each two that can reach
/// each other, by themselves. Where all of these say free, nothing touches.
class GroupCheckers {
 public:
  /// Robots of the scene that are not named stand still. `threads`: checkers made at the same time.
  GroupCheckers(const Scene& scene, std::vector<std::string> robots, const CheckerOptions& options,
                std::size_t threads = 1);

  const std::vector<std::string>& names() const { return names_; }
  std::size_t size() const { return names_.size(); }
  const Checker& alone(std::size_t i) const { return *alone_[i]; }
  /// i < j: what i and j do to each other; a configuration is i's, then j's. Null: they never meet.
  const Checker* pair(std::size_t i, std::size_t j) const {
    const auto found = pairs_.find({i, j});
    return found == pairs_.end() ? nullptr : found->second.get();
  }
  bool may_conflict(std::size_t i, std::size_t j) const { return pair(std::min(i, j), std::max(i, j)) != nullptr; }

 private:
  std::vector<std::string> names_;
  std::vector<std::unique_ptr<const Checker>> alone_;
  std::map<std::pair<std::size_t, std::size_t>, std::unique_ptr<const Checker>> pairs_;
};

}  // namespace srmp
