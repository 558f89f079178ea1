#pragma once

#include <string>
#include <string_view>

namespace srmp {

/// The text of an error as users see it: one line of UTF-8, shorter than 500 characters. Control characters count as
/// spaces, bytes that are no UTF-8 are escaped, and what is too long loses its middle: the name of the file is in
/// front, what is allowed at the end.
std::string one_sentence(std::string_view text);

}  // namespace srmp
