#include "srmp/facade/scene_checkers.hpp"

#include <algorithm>

#include "srmp/collision/pair_table.hpp"
#include "srmp/robot/robot_cover.hpp"

namespace srmp {

SceneCheckers::SceneCheckers()
    : covers_(std::make_shared<CoverStore>()), pair_tables_(std::make_shared<PairTableStore>(covers_->directory())) {}

const Checker& SceneCheckers::of(const Scene& scene, const std::string& robot, CheckMode mode) {
  scene.robot(robot);  // throws with the nearest name
  std::unique_ptr<const Checker>& slot = alone_[{robot, mode}];
  if (!slot) slot = make_checker(scene, robot, options(mode));
  return *slot;
}

const SceneCheckers::Together& SceneCheckers::of(const Scene& scene, const std::vector<std::string>& robots,
                                                 std::size_t threads) {
  std::vector<Eigen::VectorXd> others;
  for (const auto& [name, robot] : scene.robots())
    if (std::find(robots.begin(), robots.end(), name) == robots.end()) others.push_back(robot.q);
  if (together_.plan && together_.plan->names() == robots && others_ == others) return together_;
  // Both or none: a checker that cannot be made throws.
  Together now{std::make_unique<const GroupCheckers>(scene, robots, options(CheckMode::exact), threads),
               std::make_unique<const GroupCheckers>(scene, robots, CheckerOptions{.mode = CheckMode::coal}, threads)};
  together_ = std::move(now);
  others_ = std::move(others);
  return together_;
}

void SceneCheckers::cover_robots(const Scene& scene) const {
  for (const auto& [name, robot] : scene.robots()) {
    ensure_covered(*robot.model, *covers_);
    pair_tables_->tables(robot.model, robot.parts);
  }
}

void SceneCheckers::clear() {
  alone_.clear();
  together_ = {};
}

}  // namespace srmp
