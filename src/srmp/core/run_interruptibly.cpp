#include "srmp/core/run_interruptibly.hpp"

#include <unistd.h>

#include <mutex>
#include <vector>

#include "srmp/core/error.hpp"

namespace srmp::detail {

namespace {

thread_local bool is_own_thread = false;

/// Threads whose results nobody waits for. They use libraries that must outlive them, so the process ends after them.
class AbandonedThreads {
 public:
  ~AbandonedThreads() {
    for (std::thread& thread : threads_)
      if (process_ == getpid())
        thread.join();
      else
        thread.detach();  // it runs in the parent process only
  }
  void add(std::thread thread) {
    const std::lock_guard lock(mutex_);
    threads_.push_back(std::move(thread));
  }

 private:
  const pid_t process_{getpid()};
  std::mutex mutex_;
  std::vector<std::thread> threads_;
};

}  // namespace

bool needs_thread() { return can_be_interrupted() && !is_own_thread; }

AbandonedScope::AbandonedScope(const std::atomic<bool>& abandoned)
    : scope_([&abandoned] {
        if (abandoned) throw Error("the work was abandoned");  // seen by nobody
      }) {
  is_own_thread = true;
}

AbandonedScope::~AbandonedScope() { is_own_thread = false; }

void abandon(std::thread thread) {
  static AbandonedThreads threads;
  threads.add(std::move(thread));
}

}  // namespace srmp::detail
