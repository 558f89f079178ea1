#pragma once

#include <cstddef>
#include <map>
#include <unordered_map>
#include <vector>

namespace srmp {

// Approximate heap memory of containers [bytes], without what their elements allocate.

template <class T>
std::size_t memory_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

inline constexpr std::size_t tree_node_overhead = 4 * sizeof(void*);  // of std::map and std::set: colour, three links

template <class Key, class T, class... Rest>
std::size_t memory_of(const std::map<Key, T, Rest...>& map) {
  return map.size() * (sizeof(typename std::map<Key, T, Rest...>::value_type) + tree_node_overhead);
}

template <class Key, class T, class... Rest>
std::size_t memory_of(const std::unordered_map<Key, T, Rest...>& map) {
  constexpr std::size_t node = sizeof(typename std::unordered_map<Key, T, Rest...>::value_type) + 2 * sizeof(void*);
  return map.size() * node + map.bucket_count() * sizeof(void*);
}

}  // namespace srmp
