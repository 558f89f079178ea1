#include "srmp/core/jobs.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>

namespace srmp {

namespace {

constexpr auto monitor_period = std::chrono::milliseconds(10);

/// One call of Jobs::run with several threads: each worker takes the next job, and the caller monitors the deadline and
/// the progress.
class SharedJobs {
 public:
  SharedJobs(std::size_t count, const Deadline& deadline, const Jobs::Job& job, const Jobs::Progress& progress)
      : count_(count), deadline_(deadline), job_(job), progress_(progress), failed_(count) {}

  void run(WorkerPool& pool) {
    stop_ = deadline_.cancelled();
    pool.run(pool.size(), [this](std::size_t worker, std::size_t) { worker == 0 ? monitor() : work(); });
    for (const std::exception_ptr& error : {monitor_error_, error_})
      if (error) std::rethrow_exception(error);
  }

 private:
  void work() {
    for (std::size_t i; (i = next_++) < count_;) {
      try {
        if (i < failed_) job_(i, deadline_.interrupted_by([this, i] { return stop_ || i > failed_; }));
      } catch (...) {
        note_error(i, std::current_exception());
      }
      const std::lock_guard lock(mutex_);
      ++done_;
      changed_.notify_one();
    }
  }

  void note_error(std::size_t i, std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    if (i >= failed_) return;
    failed_ = i;
    error_ = std::move(error);
  }

  void monitor() {
    std::unique_lock lock(mutex_);
    for (std::size_t reported = 0; reported < count_;) {
      changed_.wait_for(lock, monitor_period, [&] { return done_ > reported; });
      const std::size_t done = done_;
      lock.unlock();
      if (!stop_) report(done, done > reported);
      reported = done;
      lock.lock();
    }
  }

  void report(std::size_t done, bool has_progress) {
    try {
      stop_ = deadline_.cancelled();
      if (has_progress && progress_ && !stop_) progress_(done);
    } catch (...) {
      monitor_error_ = std::current_exception();
      stop_ = true;
    }
  }

  const std::size_t count_;
  const Deadline& deadline_;
  const Jobs::Job& job_;
  const Jobs::Progress& progress_;
  std::atomic<std::size_t> next_{0};
  std::atomic<std::size_t> failed_;  // the smallest index of a job that failed; count_ when none did
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t done_{0};
  std::exception_ptr error_, monitor_error_;
};

}  // namespace

void Jobs::run(std::size_t count, const Deadline& deadline, const Job& job, const Progress& progress) {
  if (const std::size_t workers = std::min(threads_, count); workers > 1) {
    if (!pool_ || pool_->size() <= workers) pool_ = std::make_unique<WorkerPool>(workers + 1);
    return SharedJobs(count, deadline, job, progress).run(*pool_);
  }
  for (std::size_t i = 0; i < count; ++i) {
    job(i, deadline);
    if (progress && !deadline.cancelled()) progress(i + 1);
  }
}

}  // namespace srmp
