#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "srmp/collision/bodies.hpp"

namespace srmp::detail {

/// The pairs of bodies, those between the same two envelopes together, or between an envelope and a fixed body: what
/// keeps the envelopes apart keeps each of these pairs apart. Pairs of two bodies without envelopes are groups of one.
class PairGroups {
 public:
  /// The bodies outlive this.
  explicit PairGroups(const Bodies& bodies);

  std::size_t size() const { return around_.size(); }
  /// The envelopes as a pair, with the largest padding of the group's pairs.
  const Pair& around(std::size_t group) const { return around_[group]; }
  /// Numbers of the group's pairs.
  std::span<const std::uint32_t> members(std::size_t group) const {
    return {members_.data() + first_[group], first_[group + 1] - first_[group]};
  }

  // --- one numbering of pairs and groups: pairs come first

  /// The number of the group, or of the only pair in it.
  std::uint32_t number(std::size_t group) const {
    const auto pairs = members(group);
    return pairs.size() == 1 ? pairs.front() : static_cast<std::uint32_t>(bodies_.pairs.size() + group);
  }
  bool is_group(std::uint32_t number) const { return number >= bodies_.pairs.size(); }
  const Pair& pair_of(std::uint32_t number) const {
    return is_group(number) ? around(number - bodies_.pairs.size()) : bodies_.pairs[number];
  }
  std::span<const std::uint32_t> members_of(std::uint32_t number) const {
    return members(number - bodies_.pairs.size());
  }

 private:
  const Bodies& bodies_;
  std::vector<Pair> around_;
  std::vector<std::uint32_t> first_;    // [group], and the end
  std::vector<std::uint32_t> members_;  // of the groups, one after the other
};

}  // namespace srmp::detail
