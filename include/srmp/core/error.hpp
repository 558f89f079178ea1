#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "srmp/core/status.hpp"

namespace srmp {

/// Base of everything this library throws. The text is one sentence that says what was wrong and what is allowed.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An argument was refused at the door (Python: also a ValueError). Nothing was changed.
class InvalidArgument : public Error {
 public:
  using Error::Error;
};

/// A file is missing, unreadable or wrong (Python: also an OSError). The text names the file and, where known, the
/// line.
class FileError : public Error {
 public:
  using Error::Error;
};

/// Asked for something that this version does not do yet (Python: also a NotImplementedError).
class NotSupported : public Error {
 public:
  using Error::Error;
};

/// No trajectory: the status says which kind of no, the text says why.
class PlanningError : public Error {
 public:
  PlanningError(Status status, const std::string& reason) : Error(reason), status_(status) {}
  Status status() const { return status_; }

 private:
  Status status_;
};

/// ", did you mean 'x'?" for the known name nearest to `name` (edit distance), or "" when none is near.
std::string did_you_mean(std::string_view name, std::span<const std::string> known);

/// "'a', 'b' and 'c'"; "(none)" when empty.
std::string quoted_list(std::span<const std::string> names);

/// Throws InvalidArgument unless every value is finite; `what` names the argument, `names` its components (or empty).
void require_finite(std::span<const double> values, std::string_view what, std::span<const std::string> names = {});

/// Throws InvalidArgument unless `value` is finite and > 0.
void require_positive(double value, std::string_view what);

/// The shortest text that reads back as the same double, as error messages print numbers.
std::string to_text(double value);

}  // namespace srmp
