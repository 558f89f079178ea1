#include "srmp/core/simd_backend.hpp"

#include <cstdlib>

#include "srmp/core/error.hpp"

namespace srmp {

std::string to_string(SimdBackend backend) {
  switch (backend) {
    case SimdBackend::portable: return "portable";
    case SimdBackend::avx2: return "avx2";
    case SimdBackend::avx512: return "avx512";
  }
  return "unknown";
}

bool is_available([[maybe_unused]] SimdBackend backend) {
  if (backend == SimdBackend::portable) return true;
#if defined(__x86_64__) && !defined(SRMP_PORTABLE_ONLY)
  if (backend == SimdBackend::avx2) return __builtin_cpu_supports("avx2");
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#else
  return false;
#endif
}

std::vector<SimdBackend> available_simd_backends() {
  std::vector<SimdBackend> result;
  for (auto backend : {SimdBackend::portable, SimdBackend::avx2, SimdBackend::avx512})
    if (is_available(backend)) result.push_back(backend);
  return result;
}

SimdBackend default_simd_backend() {
  const char* name = std::getenv("SRMP_SIMD");
  if (name == nullptr || *name == '\0') return available_simd_backends().back();
  std::vector<std::string> known;
  for (auto backend : {SimdBackend::portable, SimdBackend::avx2, SimdBackend::avx512}) {
    known.push_back(to_string(backend));
    if (known.back() != name) continue;
    if (is_available(backend)) return backend;
    throw InvalidArgument("SRMP_SIMD is '" + known.back() + "', which this CPU does not have");
  }
  const std::string suggestion = did_you_mean(name, known);
  throw InvalidArgument("SRMP_SIMD is '" + std::string(name) + "'" +
                        (suggestion.empty() ? "; it may be " + quoted_list(known) : suggestion));
}

}  // namespace srmp
