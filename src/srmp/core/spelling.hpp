#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace srmp {

/// Levenshtein distance, ignoring case.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The known name nearest to `name`, or nullptr when none is near: what did_you_mean suggests.
const std::string* nearest_name(std::string_view name, std::span<const std::string> known);

/// Is `name` so near to `known` that it is taken for that one, misspelt?
inline bool is_typo(std::string_view name, std::string_view known) { return edit_distance(name, known) <= 2; }

}  // namespace srmp
