#pragma once

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <thread>
#include <utility>

#include "srmp/core/interruption.hpp"

namespace srmp {

namespace detail {

/// Does this thread have a scope that may stop its work, without being the thread of run_interruptibly itself?
bool needs_thread();

/// Marks this thread as that of run_interruptibly; its interruption_point throws once `abandoned`.
class AbandonedScope {
 public:
  explicit AbandonedScope(const std::atomic<bool>& abandoned);
  ~AbandonedScope();

 private:
  InterruptionScope scope_;
};

/// Lets the thread end by itself; the process waits for it before it ends.
void abandon(std::thread thread);

}  // namespace detail

/// Returns job(). Where the thread has an InterruptionScope, the job runs in a thread of its own while this one checks,
/// because libraries such as assimp and Coal cannot be stopped: this function then throws at once, and the job ends at
/// its next interruption_point, or with its work. So the job must own all that it uses.
template <class Job>
auto run_interruptibly(Job job) -> decltype(job()) {
  constexpr auto period = std::chrono::milliseconds(10);
  if (!detail::needs_thread()) return job();
  const auto abandoned = std::make_shared<std::atomic<bool>>(false);
  std::packaged_task<decltype(job())()> task([job = std::move(job), abandoned]() mutable {
    const detail::AbandonedScope scope(*abandoned);
    return job();
  });
  auto result = task.get_future();
  std::thread thread(std::move(task));
  try {
    while (result.wait_for(period) != std::future_status::ready) rare_interruption_point();
  } catch (...) {
    *abandoned = true;
    detail::abandon(std::move(thread));
    throw;
  }
  thread.join();
  return result.get();
}

}  // namespace srmp
