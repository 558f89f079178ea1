#pragma once

#include <functional>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "srmp/planning/options.hpp"

namespace srmp {

/// The value of an option's field. (An OptionValue is what a dictionary has in its place.)
using FieldValue = std::variant<bool, int, double, std::string, std::vector<std::string>>;

/// Which values an option may have.
struct Allowed {
  double low{-std::numeric_limits<double>::infinity()};
  double high{std::numeric_limits<double>::infinity()};
  bool excludes_low{false};
  std::vector<std::string> choices{};  ///< empty: any text
  bool names_heuristics{false};        ///< checked by require_heuristics, not by validate
  std::string unit{};
};

Allowed anything();
Allowed above(double low, std::string unit = {});
Allowed above_up_to(double low, double high, std::string unit = {});
Allowed at_least(double low, std::string unit = {});
Allowed between(double low, double high, std::string unit = {});  ///< both included
Allowed one_of(std::vector<std::string> choices);
Allowed heuristic_names();

/// One option of one planner: its description, and access to its field in the options of that planner.
struct OptionSpec {
  OptionInfo info;
  Allowed allowed;
  std::function<FieldValue(const PlannerOptions&)> get;
  std::function<void(PlannerOptions&, FieldValue)> set;
};

/// Without access to a field.
OptionSpec describe(std::string name, const FieldValue& default_value, Allowed allowed, std::string description);

/// The option that is this field of the options `Planner`.
template <class Planner, class Field>
OptionSpec option(std::string name, Field Planner::* member, Allowed allowed, std::string description) {
  OptionSpec spec = describe(std::move(name), Planner{}.*member, std::move(allowed), std::move(description));
  spec.get = [member](const PlannerOptions& options) -> FieldValue { return std::get<Planner>(options).*member; };
  spec.set = [member](PlannerOptions& options, FieldValue value) {
    std::get<Planner>(options).*member = std::get<Field>(std::move(value));
  };
  return spec;
}

/// The option that is this field of the CommonOptions of every planner.
template <class Field>
OptionSpec common_option(std::string name, Field CommonOptions::* member, Allowed allowed, std::string description) {
  OptionSpec spec = describe(std::move(name), CommonOptions{}.*member, std::move(allowed), std::move(description));
  spec.info.common = true;
  spec.get = [member](const PlannerOptions& options) -> FieldValue { return common_options(options).*member; };
  spec.set = [member](PlannerOptions& options, FieldValue value) {
    std::visit([&](auto& typed) { typed.common.*member = std::get<Field>(std::move(value)); }, options);
  };
  return spec;
}

/// "option 'weight'", as messages begin.
std::string option_text(const std::string& key);
/// A value that is text. Throws InvalidArgument for another one.
std::string as_text(const std::string& key, const OptionValue& value);
/// The end of a sentence that refuses a name: the nearest known one, if one is near, and all of them.
std::string or_known(const std::string& name, const std::vector<std::string>& known);

/// Converts a value of a dictionary to the type of an option; `key` names it in messages. Whole numbers are also
/// checked against their range. Throws InvalidArgument when the value has another type.
FieldValue read_value(const std::string& key, const OptionSpec& spec, const OptionValue& value);
/// As a dictionary has it.
OptionValue to_option_value(FieldValue value);
/// Throws InvalidArgument when the value is out of its range, or not one of the choices.
void require_allowed(const std::string& key, const FieldValue& value, const Allowed& allowed);
/// Throws InvalidArgument unless `choice` is one of `known`; anything is allowed when `known` is empty.
void require_choice(const std::string& key, const std::string& choice, const std::vector<std::string>& known);

}  // namespace srmp
