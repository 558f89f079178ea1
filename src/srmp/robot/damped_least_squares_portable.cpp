// No instruction set flags: 128-bit vectors of whatever the compiler targets.
#define SRMP_DAMPED_LEAST_SQUARES damped_least_squares_portable
#include "srmp/robot/damped_least_squares-inl.hpp"
