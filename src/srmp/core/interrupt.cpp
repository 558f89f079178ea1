#include "srmp/core/interrupt.hpp"

#include <mutex>
#include <vector>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

constexpr auto poll_every = std::chrono::milliseconds(10);

thread_local InterruptScope* innermost_scope = nullptr;
thread_local bool is_background = false;

/// Threads whose results nobody waits for. They use libraries that must outlive them, so the process ends after them.
class AbandonedThreads {
 public:
  ~AbandonedThreads() {
    for (std::thread& thread : threads_) thread.join();
  }
  void add(std::thread thread) {
    const std::lock_guard lock(mutex_);
    threads_.push_back(std::move(thread));
  }

 private:
  std::mutex mutex_;
  std::vector<std::thread> threads_;
};

}  // namespace

InterruptScope::InterruptScope(std::function<void()> poll) : poll_(std::move(poll)), outer_(innermost_scope) {
  innermost_scope = this;
}

InterruptScope::~InterruptScope() { innermost_scope = outer_; }

void poll_interrupt() {
  InterruptScope* scope = innermost_scope;
  if (!scope || !scope->poll_) return;
  const auto now = Deadline::Clock::now();
  if (now < scope->next_) return;
  scope->next_ = now + poll_every;
  scope->poll_();
}

namespace detail {

bool can_be_interrupted() { return innermost_scope && innermost_scope->may_interrupt() && !is_background; }

BackgroundScope::BackgroundScope(const std::atomic<bool>& abandoned)
    : scope_([&abandoned] {
        if (abandoned) throw Error("the work was abandoned");  // seen by nobody
      }) {
  is_background = true;
}

BackgroundScope::~BackgroundScope() { is_background = false; }

void abandon(std::thread thread) {
  static AbandonedThreads threads;
  threads.add(std::move(thread));
}

}  // namespace detail

}  // namespace srmp
