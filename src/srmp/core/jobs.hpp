#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "srmp/core/deadline.hpp"
#include "srmp/core/worker_pool.hpp"

namespace srmp {

/// Numbered jobs, a few at a time, whose results do not depend on how many that are: each writes to a place of its own.
class Jobs {
 public:
  /// With one thread, or for one job, the caller does them itself; else it keeps watch while they are done.
  /// No more threads are made than there are jobs.
  explicit Jobs(std::size_t threads) : threads_(threads) {}

  /// One job. Its deadline passes when that of all does.
  using Job = std::function<void(std::size_t i, const Deadline& deadline)>;
  /// Told by the calling thread as jobs end, those that were skipped too.
  using Progress = std::function<void(std::size_t done)>;
  /// Runs job 0 … count-1, begun in order, and returns when all are done. Throws what the first of them in order threw,
  /// though others may have been quicker to throw: jobs after one that throws may be skipped, jobs before it never are.
  /// `deadline` is asked, and `progress` called, by the calling thread alone; what they throw ends all.
  void run(std::size_t count, const Deadline& deadline, const Job& job, const Progress& progress = {});

 private:
  std::size_t threads_;
  std::unique_ptr<WorkerPool> pool_;  // null: not needed yet
};

}  // namespace srmp
