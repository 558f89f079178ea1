#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <thread>

namespace srmp {

/// Work that nobody waits for: one thread of the process, of lower priority than others where the system has such, runs
/// jobs in the order in which they came. Thread-safe. A process that forks leaves the jobs with the parent.
class Background {
 public:
  /// A job returns soon after `stop` becomes true. What it throws is dropped.
  using Job = std::function<void(const std::atomic<bool>& stop)>;

  /// A job's handle. The destructor takes the job out of the queue, or stops it and waits for its end.
  class Ticket {
   public:
    Ticket() = default;
    Ticket(Ticket&&) noexcept = default;
    Ticket& operator=(Ticket&& other) noexcept;
    ~Ticket() { cancel(); }
    void cancel();

   private:
    friend class Background;
    struct Entry;
    struct Queue;
    std::shared_ptr<Queue> queue_;
    std::shared_ptr<Entry> entry_;
  };

  /// Begins to run the job, after those before it. Without threads (the system starts no more) the job never runs.
  static Ticket submit(Job job);
};

}  // namespace srmp
