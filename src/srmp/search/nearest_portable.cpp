// No instruction set flags: 128-bit vectors of whatever the compiler targets.
#define SRMP_NEAREST nearest_portable
#include "srmp/search/nearest-inl.hpp"
