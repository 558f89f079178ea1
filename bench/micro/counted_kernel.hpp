#pragma once

#include <cstdint>

#include "srmp/collision/batch/kernel.hpp"

namespace bench {

/// Operations on 16 lanes.
struct KernelOperations {
  std::uint64_t arithmetic{}, square_root{}, gather{};
};

/// Those of run_counted since the start of the program.
extern KernelOperations kernel_operations;

}  // namespace bench

namespace srmp::batch {

/// The kernel, counting.
void run_counted(const KernelModel&, const KernelRequest&, float* scratch, KernelResult&);

}  // namespace srmp::batch
