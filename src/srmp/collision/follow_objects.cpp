// How Bodies follow objects of a scene that changed.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>

#include "srmp/collision/bodies.hpp"
#include "srmp/collision/contact_rules.hpp"
#include "srmp/scene/scene_changes.hpp"

namespace srmp::detail {

namespace {

/// Keeps those that update(each) says stay.
template <class Value, class Update>
void keep(std::vector<Value>& values, Update&& update) {
  auto end = values.begin();
  for (Value& value : values)
    if (update(value)) *end++ = value;
  values.erase(end, values.end());
}

}  // namespace

class Bodies::Following {
 public:
  Following(Bodies& bodies, const Scene& scene)
      : bodies_(bodies), scene_(scene), now_(bodies.fixed.size()), is_new_(bodies.fixed.size()) {
    const auto begin = bodies.fixed.begin();
    const auto is_link = [](const FixedBody& body) { return body.kind == BodyKind::link; };
    const auto first =
        std::find_if(begin, bodies.fixed.end(), [&](const auto& body) { return !is_link(body) || body.robot < 0; });
    first_object_ = first - begin;
    end_of_objects_ = std::find_if(first, bodies.fixed.end(), is_link) - begin;
    for (std::size_t i = 0; i < now_.size(); ++i) changes_.before.push_back(now_[i] = static_cast<int>(i));
  }

  std::optional<FixedChanges> follow(const std::set<std::string>& names) {
    for (const std::string& name : names) change(name);
    if (!changed_) return std::nullopt;
    if (renumbered_) renumber();
    update_pairs();
    if (!changes_.same_pairs) bodies_.number_pairs();
    bodies_.build_tree();
    update_overlaps();
    return std::move(changes_);
  }

 private:
  static constexpr int gone = -1;

  /// Changes a body of the object where it is, or notes that one is gone or is to be inserted.
  void change(const std::string& name) {
    const auto object = scene_.objects().find(name);
    const bool exists = object != scene_.objects().end();
    const std::size_t index = place_of(name);
    const bool existed = static_cast<std::ptrdiff_t>(index) < end_of_objects_ && bodies_.fixed[index].name == name;
    if (!exists && !existed) return;
    changed_ = true;
    if (!existed) {
      inserted_.push_back({index, &object->second});
      renumbered_ = true;
      return;
    }
    changes_.before[index] = FixedChanges::changed;
    if (exists && is_same_body(bodies_.fixed[index], object->second)) return move(index, object->second.pose);
    keep_example(index);
    is_new_[index] = true;
    if (exists) {
      bodies_.fixed[index] = bodies_.free_object(object->second);
    } else {
      now_[index] = gone;
      renumbered_ = true;
    }
  }

  /// Where an object is, or is to be inserted: objects come after the group's links, by name, those too that robots
  /// hold.
  std::size_t place_of(const std::string& name) const {
    const auto begin = bodies_.fixed.begin();
    const auto by_name = [](const FixedBody& body, const std::string& other) { return body.name < other; };
    return static_cast<std::size_t>(std::lower_bound(begin + first_object_, begin + end_of_objects_, name, by_name) -
                                    begin);
  }

  void move(std::size_t index, const Pose& pose) {
    FixedBody& body = bodies_.fixed[index];
    body.pose = bodies_.in_base(pose);
    body.center = body.pose * body.bounds.center;
  }

  /// Formulas refer to the first solids that needed them.
  void keep_example(std::size_t index) {
    const auto& examples = bodies_.formulas.examples();
    const FixedBody& body = bodies_.fixed[index];
    const auto& kept = bodies_.examples_;
    if (std::any_of(examples.begin(), examples.end(), [&](const auto& pair) { return pair.second == body.solid; }) &&
        std::find(kept.begin(), kept.end(), body.parts.hull) == kept.end())
      bodies_.examples_.push_back(body.parts.hull);
  }

  /// Puts the new bodies among those that stay, which get other numbers.
  void renumber() {
    std::vector<FixedBody> fixed;
    std::vector<char> is_new;
    std::vector<int> before;
    fixed.reserve(bodies_.fixed.size() + inserted_.size());
    auto next = inserted_.begin();
    for (std::size_t i = 0; i <= bodies_.fixed.size(); ++i) {
      for (; next != inserted_.end() && next->place == i; ++next) {
        fixed.push_back(bodies_.free_object(*next->object));
        is_new.push_back(true);
        before.push_back(FixedChanges::changed);
      }
      if (i == bodies_.fixed.size() || now_[i] == gone) continue;
      now_[i] = static_cast<int>(fixed.size());
      fixed.push_back(std::move(bodies_.fixed[i]));
      is_new.push_back(is_new_[i]);
      before.push_back(changes_.before[i]);
    }
    bodies_.fixed = std::move(fixed);
    is_new_ = std::move(is_new);
    changes_.before = std::move(before);
  }

  /// Gives a body the number that it has now; false: it has no pairs of before.
  bool update(std::uint32_t& number) const {
    const int now = now_[number];
    if (now == gone || is_new_[static_cast<std::size_t>(now)]) return false;
    number = static_cast<std::uint32_t>(now);
    return true;
  }

