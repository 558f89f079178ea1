#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace fuzz {

/// Numbers of a fixed sequence, the same on every machine (splitmix64; Steele, Lea, Flood 2014).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }
  /// Below `count`, which is above 0.
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(next() % count); }
  bool chance(unsigned percent) { return below(100) < percent; }
  template <class List>
  const auto& one_of(const List& list) {
    return list[below(list.size())];
  }

 private:
  std::uint64_t state_;
};

/// What breaks readers: extreme numbers, empty and foreign texts.
inline constexpr std::array<std::string_view, 40> hostile_words{
    "0",      "-0",     "1",     "-1",       "1e308",        "-1e308",      "1e-308",     "1e160",
    "1e-160", "1e20",   "1e400", "nan",      ".nan",         "inf",         "-.inf",      "NaN",
    "999",    "1000.1", "256",   "65536",    "2147483647",   "-2147483648", "4294967296", "9223372036854775807",
    "1.5",    "",       "\xff",  "\xc3\xa9", "\xed\xa0\x80", "null",        "true",       "[]",
    "{}",     "\"",     "<",     "&#xD800;", "../..",        "/dev/null",   "\n",         "  "};

inline bool is_word(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '.' || c == '-' || c == '_';
}

/// Begin and end of the word at, or after, a random place.
inline std::pair<std::size_t, std::size_t> random_word(const std::string& text, Random& random) {
  std::size_t begin = random.below(text.size());
  while (begin < text.size() && !is_word(text[begin])) ++begin;
  while (begin > 0 && begin < text.size() && is_word(text[begin - 1])) --begin;
  std::size_t end = begin;
  while (end < text.size() && is_word(text[end])) ++end;
  return {begin, end};
}

/// Begin and end of a line.
inline std::pair<std::size_t, std::size_t> random_line(const std::string& text, Random& random) {
  const std::size_t at = random.below(text.size());
  const std::size_t before = text.rfind('\n', at), after = text.find('\n', at);
  const std::size_t begin = before == std::string::npos || before == at ? 0 : before + 1;
  return {std::min(begin, text.size()), after == std::string::npos ? text.size() : std::max(begin, after + 1)};
}

/// One change.
inline void change(std::string& text, const std::vector<std::string>& seeds, Random& random) {
  if (text.empty()) {
    text = random.one_of(seeds);
    return;
  }
  const std::size_t at = random.below(text.size()), length = 1 + random.below(std::min<std::size_t>(64, text.size()));
  switch (random.below(10)) {
    case 0: text[at] = static_cast<char>(random.next()); break;
    case 1: text[at] = static_cast<char>(text[at] ^ (1 << random.below(8))); break;
    case 2: text.erase(at, length); break;
    case 3: text.insert(at, std::string(text.substr(random.below(text.size()), length))); break;
    case 4: {
      const auto [begin, end] = random_line(text, random);
      text.erase(begin, end - begin);
      break;
    }
    case 5: {
      const auto [begin, end] = random_line(text, random);
      text.insert(begin, std::string(text.substr(begin, end - begin)));
      break;
    }
    case 6: {
      const std::string& other = random.one_of(seeds);
      text = text.substr(0, at) + other.substr(std::min(other.size(), random.below(other.size() + 1)));
      break;
    }
    case 7: {
      const auto [from, to] = random_word(text, random);
      const std::string word = text.substr(from, to - from);
      const auto [begin, end] = random_word(text, random);
      text.replace(begin, end - begin, word);
      break;
    }
    default: {
      const auto [begin, end] = random_word(text, random);
      text.replace(begin, end - begin, std::string(random.one_of(hostile_words)));
    }
  }
}

/// A seed with a few changes. The same for the same random sequence.
inline std::string mutate(const std::vector<std::string>& seeds, Random& random) {
  std::string text = random.one_of(seeds);
  const std::size_t changes = 1 + random.below(random.chance(20) ? 16 : 4);
  for (std::size_t i = 0; i < changes; ++i) change(text, seeds, random);
  constexpr std::size_t max_size = 1 << 18;  // bytes
  if (text.size() > max_size) text.resize(max_size);
  return text;
}

/// A seed in which a few words are others of the same seed or hostile ones, or lines are missing or twice: what is
/// read well often enough that the code behind the readers is tried.
inline std::string mutate_words(const std::vector<std::string>& seeds, Random& random) {
  std::string text = random.one_of(seeds);
  for (std::size_t i = 1 + random.below(3); i-- > 0 && !text.empty();) {
    const auto [line_begin, line_end] = random_line(text, random);
    const auto [from, to] = random_word(text, random);
    const std::string line = text.substr(line_begin, line_end - line_begin), word = text.substr(from, to - from);
    const auto [begin, end] = random_word(text, random);
    switch (random.below(8)) {
      case 0: text.erase(line_begin, line.size()); break;
      case 1: text.insert(line_begin, line); break;
      case 2:
      case 3: text.replace(begin, end - begin, std::string(random.one_of(hostile_words))); break;
      default: text.replace(begin, end - begin, word);
    }
  }
  return text;
}

}  // namespace fuzz
