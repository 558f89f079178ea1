#include "srmp/core/error.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numeric>

#include "srmp/core/spelling.hpp"

namespace srmp {

namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
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

const std::string* nearest_name(std::string_view name, std::span<const std::string> known) {
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
