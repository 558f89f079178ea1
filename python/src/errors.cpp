#include "bind.hpp"
#include "interrupt.hpp"
#include "srmp/core/sentence.hpp"
#include "srmp/core/status.hpp"

namespace srmp::python {

namespace {

// Owned by the module for the life of the process.
PyObject *error_type, *invalid_argument_type, *file_error_type, *not_supported_type, *planning_error_type,
    *unknown_robot_type, *wrong_type_type, *robot_warning_type;

PyObject* make_exception(nb::module_& m, const char* name, const char* doc, PyObject* base, PyObject* builtin,
                         const nb::dict& members = {}) {
  const nb::object bases = builtin ? nb::object(nb::make_tuple(nb::handle(base), nb::handle(builtin)))
                                   : nb::object(nb::make_tuple(nb::handle(base)));
  const std::string full_name = std::string("srmp.") + name;
  PyObject* type = PyErr_NewExceptionWithDoc(full_name.c_str(), doc, bases.ptr(), members.ptr());
  m.attr(name) = nb::handle(type);
  return type;
}

void set_planning_error(const PlanningError& error, const nb::dict& statistics) {
  const nb::object exception = nb::handle(planning_error_type)(one_sentence(error.what()));
  exception.attr("status") = nb::cast(error.status());
  exception.attr("statistics") = statistics;
  PyErr_SetObject(planning_error_type, exception.ptr());
}

void set_error(PyObject* type, const char* text) { PyErr_SetString(type, one_sentence(text).c_str()); }

void translate(const std::exception_ptr& pointer, void*) {
  try {
    std::rethrow_exception(pointer);
  } catch (const PlanningError& error) {
    set_planning_error(error, {});
  } catch (const InvalidArgument& error) {
    set_error(invalid_argument_type, error.what());
  } catch (const FileError& error) {
    set_error(file_error_type, error.what());
  } catch (const NotSupported& error) {
    set_error(not_supported_type, error.what());
  } catch (const Error& error) {
    set_error(error_type, error.what());
  } catch (const std::bad_cast&) {
    set_error(invalid_argument_type,
              "an argument has another type than is expected, or is text with characters that do not exist in UTF-8");
  }
}

}  // namespace

void raise_interrupt() {
  const nb::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

StepProgress report_to_python(const std::optional<nb::callable>& progress) {
  return [&progress](std::size_t done, std::size_t total) {
    const nb::gil_scoped_acquire gil;
    raise_interrupt();
    if (progress) (*progress)(done, total);
  };
}

void raise(const PlanningError& error, const nb::dict& statistics) {
  set_planning_error(error, statistics);
  throw nb::python_error();
}

void raise_unknown_robot(const std::string& what) {
  set_error(unknown_robot_type, what.c_str());
  throw nb::python_error();
}

void set_wrong_type(const std::string& what) { set_error(wrong_type_type, what.c_str()); }

void warn_of_robot(const std::string& what) {
  if (PyErr_WarnEx(robot_warning_type, what.c_str(), 1) != 0) throw nb::python_error();
}

void bind_errors(nb::module_& m) {
  nb::enum_<Status>(m, "Status", "How a plan ended.")
      .value("solved", Status::solved, "There is a trajectory.")
      .value("timed_out", Status::timed_out, "The time limit passed before a path was found.")
      .value("exhausted", Status::exhausted,
             "The whole graph was searched: it has no path (a finer resolution may). Or the reason says that there is "
             "none.")
      .value("start_invalid", Status::start_invalid, "The start is in collision or outside a limit.")
      .value("goal_invalid", Status::goal_invalid,
             "No goal can be reached: in collision, outside limits or out of reach.")
      .value("cancelled", Status::cancelled, "The caller asked to stop.");

  error_type = make_exception(m, "Error", "Base of every exception that srmp raises.", PyExc_Exception, nullptr);
  invalid_argument_type = make_exception(m, "InvalidArgument", "An argument was refused; nothing was changed.",
                                         error_type, PyExc_ValueError);
  file_error_type =
      make_exception(m, "FileError", "A file is missing, unreadable or wrong.", error_type, PyExc_OSError);
  not_supported_type =
      make_exception(m, "NotSupported", "The request needs something that this version does not do yet.", error_type,
                     PyExc_NotImplementedError);
  nb::dict as_it_is;  // a KeyError puts its text in quotation marks
  as_it_is["__str__"] = nb::handle(PyExc_BaseException).attr("__str__");
  unknown_robot_type = make_exception(m, "UnknownRobot", "There is no robot of this name.", invalid_argument_type,
                                      PyExc_KeyError, as_it_is);
  wrong_type_type = make_exception(m, "WrongType", "An argument has the wrong type, is missing or is not known.",
                                   invalid_argument_type, PyExc_TypeError);
  robot_warning_type = make_exception(m, "RobotWarning", "Something in the files of a robot was read but not used.",
                                      PyExc_UserWarning, nullptr);
  planning_error_type = make_exception(
      m, "PlanningError",
      "There is no trajectory: `status` (a Status) says how the plan ended, the text why; `statistics`: see\n"
      "PlannerInterface.get_planning_stats.",
      error_type, nullptr);
  nb::register_exception_translator(translate);
}

}  // namespace srmp::python
