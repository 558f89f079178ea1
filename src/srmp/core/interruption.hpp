#pragma once

#include <chrono>
#include <functional>

namespace srmp {

/// Lets long computations be stopped without a parameter in each of their functions: while an object of this class
/// lives, interruption_point() of the same thread calls `check` about every 10 ms, and what it throws ends the
/// computation. Scopes nest; the innermost counts. An empty check never stops anything.
class InterruptionScope {
 public:
  explicit InterruptionScope(std::function<void()> check);
  ~InterruptionScope();
  InterruptionScope(const InterruptionScope&) = delete;
  InterruptionScope& operator=(const InterruptionScope&) = delete;

 private:
  friend void interruption_point();
  friend void rare_interruption_point();
  friend bool can_be_interrupted();
  friend std::function<void()> interruption_check();
  void call_check();

  static thread_local InterruptionScope* innermost_;
  std::function<void()> check_;
  InterruptionScope* outer_;
  unsigned calls_{};
  std::chrono::steady_clock::time_point next_;
};

/// To be called where a long computation may be stopped, at best every few microseconds.
void interruption_point();
/// The same for callers that come by rarely: reads the clock every time.
void rare_interruption_point();
/// Does this thread have a scope with a check?
bool can_be_interrupted();
/// The check of this thread's innermost scope; empty when there is none.
std::function<void()> interruption_check();

}  // namespace srmp
