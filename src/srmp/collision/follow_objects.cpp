// How Bodies follow objects of a scene that changed.

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <tuple>

#include "srmp/collision/bodies.hpp"
#include "srmp/collision/contact_rules.hpp"

namespace srmp::detail {

class Bodies::Following {
 public:
  Following(Bodies& bodies, const Scene& scene) : bodies_(bodies), scene_(scene), changed_(bodies.fixed.size()) {
    const auto begin = bodies.fixed.begin();
    const auto is_link = [](const FixedBody& body) { return body.kind == BodyKind::link; };
    const auto first =
        std::find_if(begin, bodies.fixed.end(), [&](const auto& body) { return !is_link(body) || body.robot < 0; });
    first_object_ = first - begin;
    end_of_objects_ = std::find_if(first, bodies.fixed.end(), is_link) - begin;
  }

  void follow(const std::string& name) {
    const auto object = scene_.objects().find(name);
    const bool exists = object != scene_.objects().end();
    const std::size_t index = place_of(name);
    const bool existed = static_cast<std::ptrdiff_t>(index) < end_of_objects_ && bodies_.fixed[index].name == name;
    if (!exists && !existed) return;
    using Kind = FixedChange::Kind;
    Kind kind = !existed ? Kind::inserted : !exists ? Kind::erased : Kind::replaced;
    if (kind == Kind::replaced && is_same(bodies_.fixed[index], object->second)) kind = Kind::moved;
    changes.push_back({kind, index, kind == Kind::moved});
    if (kind == Kind::moved) return move(index, object->second.pose);
    if (existed) keep_example(index);
    const auto at = static_cast<std::ptrdiff_t>(index);
    if (kind == Kind::replaced) {
      bodies_.fixed[index] = bodies_.free_object(object->second);
      changed_[index] = true;
      const PairsOfObject own = pairs_of(index);
      changes.back().same_pairs = update_pairs(index, own);
      if (changes.back().same_pairs) return;
      forget_pairs(index);
      return add_pairs(own);
    }
    if (kind == Kind::erased) {
      forget_pairs(index);
      forget_overlaps([&](bool is_fixed, std::uint32_t number) { return is_fixed && number == index; });
      --end_of_objects_;
      bodies_.fixed.erase(bodies_.fixed.begin() + at);
      changed_.erase(changed_.begin() + at);
      renumber(index + 1, -1);
      return;
    }
    ++end_of_objects_;
    renumber(index, 1);
    bodies_.fixed.insert(bodies_.fixed.begin() + at, bodies_.free_object(object->second));
    changed_.insert(changed_.begin() + at, true);
    add_pairs(pairs_of(index));
  }

  /// Updates what depends on all changes together: numbers of pairs, the tree and the overlaps.
  void finish() {
    if (!std::ranges::all_of(changes, &FixedChange::same_pairs)) bodies_.number_pairs();
    bodies_.build_tree();
    forget_overlaps([&](bool is_fixed, std::uint32_t number) { return is_fixed && changed_[number]; });
    for (const auto& [a, b] : bodies_.fixed_pairs) {
      const RigidOverlap pair{true, true, a, b};
      if ((changed_[a] || changed_[b]) && bodies_.overlap(pair)) bodies_.overlaps.push_back(pair);
    }
    // Those of moving bodies come first, in their own order.
    std::stable_sort(bodies_.overlaps.begin(), bodies_.overlaps.end(), [](const auto& a, const auto& b) {
      if (!a.a_fixed || !b.a_fixed) return a.a_fixed < b.a_fixed;
      return std::pair(a.a, a.b) < std::pair(b.a, b.b);
    });
  }

  std::vector<FixedChange> changes;

 private:
  /// Where an object is, or is to be inserted: objects come after the group's links, by name, those too that robots
  /// hold.
  std::size_t place_of(const std::string& name) const {
    const auto begin = bodies_.fixed.begin();
    const auto by_name = [](const FixedBody& body, const std::string& other) { return body.name < other; };
    return static_cast<std::size_t>(std::lower_bound(begin + first_object_, begin + end_of_objects_, name, by_name) -
                                    begin);
  }

  static bool is_same(const FixedBody& body, const Object& object) {
    return body.geometry == object.geometry && body.padding == object.padding;
  }

  void move(std::size_t index, const Pose& pose) {
    FixedBody& body = bodies_.fixed[index];
    body.pose = bodies_.in_base(pose);
    body.center = body.pose * body.bounds.center;
    changed_[index] = true;
  }

