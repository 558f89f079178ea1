#pragma once

#include <array>
#include <cstdint>

namespace srmp {

// Morton codes (Morton 1966): the cells of a grid in the order of an octree's leaves, with 21 bits for each axis;
// indices are from -2^20 to 2^20 - 1.

namespace detail {
constexpr std::uint64_t spread_bits(std::uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffffull;
  x = (x | x << 16) & 0x1f0000ff0000ffull;
  x = (x | x << 8) & 0x100f00f00f00f00full;
  x = (x | x << 4) & 0x10c30c30c30c30c3ull;
  return (x | x << 2) & 0x1249249249249249ull;
}
constexpr std::uint64_t gather_bits(std::uint64_t x) {
  x &= 0x1249249249249249ull;
  x = (x | x >> 2) & 0x10c30c30c30c30c3ull;
  x = (x | x >> 4) & 0x100f00f00f00f00full;
  x = (x | x >> 8) & 0x1f0000ff0000ffull;
  x = (x | x >> 16) & 0x1f00000000ffffull;
  return (x | x >> 32) & 0x1fffffull;
}
constexpr std::int32_t morton_middle = 1 << 20;
}  // namespace detail

/// The code of the cell with these indices along x, y and z.
constexpr std::uint64_t morton_code(const std::array<std::int32_t, 3>& key) {
  std::uint64_t code = 0;
  for (std::size_t i = 0; i < 3; ++i)
    code |= detail::spread_bits(static_cast<std::uint64_t>(key[i] + detail::morton_middle)) << i;
  return code;
}

/// The inverse of morton_code.
constexpr std::array<std::int32_t, 3> morton_key(std::uint64_t code) {
  std::array<std::int32_t, 3> key{};
  for (std::size_t i = 0; i < 3; ++i)
    key[i] = static_cast<std::int32_t>(detail::gather_bits(code >> i)) - detail::morton_middle;
  return key;
}

}  // namespace srmp
