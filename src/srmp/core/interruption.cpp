#include "srmp/core/interruption.hpp"

#include <utility>

namespace srmp {

namespace {

constexpr auto time_between_checks = std::chrono::milliseconds(10);
constexpr unsigned calls_per_clock = 64;  // reading the clock takes longer than many a step between two calls

}  // namespace

thread_local InterruptionScope* InterruptionScope::innermost_ = nullptr;

InterruptionScope::InterruptionScope(std::function<void()> check)
    : check_(std::move(check)), outer_(innermost_), next_(std::chrono::steady_clock::now() + time_between_checks) {
  innermost_ = this;
}

InterruptionScope::~InterruptionScope() { innermost_ = outer_; }

void InterruptionScope::call_check() {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + time_between_checks;
  if (check_) check_();
}

void interruption_point() {
  InterruptionScope* scope = InterruptionScope::innermost_;
  if (scope != nullptr && ++scope->calls_ % calls_per_clock == 0) scope->call_check();
}

void rare_interruption_point() {
  if (InterruptionScope::innermost_ != nullptr) InterruptionScope::innermost_->call_check();
}

bool can_be_interrupted() {
  return InterruptionScope::innermost_ != nullptr && InterruptionScope::innermost_->check_ != nullptr;
}

std::function<void()> interruption_check() {
  return InterruptionScope::innermost_ ? InterruptionScope::innermost_->check_ : std::function<void()>();
}

}  // namespace srmp
