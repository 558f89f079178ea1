#pragma once

#include "srmp/core/interruption.hpp"

namespace srmp::python {

/// Raises the exception of a Ctrl-C; called with or without the GIL by a thread that works for long.
void raise_interrupt();

}  // namespace srmp::python
