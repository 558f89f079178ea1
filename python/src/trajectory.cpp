#include "bind.hpp"
#include "srmp/io/trajectory_file.hpp"

namespace srmp::python {

namespace {

using MatrixView = nb::ndarray<nb::numpy, const double, nb::ndim<2>>;
using VectorView = nb::ndarray<nb::numpy, const double, nb::ndim<1>>;

/// A read-only view that keeps the trajectory alive.
template <RowMatrix Trajectory::* member>
MatrixView view(nb::handle_t<Trajectory> self) {
  const RowMatrix& matrix = nb::cast<const Trajectory&>(self).*member;
  return MatrixView(matrix.data(), {static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols())},
                    self);
}

VectorView times_view(nb::handle_t<Trajectory> self) {
  const Eigen::VectorXd& times = nb::cast<const Trajectory&>(self).times;
  return VectorView(times.data(), {static_cast<std::size_t>(times.size())}, self);
}

RowMatrix to_matrix(nb::handle array) {
  const auto numbers = to_numbers(array, "trajectory array");
  return Eigen::Map<const RowMatrix>(numbers.data(), static_cast<Eigen::Index>(numbers.shape(0)),
                                     static_cast<Eigen::Index>(numbers.shape(1)));
}

template <class Matrix>
bool same(const Matrix& a, const Matrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() && a == b;
}

bool same(const Trajectory& a, const Trajectory& b) {
  return a.joint_names == b.joint_names && same(a.positions, b.positions) && same(a.velocities, b.velocities) &&
         same(a.accelerations, b.accelerations) && same(a.times, b.times) && same(a.waypoints, b.waypoints);
}

}  // namespace

void bind_trajectory(nb::module_& m) {
  nb::class_<Trajectory> cls(
      m, "Trajectory",
      "A motion: n samples of dof joints. Revolute joints in rad, prismatic ones in m; values of "
      "continuous joints do not\n"
      "jump at ±pi. Arrays are read-only views without a copy.");
  cls.def_ro("joint_names", &Trajectory::joint_names, "The dof joint names, in column order.")
      .def_prop_ro("positions", &view<&Trajectory::positions>, "(n, dof) [rad or m]")
      .def_prop_ro("velocities", &view<&Trajectory::velocities>, "(n, dof) [rad/s or m/s]")
      .def_prop_ro("accelerations", &view<&Trajectory::accelerations>, "(n, dof) [rad/s^2 or m/s^2]")
      .def_prop_ro("times", &times_view, "(n,) [s], from 0, strictly increasing")
      .def_prop_ro("waypoints", &view<&Trajectory::waypoints>,
                   "(m, dof): the checked path; the motion between two rows is straight in joint space")
      .def_prop_ro("duration", &Trajectory::duration, "[s]")
      .def_prop_ro("length", &Trajectory::length, "Joint-space length of the path [rad, prismatic joints m].")
      .def(
          "sample", [](const Trajectory& self, double t) { return to_numpy(self.sample(t)); }, nb::arg("t"),
          "The configuration (dof,) at time t [s]; times outside are moved to the nearest end.\n\n"
          "Raises InvalidArgument for NaN.")
      .def(
          "save", [](const Trajectory& self, const nb::object& path) { io::save_trajectory(self, to_path(path)); },
          nb::arg("path"), nb::sig("def save(self, path: str | os.PathLike[str]) -> None"),
          "Write it with its certificate (JSON), whole or not at all; numbers read back bit for bit. Raises FileError.")
      .def_static(
          "load", [](const nb::object& path) { return io::load_trajectory(to_path(path)); }, nb::arg("path"),
          nb::sig("def load(path: str | os.PathLike[str]) -> Trajectory"),
          "The trajectory of such a file, of a problem file (PlannerInterface.save), or of what `srmp plan -o` "
          "writes.\n\n"
          "Raises FileError, with the line, for anything missing, misspelt or wrong, and a file that holds none.")
      .def("__len__", &Trajectory::size)
      .def("__repr__",
           [](const Trajectory& t) {
             return "Trajectory(" + std::to_string(t.dof()) + " joints, " + std::to_string(t.size()) + " samples, " +
                    to_text(t.duration()) + " s)";
           })
      .def("__eq__",
           [](const Trajectory& a, nb::handle other) {
             return nb::isinstance<Trajectory>(other) && same(a, nb::cast<const Trajectory&>(other));
           })
      .def("__getstate__",
           [](nb::handle_t<Trajectory> self) {
             return nb::make_tuple(self.attr("joint_names"), self.attr("positions"), self.attr("velocities"),
                                   self.attr("accelerations"), self.attr("times"), self.attr("waypoints"));
           })
      .def("__setstate__", [](Trajectory& self, const nb::tuple& state) {
        const ArrayLike times{nb::borrow<nb::object>(state[4])};
        new (&self) Trajectory{nb::cast<std::vector<std::string>>(state[0]),
                               to_matrix(state[1]),
                               to_matrix(state[2]),
                               to_matrix(state[3]),
                               times.vector("times"),
                               to_matrix(state[5])};
      });
  cls.attr("__hash__") = nb::none();
}

}  // namespace srmp::python
