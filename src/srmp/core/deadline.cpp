#include "srmp/core/deadline.hpp"

#include <algorithm>

namespace srmp {

namespace {
constexpr auto poll_period = std::chrono::milliseconds(5);
// The next poll of a deadline whose callback asks another deadline, which keeps to the period itself: were both to
// wait, a request to stop could pass unnoticed for two periods.
constexpr auto at_every_call = Deadline::Clock::time_point::max();
}  // namespace

Deadline::Deadline(double seconds, Interrupt interrupted) : limit_(seconds), interrupted_(std::move(interrupted)) {}

double Deadline::elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

Deadline Deadline::within(double seconds) const {
  Deadline other = with_limit(std::min(limit_, elapsed() + seconds), [this] { return cancelled(); });
  other.next_poll_ = at_every_call;
  return other;
}

Deadline Deadline::extended(double seconds) const {
  Deadline other = with_limit(limit_ + seconds, [this] { return cancelled(); });
  other.next_poll_ = at_every_call;
  return other;
}

Deadline Deadline::interrupted_by(Interrupt interrupted) const { return with_limit(limit_, std::move(interrupted)); }

Deadline Deadline::with_limit(double limit, Interrupt interrupted) const {
  Deadline other(limit, std::move(interrupted));
  other.start_ = start_;
  return other;
}

bool Deadline::cancelled() const {
  if (cancelled_ || !interrupted_) return cancelled_;
  if (next_poll_ == at_every_call) return cancelled_ = interrupted_();
  const auto now = Clock::now();
  if (now < next_poll_) return false;
  next_poll_ = now + poll_period;
  return cancelled_ = interrupted_();
}

}  // namespace srmp
