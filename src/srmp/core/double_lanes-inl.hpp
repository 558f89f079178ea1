// Lanes of float64 for one instruction set, chosen by the flags of the including file. Every operation is exactly
// rounded and none is fused, so all instruction sets give the same bits. No include guard: once per kernel file.

#include <cstddef>
#include <cstdint>

namespace srmp {

namespace {

#if defined(__AVX512F__)
constexpr std::size_t lane_count = 8;
#elif defined(__AVX__)
constexpr std::size_t lane_count = 4;
#else
constexpr std::size_t lane_count = 2;
#endif

using Lanes = double __attribute__((vector_size(lane_count * sizeof(double))));
using AnyLanes = double __attribute__((vector_size(lane_count * sizeof(double)), may_alias));
using LaneNumbers = std::int64_t __attribute__((vector_size(lane_count * sizeof(double))));  // or -1 where true

}  // namespace

}  // namespace srmp
