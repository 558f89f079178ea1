#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "srmp/planning/strategies/composite_roadmap.hpp"

namespace srmp {

/// Roadmaps of a world's robots, richer from level to level, each made when it is first needed. Threads share it.
class RoadmapLevels {
 public:
  static constexpr std::size_t count = 4;

  /// The world outlives this.
  explicit RoadmapLevels(MultiRobotWorld& world) : world_(world), levels_(count) {}

  CompositeRoadmap& at(std::size_t level) {
    const std::lock_guard lock(mutex_);
    auto& slot = levels_[level];
    if (!slot)
      slot = std::make_unique<CompositeRoadmap>(world_, CompositeRoadmapOptions{.retreats = std::size_t{2} << level});
    return *slot;
  }

  /// Retreat configurations of the first level, by index in the world; none of robots that did not need them.
  std::vector<std::vector<Eigen::VectorXd>> retreats(const std::vector<std::size_t>& robots) const {
    std::vector<std::vector<Eigen::VectorXd>> found(world_.size());
    if (const CompositeRoadmap* first = levels_.front().get())
      for (const std::size_t i : robots) found[i] = first->retreats(i);
    return found;
  }

  std::size_t memory() const {  ///< [bytes]
    std::size_t sum = 0;
    for (const auto& level : levels_)
      if (level) sum += level->memory();
    return sum;
  }

 private:
  MultiRobotWorld& world_;
  std::mutex mutex_;                                       // of the making of roadmaps
  std::vector<std::unique_ptr<CompositeRoadmap>> levels_;  // null: not made yet
};

}  // namespace srmp
