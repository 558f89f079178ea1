// Stands in for the bindings until python/src holds them.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>

#include <array>
#include <string>

#include "srmp/core/pose.hpp"
#include "srmp/core/version.hpp"

namespace nb = nanobind;

NB_MODULE(_srmp, m) {
  m.attr("__version__") = std::string(srmp::version());
  nb::class_<srmp::Pose>(m, "Pose")
      .def(nb::init<>())
      .def("to_list", &srmp::Pose::to_list, "x, y, z, qx, qy, qz, qw");
}
