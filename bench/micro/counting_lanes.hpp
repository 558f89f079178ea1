// Lanes of float32 that count the operations on them: what simd-inl.hpp has, with its values. Included inside of its
// namespace; kernel_operations is declared before. SRMP_WIDTH is the number of lanes.

constexpr int kWidth = SRMP_WIDTH;
struct V {
  float lane[kWidth]{};
};
struct M {
  unsigned lanes{};
};

template <class F>
V each(F&& f) {
  V result;
  for (int i = 0; i < kWidth; ++i) result.lane[i] = f(i);
  return result;
}
template <class F>
M where(F&& f) {
  M result;
  for (int i = 0; i < kWidth; ++i) result.lanes |= static_cast<unsigned>(f(i)) << i;
  return result;
}
inline void count_arithmetic() { ++kernel_operations.arithmetic; }

inline V load(const float* p) {
  return each([&](int i) { return p[i]; });
}
inline V load_any(const float* p) { return load(p); }
inline void store(float* p, V a) {
  for (int i = 0; i < kWidth; ++i) p[i] = a.lane[i];
}
inline V all(float x) {
  return each([&](int) { return x; });
}
inline V add(V a, V b) {
  return count_arithmetic(), each([&](int i) { return a.lane[i] + b.lane[i]; });
}
inline V sub(V a, V b) {
  return count_arithmetic(), each([&](int i) { return a.lane[i] - b.lane[i]; });
}
inline V mul(V a, V b) {
  return count_arithmetic(), each([&](int i) { return a.lane[i] * b.lane[i]; });
}
inline V quotient(V a, V b) {
  return count_arithmetic(), each([&](int i) { return a.lane[i] / b.lane[i]; });
}
inline V max0(V a) {
  return count_arithmetic(), each([&](int i) { return a.lane[i] > 0.0f ? a.lane[i] : 0.0f; });
}
inline V min(V a, V b) {
  return count_arithmetic(), each([&](int i) { return std::min(a.lane[i], b.lane[i]); });
}
inline V max(V a, V b) {
  return count_arithmetic(), each([&](int i) { return std::max(a.lane[i], b.lane[i]); });
}
/// Counted as what a tree of exchanges takes.
template <class F>
V of_lanes(V a, F&& f) {
  float result = a.lane[0];
  for (int i = 1; i < kWidth; i *= 2) count_arithmetic();
  for (const float x : a.lane) result = f(result, x);
  return all(result);
}
inline V lowest(V a) {
  return of_lanes(a, [](float x, float y) { return std::min(x, y); });
}
inline V highest(V a) {
  return of_lanes(a, [](float x, float y) { return std::max(x, y); });
}
inline V truncate(V a) {
  return count_arithmetic(), each([&](int i) { return std::trunc(a.lane[i]); });
}
inline V abs(V a) {
  return count_arithmetic(), each([&](int i) { return std::fabs(a.lane[i]); });
}
inline V gather(const float* p, V index) {
  return ++kernel_operations.gather, each([&](int i) { return p[static_cast<int>(index.lane[i])]; });
}
inline V sqrt(V a) {
  return ++kernel_operations.square_root, each([&](int i) { return std::sqrt(a.lane[i]); });
}
inline M less(V a, V b) {
  return count_arithmetic(), where([&](int i) { return a.lane[i] < b.lane[i]; });
}
inline M not_greater(V a, V b) {
  return count_arithmetic(), where([&](int i) { return !(a.lane[i] > b.lane[i]); });
}
inline M either(M a, M b) { return count_arithmetic(), M{a.lanes | b.lanes}; }
inline V choose(M m, V a, V b) {
  return count_arithmetic(), each([&](int i) { return m.lanes >> i & 1u ? a.lane[i] : b.lane[i]; });
}
inline unsigned bits(M m) { return m.lanes; }
