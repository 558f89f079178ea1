#pragma once

#include <optional>
#include <string>

#include "srmp/core/deadline.hpp"
#include "srmp/core/error.hpp"

namespace srmp {

/// timed_out or cancelled when it is time to stop.
std::optional<Status> stop_status(const Deadline& deadline);

/// Throws PlanningError when it is time to stop: "the time limit passed while " + `work`, or that the plan was
/// cancelled.
void stop_if_late(const Deadline& deadline, const std::string& work);

}  // namespace srmp
