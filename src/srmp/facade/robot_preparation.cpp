#include "srmp/facade/robot_preparation.hpp"

#include <algorithm>
#include <thread>

#include "srmp/core/interruption.hpp"
#include "srmp/robot/robot_cover.hpp"

namespace srmp {

namespace {

/// Ends a job in the background.
struct PreparationStopped {};

/// For plans of several robots. What `progress` throws ends it.
void prepare_quick_covers(const RobotModel& model, CoverStore& covers, const StepProgress& progress) {
  const InterruptionScope scope([&] {
    if (progress) progress(0, 1);
  });
  ensure_quickly_covered(model, covers);
}

}  // namespace

RobotPreparation::Robot& RobotPreparation::robot_of(const std::shared_ptr<const RobotModel>& model) {
  std::erase_if(robots_, [](const auto& entry) { return entry.second.model.expired(); });
  Robot& robot = robots_[model.get()];
  robot.model = model;
  return robot;
}

void RobotPreparation::begin(Robot& robot, const RobotInstance& instance) const {
  robot.job = Background::submit([covers = covers_, tables = tables_, weak = robot.model, parts = instance.parts,
                                  computed = robot.computed](const std::atomic<bool>& stop) {
    const std::shared_ptr<const RobotModel> model = weak.lock();
    if (!model) return;
    const StepProgress progress = [&](std::size_t, std::size_t) {
      if (stop || model.use_count() == 1) throw PreparationStopped();  // the robot is in no scene any more
    };
    tables->tables(model, parts, 1, progress);
    cover_robot(*model, *covers, {.threads = 1}, progress);
    *computed = true;
    prepare_quick_covers(*model, *covers, progress);
  });
}

bool RobotPreparation::update(const Scene& scene) {
  bool changed = false;
  for (const auto& [name, instance] : scene.robots()) {
    Robot& robot = robot_of(instance.model);
    if (robot.ready) continue;
    if (*robot.computed) {
      robot.ready = changed = true;
    } else if (robot.begun_by != getpid()) {
      robot.ready = ensure_covered(*instance.model, *covers_) && tables_->find(instance.model);
      if (!robot.ready) begin(robot, instance);
      robot.begun_by = getpid();  // unless an exception ended this
    }
  }
  return changed;
}

bool RobotPreparation::finish(const Scene& scene, const StepProgress& progress) {
  const std::size_t threads = std::max(1U, std::thread::hardware_concurrency());
  bool changed = false;
  for (const auto& [name, instance] : scene.robots()) {
    Robot& robot = robot_of(instance.model);
    if (scene.robots().size() > 1) prepare_quick_covers(*instance.model, *covers_, progress);
    if (robot.ready) continue;
    robot.job.cancel();
    robot.begun_by = 0;  // where `progress` ends this, the next plan begins again
    cover_robot(*instance.model, *covers_, {.threads = threads}, progress);
    tables_->tables(instance.model, instance.parts, threads, progress);
    robot.ready = changed = true;
  }
  return changed;
}

}  // namespace srmp
