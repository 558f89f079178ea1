#pragma once

#include <cstddef>

#include "srmp/core/simd_backend.hpp"

namespace srmp::search {

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
