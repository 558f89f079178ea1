#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace srmp {

/// A pool of threads that run numbered jobs; worker 0 is the calling thread. Job i always runs on worker i mod size(),
/// so that the scratch memory of a worker is used by the same jobs on every run.
class WorkerPool {
 public:
  /// Starts workers - 1 threads. Throws std::system_error when the system cannot start them.
  explicit WorkerPool(std::size_t workers);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// The number of workers, at least 1.
  std::size_t size() const { return threads_.size() + 1; }
  /// Runs job(worker, i) for i = 0 … count-1 and returns when all have ended. Jobs must not throw.
  void run(std::size_t count, const std::function<void(std::size_t worker, std::size_t i)>& job);

 private:
  void stop();
  void work(std::size_t worker);
  void run_jobs_of(std::size_t worker) const;

  std::mutex mutex_;
  std::condition_variable start_, done_;
  const std::function<void(std::size_t, std::size_t)>* job_{nullptr};
  std::size_t count_{0};
  std::size_t round_{0};
  std::size_t running_{0};
  bool stop_{false};
  std::vector<std::thread> threads_;
};

}  // namespace srmp
