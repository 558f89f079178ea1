#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <string>

#include "srmp/collision/checker.hpp"

namespace srmp::python {

/// Throws InvalidArgument with the modes there are.
CheckMode to_check_mode(const std::string& mode);
/// The Python object for a checker.
nanobind::object wrap_checker(std::shared_ptr<const Checker> checker);

}  // namespace srmp::python
