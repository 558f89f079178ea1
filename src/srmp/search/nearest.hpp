#pragma once

#include <cfloat>
#include <cstddef>
#include <numbers>

#include "srmp/core/simd_backend.hpp"

static_assert(FLT_EVAL_METHOD == 0, "wrapped() needs sums that are rounded to double precision");
#ifdef __FAST_MATH__
#error "wrapped() needs sums in the order in which they are written, so no -ffast-math"
#endif

namespace srmp::search {

/// An angle, or a vector of several, wrapped to [-pi, pi] [rad]. Adding and subtracting `rounding` rounds to the
/// nearest whole number, as std::nearbyint does, but without a call; below 2^51 turns.
template <class Angles>
Angles wrapped(const Angles& angles) {
  constexpr double rounding = 0x1.8p52;
  return angles - 2.0 * std::numbers::pi * ((angles * (0.5 / std::numbers::pi) + rounding) - rounding);
}

/// One component of as many configurations as are compared at once.
struct alignas(64) ComponentBlock {
  static constexpr std::size_t size = 16;
  double values[size];
};

/// Configurations in blocks: of each block one component of all, the next one, ...
struct ConfigurationBlocks {
  const ComponentBlock* blocks;  ///< count * components
  std::size_t count;
  std::size_t components;
  const char* wraps;  ///< by component: is it an angle that wraps around [rad]? nullptr: none is
};

/// The number of the first configuration that is nearest to q, by comparing all; 0 when there is none, or when no
/// distance is a number.
using NearestFunction = std::size_t (*)(const ConfigurationBlocks& configurations, const double* q);

std::size_t nearest_portable(const ConfigurationBlocks& configurations, const double* q);
#if defined(__x86_64__) && !defined(SRMP_PORTABLE_ONLY)
std::size_t nearest_avx2(const ConfigurationBlocks& configurations, const double* q);
std::size_t nearest_avx512(const ConfigurationBlocks& configurations, const double* q);
#endif

/// Of an instruction set that the CPU has; all give the same number.
NearestFunction nearest_function(SimdBackend backend);

}  // namespace srmp::search
