#pragma once

#include <string_view>

namespace srmp {

/// The index of the first byte that is not part of valid UTF-8 (RFC 3629: no overlong forms, no surrogates), or npos
/// when all of the text is.
std::size_t find_invalid_utf8(std::string_view text);

/// Is all of the text UTF-8? Names and files must be: Python and JSON cannot represent anything else.
inline bool is_utf8(std::string_view text) { return find_invalid_utf8(text) == std::string_view::npos; }

}  // namespace srmp
