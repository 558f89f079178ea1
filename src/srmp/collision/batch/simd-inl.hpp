// Lanes of float32 for one instruction set, chosen by the flags of the including file. Every operation is exactly
// rounded and none is fused, so all instruction sets give the same bits. No include guard: once per kernel file.

#if defined(__AVX512F__)
#include <immintrin.h>
#elif defined(__AVX2__)
#include <immintrin.h>
#endif

namespace {

#define SRMP_INLINE inline __attribute__((always_inline))

#if defined(SRMP_LANES)  // lanes of another kind, such as those that count (bench/micro/counted_kernel.cpp)
#include SRMP_LANES
#elif defined(__AVX512F__)

constexpr int kWidth = 16;
using V = __m512;
using M = __mmask16;
SRMP_INLINE V load(const float* p) { return _mm512_load_ps(p); }
SRMP_INLINE V load_any(const float* p) { return _mm512_loadu_ps(p); }  // not aligned
SRMP_INLINE void store(float* p, V a) { _mm512_store_ps(p, a); }
SRMP_INLINE V all(float x) { return _mm512_set1_ps(x); }
SRMP_INLINE V add(V a, V b) { return _mm512_add_ps(a, b); }
SRMP_INLINE V sub(V a, V b) { return _mm512_sub_ps(a, b); }
SRMP_INLINE V mul(V a, V b) { return _mm512_mul_ps(a, b); }
SRMP_INLINE V quotient(V a, V b) { return _mm512_div_ps(a, b); }
SRMP_INLINE V max0(V a) { return _mm512_max_ps(a, _mm512_setzero_ps()); }
SRMP_INLINE V min(V a, V b) { return _mm512_min_ps(a, b); }
SRMP_INLINE V max(V a, V b) { return _mm512_max_ps(a, b); }
SRMP_INLINE V lowest(V a) { return all(_mm512_reduce_min_ps(a)); }  // of all lanes, in every lane
SRMP_INLINE V highest(V a) { return all(_mm512_reduce_max_ps(a)); }
SRMP_INLINE V truncate(V a) { return _mm512_roundscale_ps(a, _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC); }
SRMP_INLINE V gather(const float* p, V index) { return _mm512_i32gather_ps(_mm512_cvttps_epi32(index), p, 4); }
SRMP_INLINE V abs(V a) { return _mm512_abs_ps(a); }
SRMP_INLINE V sqrt(V a) { return _mm512_sqrt_ps(a); }
SRMP_INLINE M less(V a, V b) { return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ); }
SRMP_INLINE M not_greater(V a, V b) { return _mm512_cmp_ps_mask(a, b, _CMP_NGT_UQ); }
SRMP_INLINE M either(M a, M b) { return a | b; }
SRMP_INLINE V choose(M m, V a, V b) { return _mm512_mask_blend_ps(m, b, a); }
SRMP_INLINE unsigned bits(M m) { return m; }

#elif defined(__AVX2__)

constexpr int kWidth = 8;
using V = __m256;
using M = __m256;
SRMP_INLINE V load(const float* p) { return _mm256_load_ps(p); }
SRMP_INLINE V load_any(const float* p) { return _mm256_loadu_ps(p); }
SRMP_INLINE void store(float* p, V a) { _mm256_store_ps(p, a); }
SRMP_INLINE V all(float x) { return _mm256_set1_ps(x); }
SRMP_INLINE V add(V a, V b) { return _mm256_add_ps(a, b); }
SRMP_INLINE V sub(V a, V b) { return _mm256_sub_ps(a, b); }
SRMP_INLINE V mul(V a, V b) { return _mm256_mul_ps(a, b); }
SRMP_INLINE V quotient(V a, V b) { return _mm256_div_ps(a, b); }
SRMP_INLINE V max0(V a) { return _mm256_max_ps(a, _mm256_setzero_ps()); }
SRMP_INLINE V min(V a, V b) { return _mm256_min_ps(a, b); }
SRMP_INLINE V max(V a, V b) { return _mm256_max_ps(a, b); }
template <class Op>
SRMP_INLINE V of_lanes(V a, Op&& op) {
  a = op(a, _mm256_permute2f128_ps(a, a, 1));
  a = op(a, _mm256_permute_ps(a, 0x4e));
  return op(a, _mm256_permute_ps(a, 0xb1));
}
SRMP_INLINE V lowest(V a) { return of_lanes(a, min); }
SRMP_INLINE V highest(V a) { return of_lanes(a, max); }
SRMP_INLINE V truncate(V a) { return _mm256_round_ps(a, _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC); }
SRMP_INLINE V gather(const float* p, V index) { return _mm256_i32gather_ps(p, _mm256_cvttps_epi32(index), 4); }
SRMP_INLINE V abs(V a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a); }
SRMP_INLINE V sqrt(V a) { return _mm256_sqrt_ps(a); }
SRMP_INLINE M less(V a, V b) { return _mm256_cmp_ps(a, b, _CMP_LT_OQ); }
SRMP_INLINE M not_greater(V a, V b) { return _mm256_cmp_ps(a, b, _CMP_NGT_UQ); }
SRMP_INLINE M either(M a, M b) { return _mm256_or_ps(a, b); }
SRMP_INLINE V choose(M m, V a, V b) { return _mm256_blendv_ps(b, a, m); }
SRMP_INLINE unsigned bits(M m) { return static_cast<unsigned>(_mm256_movemask_ps(m)); }

