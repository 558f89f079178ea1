#include "srmp/robot/damped_least_squares.hpp"

namespace srmp {

DampedLeastSquaresFunction damped_least_squares([[maybe_unused]] SimdBackend backend) {
#if defined(__x86_64__) && !defined(SRMP_PORTABLE_ONLY)
  if (backend == SimdBackend::avx512) return damped_least_squares_avx512;
  if (backend == SimdBackend::avx2) return damped_least_squares_avx2;
#endif
  return damped_least_squares_portable;
}

}  // namespace srmp
