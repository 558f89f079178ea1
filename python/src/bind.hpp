#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "srmp/core/error.hpp"
#include "srmp/core/pose.hpp"
#include "srmp/planner/goal.hpp"
#include "srmp/planner/options.hpp"
#include "srmp/planner/planner_interface.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace nb = nanobind;

namespace srmp::python {

/// An argument that NumPy can make numbers of: a list, a tuple, an array.
struct ArrayLike {
  nb::object value;

  Eigen::VectorXd vector(const std::string& what) const;
  Eigen::Vector3d vector3(const std::string& what) const;
  /// Rows of `columns` numbers.
  RowMatrix rows(const std::string& what, Eigen::Index columns) const;
};

/// NumPy's float64 view or copy of any argument; InvalidArgument says `what` was not numbers.
nb::ndarray<const double, nb::c_contig, nb::device::cpu> to_numbers(nb::handle value, const std::string& what);

/// A NumPy array of float64; a type of its own so that the type stubs say so.
class NumpyArray : public nb::object {
  NB_OBJECT(NumpyArray, nb::object, "numpy.typing.NDArray[numpy.float64]", nb::ndarray_check)
};

/// A new NumPy array of the vector's numbers.
NumpyArray to_numpy(const Eigen::Ref<const Eigen::VectorXd>& vector);
/// A new NumPy array with the rows; (0, columns) when there are none.
NumpyArray to_numpy_rows(const std::vector<Eigen::VectorXd>& rows, std::size_t columns);
NumpyArray to_numpy_rows(RowMatrix rows);

OptionMap to_option_map(nb::handle dictionary);
nb::dict to_dict(const OptionMap& map);
std::vector<GoalConstraint> to_goals(nb::handle goal);
/// The arguments of plan_multi.
MultiPlanRequest to_multi_request(const std::map<std::string, ArrayLike>& starts,
                                  const std::map<std::string, nb::object>& goals,
                                  const std::optional<std::map<std::string, Trajectory>>& obstacles);
/// A str or os.PathLike.
std::string to_path(nb::handle path);
/// One name, or a list of names.
std::vector<std::string> to_names(nb::handle names);

nb::dict to_dict(const PlanStatistics& statistics);
nb::dict to_dict(const Solution& solution);

/// Raises PlanningError with these attributes.
[[noreturn]] void raise(const PlanningError& error, const nb::dict& statistics);

/// Gives a class the manners of a value. `get` makes a tuple of Python objects that can be compared and pickled, `set`
/// makes the value from it; with them it is compared, pickled and copied. Values can change hands but have no hash.
template <class T, class Get, class Set>
void make_value(nb::class_<T>& cls, Get get, Set set) {
  cls.def("__getstate__", get)
      .def("__setstate__", [set](T& self, const nb::tuple& state) { new (&self) T(set(state)); })
      .def("__eq__", [get](const T& self, nb::handle other) {
        return nb::isinstance<T>(other) && get(self).equal(get(nb::cast<const T&>(other)));
      });
  cls.attr("__hash__") = nb::none();
}

/// A robot of a PlannerInterface where it stands; None: its only one.
PlacedRobot placed_robot(nb::handle planner, nb::handle robot);

void bind_certificate(nb::module_& m);
void bind_collision_checker(nb::module_& m);
void bind_cover(nb::module_& m);
void bind_errors(nb::module_& m);
void bind_pose(nb::module_& m);
void bind_goal(nb::module_& m);
void bind_parameterize(nb::module_& m);
void bind_options(nb::module_& m);
void bind_trajectory(nb::module_& m);
void bind_multi_trajectory(nb::module_& m);
void bind_io(nb::module_& m);
void bind_plan_many(nb::module_& m);
void bind_planner_interface(nb::module_& m);

}  // namespace srmp::python

namespace nanobind::detail {

template <>
struct type_caster<srmp::python::ArrayLike> {
  NB_TYPE_CASTER(srmp::python::ArrayLike, const_name("numpy.typing.ArrayLike"))
  bool from_python(handle source, uint8_t, cleanup_list*) noexcept {
    value.value = borrow<object>(source);
    return true;
  }
};

}  // namespace nanobind::detail
