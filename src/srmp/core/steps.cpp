#include "srmp/core/steps.hpp"

#include <chrono>
#include <thread>
#include <utility>
#include <vector>

#include "srmp/core/interruption.hpp"

namespace srmp {

namespace {

constexpr auto time_between_reports = std::chrono::milliseconds(10);

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
    : pool_(threads < 2 ? 1 : threads + 1), total_(total), progress_(std::move(progress)) {}

void Steps::report() const {
  if (interruption_check_) interruption_check_();
  if (progress_) progress_(done_, total_);
}

void Steps::work(std::size_t i, const std::function<void(std::size_t)>& step, std::exception_ptr& error) {
  if (stop_) return;
  try {
    const bool alone = pool_.size() == 1;
    const InterruptionScope scope([&] {
      if (stop_) throw StepStopped();
      if (alone) report();
    });
    if (alone) report();
    step(i);
    ++done_;
  } catch (...) {
    error = std::current_exception();
    stop_ = true;
  }
}

void Steps::monitor(const std::atomic<std::size_t>& working, std::exception_ptr& error) {
  while (working > 0) {
    try {
      if (!stop_) report();
    } catch (...) {
      error = std::current_exception();
      stop_ = true;
    }
    std::this_thread::sleep_for(time_between_reports);
  }
}

void Steps::run(std::size_t count, const std::function<void(std::size_t)>& step) {
  interruption_check_ = interruption_check();
  std::vector<std::exception_ptr> errors(count + 1);  // the last is the caller's
  if (pool_.size() == 1) {
    for (std::size_t i = 0; i < count; ++i) work(i, step, errors[i]);
  } else {
    std::atomic<std::size_t> next{0}, working{pool_.size() - 1};
    pool_.run(pool_.size(), [&](std::size_t worker, std::size_t) {
      if (worker == 0) return monitor(working, errors[count]);
      for (std::size_t i = next++; i < count; i = next++) work(i, step, errors[i]);
      --working;
    });
  }
  rethrow_first(errors);
  if (progress_) progress_(done_, total_);
}

}  // namespace srmp
