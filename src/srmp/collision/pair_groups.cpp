#include "srmp/collision/pair_groups.hpp"

#include <algorithm>

namespace srmp::detail {

PairGroups::PairGroups(const Bodies& bodies) : bodies_(bodies) {
  const std::size_t moving = bodies.moving.size() + bodies.envelopes.size(), others = bodies.fixed.size() + moving;
  std::vector<std::int32_t> group_between(moving * others, -1);
  std::vector<std::uint32_t> group_of;
  group_of.reserve(bodies.pairs.size());
  for (const Pair& pair : bodies.pairs) {
    Pair around = pair;
    around.a = bodies.envelope_of[pair.a];
    if (!pair.b_fixed) around.b = bodies.envelope_of[pair.b];
    std::int32_t& group = group_between[around.a * others + around.b + (pair.b_fixed ? moving : 0)];
    if (group < 0) {
      group = static_cast<std::int32_t>(around_.size());
      around_.push_back(around);
      first_.push_back(0);
    }
    const auto number = static_cast<std::size_t>(group);
    group_of.push_back(static_cast<std::uint32_t>(group));
    around_[number].padding = std::max(around_[number].padding, pair.padding);
    ++first_[number];
  }
  std::uint32_t end = 0;
  for (std::uint32_t& first : first_) first = end += first;  // filled from the back
  first_.push_back(end);
  members_.resize(bodies.pairs.size());
  for (std::size_t i = group_of.size(); i-- > 0;) members_[--first_[group_of[i]]] = static_cast<std::uint32_t>(i);
}

}  // namespace srmp::detail
