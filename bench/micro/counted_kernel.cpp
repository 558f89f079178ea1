#include "counted_kernel.hpp"

#include <algorithm>
#include <cmath>

namespace bench {
KernelOperations kernel_operations;
}

using bench::kernel_operations;

#define SRMP_LANES "counting_lanes.hpp"
#define SRMP_KERNEL run_counted
#include "srmp/collision/batch/kernel-inl.hpp"
