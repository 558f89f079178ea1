#include "srmp/planning/options/option_spec.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Throws for a value of another kind than is `needed`.
[[noreturn]] void refuse(const std::string& key, const OptionValue& value, const char* needed) {
  std::string given;
  if (const auto* flag = std::get_if<bool>(&value)) given = *flag ? "true" : "false";
  if (const auto* number = std::get_if<double>(&value)) given = to_text(*number);
  if (const auto* text = std::get_if<std::string>(&value)) given = "'" + *text + "'";
  if (const auto* names = std::get_if<std::vector<std::string>>(&value)) given = "[" + quoted_list(*names) + "]";
  throw InvalidArgument(option_text(key) + " is " + given + "; it must be " + needed);
}

double as_number(const std::string& key, const OptionValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return *number;
  if (const auto* text = std::get_if<std::string>(&value)) {
    double number{};
    const char* end = text->data() + text->size();
    const auto [stop, error] = std::from_chars(text->data(), end, number);
    if (error == std::errc{} && stop == end) return number;
  }
  refuse(key, value, "a number");
}

bool as_bool(const std::string& key, const OptionValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag;
  if (const auto* text = std::get_if<std::string>(&value)) {
    if (*text == "true" || *text == "True" || *text == "1") return true;
    if (*text == "false" || *text == "False" || *text == "0") return false;
  }
  if (const auto* number = std::get_if<double>(&value); number && (*number == 0.0 || *number == 1.0))
    return *number == 1.0;
  refuse(key, value, "true or false");
}

std::vector<std::string> as_names(const std::string& key, const OptionValue& value) {
  if (const auto* names = std::get_if<std::vector<std::string>>(&value)) return *names;
  const auto* text = std::get_if<std::string>(&value);
  if (!text) refuse(key, value, "a list of names");
  std::vector<std::string> names;
  std::string name;
  for (const char c : *text + ',') {
    if (c != ',' && c != ' ')
      name += c;
    else if (!name.empty())
      names.push_back(std::move(name)), name.clear();
  }
  return names;
}

void require_in_range(const std::string& key, double value, const Allowed& range) {
  const bool ok =
      std::isfinite(value) && (range.excludes_low ? value > range.low : value >= range.low) && value <= range.high;
  if (ok) return;
  std::string bounds = std::isfinite(value) ? "it must be " : "it must be a finite number, ";
  bounds += (range.excludes_low ? "above " : "at least ") + to_text(range.low);
  if (range.high < infinity) bounds += " and at most " + to_text(range.high);
  throw InvalidArgument(option_text(key) + " is " + to_text(value) + "; " + bounds);
}

int as_whole_number(const std::string& key, const OptionValue& value, const Allowed& range) {
  const double number = as_number(key, value);
  require_in_range(key, number, range);
  if (number != std::floor(number) || number > 1e9)
    throw InvalidArgument(option_text(key) + " is " + to_text(number) + "; it must be a whole number");
  return static_cast<int>(number);
}

std::string range_text(const Allowed& allowed) {
  if (allowed.low == -infinity) return {};
  std::string text = (allowed.excludes_low ? "> " : ">= ") + to_text(allowed.low);
  if (allowed.high < infinity) text += " and <= " + to_text(allowed.high);
  return text;
}

}  // namespace

Allowed anything() { return {}; }
Allowed above(double low, std::string unit) { return {.low = low, .excludes_low = true, .unit = std::move(unit)}; }
Allowed above_up_to(double low, double high, std::string unit) {
  return {.low = low, .high = high, .excludes_low = true, .unit = std::move(unit)};
}
Allowed at_least(double low, std::string unit) { return {.low = low, .unit = std::move(unit)}; }
Allowed between(double low, double high, std::string unit) {
  return {.low = low, .high = high, .unit = std::move(unit)};
}
Allowed one_of(std::vector<std::string> choices) { return {.choices = std::move(choices)}; }
Allowed heuristic_names() { return {.names_heuristics = true}; }

OptionSpec describe(std::string name, const FieldValue& default_value, Allowed allowed, std::string description) {
  static_assert(std::variant_size_v<FieldValue> == 5, "OptionType has one enumerator for each, in the same order");
  OptionInfo info{.name = std::move(name),
                  .type = static_cast<OptionType>(default_value.index()),
                  .default_value = to_option_value(default_value),
                  .unit = allowed.unit,
                  .range = range_text(allowed),
                  .choices = allowed.choices,
                  .description = std::move(description)};
  return {.info = std::move(info), .allowed = std::move(allowed), .get = {}, .set = {}};
}

std::string option_text(const std::string& key) { return "option '" + key + "'"; }

std::string as_text(const std::string& key, const OptionValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  refuse(key, value, "a word");
}

std::string or_known(const std::string& name, const std::vector<std::string>& known) {
  const std::string hint = did_you_mean(name, known);
  return (hint.empty() ? "; known are " : hint + " Known are ") + quoted_list(known);
}

FieldValue read_value(const std::string& key, const OptionSpec& spec, const OptionValue& value) {
  switch (spec.info.type) {
    case OptionType::boolean: return as_bool(key, value);
    case OptionType::integer: return as_whole_number(key, value, spec.allowed);
    case OptionType::number: return as_number(key, value);
    case OptionType::text: return as_text(key, value);
    case OptionType::text_list: break;
  }
  return as_names(key, value);
}

OptionValue to_option_value(FieldValue value) {
  return std::visit(
      [](auto&& typed) -> OptionValue {
        if constexpr (std::is_same_v<std::decay_t<decltype(typed)>, int>)
          return static_cast<double>(typed);
        else
          return std::forward<decltype(typed)>(typed);
      },
      std::move(value));
}

void require_allowed(const std::string& key, const FieldValue& value, const Allowed& allowed) {
  if (const auto* number = std::get_if<double>(&value))
    require_in_range(key, *number, allowed);
  else if (const auto* whole = std::get_if<int>(&value))
    require_in_range(key, *whole, allowed);
  else if (const auto* text = std::get_if<std::string>(&value))
    require_choice(key, *text, allowed.choices);
}

void require_choice(const std::string& key, const std::string& choice, const std::vector<std::string>& known) {
  if (known.empty() || std::find(known.begin(), known.end(), choice) != known.end()) return;
  throw InvalidArgument(option_text(key) + " is '" + choice + "'" + or_known(choice, known));
}

}  // namespace srmp
