#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "srmp/core/deadline.hpp"
#include "srmp/core/worker_pool.hpp"

namespace srmp {

/// Runs numbered jobs on several threads. Results do not depend on the number of threads when each job writes to a
/// place of its own.
class Jobs {
 public:
  /// With one thread, or for one job, the calling thread runs the jobs; otherwise `threads` workers do, and the calling
  /// thread monitors them. No more workers are started than there are jobs.
  explicit Jobs(std::size_t threads) : threads_(threads) {}

  /// Runs job `i`. Its deadline passes when that of the whole run does, or a job before it has thrown.
  using Job = std::function<void(std::size_t i, const Deadline& deadline)>;
  /// Called by the calling thread when jobs end; `done` includes skipped jobs.
  using Progress = std::function<void(std::size_t done)>;
  /// Starts the jobs 0 … count-1 in order and returns when all have ended. When jobs throw, rethrows the exception of
  /// the one with the smallest index, whichever threw first: jobs after one that throws may be skipped or
  /// stopped, jobs before it never are. Only the calling thread checks `deadline` and calls `progress`; an exception of
  /// either stops all jobs.
  void run(std::size_t count, const Deadline& deadline, const Job& job, const Progress& progress = {});

 private:
  std::size_t threads_;
  std::unique_ptr<WorkerPool> pool_;  // null until it is needed
};

}  // namespace srmp