  void update_pairs() {
    if (std::ranges::none_of(is_new_, [](char other) { return other; }) && !renumbered_) {
      changes_.same_pairs = true;
      return;
    }
    std::vector<Pair> own = pairs_of_new();
    if (!renumbered_ && replace(own)) {
      changes_.same_pairs = true;
    } else {
      keep(bodies_.pairs, [&](Pair& pair) { return !pair.b_fixed || update(pair.b); });
      std::vector<Pair> all;
      all.reserve(bodies_.pairs.size() + own.size());
      std::ranges::merge(bodies_.pairs, own, std::back_inserter(all), comes_before);
      bodies_.pairs = std::move(all);
    }
    keep(bodies_.apart, [&](Pair& pair) { return !pair.b_fixed || update(pair.b); });
    update_fixed_pairs();
  }

  /// Bodies::add_pairs makes pairs in this order.
  static bool comes_before(const Pair& x, const Pair& y) {
    const auto key = [](const Pair& pair) {  // first, is it of two moving bodies, second
      const std::uint64_t first = pair.b_fixed ? pair.a : std::min(pair.a, pair.b);
      return first << 33 | std::uint64_t{!pair.b_fixed} << 32 | (pair.b_fixed ? pair.b : std::max(pair.a, pair.b));
    };
    return key(x) < key(y);
  }

  /// Pairs of moving bodies and of those that are new or replaced.
  std::vector<Pair> pairs_of_new() {
    ContactRules rules(scene_, bodies_.group_, false);
    const std::vector<PairSide> of_moving = rules.sides(bodies_.moving);
    std::vector<std::pair<std::uint32_t, PairSide>> added, links;  // links that stand still, and what they hold
    for (std::uint32_t i = 0; i < is_new_.size(); ++i)
      if (is_new_[i] || bodies_.fixed[i].robot == 0)
        (is_new_[i] ? added : links).emplace_back(i, rules.side(bodies_.fixed[i]));
    std::vector<Pair> pairs;
    pairs.reserve(of_moving.size() * added.size());
    for (std::size_t i = 0; i < of_moving.size(); ++i)
      for (const auto& [j, other] : added)
        if (rules.count(of_moving[i], other)) pairs.push_back(bodies_.pair_of(of_moving[i], i, other, true, j));
    for (const auto& [i, link] : links)
      for (const auto& [j, other] : added)
        if (rules.count(link, other)) fixed_pairs_.emplace_back(i, j);
    return pairs;
  }

  /// Puts pairs where those of the same bodies were; false, and nothing is done, where there were others.
  bool replace(const std::vector<Pair>& own) {
    std::vector<Pair*> before;
    for (Pair& pair : bodies_.pairs)
      if (pair.b_fixed && is_new_[pair.b]) before.push_back(&pair);
    const auto bodies = [](const Pair& pair) { return std::pair(pair.a, pair.b); };
    if (!std::ranges::equal(before, own, {}, [&](const Pair* pair) { return bodies(*pair); }, bodies)) return false;
    for (std::size_t i = 0; i < own.size(); ++i) *before[i] = own[i];
    return true;
  }

  void update_fixed_pairs() {
    keep(bodies_.fixed_pairs, [&](auto& pair) { return update(pair.first) && update(pair.second); });
    const auto own = bodies_.fixed_pairs.insert(bodies_.fixed_pairs.end(), fixed_pairs_.begin(), fixed_pairs_.end());
    std::ranges::inplace_merge(bodies_.fixed_pairs, own);
  }

  void update_overlaps() {
    const auto is_changed = [&](std::uint32_t number) { return changes_.before[number] == FixedChanges::changed; };
    const auto stays = [&](bool is_fixed, std::uint32_t& number) {
      return !is_fixed || (update(number) && !is_changed(number));
    };
    keep(bodies_.overlaps,
         [&](RigidOverlap& pair) { return stays(pair.a_fixed, pair.a) && stays(pair.b_fixed, pair.b); });
    for (const auto& [a, b] : bodies_.fixed_pairs) {
      const RigidOverlap pair{true, true, a, b};
      if ((is_changed(a) || is_changed(b)) && bodies_.overlap(pair)) bodies_.overlaps.push_back(pair);
    }
    // Those of moving bodies come first, in their own order.
    std::stable_sort(bodies_.overlaps.begin(), bodies_.overlaps.end(), [](const auto& a, const auto& b) {
      if (!a.a_fixed || !b.a_fixed) return a.a_fixed < b.a_fixed;
      return std::pair(a.a, a.b) < std::pair(b.a, b.b);
    });
  }

  struct Insertion {
    std::size_t place;  // before the body that had this number
    const Object* object;
  };

  Bodies& bodies_;
  const Scene& scene_;
  std::ptrdiff_t first_object_{}, end_of_objects_{};  // before
  bool changed_{}, renumbered_{};
  std::vector<int> now_;  // of each fixed body before: its number now, or gone
  FixedChanges changes_;
  std::vector<Insertion> inserted_;
  std::vector<char> is_new_;                                          // by fixed body: it is new or replaced
  std::vector<std::pair<std::uint32_t, std::uint32_t>> fixed_pairs_;  // of those, with links that stand still
};

std::optional<FixedChanges> Bodies::follow_objects(const Scene& scene, const std::set<std::string>& names) {
  if (options_.other_robots_only) return std::nullopt;
  return Following(*this, scene).follow(names);
}

}  // namespace srmp::detail
