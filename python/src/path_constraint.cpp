#include "srmp/trajectory/path_constraint.hpp"

#include "bind.hpp"

namespace srmp::python {

namespace {

AxisTolerance to_axes(const ArrayLike& value, const std::string& what) {
  const auto numbers = to_numbers(value.value, what);
  if (numbers.size() == 1) return numbers.data()[0];
  if (numbers.ndim() != 1 || numbers.size() != 3)
    throw InvalidArgument(what + " must be one number or three, for x, y and z");
  return {numbers.data()[0], numbers.data()[1], numbers.data()[2]};
}

Eigen::Quaterniond to_quaternion(const ArrayLike& value) {
  const Eigen::VectorXd q = value.vector("the quaternion of an orientation");
  if (q.size() != 4)
    throw InvalidArgument("the quaternion of an orientation is 4 numbers, x, y, z, w, but got " +
                          std::to_string(q.size()));
  return {q[3], q[0], q[1], q[2]};
}

PathConstraint made(PathConstraint constraint, const std::string& link, const std::string& frame,
                    const std::optional<ArrayLike>& point = {}) {
  constraint.link = link;
  constraint.frame = frame;
  if (point) constraint.point = point->vector3("point_in_link");
  constraint.validate();
  return constraint;
}

nb::object plain(const Eigen::Vector3d& v) { return nb::cast(std::array{v[0], v[1], v[2]}); }
Eigen::Vector3d numbers3(const nb::object& value) {
  const auto v = nb::cast<std::array<double, 3>>(value);
  return {v[0], v[1], v[2]};
}

#define SRMP_LINK nb::kw_only(), nb::arg("link") = "", nb::arg("frame") = ""
#define SRMP_POINT SRMP_LINK, nb::arg("point_in_link") = nb::none()

void bind_factories(nb::class_<PathConstraint>& cls) {
  cls.def_static(
         "cone",
         [](const ArrayLike& axis, const ArrayLike& direction, double tolerance, const std::string& link,
            const std::string& frame) {
           return made(PathConstraint::cone(axis.vector3("axis"), direction.vector3("direction"), tolerance), link,
                       frame);
         },
         nb::arg("axis"), nb::arg("direction"), nb::arg("tolerance"), SRMP_LINK,
         "`axis` of the link (3,) stays within `tolerance` [rad], below pi, of `direction` (3,) in the frame.")
      .def_static(
          "orientation",
          [](const ArrayLike& q, const ArrayLike& tolerance, const std::string& link, const std::string& frame) {
            return made(PathConstraint::orientation(to_quaternion(q), to_axes(tolerance, "tolerance")), link, frame);
          },
          nb::arg("q"), nb::arg("tolerance"), SRMP_LINK,
          "The link's orientation differs from the quaternion q [x, y, z, w] by a rotation vector whose components "
          "along\n"
          "the axes of q are within the tolerance [rad]: one number or three; infinity: that axis is free.")
      .def_static(
          "pose",
          [](const Pose& pose, const ArrayLike& position_tolerance, const ArrayLike& rotation_tolerance,
             const std::string& link, const std::string& frame, const std::optional<ArrayLike>& point) {
            return made(PathConstraint::pose(pose, to_axes(position_tolerance, "position_tolerance"),
                                             to_axes(rotation_tolerance, "rotation_tolerance")),
                        link, frame, point);
          },
          nb::arg("pose"), nb::arg("position_tolerance"), nb::arg("rotation_tolerance"), SRMP_POINT,
          "The link stays at a pose, to tolerances [m, rad] along and about the axes of that pose: one number or "
          "three;\n"
          "infinity: that axis is free. With `frame`, the relative pose of two links.")
      .def_static(
          "box",
          [](const ArrayLike& size, const Pose& pose, const std::string& link, const std::string& frame,
             const std::optional<ArrayLike>& point) {
            return made(PathConstraint::box(size.vector3("size"), pose), link, frame, point);
          },
          nb::arg("size"), nb::arg("pose"), SRMP_POINT,
          "A point of the link (default: its origin) stays in a box with full edge lengths `size` (3,) [m] centred at\n"
          "`pose`; infinity: unbounded along that axis.")
      .def_static(
          "plane",
          [](const ArrayLike& through, const ArrayLike& normal, double tolerance, const std::string& link,
             const std::string& frame, const std::optional<ArrayLike>& point) {
            return made(PathConstraint::plane(through.vector3("through"), normal.vector3("normal"), tolerance), link,
                        frame, point);
          },
          nb::arg("through"), nb::arg("normal"), nb::arg("tolerance"), SRMP_POINT,
          "A point of the link (default: its origin) stays within `tolerance` [m] of the plane through a point (3,).")
      .def_static(
          "line",
          [](const ArrayLike& through, const ArrayLike& direction, double tolerance, const std::string& link,
             const std::string& frame, const std::optional<ArrayLike>& point) {
            return made(PathConstraint::line(through.vector3("through"), direction.vector3("direction"), tolerance),
                        link, frame, point);
          },
          nb::arg("through"), nb::arg("direction"), nb::arg("tolerance"), SRMP_POINT,
          "A point of the link (default: its origin) stays within `tolerance` [m] of the line through a point (3,).")
      .def_static(
          "distance",
          [](const ArrayLike& centre, double min_distance, double max_distance, const std::string& link,
             const std::string& frame, const std::optional<ArrayLike>& point) {
            return made(PathConstraint::distance(centre.vector3("centre"), min_distance, max_distance), link, frame,
                        point);
          },
          nb::arg("centre"), nb::arg("min_distance"), nb::arg("max_distance"), SRMP_POINT,
          "A point of the link (default: its origin) keeps a distance of min_distance to max_distance [m] from "
          "`centre`.");
}

}  // namespace

void bind_path_constraint(nb::module_& m) {
  nb::class_<PathConstraint> cls(
      m, "PathConstraint",
      R"(What has to hold at every instant of a motion: argument `constraints` of PlannerInterface.plan and,
by robot name, of plan_multi.

link: a link of the robot, or an object that it holds; '' = the end effector. frame: in whose frame the numbers are;
'' = the world; a link of the same robot, which may move; or what stands still: an object, or a link of another robot
as 'robot/link'. point_in_link: (3,) [m] which point of the link; default: its origin. Made by the functions below,
which raise InvalidArgument for NaN, directions and quaternions of length 0, tolerances that are not above 0 and
constraints that leave everything free.)");
  bind_factories(cls);
  cls.def_prop_ro(
         "type", [](const PathConstraint& c) { return std::string(to_string(c.type)); },
         "What it bounds: 'cone', 'orientation', 'pose', 'box', 'plane', 'line' or 'distance'.")
      .def_ro("link", &PathConstraint::link, "A link of the robot, or an object that it holds; '' = the end effector.")
      .def_ro("frame", &PathConstraint::frame, "In whose frame it is; '' = the world.")
      .def("__repr__", [](const PathConstraint& c) {
        return "PathConstraint." + std::string(to_string(c.type)) + (c.link.empty() ? "()" : "(link='" + c.link + "')");
      });
  make_value(
      cls,
      [](const PathConstraint& c) {
        return nb::make_tuple(static_cast<int>(c.type), c.link, c.frame, c.target.to_list(), plain(c.axis),
                              plain(c.point), plain(c.position_tolerance.axes), plain(c.rotation_tolerance.axes),
                              c.tolerance, c.min_distance, c.max_distance);
      },
      [](const State& s) {
        PathConstraint c;
        c.type = static_cast<PathConstraintType>(nb::cast<int>(s[0]));
        c.link = nb::cast<std::string>(s[1]);
        c.frame = nb::cast<std::string>(s[2]);
        c.target = Pose::from_list(nb::cast<std::array<double, 7>>(s[3]));
        c.axis = numbers3(s[4]);
        c.point = numbers3(s[5]);
        c.position_tolerance = numbers3(s[6]);
        c.rotation_tolerance = numbers3(s[7]);
        c.tolerance = nb::cast<double>(s[8]);
        c.min_distance = nb::cast<double>(s[9]);
        c.max_distance = nb::cast<double>(s[10]);
        c.validate();
        return c;
      });
}

}  // namespace srmp::python