#else

constexpr int kWidth = 4;
typedef float V __attribute__((vector_size(16)));
typedef int M __attribute__((vector_size(16)));
SRMP_INLINE V load(const float* p) { return *reinterpret_cast<const V*>(p); }
SRMP_INLINE V load_any(const float* p) { return V{p[0], p[1], p[2], p[3]}; }
SRMP_INLINE void store(float* p, V a) { *reinterpret_cast<V*>(p) = a; }
SRMP_INLINE V all(float x) { return V{x, x, x, x}; }
SRMP_INLINE V add(V a, V b) { return a + b; }
SRMP_INLINE V sub(V a, V b) { return a - b; }
SRMP_INLINE V mul(V a, V b) { return a * b; }
SRMP_INLINE V quotient(V a, V b) { return a / b; }
SRMP_INLINE M less(V a, V b) { return a < b; }
SRMP_INLINE M not_greater(V a, V b) { return ~(a > b); }
SRMP_INLINE M either(M a, M b) { return a | b; }
SRMP_INLINE V choose(M m, V a, V b) { return (V)((m & (M)a) | (~m & (M)b)); }
SRMP_INLINE V max0(V a) { return choose(a > V{}, a, V{}); }
SRMP_INLINE V min(V a, V b) { return choose(a < b, a, b); }
SRMP_INLINE V max(V a, V b) { return choose(a > b, a, b); }
SRMP_INLINE V lowest(V a) {
  a = min(a, V{a[2], a[3], a[0], a[1]});
  return min(a, V{a[1], a[0], a[3], a[2]});
}
SRMP_INLINE V highest(V a) { return V{} - lowest(-a); }
SRMP_INLINE V truncate(V a) { return __builtin_convertvector(__builtin_convertvector(a, M), V); }
SRMP_INLINE V gather(const float* p, V index) {
  const M i = __builtin_convertvector(index, M);
  return V{p[i[0]], p[i[1]], p[i[2]], p[i[3]]};
}
SRMP_INLINE V abs(V a) { return (V)((M)a & M{0x7fffffff, 0x7fffffff, 0x7fffffff, 0x7fffffff}); }
SRMP_INLINE V sqrt(V a) {
  return V{__builtin_sqrtf(a[0]), __builtin_sqrtf(a[1]), __builtin_sqrtf(a[2]), __builtin_sqrtf(a[3])};
}
SRMP_INLINE unsigned bits(M m) {
  return (static_cast<unsigned>(m[0]) & 1u) | (static_cast<unsigned>(m[1]) & 2u) | (static_cast<unsigned>(m[2]) & 4u) |
         (static_cast<unsigned>(m[3]) & 8u);
}

#endif

SRMP_INLINE V sum(V a, V b, V c) { return add(add(a, b), c); }

/// Nearest integer, for |a| < 2^22.
SRMP_INLINE V round(V a) { return sub(add(a, all(12582912.0f)), all(12582912.0f)); }

struct SinCos {
  V sin, cos;
};

/// Sine and cosine of |x| <= 8, within 2.5e-7. Cody-Waite reduction to a quarter turn, then minimax polynomials.
SRMP_INLINE SinCos sincos(V x) {
  const V n = round(mul(x, all(0.63661977236758134f)));
  V r = sub(x, mul(n, all(1.5703125f)));  // pi/2 in three parts; the products are exact
  r = sub(r, mul(n, all(4.837512969970703125e-4f)));
  r = sub(r, mul(n, all(7.549789954891882e-8f)));
  const V r2 = mul(r, r);
  V s = add(mul(all(-1.9515295891e-4f), r2), all(8.3321608736e-3f));
  s = add(mul(s, r2), all(-1.6666654611e-1f));
  s = add(mul(mul(s, r2), r), r);
  V c = add(mul(all(2.443315711809948e-5f), r2), all(-1.388731625493765e-3f));
  c = add(mul(c, r2), all(4.166664568298827e-2f));
  c = add(sub(mul(mul(c, r2), r2), mul(all(0.5f), r2)), all(1.0f));
  const V quarter = sub(n, mul(all(4.0f), round(mul(n, all(0.25f)))));  // -2 .. 2
  const V odd = sub(abs(quarter), all(1.0f));
  const M swapped = less(abs(odd), all(0.5f));
  const V a = choose(swapped, c, s), b = choose(swapped, s, c);
  const V minus_a = sub(V{}, a), minus_b = sub(V{}, b);
  return {choose(either(less(quarter, all(-0.5f)), less(all(1.5f), quarter)), minus_a, a),
          choose(either(less(all(0.5f), quarter), less(quarter, all(-1.5f))), minus_b, b)};
}

}  // namespace
