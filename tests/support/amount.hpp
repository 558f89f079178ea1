#pragma once

/// How many random cases a test runs: all of them; one in ten where a sanitizer makes each ten to thirty times slower.
template <class Count>
constexpr Count amount(Count all) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return (all + 9) / 10;
#else
  return all;
#endif
}
