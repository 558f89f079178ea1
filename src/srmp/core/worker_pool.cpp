#include "srmp/core/worker_pool.hpp"

#include "srmp/core/interruption.hpp"

namespace srmp {

WorkerPool::WorkerPool(std::size_t workers) {
  try {
    for (std::size_t worker = 1; worker < workers; ++worker) threads_.emplace_back([this, worker] { work(worker); });
  } catch (...) {  // the system cannot start more threads
    stop();
    throw;
  }
}

WorkerPool::~WorkerPool() { stop(); }

void WorkerPool::stop() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  start_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::run_jobs_of(std::size_t worker) const {
  for (std::size_t i = worker; i < count_; i += size()) (*job_)(worker, i);
}

void WorkerPool::run(std::size_t count, const std::function<void(std::size_t, std::size_t)>& job) {
  const InterruptionScope jobs_must_not_throw({});
  if (count < 2 || threads_.empty()) {
    for (std::size_t i = 0; i < count; ++i) job(0, i);
    return;
  }
  {
    const std::lock_guard lock(mutex_);
    job_ = &job;
    count_ = count;
    running_ = threads_.size();
    ++round_;
  }
  start_.notify_all();
  run_jobs_of(0);
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return running_ == 0; });
}

void WorkerPool::work(std::size_t worker) {
  std::size_t seen = 0;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      start_.wait(lock, [&] { return stop_ || round_ != seen; });
      if (stop_) return;
      seen = round_;
    }
    run_jobs_of(worker);
    {
      const std::lock_guard lock(mutex_);
      --running_;
    }
    done_.notify_one();
  }
}

}  // namespace srmp
