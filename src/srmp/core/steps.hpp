#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>

#include "srmp/core/worker_pool.hpp"

namespace srmp {

/// Called often, with the number of steps that are done and of all steps. An exception ends the computation within
/// 0.1 s and passes through.
using StepProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Runs the numbered steps of a long computation on several threads. Only the calling thread reports progress, about
/// every 10 ms, and calls the check of its InterruptionScope: with one thread between steps and within them at each
/// interruption_point(), with several while these work. Of several exceptions, that of the step with the smallest index
/// is rethrown, and the others end early.
class Steps {
 public:
  /// At least one thread. `progress` may be empty.
  Steps(std::size_t threads, std::size_t total, StepProgress progress);

  /// Runs step(i) for i = 0 … count-1 and returns when all have ended.
  void run(std::size_t count, const std::function<void(std::size_t)>& step);

 private:
  void report() const;
  void work(std::size_t i, const std::function<void(std::size_t)>& step, std::exception_ptr& error);
  void monitor(const std::atomic<std::size_t>& working, std::exception_ptr& error);

  WorkerPool pool_;
  const std::size_t total_;
  const StepProgress progress_;
  std::atomic<std::size_t> done_{0};
  std::atomic<bool> stop_{false};
  std::function<void()> interruption_check_;  // the caller's
};

}  // namespace srmp