  /// Those of bodies of which is_gone(fixed?, number).
  template <class IsGone>
  void forget_overlaps(IsGone&& is_gone) {
    std::erase_if(bodies_.overlaps, [&](const RigidOverlap& pair) {
      return is_gone(pair.a_fixed, pair.a) || is_gone(pair.b_fixed, pair.b);
    });
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

  void forget_pairs(std::size_t index) {
    std::erase_if(bodies_.pairs, [&](const Pair& pair) { return pair.b_fixed && pair.b == index; });
    std::erase_if(bodies_.fixed_pairs, [&](const auto& pair) { return pair.first == index || pair.second == index; });
  }

  /// What is numbered from `first` on gets other numbers.
  void renumber(std::size_t first, int by) {
    const auto renumber = [&](bool is_fixed, std::uint32_t& number) {
      if (is_fixed && number >= first) number = static_cast<std::uint32_t>(static_cast<int>(number) + by);
    };
    for (std::vector<Pair>* pairs : {&bodies_.pairs, &bodies_.apart})
      for (Pair& pair : *pairs) renumber(pair.b_fixed, pair.b);
    for (RigidOverlap& pair : bodies_.overlaps) renumber(pair.a_fixed, pair.a), renumber(pair.b_fixed, pair.b);
    for (auto& [a, b] : bodies_.fixed_pairs) renumber(true, a), renumber(true, b);
  }

  /// Bodies::add_pairs makes pairs in this order.
  static bool comes_before(const Pair& x, const Pair& y) {
    const auto key = [](const Pair& pair) {
      return pair.b_fixed ? std::tuple(pair.a, false, pair.b)
                          : std::tuple(std::min(pair.a, pair.b), true, std::max(pair.a, pair.b));
    };
    return key(x) < key(y);
  }

  using FixedPair = std::pair<std::uint32_t, std::uint32_t>;
  /// Those of an object that count, in their order.
  struct PairsOfObject {
    std::vector<Pair> moving;      // with moving bodies
    std::vector<FixedPair> fixed;  // with links that stand still
  };

  PairsOfObject pairs_of(std::size_t index) {
    ContactRules rules(scene_, bodies_.group_, false);
    const std::vector<PairSide> of_moving = rules.sides(bodies_.moving);
    const PairSide object = rules.side(bodies_.fixed[index]);
    PairsOfObject found;
    for (std::size_t i = 0; i < of_moving.size(); ++i)
      if (rules.count(of_moving[i], object))
        found.moving.push_back(bodies_.pair_of(of_moving[i], i, object, true, index));
    for (std::uint32_t i = 0; i < bodies_.fixed.size(); ++i)
      if (i != index && bodies_.fixed[i].robot == 0 && rules.count(rules.side(bodies_.fixed[i]), object))
        found.fixed.emplace_back(i, static_cast<std::uint32_t>(index));
    return found;
  }

  /// Puts the object's pairs where those of before are; false, and nothing is done, where these are with other bodies.
  bool update_pairs(std::size_t index, const PairsOfObject& own) {
    std::vector<Pair*> before;
    for (Pair& pair : bodies_.pairs)
      if (pair.b_fixed && pair.b == index) before.push_back(&pair);
    std::vector<FixedPair> fixed;
    std::ranges::copy_if(bodies_.fixed_pairs, std::back_inserter(fixed),
                         [&](const FixedPair& pair) { return pair.first == index || pair.second == index; });
    if (fixed != own.fixed || !std::ranges::equal(before, own.moving, {}, &Pair::a, &Pair::a)) return false;
    for (std::size_t i = 0; i < before.size(); ++i) *before[i] = own.moving[i];
    return true;
  }

  void add_pairs(const PairsOfObject& own) {
    std::vector<Pair> all;
    all.reserve(bodies_.pairs.size() + own.moving.size());
    auto next = bodies_.pairs.begin();
    for (const Pair& pair : own.moving) {
      const auto place = std::lower_bound(next, bodies_.pairs.end(), pair, comes_before);
      all.insert(all.end(), next, place);
      all.push_back(pair);
      next = place;
    }
    all.insert(all.end(), next, bodies_.pairs.end());
    bodies_.pairs = std::move(all);
    for (const FixedPair& pair : own.fixed)
      bodies_.fixed_pairs.insert(std::ranges::upper_bound(bodies_.fixed_pairs, pair), pair);
  }

  Bodies& bodies_;
  const Scene& scene_;
  std::ptrdiff_t first_object_, end_of_objects_;
  std::vector<char> changed_;  // by fixed body: it was added, replaced or moved
};

std::vector<FixedChange> Bodies::follow_objects(const Scene& scene, const std::set<std::string>& names) {
  if (options_.other_robots_only) return {};
  Following following(*this, scene);
  for (const std::string& name : names) following.follow(name);
  if (!following.changes.empty()) following.finish();
  return std::move(following.changes);
}

}  // namespace srmp::detail
