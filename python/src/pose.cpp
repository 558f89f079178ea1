#include "bind.hpp"

namespace srmp::python {

namespace {

std::array<double, 4> four(const ArrayLike& q, const std::string& what) {
  const Eigen::VectorXd v = q.vector(what);
  if (v.size() != 4) throw InvalidArgument(what + " must be 4 numbers, but got " + std::to_string(v.size()));
  return {v[0], v[1], v[2], v[3]};
}

std::string text(const Pose& pose) {
  const auto v = pose.to_list();
  std::string result = "Pose(p=[";
  for (std::size_t i = 0; i < 7; ++i) result += to_text(v[i]) + (i == 2 ? "], q=[" : i == 6 ? "])" : ", ");
  return result;
}

}  // namespace

void bind_pose(nb::module_& m) {
  nb::class_<Pose> cls(
      m, "Pose",
      "A rigid transform: position p [m] and unit quaternion q = [x, y, z, w], in the world frame unless said "
      "otherwise.\n\n"
      "Iterates over its seven numbers x, y, z, qx, qy, qz, qw; `pose @ point` and `pose @ pose` transform.");
  cls.def(
         "__init__",
         [](Pose* self, const std::optional<ArrayLike>& p, const std::optional<ArrayLike>& q) {
           new (self) Pose(Pose::from_xyzw(p ? p->vector3("pose position") : Eigen::Vector3d(Eigen::Vector3d::Zero()),
                                           q ? four(*q, "pose quaternion") : std::array<double, 4>{0, 0, 0, 1}));
         },
         nb::arg("p") = nb::none(), nb::arg("q") = nb::none(),
         R"(A pose from a position [m] (default: origin) and a quaternion [x, y, z, w] (default: identity; normalised).

Raises InvalidArgument for NaN, a zero quaternion or a wrong number of entries.)")
      .def_static(
          "from_xyzw",
          [](const ArrayLike& p, const ArrayLike& q) {
            return Pose::from_xyzw(p.vector3("pose position"), four(q, "quaternion"));
          },
          nb::arg("p"), nb::arg("q"), R"(A pose from a position [m] and a quaternion [x, y, z, w], which is normalised.

Raises InvalidArgument for NaN, a zero quaternion or a wrong number of entries.)")
      .def_static(
          "from_wxyz",
          [](const ArrayLike& p, const ArrayLike& q) {
            return Pose::from_wxyz(p.vector3("pose position"), four(q, "quaternion"));
          },
          nb::arg("p"), nb::arg("q"), R"(A pose from a position [m] and a quaternion [w, x, y, z], which is normalised.

Raises InvalidArgument for NaN, a zero quaternion or a wrong number of entries.)")
      .def_static(
          "from_rpy",
          [](const ArrayLike& p, const ArrayLike& rpy) {
            return Pose::from_rpy(p.vector3("pose position"), rpy.vector3("roll, pitch, yaw"));
          },
          nb::arg("p"), nb::arg("rpy"),
          R"(A pose from a position [m] and fixed-axis roll, pitch, yaw [rad] as in URDF: R = Rz(yaw) Ry(pitch) Rx(roll).

Raises InvalidArgument for NaN or a wrong number of entries.)")
      .def_static(
          "from_matrix",
          [](const ArrayLike& matrix) {
            const RowMatrix rows = matrix.rows("pose matrix", 4);
            if (rows.rows() != 4) throw InvalidArgument("pose matrix must have the shape (4, 4)");
            return Pose::from_matrix(rows);
          },
          nb::arg("matrix"),
          R"(A pose from a homogeneous matrix (4, 4).

Raises InvalidArgument unless its rotation is orthonormal to 1e-6.)")
      .def_prop_ro(
          "p", [](const Pose& pose) { return to_numpy(pose.p); }, "The position x, y, z, (3,) [m].")
      .def_prop_ro(
          "q", [](const Pose& pose) { return to_numpy(pose.q.coeffs()); }, "The unit quaternion x, y, z, w, (4,).")
      .def(
          "matrix",
          [](const Pose& pose) {
            const Eigen::Matrix4d matrix = pose.matrix();
            return to_numpy_rows({matrix.row(0), matrix.row(1), matrix.row(2), matrix.row(3)}, 4);
          },
          "The homogeneous matrix (4, 4).")
      .def(
          "rpy", [](const Pose& pose) { return to_numpy(pose.rpy()); },
          R"(The roll, pitch, yaw of `from_rpy`, (3,) [rad], with pitch within ±pi/2.

At its ends, where roll and yaw turn about one axis, the two together give the orientation.)")
      .def("inverse", &Pose::inverse, "The inverse transform: `pose.inverse() @ pose` is the identity.")
      .def(
          "__matmul__", [](const Pose& a, const Pose& b) { return a * b; }, nb::is_operator())
      .def(
          "__matmul__", [](const Pose& a, const ArrayLike& point) { return to_numpy(a * point.vector3("point")); },
          nb::is_operator())
      .def(
          "__iter__", [](const Pose& pose) { return nb::iter(nb::cast(pose.to_list())); },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[float]"))
      .def("__len__", [](const Pose&) { return 7; })
      .def("__repr__", &text);
  make_value(
      cls, [](const Pose& pose) { return nb::tuple(nb::cast(pose.to_list())); },
      [](const State& state) {
        std::array<double, 7> v{};
        for (std::size_t i = 0; i < v.size(); ++i) v[i] = nb::cast<double>(state[i]);
        return Pose{{v[0], v[1], v[2]}, {v[6], v[3], v[4], v[5]}};
      });
}

}  // namespace srmp::python
