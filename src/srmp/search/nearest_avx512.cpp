// Built with the flags for this instruction set (kernels.cmake); only called where the CPU has it.
#if defined(__x86_64__)
#define SRMP_NEAREST nearest_avx512
#include "srmp/search/nearest-inl.hpp"
#endif
