#include "srmp/core/status.hpp"

namespace srmp {

std::string_view to_string(Status status) {
  switch (status) {
    case Status::solved: return "solved";
    case Status::timed_out: return "timed_out";
    case Status::exhausted: return "exhausted";
    case Status::start_invalid: return "start_invalid";
    case Status::goal_invalid: return "goal_invalid";
    case Status::cancelled: return "cancelled";
  }
  return "unknown";
}

}  // namespace srmp
