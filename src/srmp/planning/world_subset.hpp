#pragma once

#include <vector>

#include "srmp/planning/multi_robot_world.hpp"

namespace srmp {

/// Some of the robots of a world, as a world.
class WorldSubset : public multi::World {
 public:
  WorldSubset(MultiRobotWorld& world, std::vector<std::size_t> robots) : world_(world), robots_(std::move(robots)) {}

  std::size_t size() const override { return robots_.size(); }
  multi::Agent& agent(std::size_t i) override { return world_.agent(robots_[i]); }
  bool may_conflict(std::size_t a, std::size_t b) const override { return world_.may_conflict(robots_[a], robots_[b]); }
  bool in_conflict(std::size_t a, const multi::Move& move_a, std::size_t b, const multi::Move& move_b) override {
    return world_.in_conflict(robots_[a], move_a, robots_[b], move_b);
  }

 private:
  MultiRobotWorld& world_;
  std::vector<std::size_t> robots_;
};

}  // namespace srmp
