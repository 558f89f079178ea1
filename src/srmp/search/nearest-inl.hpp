// srmp::search::nearest_* for one instruction set, chosen by the flags of the including file, which defines
// SRMP_NEAREST as its name. Every operation is exactly rounded and none is fused, so all give the same bits. No include
// guard: once per kernel file.

#include <cstdint>
#include <limits>

#include "srmp/search/nearest.hpp"

namespace srmp::search {

namespace {

#if defined(__AVX512F__)
constexpr std::size_t lanes = 8;
#elif defined(__AVX__)
constexpr std::size_t lanes = 4;
#else
constexpr std::size_t lanes = 2;
#endif
constexpr std::size_t parts = ComponentBlock::size / lanes;

using Lanes = double __attribute__((vector_size(lanes * sizeof(double))));
using AnyLanes = double __attribute__((vector_size(lanes * sizeof(double)), may_alias));
using Numbers = std::int64_t __attribute__((vector_size(lanes * sizeof(double))));

}  // namespace

std::size_t SRMP_NEAREST(const ConfigurationBlocks& configurations, const double* q) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto& [blocks, count, components, wraps] = configurations;
  Lanes least[parts];  // by place in a block
  Numbers where[parts];
  for (std::size_t p = 0; p < parts; ++p) least[p] = Lanes{} + infinity, where[p] = Numbers{};
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
      const Numbers nearer = squares[p] < least[p];
      least[p] = nearer ? squares[p] : least[p];
      where[p] = nearer ? Numbers{} + static_cast<std::int64_t>(b) : where[p];
    }
  }
  std::size_t best = 0;
  double square = infinity;
  for (std::size_t i = 0; i < ComponentBlock::size; ++i) {
    const double other = least[i / lanes][i % lanes];
    const std::size_t number = static_cast<std::size_t>(where[i / lanes][i % lanes]) * ComponentBlock::size + i;
    if (other < square || (other == square && square < infinity && number < best)) square = other, best = number;
  }
  return best;
}

}  // namespace srmp::search
