#include "srmp/core/stopping.hpp"

namespace srmp {

std::optional<Status> stop_status(const Deadline& deadline) {
  if (deadline.cancelled()) return Status::cancelled;
  if (deadline.expired()) return Status::timed_out;
  return std::nullopt;
}

void stop_if_late(const Deadline& deadline, const std::string& work) {
  const auto stop = stop_status(deadline);
  if (!stop) return;
  const std::string event = *stop == Status::cancelled ? "the plan was cancelled" : "the time limit passed";
  throw PlanningError(*stop, event + " while " + work);
}

}  // namespace srmp
