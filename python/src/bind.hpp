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
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <typeinfo>
#include <vector>

#include "srmp/core/error.hpp"
#include "srmp/core/pose.hpp"
#include "srmp/planner_interface.hpp"
#include "srmp/planning/goal.hpp"
#include "srmp/planning/options.hpp"
#include "srmp/trajectory/trajectory.hpp"

namespace nb = nanobind;

namespace srmp::python {

/// An argument that NumPy can convert to numbers: a list, a tuple, an array.
struct ArrayLike {
  nb::object value;

  Eigen::VectorXd vector(const std::string& what) const;
  Eigen::Vector3d vector3(const std::string& what) const;
  /// Rows of `columns` numbers.
  RowMatrix rows(const std::string& what, Eigen::Index columns) const;
};

/// The numbers; none for None.
inline Eigen::VectorXd vector_or_none(const std::optional<ArrayLike>& numbers, const std::string& what) {
  return numbers ? numbers->vector(what) : Eigen::VectorXd();
}

/// What Python would print of a value, on one line of a sentence.
std::string brief(nb::handle value);

/// Seconds as a person reads them in a repr: to the microsecond.
inline std::string brief_seconds(double seconds) { return to_text(std::round(1e6 * seconds) / 1e6) + " s"; }

/// NumPy's float64 view or copy of an argument.
using Numbers = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
/// Those of any argument. Throws InvalidArgument, naming `what`, when it is not numbers.
Numbers to_numbers(nb::handle value, const std::string& what);
/// The error of numbers that must have the shape (n, columns).
InvalidArgument wrong_shape(const std::string& what, const std::string& columns, const Numbers& numbers);

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
/// The type of a goal in any form, and of several, as signatures have it. (Of a list of several forms, type checkers
/// see a list of objects.)
#define SRMP_GOAL                                                                           \
  "GoalConstraint | Pose | numpy.typing.ArrayLike | collections.abc.Mapping[str, float] | " \
  "collections.abc.Mapping[str, Pose] | str"
/// The arguments of motions along poses: CartesianOptions.
#define SRMP_CARTESIAN                                                               \
  nb::arg("link") = "", nb::arg("max_deviation") = CartesianOptions{}.max_deviation, \
  nb::arg("max_rotation") = CartesianOptions{}.max_rotation, nb::arg("constraints") = std::vector<PathConstraint>()
#define SRMP_CARTESIAN_SIG                                                                     \
  "link: str = '', max_deviation: float = 0.001, max_rotation: float = 0.008726646259971648, " \
  "constraints: collections.abc.Sequence[PathConstraint] = ()"
#define SRMP_GOALS SRMP_GOAL " | collections.abc.Sequence[object]"

/// A goal in any form, or several; `what` names it in messages.
std::vector<Goal> to_goals(nb::handle goal, const std::string& what = "a goal");
/// A dictionary of poses by link name. Throws InvalidArgument for anything else.
std::map<std::string, Pose> to_link_poses(nb::handle value);
/// Makes a GoalConstraint of a goal in any form for a robot, as PlannerInterface::goal does.
using ToConstraint = std::function<GoalConstraint(const std::string& robot, const Goal& goal,
                                                  const std::optional<Eigen::VectorXd>& start)>;
/// Without a scene: refuses names of states and of joints, which it does not know.
GoalConstraint constraint_without_scene(const std::string& robot, const Goal& goal,
                                        const std::optional<Eigen::VectorXd>& start = {});
/// By robot name; `what` says which argument it is.
std::map<std::string, nb::object> to_map(nb::handle mapping, const std::string& what);
std::map<std::string, Trajectory> to_trajectories(nb::handle mapping, const std::string& what);
/// Lists of PathConstraints by robot name, or None.
std::map<std::string, std::vector<PathConstraint>> to_path_constraints(nb::handle mapping);
/// The arguments of plan_multi; obstacles and constraints may be None.
MultiPlanRequest to_multi_request(nb::handle starts, nb::handle goals, nb::handle obstacles, nb::handle constraints,
                                  const ToConstraint& to_constraint = constraint_without_scene);
/// A str or os.PathLike.
std::string to_path(nb::handle path);
/// One name, or a list of names, of the argument that errors call `what`.
std::vector<std::string> to_names(nb::handle names, const std::string& what);

nb::dict to_dict(const PlanStatistics& statistics);
nb::dict to_dict(const Solution& solution);

/// Raises PlanningError with these attributes.
[[noreturn]] void raise(const PlanningError& error, const nb::dict& statistics);
/// Raises UnknownRobot, an InvalidArgument for a mapping's key.
[[noreturn]] void raise_unknown_robot(const std::string& what);
/// Sets WrongType, an InvalidArgument and TypeError, as the current error of Python.
void set_wrong_type(const std::string& what);
/// Issues a RobotWarning; throws when the user made errors of warnings.
void warn_of_robot(const std::string& what);

/// The argument of __setstate__, which may be anything.
class State {
 public:
  explicit State(nb::tuple entries) : entries_(std::move(entries)) {}

