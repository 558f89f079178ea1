#include "srmp/core/error.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numeric>

#include "srmp/core/sentence.hpp"
#include "srmp/core/spelling.hpp"
#include "srmp/core/utf8.hpp"

namespace srmp {

namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

/// On one line: control characters count as spaces, and bytes that are no UTF-8 are escaped.
std::string one_line(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string line;
  for (std::size_t bad = find_invalid_utf8(text); !text.empty(); bad = find_invalid_utf8(text)) {
    line += text.substr(0, bad);
    text.remove_prefix(std::min(bad, text.size()));
    if (text.empty()) break;
    const auto byte = static_cast<unsigned char>(text.front());
    line.append("\\x").append({digits[byte >> 4], digits[byte & 15]});
    text.remove_prefix(1);
  }
  std::string clean;
  for (const char c : line) {
    const bool is_control = (c >= 0 && c < ' ') || c == 127;
    if (!is_control || clean.empty() || clean.back() != ' ') clean += is_control ? ' ' : c;
  }
  return clean;
}

std::string shortened(std::string text) {
  constexpr std::size_t front = 300, back = 190;
  if (text.size() <= front + back) return text;
  const auto begins_character = [&](std::size_t i) { return (static_cast<unsigned char>(text[i]) & 0xC0) != 0x80; };
  std::size_t first = front, last = text.size() - back;
  while (!begins_character(first)) --first;
  while (last < text.size() && !begins_character(last)) ++last;
  return text.substr(0, first) + " … " + text.substr(last);
}

}  // namespace

std::size_t edit_distance(std::string_view raw_a, std::string_view raw_b) {
  const std::string a = lower(raw_a), b = lower(raw_b);
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

Error::Error(const std::string& text) : std::runtime_error(one_sentence(text)) {}

std::string one_sentence(std::string_view text) { return shortened(one_line(text)); }

const std::string* nearest_name(std::string_view name, std::span<const std::string> known) {
  constexpr std::size_t longest_name = 200;  // characters; the distance takes the product of the lengths
  if (name.size() > longest_name) return nullptr;
  const std::string* nearest = nullptr;
  std::size_t min_distance = std::max<std::size_t>(2, name.size() / 2) + 1;
  for (const std::string& candidate : known) {
    const std::size_t distance = edit_distance(name, candidate);
    if (distance < min_distance) {
      min_distance = distance;
      nearest = &candidate;
    }
  }
  return nearest;
}

std::string did_you_mean(std::string_view name, std::span<const std::string> known) {
  const std::string* nearest = nearest_name(name, known);
  return nearest ? ", did you mean '" + *nearest + "'?" : "";
}

std::string quoted_list(std::span<const std::string> names) {
  if (names.empty()) return "(none)";
  std::string text = "'" + names[0] + "'";
  for (std::size_t i = 1; i < names.size(); ++i) text += (i + 1 == names.size() ? " and '" : ", '") + names[i] + "'";
  return text;
}

void require_finite(std::span<const double> values, std::string_view what, std::span<const std::string> names) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i])) continue;
    const std::string which = i < names.size() ? names[i] : "component " + std::to_string(i);
    throw InvalidArgument(std::string(what) + ": " + which + " is " + to_text(values[i]) +
                          "; only finite numbers are allowed");
  }
}

void require_positive(double value, std::string_view what) {
  if (!(std::isfinite(value) && value > 0.0))
    throw InvalidArgument(std::string(what) + " is " + to_text(value) + "; it must be a finite number above 0");
}

std::string to_text(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0 ? "infinity" : "-infinity";
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

}  // namespace srmp
