// No instruction set flags: 128-bit vectors of whatever the compiler targets.
#define SRMP_KERNEL run_portable
#include "srmp/collision/batch/kernel-inl.hpp"
