#include "srmp/facade/scene_checkers.hpp"

#include <algorithm>

#include "srmp/collision/batch/batch_robot.hpp"
#include "srmp/collision/pair_table.hpp"

namespace srmp {

namespace {

/// Each object that was added, removed or replaced takes a checker that follows about a tenth of the time of making
/// one.
constexpr std::size_t max_replaced = 8;

}  // namespace

SceneCheckers::SceneCheckers()
    : covers_(std::make_shared<CoverStore>()),
      pair_tables_(std::make_shared<PairTableStore>(covers_->directory())),
      batch_robots_(std::make_shared<BatchRobotStore>()),
      preparation_(covers_, pair_tables_) {}

const Checker& SceneCheckers::of(const Scene& scene, const std::string& robot, CheckMode mode) {
  scene.robot(robot);  // throws with the nearest name
  follow_objects(scene);
  std::unique_ptr<SceneChecker>& slot = alone_[{robot, mode}];
  if (!slot) slot = std::make_unique<SceneChecker>(scene, robot, options(mode));
  return *slot;
}

std::shared_ptr<const ProblemCheckers> SceneCheckers::of(const Scene& scene, const std::vector<std::string>& robots,
                                                         double clearance, std::size_t threads,
                                                         const Deadline& deadline) {
  follow_objects(scene);
  std::vector<Eigen::VectorXd> others;
  for (const auto& [name, robot] : scene.robots())
    if (std::find(robots.begin(), robots.end(), name) == robots.end()) others.push_back(robot.q);
  if (together_ && together_->planning.names() == robots && together_->options.clearance == clearance &&
      others_ == others)
    return together_;
  CheckerOptions options = this->options(CheckMode::exact);
  options.clearance = clearance;
  auto made = std::make_shared<ProblemCheckers>(scene, robots, options, threads, backend_, deadline);
  together_ = std::move(made);
  others_ = std::move(others);
  return together_;
}

std::shared_ptr<const ProblemCheckers> SceneCheckers::of_one(const Scene& scene, const std::string& robot,
                                                             double clearance) {
  scene.robot(robot);  // throws with the nearest name
  follow_objects(scene);
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

void SceneCheckers::object_moved(const std::string& name) { changed_.insert(name); }

void SceneCheckers::object_changed(const std::string& name) {
  changed_.insert(name);
  replaced_.insert(name);
  if (replaced_.size() > max_replaced) clear();
}

void SceneCheckers::follow_objects(const Scene& scene) {
  if (changed_.empty()) return;
  const auto can_follow = [&](const auto& checkers) { return !backend_ && checkers.use_count() == 1; };
  std::erase_if(single_, [&](const auto& entry) { return !can_follow(entry.second); });
  if (!can_follow(together_)) together_.reset();
  try {
    for (const auto& [key, checker] : alone_) checker->follow_objects(scene, changed_);
    for (const auto& [key, checkers] : single_) checkers->follow_objects(scene, changed_);
    if (together_) together_->follow_objects(scene, changed_);
  } catch (...) {
    clear();
    throw;
  }
  changed_.clear();
  replaced_.clear();
}

void SceneCheckers::clear() {
  changed_.clear();
  replaced_.clear();
  alone_.clear();
  single_.clear();
  together_.reset();
  batch_robots_->scene_changed();
  covers_->release_unused();  // those of robots that left the scene
}

}  // namespace srmp
