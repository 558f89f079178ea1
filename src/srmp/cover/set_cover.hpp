#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace srmp {

/// Elements 0 … count-1 of each set, each once.
struct SetSystem {
  std::size_t elements{};
  std::vector<std::vector<std::uint32_t>> sets;
};

/// Tries to cover what the sets of `cover` (indices) hold together with fewer sets, by local search: drop a set, mend,
/// and let elements that stay open long weigh more (row weighting: Gao, Weise and Li 2015). Stops after `work` updates
/// of set scores, so that the same question has the same answer. Never returns more sets than it was given.
std::vector<int> smaller_cover(const SetSystem& system, const std::vector<int>& cover, std::size_t work);

}  // namespace srmp
