#include "srmp/core/steps.hpp"

#include <limits>
#include <utility>

#include "srmp/core/interruption.hpp"

namespace srmp {

namespace {

/// Ends a step because another one has failed, which says why.
struct StepStopped {};

}  // namespace

Steps::Steps(std::size_t threads, std::size_t total, StepProgress progress)
    : jobs_(threads), total_(total), progress_(std::move(progress)) {}

void Steps::run(std::size_t count, const std::function<void(std::size_t)>& step) {
  const auto report = [this] {
    if (progress_) progress_(done_, total_);
  };
  const std::function<void()> check = interruption_check();
  const Deadline deadline(std::numeric_limits<double>::infinity(), [&] {
    if (check) check();
    report();
    return false;
  });
  const auto run_step = [&](std::size_t i, const Deadline& until) {
    const InterruptionScope scope([&until] {
      if (until.cancelled()) throw StepStopped();
    });
    step(i);
    ++done_;
  };
  jobs_.run(count, deadline, run_step, [&](std::size_t) { report(); });
}

}  // namespace srmp
