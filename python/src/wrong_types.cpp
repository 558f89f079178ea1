// Calls whose arguments have wrong types, are missing or have unknown names: one sentence of ours in place of
// nanobind's list of overloads. The functions of nanobind have no hook for it, but they are called through a pointer
// that every callable of Python may have (PEP 590), and that is replaced here for all of them, once they are all bound.
#include <string>
#include <string_view>
#include <unordered_map>

#include "bind.hpp"

namespace srmp::python {

namespace {

std::unordered_map<PyObject*, vectorcallfunc>& originals() {
  static auto* map = new std::unordered_map<PyObject*, vectorcallfunc>;  // as old as the functions, which never go
  return *map;
}

vectorcallfunc& pointer_of(PyObject* function) {
  return *reinterpret_cast<vectorcallfunc*>(reinterpret_cast<char*>(function) +
                                            Py_TYPE(function)->tp_vectorcall_offset);
}

/// Is the error that is set the one of a call that fits no signature?
bool fits_no_signature() {
  if (!PyErr_ExceptionMatches(PyExc_TypeError)) return false;
  nb::python_error error;
  const bool found =
      std::string_view(error.what()).find("(): incompatible function arguments. The") != std::string_view::npos;
  error.restore();
  return found;
}

/// The sentence that srmp._wrong_types makes of the call; "" when that fails.
std::string sentence(PyObject* function, PyObject* const* args, std::size_t count, PyObject* names) {
  try {
    const std::size_t named = names ? static_cast<std::size_t>(PyTuple_Size(names)) : 0;
    nb::list values;
    nb::dict keywords;
    for (std::size_t i = 0; i < count; ++i) values.append(nb::handle(args[i]));
    for (std::size_t i = 0; i < named; ++i)
      keywords[nb::handle(PyTuple_GetItem(names, static_cast<Py_ssize_t>(i)))] = nb::handle(args[count + i]);
    const nb::object made =
        nb::module_::import_("srmp._wrong_types").attr("sentence")(nb::handle(function), values, keywords);
    return nb::cast<std::string>(made);
  } catch (const nb::python_error& error) {
    if (error.matches(PyExc_KeyboardInterrupt)) PyErr_SetInterrupt();  // heard once the call has ended
    return {};
  } catch (...) {
    return {};
  }
}

PyObject* call(PyObject* self, PyObject* const* args, std::size_t flagged_count, PyObject* names) {
  PyObject* result = originals().at(self)(self, args, flagged_count, names);
  if (result || !fits_no_signature()) return result;
  constexpr std::size_t max_count = ~std::size_t{0} >> 2;  // the two bits above are flags, one of them nanobind's
  nb::python_error theirs;
  const std::string ours = sentence(self, args, flagged_count & max_count, names);
  if (ours.empty())
    theirs.restore();
  else
    set_wrong_type(ours);
  return nullptr;
}

void replace(nb::handle object) {
  const std::string_view type = Py_TYPE(object.ptr())->tp_name;
  if (type.ends_with("nb_func") || type.ends_with("nb_method")) {
    vectorcallfunc& pointer = pointer_of(object.ptr());
    if (originals().emplace(object.ptr(), pointer).second) pointer = call;
  } else if (nb::isinstance(object, nb::handle(reinterpret_cast<PyObject*>(&PyProperty_Type)))) {
    for (const char* part : {"fget", "fset"}) replace(object.attr(part));
  } else if (nb::hasattr(object, "__func__")) {  // a static method
    replace(object.attr("__func__"));
  }
}

}  // namespace

void restate_wrong_types(nb::module_& m) {
  for (nb::handle value : nb::cast<nb::dict>(m.attr("__dict__")).values()) {
    replace(value);
    if (!nb::isinstance<nb::type_object>(value)) continue;
    for (nb::handle member : nb::module_::import_("builtins").attr("dict")(value.attr("__dict__")).attr("values")())
      replace(member);
  }
}

}  // namespace srmp::python
