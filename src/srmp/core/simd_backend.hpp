#pragma once

#include <string>
#include <vector>

namespace srmp {

/// Instruction sets for which kernels are compiled. All give the same bits.
enum class SimdBackend { portable, avx2, avx512 };
std::string to_string(SimdBackend backend);
/// Does this CPU have it?
bool is_available(SimdBackend backend);
std::vector<SimdBackend> available_simd_backends();
/// The best that this CPU has, or what the environment variable SRMP_SIMD names. Throws InvalidArgument when it names
/// none, or one that this CPU lacks.
SimdBackend default_simd_backend();

}  // namespace srmp
