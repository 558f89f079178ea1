#include "srmp/core/background.hpp"

#include <unistd.h>

#include <system_error>
#include <utility>

#ifdef __linux__
#include <sys/resource.h>
#endif

namespace srmp {

struct Background::Ticket::Entry {
  Job job;
  std::atomic<bool> stop{false};
};

/// The jobs of one process, and the thread that runs them; the thread exists while there are jobs.
struct Background::Ticket::Queue {
  ~Queue() { stop(); }

  void add(std::shared_ptr<Entry> entry) {
    const std::lock_guard lock(mutex);
    entries.push_back(std::move(entry));
    if (!running) start();
  }

  void cancel(const std::shared_ptr<Entry>& entry) {
    entry->stop = true;
    std::unique_lock lock(mutex);
    entries.remove(entry);
    changed.wait(lock, [&] { return current != entry; });
  }

  /// Stops all jobs and the thread.
  void stop() {
    if (process != getpid()) {  // the thread is the parent's
      if (thread.joinable()) thread.detach();
      return;
    }
    {
      const std::lock_guard lock(mutex);
      entries.clear();
      if (current) current->stop = true;
    }
    if (thread.joinable()) thread.join();
  }

  const pid_t process{getpid()};

 private:
  void start() {
    if (thread.joinable()) thread.join();  // it has ended, or is about to
    try {
      thread = std::thread([this] { run(); });
      running = true;
    } catch (const std::system_error&) {
      entries.clear();
    }
  }

  void run() {
#ifdef __linux__
    setpriority(PRIO_PROCESS, 0, 10);  // of this thread: so Linux has it
#endif
    std::unique_lock lock(mutex);
    while (!entries.empty()) {
      current = std::move(entries.front());
      entries.pop_front();
      lock.unlock();
      try {
        if (!current->stop) current->job(current->stop);
      } catch (...) {  // nobody waits for the job, and without it all results are the same
      }
      current->job = nullptr;  // with what it holds
      lock.lock();
      current.reset();
      changed.notify_all();
    }
    running = false;
  }

  std::mutex mutex;
  std::condition_variable changed;
  std::list<std::shared_ptr<Entry>> entries;
  std::shared_ptr<Entry> current;
  bool running{false};
  std::thread thread;
};

Background::Ticket& Background::Ticket::operator=(Ticket&& other) noexcept {
  cancel();
  queue_ = std::move(other.queue_);
  entry_ = std::move(other.entry_);
  return *this;
}

void Background::Ticket::cancel() {
  if (entry_ && queue_->process == getpid()) queue_->cancel(entry_);
  entry_.reset();
  queue_.reset();
}

Background::Ticket Background::submit(Job job) {
  static std::mutex mutex;
  static std::shared_ptr<Ticket::Queue> queue;
  Ticket ticket;
  ticket.entry_ = std::make_shared<Ticket::Entry>();
  ticket.entry_->job = std::move(job);
  const std::lock_guard lock(mutex);
  if (queue && queue->process != getpid()) new std::shared_ptr(queue);  // never destroyed: its locks are the parent's
  if (!queue || queue->process != getpid()) queue = std::make_shared<Ticket::Queue>();
  ticket.queue_ = queue;
  queue->add(ticket.entry_);
  return ticket;
}

}  // namespace srmp
