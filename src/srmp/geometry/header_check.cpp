#include "srmp/geometry/header_check.hpp"

#include <array>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <vector>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"

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
                           std::uint64_t max_count) {
  const std::optional<std::uint64_t> count = to_count(word);
  if (!count) refuse(path, "gives '" + word + "' as the number of " + what + ", which is no number");
  if (*count > max_count) refuse(path, "says that it has " + word + " " + what + "; the file is too short for so many");
  return *count;
}

bool is_ply_header_line(const std::vector<std::string>& words) {
  const std::string& keyword = words[0];
  if (keyword == "element") return words.size() == 3;
  if (keyword == "format" || keyword == "property") return words.size() >= 3;
  return keyword == "ply" || keyword == "comment" || keyword == "obj_info" || keyword == "end_header";
}

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  return {std::istream_iterator<std::string>(stream), {}};
}

std::ifstream opened(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) refuse(path, "cannot be read");
  return file;
}

}  // namespace

void require_sound_ply_header(const std::string& path) {
  std::error_code ignored;
  const std::uint64_t size = std::filesystem::file_size(path, ignored);
  std::ifstream file = opened(path);
  std::uint64_t elements = 0, rows = 0;
  bool has_end = false, is_ascii = false;
  for (std::string line; !has_end && std::getline(file, line);) {
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) refuse(path, "has an empty line in its header");
    if (!is_ply_header_line(words)) refuse(path, "has '" + words[0] + "' in its header, which is not of the format");
    if (words[0] == "format") is_ascii = words[1] == "ascii";
    if (words[0] == "element") elements += require_room(path, "elements '" + words[1] + "'", words[2], size);
    has_end = words[0] == "end_header";
  }
  if (!has_end) refuse(path, "has a header without its last line, end_header");
  if (!is_ascii) return;
  for (std::string line; rows < elements && std::getline(file, line);) {
    interruption_point();
    rows += line.find_first_not_of(" \t\r") != std::string::npos;
  }
  if (rows < elements)
    refuse(path, "has " + std::to_string(rows) + " rows, but counts " + std::to_string(elements) + " elements");
}

void require_sound_off_header(const std::string& path) {
  std::ifstream file = opened(path);
  std::string word;
  const auto next_word = [&] {
    interruption_point();
    if (!(file >> word)) return false;
    if (word.front() == '#') refuse(path, "has a comment (#), with which assimp does not end; remove it");
    return true;
  };
  bool is_word = next_word();
  if (is_word && word.ends_with("nOFF")) refuse(path, "has vertices of more or fewer than three coordinates (nOFF)");
  if (is_word && word.ends_with("OFF")) is_word = next_word();
  std::array<std::string, 3> counts;  // of vertices, faces, edges
  for (std::string& count : counts) {
    if (!is_word) refuse(path, "does not say how many vertices, faces and edges it has");
    count = word;
    is_word = next_word();
  }
  std::uint64_t numbers_after_counts = 0;
  for (; is_word; is_word = next_word()) ++numbers_after_counts;
  const std::uint64_t vertices = require_room(path, "vertices", counts[0], numbers_after_counts / 3);
  require_room(path, "faces", counts[1], (numbers_after_counts - 3 * vertices) / 2);
  require_room(path, "edges", counts[2], std::numeric_limits<std::uint64_t>::max());
}

void require_gltf(const std::string& path) {
  std::ifstream file = opened(path);
  std::string word;
  file >> word;
  if (!word.starts_with("glTF") && !word.starts_with('{')) refuse(path, "is no glTF");
}

}  // namespace srmp
