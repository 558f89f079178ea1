#include "srmp/core/steps.hpp"

#include <algorithm>
#include <exception>
#include <utility>
#include <vector>

#include "srmp/core/interruption.hpp"

namespace srmp {

namespace {

/// Ends a step because another one has failed, which says why.
struct StepStopped {};

void rethrow_first(const std::vector<std::exception_ptr>& errors) {
  for (const std::exception_ptr& error : errors) {
    try {
      if (error) std::rethrow_exception(error);
    } catch (const StepStopped&) {
    }
  }
}

}  // namespace

Steps::Steps(std::size_t threads, std::size_t total, StepProgress progress)
    : pool_(std::max<std::size_t>(1, threads)), total_(total), progress_(std::move(progress)) {}

void Steps::check(std::size_t worker) {
  if (stop_) throw StepStopped();
  if (worker == 0 && progress_) progress_(done_, total_);
}

void Steps::run(std::size_t count, const std::function<void(std::size_t)>& step) {
  std::vector<std::exception_ptr> errors(count);
  pool_.run(count, [&](std::size_t worker, std::size_t i) {
    if (stop_) return;
    try {
      check(worker);
      const InterruptionScope scope([&] { check(worker); });
      step(i);
      ++done_;
    } catch (...) {
      errors[i] = std::current_exception();
      stop_ = true;
    }
  });
  rethrow_first(errors);
  if (progress_) progress_(done_, total_);
}

}  // namespace srmp
