#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <future>
#include <memory>
#include <thread>
#include <utility>

#include "srmp/core/deadline.hpp"

namespace srmp {

// Long work that no Deadline limits, such as reading a mesh, can be stopped by its caller: by Ctrl-C in Python.

/// While it lives, poll_interrupt in this thread calls `poll`, at most every 10 ms. `poll` throws to stop the work; an
/// empty one means that nothing stops it. Scopes nest, and the innermost counts.
class InterruptScope {
 public:
  explicit InterruptScope(std::function<void()> poll);
  ~InterruptScope();
  InterruptScope(const InterruptScope&) = delete;
  InterruptScope& operator=(const InterruptScope&) = delete;
  bool may_interrupt() const { return static_cast<bool>(poll_); }

 private:
  friend void poll_interrupt();
  std::function<void()> poll_;
  Deadline::Clock::time_point next_{};
  InterruptScope* outer_;
};

/// Throws what the scope of this thread throws when the caller wants to stop. Cheap enough for inner loops.
void poll_interrupt();

namespace detail {

/// Does this thread have a scope that may stop its work, without being the thread of a background job itself?
bool can_be_interrupted();

/// Marks this thread as that of a background job, whose poll_interrupt throws once `abandoned`.
class BackgroundScope {
 public:
  explicit BackgroundScope(const std::atomic<bool>& abandoned);
  ~BackgroundScope();

 private:
  InterruptScope scope_;
};

/// Lets the thread end by itself; the process waits for it before it ends.
void abandon(std::thread thread);

}  // namespace detail

/// Returns job(). When the thread can be interrupted, the job runs in a thread of its own while this one polls, because
/// libraries such as assimp and Coal cannot be stopped: this function then throws at once, and the job ends at its next
/// poll_interrupt, or with its work. So the job must own all that it uses.
template <class Job>
auto run_interruptibly(Job job) -> decltype(job()) {
  constexpr auto period = std::chrono::milliseconds(10);
  if (!detail::can_be_interrupted()) return job();
  const auto abandoned = std::make_shared<std::atomic<bool>>(false);
  std::packaged_task<decltype(job())()> task([job = std::move(job), abandoned]() mutable {
    const detail::BackgroundScope scope(*abandoned);
    return job();
  });
  auto result = task.get_future();
  std::thread thread(std::move(task));
  try {
    while (result.wait_for(period) != std::future_status::ready) poll_interrupt();
  } catch (...) {
    *abandoned = true;
    detail::abandon(std::move(thread));
    throw;
  }
  thread.join();
  return result.get();
}

}  // namespace srmp
