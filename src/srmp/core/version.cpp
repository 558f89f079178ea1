#include "srmp/core/version.hpp"

namespace srmp {

std::string_view version() { return SRMP_VERSION; }

}  // namespace srmp
