#include "srmp/core/deadline.hpp"

namespace srmp {

namespace {
constexpr auto poll_period = std::chrono::milliseconds(10);
}

Deadline::Deadline(double seconds, Interrupt interrupted) : limit_(seconds), interrupted_(std::move(interrupted)) {}

double Deadline::elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

double Deadline::remaining() const { return limit_ - elapsed(); }

bool Deadline::cancelled() const {
  if (cancelled_ || !interrupted_) return cancelled_;
  const auto now = Clock::now();
  if (now < next_poll_) return false;
  next_poll_ = now + poll_period;
  return cancelled_ = interrupted_();
}

}  // namespace srmp
