#pragma once

#include <string_view>

namespace srmp {

/// How a plan ended.
enum class Status {
  solved,         ///< a trajectory was found
  timed_out,      ///< the time limit passed before a path was found
  exhausted,      ///< the graph, searched whole, has no path (a finer one may); or there is none, as the reason says
  start_invalid,  ///< the start is in collision or outside a limit
  goal_invalid,   ///< every goal is in collision, outside limits or out of reach
  cancelled,      ///< the caller requested to stop
};

/// The enumerator's name, such as "timed_out".
std::string_view to_string(Status status);

}  // namespace srmp
