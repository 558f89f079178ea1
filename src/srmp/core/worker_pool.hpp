#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace srmp {

/// A few threads that run numbered jobs. Worker 0 is the caller. Which worker runs which job is fixed (job i goes to
/// worker i mod size), so scratch memory per worker sees the same jobs on every run.
class WorkerPool {
 public:
  /// Throws std::system_error when the system has no more threads.
  explicit WorkerPool(std::size_t workers);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  std::size_t size() const { return threads_.size() + 1; }
  /// Runs job(worker, i) for i = 0 … count-1 and returns when all are done. Jobs must not throw.
  void run(std::size_t count, const std::function<void(std::size_t worker, std::size_t i)>& job);

 private:
  void stop();
  void work(std::size_t worker);
  void run_share(std::size_t worker) const;

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
