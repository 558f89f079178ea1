#include "srmp/collision/contact_rules.hpp"

#include <algorithm>

namespace srmp::detail {

ContactRules::ContactRules(const Scene& scene, const RobotGroup& group, bool other_robots_only)
    : scene_(scene),
      planned_(group.model(0)),
      other_robots_only_(other_robots_only),
      geometries_(planned_.geometries().size()) {}

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
  if (allowed(a.name, b.name)) return false;
  if (!same_robot || is_self_pair(a, b)) return true;
  // The model may leave out more than it allows; a pair that it allows gets here by the scene's own setting.
  return planned_.allowed(planned_.geometries()[a.source].link, planned_.geometries()[b.source].link);
}

/// Does a setting name the body or the robot that it is a link of?
bool ContactRules::has_setting(const std::string& name) const {
  const auto names = [&](const std::string& key) {
    return name.starts_with(key) && (name.size() == key.size() || name[key.size()] == '/');
  };
  return std::any_of(scene_.allowed_settings().begin(), scene_.allowed_settings().end(),
                     [&](const auto& setting) { return names(setting.first.first) || names(setting.first.second); });
}

void ContactRules::find_self_pairs() {
  self_pairs_.resize(geometries_ * geometries_);
  for (const auto& [a, b] : planned_.self_pairs())
    self_pairs_[a * geometries_ + b] = self_pairs_[b * geometries_ + a] = 1;
}

bool ContactRules::allowed(std::size_t a, std::size_t b) {
  if (allowed_.empty()) allowed_.assign(names_.size() * names_.size(), unknown);
  char& known = allowed_[a * names_.size() + b];
  if (known == unknown) known = scene_.allowed_collision(*names_[a], *names_[b]);
  return known;
}

}  // namespace srmp::detail
