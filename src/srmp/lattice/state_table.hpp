#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "srmp/search/graph.hpp"

namespace srmp {

/// Numbers integer vectors of one length 0, 1, 2, … in order of insertion. Whole keys are compared; a hash only gives
/// their slot. Open addressing; grows by doubling, without allocations per state.
class StateTable {
 public:
  explicit StateTable(std::size_t width) : width_(width), slots_(1024, search::no_state) {}

  /// The number of `key`, new or old.
  search::StateId insert(std::span<const std::int32_t> key) {
    std::size_t slot = hash(key) & (slots_.size() - 1);
    while (slots_[slot] != search::no_state) {
      if (std::equal(key.begin(), key.end(), keys_.begin() + static_cast<std::ptrdiff_t>(slots_[slot] * width_)))
        return slots_[slot];
      slot = (slot + 1) & (slots_.size() - 1);
    }
    const auto id = static_cast<search::StateId>(size_++);
    keys_.insert(keys_.end(), key.begin(), key.end());
    slots_[slot] = id;
    if (2 * size_ > slots_.size()) grow();
    return id;
  }

  std::span<const std::int32_t> key(search::StateId id) const { return {keys_.data() + id * width_, width_}; }
  std::size_t size() const { return size_; }
  std::size_t memory() const {
    return keys_.capacity() * sizeof(std::int32_t) + slots_.capacity() * sizeof(search::StateId);
  }

 private:
  static std::size_t hash(std::span<const std::int32_t> key) {
    std::uint64_t h = 0x9E3779B97F4A7C15ull;
    for (const std::int32_t v : key) {
      h ^= static_cast<std::uint32_t>(v);
      h *= 0xFF51AFD7ED558CCDull;
      h ^= h >> 32;
    }
    return h;
  }

  void grow() {
    slots_.assign(2 * slots_.size(), search::no_state);
    for (std::size_t id = 0; id < size_; ++id) {
      std::size_t slot = hash(key(static_cast<search::StateId>(id))) & (slots_.size() - 1);
      while (slots_[slot] != search::no_state) slot = (slot + 1) & (slots_.size() - 1);
      slots_[slot] = static_cast<search::StateId>(id);
    }
  }

  std::size_t width_;
  std::size_t size_{0};
  std::vector<std::int32_t> keys_;
  std::vector<search::StateId> slots_;
};

}  // namespace srmp
