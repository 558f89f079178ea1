#pragma once

#include <string_view>

namespace srmp {

/// How a plan ended. Never a bare "failed".
enum class Status {
  solved,
  timed_out,      ///< the time limit passed before a path was found
  exhausted,      ///< the whole graph was searched: it holds no path (a finer resolution may)
  start_invalid,  ///< the start is in collision or outside a limit
  goal_invalid,   ///< no goal can be met: in collision, outside limits or out of reach
  cancelled,      ///< the caller asked to stop
};

std::string_view to_string(Status status);

}  // namespace srmp
