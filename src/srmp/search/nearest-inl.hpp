// srmp::search::nearest_* for one instruction set, chosen by the flags of the including file, which defines
// SRMP_NEAREST as its name. Every operation is exactly rounded and none is fused, so all give the same bits. No include
// guard: once per kernel file.

#include <limits>

#include "srmp/core/double_lanes-inl.hpp"
#include "srmp/search/nearest.hpp"

namespace srmp::search {

std::size_t SRMP_NEAREST(const ConfigurationBlocks& configurations, const double* q) {
  constexpr std::size_t parts = ComponentBlock::size / lane_count;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto& [blocks, count, components, wraps] = configurations;
  Lanes least[parts];  // by place in a block
  LaneNumbers where[parts];
  for (std::size_t p = 0; p < parts; ++p) least[p] = Lanes{} + infinity, where[p] = LaneNumbers{};
  const ComponentBlock* component = blocks;
  for (std::size_t b = 0; b < count; ++b) {
    Lanes squares[parts]{};
    for (std::size_t k = 0; k < components; ++k, ++component) {
      Lanes difference[parts];
      const auto* values = reinterpret_cast<const AnyLanes*>(component->values);
      for (std::size_t p = 0; p < parts; ++p) difference[p] = values[p] - q[k];
      if (wraps && wraps[k])
        for (std::size_t p = 0; p < parts; ++p) difference[p] = wrapped(difference[p]);
      for (std::size_t p = 0; p < parts; ++p) squares[p] += difference[p] * difference[p];
    }
    for (std::size_t p = 0; p < parts; ++p) {
      const LaneNumbers nearer = squares[p] < least[p];
      least[p] = nearer ? squares[p] : least[p];
      where[p] = nearer ? LaneNumbers{} + static_cast<std::int64_t>(b) : where[p];
    }
  }
  std::size_t best = 0;
  double square = infinity;
  for (std::size_t i = 0; i < ComponentBlock::size; ++i) {
    const double other = least[i / lane_count][i % lane_count];
    const std::size_t number =
        static_cast<std::size_t>(where[i / lane_count][i % lane_count]) * ComponentBlock::size + i;
    if (other < square || (other == square && square < infinity && number < best)) square = other, best = number;
  }
  return best;
}

}  // namespace srmp::search
