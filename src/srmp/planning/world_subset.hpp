#pragma once

#include <vector>

#include "srmp/planning/multi_robot_world.hpp"

namespace srmp {

/// Some of the arms of a world, as a world.
class WorldSubset : public multi::World {
 public:
  WorldSubset(MultiRobotWorld& world, std::vector<std::size_t> arms) : world_(world), arms_(std::move(arms)) {}

  std::size_t size() const override { return arms_.size(); }
  multi::Agent& agent(std::size_t i) override { return world_.agent(arms_[i]); }
  bool may_conflict(std::size_t a, std::size_t b) const override { return world_.may_conflict(arms_[a], arms_[b]); }
  bool in_conflict(std::size_t a, const multi::Move& move_a, std::size_t b, const multi::Move& move_b) override {
    return world_.in_conflict(arms_[a], move_a, arms_[b], move_b);
  }

 private:
  MultiRobotWorld& world_;
  std::vector<std::size_t> arms_;
};

}  // namespace srmp
