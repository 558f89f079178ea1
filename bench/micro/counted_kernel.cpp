// Compiled once for each number of lanes; SRMP_KERNEL is the function's name.

#include "counted_kernel.hpp"

#include <algorithm>
#include <cmath>

using bench::kernel_operations;

#define SRMP_LANES "counting_lanes.hpp"
#include "srmp/collision/batch/kernel-inl.hpp"