  nb::object operator[](std::size_t i) const {
    read_ = std::max(read_, i + 1);
    if (i >= entries_.size()) throw std::out_of_range("it ends too early");
    return entries_[i];
  }
  void require_all_read() const {
    if (read_ < entries_.size()) throw std::out_of_range("it has more entries than are known");
  }

 private:
  nb::tuple entries_;
  mutable std::size_t read_{};
};

/// `get` makes a tuple of Python objects, `set` makes the value from them again, given a State.
template <class T, class Get, class Set>
void make_picklable(nb::class_<T>& cls, Get get, Set set) {
  const auto restored = [set, name = nb::cast<std::string>(cls.attr("__name__"))](const nb::tuple& entries) -> T {
    const auto refuse = [&](const char* why) -> InvalidArgument {
      return InvalidArgument("this is not the pickled state of a " + name + ": " + why);
    };
    try {
      const State state(entries);
      T value = set(state);
      state.require_all_read();
      return value;
    } catch (const std::bad_cast&) {
      throw refuse("an entry has another type");
    } catch (const std::out_of_range& error) {
      throw refuse(error.what());
    } catch (nb::python_error& error) {
      throw refuse(error.what());
    }
  };
  cls.def("__getstate__", get).def("__setstate__", [restored](T& self, const nb::tuple& entries) {
    new (&self) T(restored(entries));
  });
}

/// Values are compared but not hashed. They differ from every object of another type, None too.
template <class T, class Same>
void make_comparable(nb::class_<T>& cls, Same same) {
  cls.def(
      "__eq__",
      [same](const T& self, nb::handle other) {
        return nb::isinstance<T>(other) && nb::inst_ready(other) && same(self, nb::cast<const T&>(other));
      },
      nb::arg().none(), nb::sig("def __eq__(self, arg: object, /) -> bool"));
  cls.attr("__hash__") = nb::none();
}

/// Makes a class a value type: it is compared, pickled and copied by the tuple that `get` makes of it.
template <class T, class Get, class Set>
void make_value(nb::class_<T>& cls, Get get, Set set) {
  make_picklable(cls, get, set);
  make_comparable(cls, [get](const T& a, const T& b) { return get(a).equal(get(b)); });
}

/// Objects of the class show themselves in notebooks: by srmp/_notebook.py.
template <class Class>
void make_html(Class& cls) {
  cls.def(
      "_repr_html_", [](nb::handle self) { return nb::module_::import_("srmp._notebook").attr("html_of")(self); },
      nb::sig("def _repr_html_(self) -> str"));
}

#define SRMP_LINK_SPEEDS \
  "collections.abc.Mapping[str, float | tuple[float | None, float | None]] | collections.abc.Sequence[LinkSpeedLimit]"

/// Limits of links: None and {} are none; a dictionary from link to speed, or to (speed, angular speed); or a list of
/// LinkSpeedLimit.
std::vector<LinkSpeedLimit> to_link_speeds(nb::handle value);

/// A robot of a PlannerInterface with its base pose; None: its only one.
PlacedRobot placed_robot(nb::handle planner, nb::handle robot);

void bind_certificate(nb::module_& m);
void bind_collision_checker(nb::module_& m);
void bind_cover(nb::module_& m);
void bind_end_effector(nb::module_& m);
void bind_errors(nb::module_& m);
void bind_pose(nb::module_& m);
void bind_goal(nb::module_& m);
void bind_path_constraint(nb::module_& m);
void bind_parameterize(nb::module_& m);
void bind_options(nb::module_& m);
void bind_trajectory(nb::module_& m);
void bind_multi_trajectory(nb::module_& m);
void bind_io(nb::module_& m);
void bind_plan_many(nb::module_& m);
void bind_search_trace(nb::module_& m);
void bind_sequence(nb::module_& m);
void bind_planner_interface(nb::module_& m);
/// From now on all functions of the module raise WrongType where their arguments fit no signature.
void restate_wrong_types(nb::module_& m);

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
