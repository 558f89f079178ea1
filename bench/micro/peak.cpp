// Compiled once for each instruction set, with the flags of its kernel; SRMP_PEAK is the function's name.

#include "peak.hpp"

#include <cstddef>

#include "cpu_seconds.hpp"
#include "srmp/collision/batch/simd-inl.hpp"

namespace bench {

namespace {

constexpr int rounds = 200'000, chains = 10;
alignas(64) float table[1024], sink[kWidth];

/// Operations a second, the best of several runs.
template <class Body>
double rate(double operations, Body&& body) {
  double best = 1e9;
  for (int i = 0; i < 7; ++i) {
    const double start = cpu_seconds();
    body();
    const double seconds = cpu_seconds() - start;
    if (seconds < best) best = seconds;  // std::min would be shared by objects of several instruction sets
  }
  return operations / best;
}

/// Applies `step` to independent chains, so that the latency of one hides behind the others.
template <class Step>
SRMP_INLINE void run_chains(float start, Step&& step) {
  V x[chains];
  for (int k = 0; k < chains; ++k) x[k] = all(start + 0.25f * static_cast<float>(k));  // equal ones would become one
  for (int i = 0; i < rounds; ++i)
    for (V& value : x) value = step(value);
  for (const V& value : x) store(sink, add(load(sink), value));
}

}  // namespace

Peak SRMP_PEAK() {
  for (std::size_t i = 0; i < 1024; ++i) table[i] = static_cast<float>(i * 37 % 1000);
  const V factor = all(0.999999f), term = all(1e-6f);
  Peak peak;
  peak.arithmetic =
      rate(2.0 * rounds * chains, [&] { run_chains(1.0f, [&](V x) { return add(mul(x, factor), term); }); });
  peak.square_root = rate(1.0 * rounds * chains, [&] { run_chains(2.0f, [](V x) { return sqrt(x); }); });
  peak.gather = rate(1.0 * rounds * chains, [&] { run_chains(3.0f, [](V x) { return gather(table, x); }); });
  return peak;
}

}  // namespace bench
