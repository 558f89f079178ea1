#pragma once

#include <chrono>
#include <functional>
#include <limits>
#include <utility>

namespace srmp {

/// A point in time that all phases of one request share, and the caller's wish to stop.
///
/// The clock decides nothing but when to stop. `interrupted` (may be empty) is asked at most every 10 ms, always from
/// the thread that calls stop_requested(); Python uses it for Ctrl-C.
class Deadline {
 public:
  using Clock = std::chrono::steady_clock;
  using Interrupt = std::function<bool()>;

  /// Never expires.
  Deadline() = default;
  /// Expires `seconds` from now; infinity means never.
  explicit Deadline(double seconds, Interrupt interrupted = {});

  double remaining() const;  ///< [s], negative once passed, infinity without a limit
  double elapsed() const;    ///< [s] since construction
  bool expired() const { return remaining() <= 0.0; }
  /// Has the caller asked to stop? Sticky: once true, stays true.
  bool cancelled() const;
  bool stop_requested() const { return expired() || cancelled(); }

 private:
  Clock::time_point start_{Clock::now()};
  double limit_{std::numeric_limits<double>::infinity()};
  Interrupt interrupted_;
  mutable Clock::time_point next_poll_{};
  mutable bool cancelled_{false};
};

}  // namespace srmp
