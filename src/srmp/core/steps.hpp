#pragma once

#include <atomic>
#include <cstddef>
#include <functional>

#include "srmp/core/jobs.hpp"

namespace srmp {

/// Called often, with the number of steps that are done and of all steps. An exception ends the computation within
/// 0.1 s and passes through.
using StepProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Runs the numbered steps of a long computation as Jobs, which stop at an interruption_point(). Only the calling
/// thread reports progress, when a step ends and about every 10 ms, and calls the check of its InterruptionScope: with
/// one thread within the steps, with several while these work.
class Steps {
 public:
  /// `progress` may be empty.
  Steps(std::size_t threads, std::size_t total, StepProgress progress);

  /// Runs step(i) for i = 0 … count-1 and returns when all have ended. Exceptions as in Jobs::run; the other steps end
  /// early.
  void run(std::size_t count, const std::function<void(std::size_t)>& step);

 private:
  Jobs jobs_;
  const std::size_t total_;
  const StepProgress progress_;
  std::atomic<std::size_t> done_{0};
};

}  // namespace srmp
