#include "srmp/search/nearest.hpp"

namespace srmp::search {

NearestFunction nearest_function([[maybe_unused]] SimdBackend backend) {
#if defined(__x86_64__) && !defined(SRMP_PORTABLE_ONLY)
  if (backend == SimdBackend::avx512) return nearest_avx512;
  if (backend == SimdBackend::avx2) return nearest_avx2;
#endif
  return nearest_portable;
}

}  // namespace srmp::search
