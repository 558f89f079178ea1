#include "srmp/scene/scene_changes.hpp"

namespace srmp {

namespace {

bool same(const Object& a, const Object& b) { return is_same_body(a, b) && a.pose == b.pose; }
bool same(bool a, bool b) { return a == b; }

bool same(const Attachment& a, const Attachment& b) {
  return a.robot == b.robot && a.link == b.link && a.touch_links == b.touch_links;
}

/// Apart from where the planned joints stand.
bool same(const RobotInstance& a, const RobotInstance& b) {
  return a.model == b.model && a.base == b.base && a.other_positions == b.other_positions && a.padding == b.padding;
}

/// visit(key) for all that is in one of two maps alone, or in both and different.
template <class Map, class Visit>
void for_each_difference(const Map& a, const Map& b, Visit&& visit) {
  auto x = a.begin(), y = b.begin();
  while (x != a.end() || y != b.end()) {
    const bool in_a = x != a.end() && (y == b.end() || !(y->first < x->first));
    const bool in_b = y != b.end() && (x == a.end() || !(x->first < y->first));
    if (!(in_a && in_b && same(x->second, y->second))) visit((in_a ? x : y)->first);
    if (in_a) ++x;
    if (in_b) ++y;
  }
}

/// Is there an object of this name in one of them alone, or another one in each?
bool is_another(const std::string& name, const Scene& before, const Scene& after) {
  const auto a = before.objects().find(name), b = after.objects().find(name);
  const bool in_a = a != before.objects().end(), in_b = b != after.objects().end();
  return in_a && in_b ? !is_same_body(a->second, b->second) : in_a || in_b;
}

}  // namespace

SceneChanges changes_between(const Scene& before, const Scene& after) {
  SceneChanges changes;
  const auto is_anything_else = [&](const std::string&) { changes.anything_else = true; };
  for_each_difference(before.robots(), after.robots(), is_anything_else);
  for_each_difference(before.attachments(), after.attachments(), is_anything_else);
  if (changes.anything_else) return changes;
  for (const auto& [name, robot] : after.robots())
    if (robot.q != before.robot(name).q) changes.robots.insert(name);
  for_each_difference(before.objects(), after.objects(), [&](const std::string& name) {
    changes.objects.insert(name);
    if (after.attachments().contains(name)) changes.anything_else = true;
  });
  // Settings of an object come and go with it.
  for_each_difference(before.allowed_settings(), after.allowed_settings(), [&](const auto& names) {
    if (!is_another(names.first, before, after) && !is_another(names.second, before, after))
      changes.anything_else = true;
  });
  return changes;
}

}  // namespace srmp
