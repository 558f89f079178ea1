#include "srmp/collision/scene_model.hpp"

#include <algorithm>

#include "srmp/robot/robot_cover.hpp"

namespace srmp::detail {

namespace {

/// Where spheres are the bodies, subdividing down to them decides the check. Elsewhere the batch stops early, because
/// Coal resolves what is left open, pair by pair, in less time than more blocks would take.
BatchChecker::MotionOptions batch_options_for(const BatchRobotModel& robot) {
  return {.step = robot.exact ? 0.2 : 0.14, .refinements = robot.exact ? 4 : 1, .max_blocks = 64};
}

using Tables = std::vector<std::shared_ptr<const PairTables>>;
Tables tables_of(const RobotGroup& group, const CheckerOptions& options) {
  Tables tables(group.size());
  const bool tables_hold = options.clearance == 0.0;  // they know where two links touch, not how far they are apart
  if (options.mode == CheckMode::exact && options.pair_tables && !options.other_robots_only && tables_hold)
    for (std::size_t i = 0; i < group.size(); ++i) tables[i] = options.pair_tables->find(group.instance(i).model);
  return tables;
}
std::vector<const PairTables*> addresses(const Tables& tables) {
  std::vector<const PairTables*> result;
  for (const auto& table : tables) result.push_back(table.get());
  return result;
}

}  // namespace

SceneModel::SceneModel(const Scene& scene, const RobotGroup& robots, const CheckerOptions& options)
    : group(robots),
      tables(tables_of(group, options)),
      bodies(scene, group, options, addresses(tables)),
      mode(options.mode) {
  if (mode == CheckMode::coal) return;
  const auto covers = options.covers ? options.covers : std::make_shared<CoverStore>();
  for (const auto& [name, other] : scene.robots()) {
    if (!group.contains(name) && bodies.leaves_out(name)) continue;
    if (options.quick_covers)
      ensure_quickly_covered(*other.model, *covers);
    else if (!ensure_covered(*other.model, *covers) && mode == CheckMode::conservative)
      cover_robot(*other.model, *covers);  // here covers decide
  }
  const CoverOf cover_of = [&](const auto& shape) {
    if (options.quick_covers)
      if (auto quick = covers->adopted_quick(shape)) return quick;
    return covers->cover(shape);
  };
  BatchRobotStore none;
  batch_scene = make_batch_scene(bodies, group, cover_of, options.batch_robots ? *options.batch_robots : none);
  batch.emplace(batch_scene.robot, batch_scene.pairs);
  batch_options = batch_options_for(*batch_scene.robot);
}

void SceneModel::follow_objects(const Scene& scene, const std::set<std::string>& names) {
  const std::optional<FixedChanges> changes = bodies.follow_objects(scene, names);
  if (!changes) return;
  pair_groups_.reset();
  if (!batch) return;
  const std::vector<int> known = batch_scene.follow(bodies, *changes);
  BatchChecker next(*batch, batch_scene.pairs, known);
  batch.emplace(std::move(next));
}

const PairGroups& SceneModel::pair_groups() const {
  const std::lock_guard lock(mutex_);
  if (!pair_groups_) pair_groups_.emplace(bodies);
  return *pair_groups_;
}

bool SceneModel::spheres_reach(ConstVector q) const {
  for (std::size_t i = 0; i < group.joints().size(); ++i) {
    const Joint& joint = group.joints()[i];
    const double value = q[static_cast<Eigen::Index>(i)];
    if (joint.kind == JointKind::prismatic && (value < joint.lower - 1.0 || value > joint.upper + 1.0)) return false;
  }
  return true;
}

}  // namespace srmp::detail
