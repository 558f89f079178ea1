#pragma once

#include <ctime>

namespace bench {

/// CPU time of this thread [s]. Static: objects of several instruction sets must not share it.
static inline double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace bench
