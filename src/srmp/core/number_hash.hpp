#pragma once

#include <cstddef>
#include <cstdint>

namespace srmp {

/// Hashes ranges of unsigned integers, for unordered maps.
struct NumberHash {
  template <class Numbers>
  std::size_t operator()(const Numbers& numbers) const {
    std::uint64_t hash = 0;
    for (const auto number : numbers) hash = (hash ^ number) * 0x9e3779b97f4a7c15u ^ hash >> 29;
    return hash;
  }
};

}  // namespace srmp
