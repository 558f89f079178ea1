#pragma once

#include "bind.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/core/steps.hpp"

namespace srmp::python {

/// Raises the exception of a Ctrl-C; called with or without the GIL by a thread that works for long.
void raise_interrupt();

/// Calls `progress`, if there is one, and raises the exception of a Ctrl-C. It keeps a reference to `progress`.
StepProgress report_to_python(const std::optional<nb::callable>& progress);

}  // namespace srmp::python
