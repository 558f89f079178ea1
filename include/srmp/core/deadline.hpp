#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <utility>

namespace srmp {

/// The time limit that all phases of one request share, together with the caller's request to stop.
///
/// The clock decides when to stop and nothing else. The callback `interrupted` (may be empty) returns whether the
/// caller wants to stop. It is called at most every 10 ms, always from the thread that calls cancelled() or
/// stop_requested(); Python uses it for Ctrl-C. What it throws passes through. Not thread-safe.
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

  double remaining() const;  ///< [s], negative once the deadline has passed, infinity without a limit
  double elapsed() const;    ///< [s] since construction
  /// Has the time limit passed?
  bool expired() const { return remaining() <= 0.0; }
  /// Has the caller requested to stop? Once true, it stays true.
  bool cancelled() const;
  /// expired() or cancelled().
  bool stop_requested() const { return expired() || cancelled(); }

 private:
  Clock::time_point start_{Clock::now()};
  double limit_{std::numeric_limits<double>::infinity()};
  Interrupt interrupted_;
  mutable Clock::time_point next_poll_{};
  mutable bool cancelled_{false};
};

}  // namespace srmp
