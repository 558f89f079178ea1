#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "srmp/collision/body.hpp"
#include "srmp/collision/robot_group.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp::detail {

/// What the rules of contact and the pairs need of a body, close together in memory: there are many pairs.
struct PairSide {
  int robot;
  bool link, attached, is_solid;
  std::size_t name, source;  // number of the scene name; as in Body
  std::uint64_t support;
  double padding;
  const coal::CollisionGeometry* solid;
};

/// Decides whether contact between two bodies is a collision. The scene, the group and the bodies outlive this, and
/// bodies stay where they are in memory.
class ContactRules {
 public:
  ContactRules(const Scene& scene, const RobotGroup& group, bool other_robots_only);

  PairSide side(const Body& body);
  template <class BodyRange>
  std::vector<PairSide> sides(const BodyRange& bodies) {
    std::vector<PairSide> sides;
    sides.reserve(bodies.size());
    for (const Body& body : bodies) sides.push_back(side(body));
    return sides;
  }

  bool count(const PairSide& a, const PairSide& b) {
    if (a.robot != 0 && b.robot != 0) return false;
    if (other_robots_only_ && (a.robot == b.robot || a.robot < 0 || b.robot < 0)) return false;
    const bool same_robot = a.robot == b.robot && a.link && b.link;  // the planned one
    if (by_model_alone(a, b)) return !same_robot || is_self_pair(a, b);
    return by_names(a, b, same_robot);
  }

 private:
  static constexpr char unknown = 2;

  /// No setting of the scene names both, as for most pairs of most scenes: the model's own rules decide.
  bool by_model_alone(const PairSide& a, const PairSide& b) const {
    return !(has_setting_[a.name] && has_setting_[b.name]) && !a.attached && !b.attached;
  }
  bool by_names(const PairSide& a, const PairSide& b, bool same_robot);
  bool has_setting(const std::string& name) const;
  bool is_self_pair(const PairSide& a, const PairSide& b) {
    if (self_pairs_.empty()) find_self_pairs();
    return self_pairs_[a.source * geometries_ + b.source];
  }
  void find_self_pairs();
  bool allowed(std::size_t a, std::size_t b);

  const Scene& scene_;
  const RobotModel& planned_;
  bool other_robots_only_;
  std::map<std::string_view, std::size_t> links_;  // several geometries share a link, and its name
  std::vector<const std::string*> names_;
  std::vector<char> has_setting_;  // by number of the name
  std::vector<char> allowed_;      // [a * names + b]; empty until needed
  std::size_t geometries_;         // of the planned robot
  std::vector<char> self_pairs_;   // its own [a * geometries + b]; empty until needed
};

}  // namespace srmp::detail
