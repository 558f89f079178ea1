#include "srmp/collision/contact_rules.hpp"

#include <algorithm>

namespace srmp::detail {

ContactRules::ContactRules(const Scene& scene, const RobotGroup& group, bool other_robots_only)
    : scene_(scene), group_(group), other_robots_only_(other_robots_only), self_pairs_(group.size()) {}

PairSide ContactRules::side(const Body& body) {
  const bool link = body.kind == BodyKind::link;
  const std::size_t name = link ? links_.try_emplace(body.scene_name, names_.size()).first->second : names_.size();
  if (name == names_.size()) {
    names_.push_back(&body.scene_name);
    has_setting_.push_back(has_setting(body.scene_name));
    allowed_.clear();
  }
  return {body.robot,      link,         body.kind == BodyKind::attached_object,
          body.is_solid(), name,         body.source,
          body.support,    body.padding, body.solid};
}

bool ContactRules::by_names(const PairSide& a, const PairSide& b, bool same_robot) {
  const bool by_model = by_model_alone(a, b);
  if (!by_model && allowed(a.name, b.name)) return false;
  if (!same_robot) return true;
  const auto robot = static_cast<std::size_t>(a.robot);
  const RobotModel& model = group_.model(robot);
  if (is_self_pair(model, robot, a.source, b.source)) return true;
  // The model may leave out more than it allows; a pair that it allows gets here by the scene's own setting.
  return !by_model && model.allowed(model.geometries()[a.source].link, model.geometries()[b.source].link);
}

/// Does a setting name the body or the robot that it is a link of?
bool ContactRules::has_setting(const std::string& name) const {
  const auto names = [&](const std::string& key) {
    return name.starts_with(key) && (name.size() == key.size() || name[key.size()] == '/');
  };
  return std::any_of(scene_.allowed_settings().begin(), scene_.allowed_settings().end(),
                     [&](const auto& setting) { return names(setting.first.first) || names(setting.first.second); });
}

bool ContactRules::is_self_pair(const RobotModel& model, std::size_t robot, std::size_t a, std::size_t b) {
  std::vector<char>& table = self_pairs_[robot];
  const std::size_t count = model.geometries().size();
  if (table.empty()) {
    table.assign(count * count, false);
    for (const auto& [i, j] : model.self_pairs()) table[i * count + j] = table[j * count + i] = true;
  }
  return table[a * count + b];
}

bool ContactRules::allowed(std::size_t a, std::size_t b) {
  if (allowed_.empty()) allowed_.assign(names_.size() * names_.size(), unknown);
  char& known = allowed_[a * names_.size() + b];
  if (known == unknown) known = scene_.allowed_collision(*names_[a], *names_[b]);
  return known;
}

}  // namespace srmp::detail
