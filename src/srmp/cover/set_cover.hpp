#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace srmp {

/// Sets over the elements 0 … elements-1.
struct SetSystem {
  std::size_t elements{};
  std::vector<std::vector<std::uint32_t>> sets;  ///< elements of each set, each at most once
};

/// Tries to cover the union of the sets of `cover` (indices of sets) with fewer sets, by local search with row
/// weighting (Gao, Weise and Li 2015): remove a set, repair the cover, and increase the weight of elements that stay
/// uncovered. Stops after `work` updates of set scores and not by the clock, so the result is deterministic. Returns
/// indices of sets in ascending order, never more than it was given.
std::vector<int> smaller_cover(const SetSystem& system, const std::vector<int>& cover, std::size_t work);

}  // namespace srmp
