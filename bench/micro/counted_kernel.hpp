#pragma once

#include <cstdint>

#include "srmp/collision/batch/kernel.hpp"

namespace bench {

/// Operations on vectors.
struct KernelOperations {
  std::uint64_t arithmetic{}, square_root{}, gather{};
};

/// Those of the functions below since the start of the program.
inline KernelOperations kernel_operations;

}  // namespace bench

namespace srmp::batch {

// The kernel, counting; with as many lanes in a vector as the instruction set has.
void run_counted_portable(const KernelModel&, const KernelRequest&, float* scratch, KernelResult&);
void run_counted_avx2(const KernelModel&, const KernelRequest&, float* scratch, KernelResult&);
void run_counted_avx512(const KernelModel&, const KernelRequest&, float* scratch, KernelResult&);

}  // namespace srmp::batch
