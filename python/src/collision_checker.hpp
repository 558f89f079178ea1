#pragma once

#include <nanobind/nanobind.h>

#include <map>
#include <memory>
#include <string>

#include "srmp/collision/timed_checker.hpp"

namespace srmp::python {

/// Throws InvalidArgument with the modes there are.
CheckMode to_check_mode(const std::string& mode);
/// The Python object for a checker.
nanobind::object wrap_checker(std::shared_ptr<const Checker> checker);
nanobind::object wrap_checker(std::shared_ptr<const TimedChecker> checker);
/// From a dict: robot name -> (times, configurations).
std::map<std::string, TimedPath> to_timed_paths(nanobind::handle others);

}  // namespace srmp::python
