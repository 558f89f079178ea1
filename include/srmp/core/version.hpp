#pragma once

#include <string_view>

namespace srmp {

/// "major.minor.patch" of the library that is running.
std::string_view version();

}  // namespace srmp
