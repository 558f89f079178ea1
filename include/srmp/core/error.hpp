#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "srmp/core/status.hpp"

namespace srmp {

/// Base class of all exceptions of this library. The text is one sentence that says what is wrong and what is allowed:
/// one line of UTF-8, shorter than 500 characters.
class Error : public std::runtime_error {
 public:
  /// Control characters of `text` count as spaces, bytes that are no UTF-8 are escaped, and what is too long loses its
  /// middle.
  explicit Error(const std::string& text);
};

/// An argument is invalid (Python: also a ValueError). The call changed nothing.
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

/// This version does not support what the call requires (Python: also a NotImplementedError).
class NotSupported : public Error {
 public:
  using Error::Error;
};

/// A plan has no trajectory: the status classifies the failure, the text gives the reason.
class PlanningError : public Error {
 public:
  /// `status` must not be Status::solved.
  PlanningError(Status status, const std::string& reason) : Error(reason), status_(status) {}
  /// How the plan ended.
  Status status() const { return status_; }

 private:
  Status status_;
};

#if __cplusplus >= 202002L  // MoveIt 1 is C++17
/// ", did you mean 'x'?" for the known name nearest to `name` (Levenshtein distance, ignoring case), or "" when none is
/// near.
std::string did_you_mean(std::string_view name, std::span<const std::string> known);

/// The names as text: "'a', 'b' and 'c'", or "(none)" when there are none.
std::string quoted_list(std::span<const std::string> names);

/// Throws InvalidArgument unless every value is finite. `what` names the argument, `names` its components; where there
/// is no name, the message gives the index.
void require_finite(std::span<const double> values, std::string_view what, std::span<const std::string> names = {});
#endif

/// Throws InvalidArgument unless `value` is finite and > 0; `what` names the argument.
void require_positive(double value, std::string_view what);

/// The shortest text that reads back as the same double; error messages print numbers this way.
std::string to_text(double value);

}  // namespace srmp
