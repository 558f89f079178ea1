#include "srmp/facade/scene_checkers.hpp"

#include <algorithm>

#include "srmp/collision/batch/batch_robot.hpp"
#include "srmp/collision/pair_table.hpp"

namespace srmp {

SceneCheckers::SceneCheckers()
    : covers_(std::make_shared<CoverStore>()),
      pair_tables_(std::make_shared<PairTableStore>(covers_->directory())),
      batch_robots_(std::make_shared<BatchRobotStore>()),
      preparation_(covers_, pair_tables_) {}

const Checker& SceneCheckers::of(const Scene& scene, const std::string& robot, CheckMode mode) {
  scene.robot(robot);  // throws with the nearest name
  follow(scene);
  std::unique_ptr<SceneChecker>& slot = alone_[{robot, mode}];
  if (!slot) slot = std::make_unique<SceneChecker>(scene, robot, options(mode));
  return *slot;
}

std::shared_ptr<const ProblemCheckers> SceneCheckers::of(const Scene& scene, const Scene& placed,
                                                         const std::vector<std::string>& robots, double clearance,
                                                         std::size_t threads, const Deadline& deadline) {
  follow(scene);
  std::vector<Eigen::VectorXd> others;
  for (const auto& [name, robot] : placed.robots())
    if (std::find(robots.begin(), robots.end(), name) == robots.end()) others.push_back(robot.q);
  if (together_ && together_->planning.names() == robots && together_->options.clearance == clearance &&
      others_ == others)
    return together_;
  CheckerOptions options = this->options(CheckMode::exact);
  options.clearance = clearance;
  if (together_ && others_ != others) forget_unused();
  auto made = std::make_shared<ProblemCheckers>(placed, robots, options, threads, backend_, deadline);
  together_ = std::move(made);
  others_ = std::move(others);
  return together_;
}

std::shared_ptr<const ProblemCheckers> SceneCheckers::of_one(const Scene& scene, const std::string& robot,
                                                             double clearance) {
  scene.robot(robot);  // throws with the nearest name
  follow(scene);
  auto& slot = single_[{robot, clearance > 0.0}];
  if (!slot || slot->options.clearance != clearance) {
    CheckerOptions options = this->options(CheckMode::exact);
    options.clearance = clearance;
    slot = std::make_shared<ProblemCheckers>(scene, std::vector{robot}, options, 1, backend_);
  }
  return slot;
}

void SceneCheckers::prepare_in_background(const Scene& scene) {
  if (preparation_.update(scene)) clear();
}

void SceneCheckers::prepare(const Scene& scene, const StepProgress& progress) {
  if (preparation_.finish(scene, progress)) clear();
}

void SceneCheckers::set_backend(CheckerFactory backend) {
  backend_ = std::move(backend);
  clear();
}

void SceneCheckers::follow(const Scene& scene) {
  if (is_followed_) return;
  const SceneChanges changes = changes_between(seen_, scene);
  if (changes.anything_else || backend_) {
    clear();
    seen_ = scene;
    is_followed_ = true;
    return;
  }
  const auto others_moved = [&](const auto& entry) {
    return std::ranges::any_of(changes.robots, [&](const std::string& robot) { return robot != entry.first.first; });
  };
  const auto cannot_follow = [&](const auto& entry) { return others_moved(entry) || entry.second.use_count() > 1; };
  const std::size_t forgotten = std::erase_if(alone_, others_moved) + std::erase_if(single_, cannot_follow);
  if (forgotten > 0) forget_unused();
  if (together_.use_count() > 1) together_.reset();
  try {
    for (const auto& [key, checker] : alone_) checker->follow_objects(scene, changes.objects);
    for (const auto& [key, checkers] : single_) checkers->follow(scene, changes);
    if (together_) together_->follow(scene, changes);
    seen_.follow_objects(scene, changes.objects);
    for (const std::string& robot : changes.robots) seen_.set_qpos(robot, scene.robot(robot).q);
  } catch (...) {
    clear();
    throw;
  }
  is_followed_ = true;
}

void SceneCheckers::clear() {
  alone_.clear();
  single_.clear();
  together_.reset();
  seen_.reset();
  is_followed_ = false;
  forget_unused();
}

/// Forgets what no checker needed since the last call and the one before.
void SceneCheckers::forget_unused() {
  batch_robots_->scene_changed();
  covers_->release_unused();  // those of robots that left the scene
}

}  // namespace srmp
