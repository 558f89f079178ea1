// Compiled as C++17, and not as C++20 like everything else: the plugin for MoveIt 1 includes these headers.
// tests/python/test_layers.py compares the list with moveit/src.
#include <srmp/core/error.hpp>
#include <srmp/moveit_session.hpp>

static_assert(__cplusplus == 201703L, "this file shows nothing when it is compiled as C++20");
