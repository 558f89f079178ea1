#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "srmp/core/block_vector.hpp"
#include "srmp/search/graph.hpp"

namespace srmp {

/// Numbers integer vectors of one length 0, 1, 2, … in order of insertion. Whole keys are compared; a hash only gives
/// their bucket. Linear hashing (Litwin 1980, "Linear hashing: a new tool for file and table addressing"): each new key
/// splits two buckets, so that the table grows with its keys and no insertion takes long.
class StateTable {
 public:
  explicit StateTable(std::size_t width) : width_(width) { buckets_.grow_to(half_, search::no_state); }

  /// The number of `key`, new or old.
  search::StateId insert(std::span<const std::int32_t> key) {
    const std::uint32_t h = hash(key);
    for (search::StateId at = buckets_[bucket_of(h)]; at != search::no_state; at = entries_[at].next)
      if (entries_[at].hash == h && std::equal(key.begin(), key.end(), this->key(at).begin())) return at;
    split_bucket();
    split_bucket();
    const auto id = static_cast<search::StateId>(size());
    append(key);
    search::StateId& first = buckets_[bucket_of(h)];
    entries_.push_back({h, first});
    return first = id;
  }

  std::span<const std::int32_t> key(search::StateId id) const {
    return {keys_[id / block_size].data() + id % block_size * width_, width_};
  }
  std::size_t size() const { return entries_.size(); }
  std::size_t memory() const {
    const std::size_t keys = keys_.empty() ? 0 : (keys_.size() - 1) * block_size * width_ + keys_.front().capacity();
    return keys * sizeof(std::int32_t) + buckets_.memory() + entries_.memory();
  }

 private:
  static constexpr std::size_t block_size = 1024;  // keys

  struct Entry {
    std::uint32_t hash;
    search::StateId next;  // of the same bucket
  };

  static std::uint32_t hash(std::span<const std::int32_t> key) {
    std::uint64_t h = 0x9E3779B97F4A7C15ull;
    for (const std::int32_t v : key) {
      h ^= static_cast<std::uint32_t>(v);
      h *= 0xFF51AFD7ED558CCDull;
      h ^= h >> 32;
    }
    return static_cast<std::uint32_t>(h);
  }

  /// There are between half_ and 2 * half_ buckets; the first ones are split already, and by one more bit of the hash.
  std::size_t bucket_of(std::uint32_t hash) const {
    const std::size_t bucket = hash & (2 * half_ - 1);
    return bucket < buckets_.size() ? bucket : bucket - half_;
  }

  /// Moves the keys whose hash says so from the next bucket that is not split into a new one.
  void split_bucket() {
    const std::size_t old = buckets_.size() - half_;
    search::StateId at = std::exchange(buckets_[old], search::no_state);
    buckets_.push_back(search::no_state);
    while (at != search::no_state) {
      Entry& entry = entries_[at];
      at = std::exchange(entry.next, std::exchange(buckets_[bucket_of(entry.hash)], at));
    }
    if (buckets_.size() == 2 * half_) half_ *= 2;
  }

  void append(std::span<const std::int32_t> key) {
    if (size() == keys_.size() * block_size) {
      keys_.emplace_back();
      if (keys_.size() > 1) keys_.back().reserve(block_size * width_);
    }
    keys_.back().insert(keys_.back().end(), key.begin(), key.end());
  }

  std::size_t width_;
  std::size_t half_{64};                         // a power of two
  std::vector<std::vector<std::int32_t>> keys_;  // in blocks
  BlockVector<search::StateId> buckets_;         // the first key of each
  BlockVector<Entry> entries_;                   // by key
};

}  // namespace srmp
