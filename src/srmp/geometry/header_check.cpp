#include "srmp/geometry/header_check.hpp"

#include <cctype>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

std::optional<std::uint64_t> to_count(const std::string& word) {
  std::uint64_t count{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), count);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return count;
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw FileError("mesh file '" + path + "' " + why);
}

std::uint64_t require_room(const std::string& path, const std::string& what, const std::string& word,
                           std::uint64_t most) {
  const std::optional<std::uint64_t> count = to_count(word);
  if (!count) refuse(path, "gives '" + word + "' as the number of " + what + ", which is no number");
  if (*count > most) refuse(path, "says that it has " + word + " " + what + "; it is too short for so many");
  return *count;
}

bool is_ply_header(const std::vector<std::string>& words) {
  const std::string& keyword = words[0];
  if (keyword == "element") return words.size() == 3;
  if (keyword == "format" || keyword == "property") return words.size() >= 3;
  return keyword == "ply" || keyword == "comment" || keyword == "obj_info" || keyword == "end_header";
}

/// Calls `visit` with the words of each line until it returns false.
template <class Visit>
void for_each_line(const std::string& path, Visit&& visit) {
  std::ifstream file(path, std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    std::istringstream stream(line);
    const std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
    if (!visit(words)) return;
  }
}

}  // namespace

void require_sound_ply_header(const std::string& path) {
  const std::uint64_t size = std::filesystem::file_size(path);
  std::uint64_t elements = 0, rows = 0;
  bool has_end = false, is_ascii = false;
  for_each_line(path, [&](const std::vector<std::string>& words) {
    if (has_end) {
      rows += !words.empty();
      return true;
    }
    if (words.empty()) refuse(path, "has an empty line in its header");
    const std::string& keyword = words[0];
    if (!is_ply_header(words)) refuse(path, "has '" + keyword + "' in its header, which is not of the format");
    if (keyword == "format") is_ascii = words[1] == "ascii";
    if (keyword == "element") elements += require_room(path, "elements '" + words[1] + "'", words[2], size);
    has_end = keyword == "end_header";
    return !has_end || is_ascii;
  });
  if (!has_end) refuse(path, "has a header without its last line, end_header");
  if (is_ascii && rows < elements)
    refuse(path, "has " + std::to_string(rows) + " rows, but counts " + std::to_string(elements) + " elements");
}

void require_sound_off_header(const std::string& path) {
  constexpr std::size_t wanted = 3;  // vertices, faces, edges
  std::vector<std::string> counts;
  std::uint64_t numbers = 0;  // that follow them
  bool is_first = true;
  for_each_line(path, [&](const std::vector<std::string>& words) {
    if (words.empty() || words[0].front() == '#') return true;
    const bool is_header = std::exchange(is_first, false) && std::isalpha(static_cast<unsigned char>(words[0].front()));
    for (std::size_t i = is_header ? 1 : 0; i < words.size(); ++i)
      if (counts.size() < wanted)
        counts.push_back(words[i]);
      else
        ++numbers;
    return true;
  });
  if (counts.size() < wanted) refuse(path, "does not say how many vertices, faces and edges it has");
  require_room(path, "vertices", counts[0], numbers / 3);
  require_room(path, "faces", counts[1], (numbers - 3 * *to_count(counts[0])) / 2);
  require_room(path, "edges", counts[2], std::numeric_limits<std::uint64_t>::max());
}

}  // namespace srmp
