#include <system_error>

#include "apps/python/binding.h"
#include "kinematics/io/parse_error.h"

namespace gelenk::python {
namespace {

/// ParseError(ValueError) with file, line, expected and found.
void addParseError(py::module_& m) {
  static PyObject* type = PyErr_NewExceptionWithDoc(
      "gelenk.ParseError", "A file that cannot be read as what it should be: file, line, expected, found.",
      PyExc_ValueError, nullptr);
  m.attr("ParseError") = py::reinterpret_borrow<py::object>(type);
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const ParseError& error) {
      py::object value = py::reinterpret_borrow<py::object>(type)(error.what());
      value.attr("file") = error.file();
      value.attr("line") = error.line();
      value.attr("expected") = error.expected();
      value.attr("found") = error.found();
      PyErr_SetObject(type, value.ptr());
    }
  });
}

/// What the system refuses, such as a file that is not there, is an OSError, of the class that goes with its
/// number, with the program's sentence.
void addSystemErrors() {
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const std::system_error& error) {
      const int number = error.code().value();
      const py::object type = py::type::of(py::reinterpret_borrow<py::object>(PyExc_OSError)(number, ""));
      py::object value = type(error.what());
      value.attr("errno") = number;
      PyErr_SetObject(type.ptr(), value.ptr());
    }
  });
}

}  // namespace
}  // namespace gelenk::python

PYBIND11_MODULE(_gelenk, m) {
  using namespace gelenk::python;
  m.attr("version") = GELENK_VERSION;
  addParseError(m);
  addSystemErrors();
  addModel(m);
  addGoals(m);
  addMathematics(m);
  addSolve(m);
  addOwn(m);
  addLab(m);
  addSkin(m);
  addMotion(m);
}
