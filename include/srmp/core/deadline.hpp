#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <utility>

namespace srmp {

/// The time limit that all phases of one request share, together with the caller's request to stop.
///
/// The clock decides when to stop and nothing else: nobody is told how much time is left, so that nothing can be given
/// a fraction of it, and a request has one answer for all limits that it does not reach. The callback `interrupted`
/// (may be empty) returns whether the caller wants to stop. It is called at most every 5 ms, always from the thread
/// that calls cancelled() or stop_requested(); Python uses it for Ctrl-C. What it throws passes through. Not
/// thread-safe.
class Deadline {
 public:
  /// A monotonic clock.
  using Clock = std::chrono::steady_clock;
  /// Returns true when the caller wants to stop.
  using Interrupt = std::function<bool()>;

  /// Never expires.
  Deadline() = default;
  /// Expires `seconds` [s] from now; infinity means never.
  explicit Deadline(double seconds, Interrupt interrupted = {});

  /// The same clock and limit, but passes `seconds` [s] from now if that is earlier; infinity changes nothing. It must
  /// not outlive this one, whose callback it calls.
  Deadline within(double seconds) const;
  /// The same, but passes `seconds` [s] later.
  Deadline extended(double seconds) const;
  /// The same with another callback, which may be called by another thread.
  Deadline interrupted_by(Interrupt interrupted) const;

  double elapsed() const;  ///< [s] since the construction of the first one
  /// Has the time limit passed?
  bool expired() const { return elapsed() >= limit_; }
  /// Has the caller requested to stop? Once true, it stays true.
  bool cancelled() const;
  /// expired() or cancelled().
  bool stop_requested() const { return expired() || cancelled(); }

 private:
  Deadline with_limit(double limit, Interrupt interrupted) const;

  Clock::time_point start_{Clock::now()};
  double limit_{std::numeric_limits<double>::infinity()};
  Interrupt interrupted_;
  mutable Clock::time_point next_poll_{};
  mutable bool cancelled_{false};
};

}  // namespace srmp
