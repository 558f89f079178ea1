// Built with the flags for this instruction set (kernels.cmake); only called where the CPU has it.
#if defined(__x86_64__)
#define SRMP_DAMPED_LEAST_SQUARES damped_least_squares_avx512
#include "srmp/robot/damped_least_squares-inl.hpp"
#endif
