#pragma once

namespace bench {

/// What an instruction set can do at best, in operations on a vector of float32 a second of CPU time: independent
/// additions and multiplications, square roots, and gathers from a table in the cache.
struct Peak {
  double arithmetic{}, square_root{}, gather{};
};

Peak peak_portable();
Peak peak_avx2();
Peak peak_avx512();

}  // namespace bench
