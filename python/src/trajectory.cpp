#include "srmp/trajectory/trajectory.hpp"

#include "planner_interface.hpp"
#include "srmp/io/trajectory_file.hpp"

namespace srmp::python {

namespace {

using MatrixView = nb::ndarray<nb::numpy, const double, nb::ndim<2>>;
using VectorView = nb::ndarray<nb::numpy, const double, nb::ndim<1>>;

/// A read-only view that keeps the trajectory alive.
template <RowMatrix Trajectory::* member>
MatrixView view(nb::handle_t<Trajectory> self) {
  const auto& trajectory = nb::cast<const Trajectory&>(self);
  const RowMatrix& matrix = trajectory.*member;
  return MatrixView(matrix.data(), {static_cast<std::size_t>(matrix.rows()), trajectory.dof()}, self);
}

VectorView times_view(nb::handle_t<Trajectory> self) {
  const Eigen::VectorXd& times = nb::cast<const Trajectory&>(self).times;
  return VectorView(times.data(), {static_cast<std::size_t>(times.size())}, self);
}

RowMatrix to_matrix(nb::handle array, const std::string& what, std::size_t columns) {
  const auto numbers = to_numbers(array, what);
  if (numbers.size() == 0) return RowMatrix(0, static_cast<Eigen::Index>(columns));
  if (numbers.ndim() != 2) throw wrong_shape(what, std::to_string(columns), numbers);
  return Eigen::Map<const RowMatrix>(numbers.data(), static_cast<Eigen::Index>(numbers.shape(0)),
                                     static_cast<Eigen::Index>(numbers.shape(1)));
}

RowMatrix to_matrix(const std::optional<ArrayLike>& array, const std::string& what, std::size_t columns) {
  return array ? to_matrix(array->value, what, columns) : RowMatrix(0, static_cast<Eigen::Index>(columns));
}

Trajectory make_trajectory(nb::handle joint_names, const ArrayLike& positions, const std::optional<ArrayLike>& times,
                           const std::optional<ArrayLike>& velocities, const std::optional<ArrayLike>& accelerations,
                           const std::optional<ArrayLike>& waypoints) {
  const std::vector<std::string> names = to_names(joint_names, "joint_names");
  Trajectory t{names,
               to_matrix(positions.value, "positions", names.size()),
               to_matrix(velocities, "velocities", names.size()),
               to_matrix(accelerations, "accelerations", names.size()),
               times ? times->vector("times") : Eigen::VectorXd(0),
               to_matrix(waypoints, "waypoints", names.size())};
  if (t.waypoints.rows() == 0) t.waypoints = t.positions;
  t.validate();
  return t;
}

bool same(const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return a.size() == b.size() && a == b; }
bool same(const RowMatrix& a, const RowMatrix& b) {
  return a.rows() == b.rows() && (a.rows() == 0 || (a.cols() == b.cols() && a == b));
}
bool same(const Trajectory& a, const Trajectory& b) {
  return a.joint_names == b.joint_names && same(a.positions, b.positions) && same(a.velocities, b.velocities) &&
         same(a.accelerations, b.accelerations) && same(a.times, b.times) && same(a.waypoints, b.waypoints);
}

/// The states at one time, or at many, as arrays (dof,) or (k, dof): one for each of the members.
template <class... Member>
nb::tuple states(const Trajectory& self, const ArrayLike& t, Member... member) {
  const auto numbers = to_numbers(t.value, "t");
  const auto dimensions = nb::cast<int>(nb::module_::import_("numpy").attr("ndim")(t.value));
  if (dimensions > 1)
    throw InvalidArgument("t must be a number or one row of numbers, but has " + std::to_string(dimensions) +
                          " dimensions");
  const auto count = static_cast<Eigen::Index>(numbers.size());
  std::array<RowMatrix, sizeof...(Member)> rows;
  rows.fill(RowMatrix(count, static_cast<Eigen::Index>(self.dof())));
  for (Eigen::Index i = 0; i < count; ++i) {
    const MotionState state = self.state(numbers.data()[i]);
    std::size_t k = 0;
    ((rows[k++].row(i) = (state.*member).transpose()), ...);
  }
  nb::list arrays;
  for (RowMatrix& matrix : rows) {
    const NumpyArray array = to_numpy_rows(std::move(matrix));
    arrays.append(dimensions == 0 ? nb::object(array.attr("reshape")(-1)) : nb::object(array));
  }
  return nb::tuple(arrays);
}

Trajectory part(const Trajectory& self, nb::handle rows) {
  if (!nb::isinstance<nb::slice>(rows))
    throw InvalidArgument("a trajectory is cut with trajectory[first:last]; positions[i] is one row of it");
  const auto [start, stop, step, length] = nb::borrow<nb::slice>(rows).compute(self.size());
  if (step != 1)
    throw InvalidArgument("trajectory[::" + std::to_string(step) +
                          "] would leave out rows and be another motion; resample makes one");
  return self.rows(static_cast<std::size_t>(start), static_cast<std::size_t>(start) + length);
}

/// A function of srmp/_trajectory.py, which has the properties and methods that need no C++.
nb::object in_python(const char* function) { return nb::module_::import_("srmp._trajectory").attr(function); }

std::string repr(const Trajectory& t) {
  return "Trajectory(" + std::to_string(t.dof()) + (t.dof() == 1 ? " joint, " : " joints, ") +
         std::to_string(t.size()) + (t.size() == 1 ? " row, " : " rows, ") +
         (t.timed() ? brief_seconds(t.duration()) + ")" : "no times)");
}

Trajectory from_state(const State& state) {
  const auto names = nb::cast<std::vector<std::string>>(state[0]);
  const auto matrix = [&](std::size_t i, const char* what) {
    RowMatrix rows = to_matrix(state[i], what, names.size());
    if (static_cast<std::size_t>(rows.cols()) != names.size())
      throw InvalidArgument(std::string(what) + " have " + std::to_string(rows.cols()) + " columns, but there are " +
                            std::to_string(names.size()) + " joint names");
    return rows;
  };
  std::shared_ptr<const Certificate> certificate;
  if (!state[6].is_none()) certificate = std::make_shared<const Certificate>(nb::cast<Certificate>(state[6]));
  return {names,
          matrix(1, "positions"),
          matrix(2, "velocities"),
          matrix(3, "accelerations"),
          ArrayLike{state[4]}.vector("times"),
          matrix(5, "waypoints"),
          certificate};
}

void bind_data(nb::class_<Trajectory>& cls) {
  cls.def(
         "__init__",
         [](Trajectory* self, nb::handle joint_names, const ArrayLike& positions, const std::optional<ArrayLike>& times,
            const std::optional<ArrayLike>& velocities, const std::optional<ArrayLike>& accelerations,
            const std::optional<ArrayLike>& waypoints) {
           new (self) Trajectory(make_trajectory(joint_names, positions, times, velocities, accelerations, waypoints));
         },
         nb::arg("joint_names").none(), nb::arg("positions"), nb::arg("times") = nb::none(),
         nb::arg("velocities") = nb::none(), nb::arg("accelerations") = nb::none(), nb::arg("waypoints") = nb::none(),
         nb::sig("def __init__(self, joint_names: collections.abc.Sequence[str], positions: numpy.typing.ArrayLike, "
                 "times: numpy.typing.ArrayLike | None = None, velocities: numpy.typing.ArrayLike | None = None, "
                 "accelerations: numpy.typing.ArrayLike | None = None, "
                 "waypoints: numpy.typing.ArrayLike | None = None) -> None"),
         R"(A trajectory of your own, or of another planner.

positions, velocities, accelerations: (n, dof) [rad or m, /s, /s^2]; times: (n,) [s]; waypoints: (m, dof), default
the positions. Without velocities the motion between rows is straight; without times it is only a path.

Raises InvalidArgument, naming row and joint, for wrong shapes, no rows, NaN and infinity, names that are empty or
used twice, times that do not increase, velocities without times, accelerations without velocities.)")
      .def_ro("joint_names", &Trajectory::joint_names, "The dof joint names, in column order.")
      .def_prop_ro("positions", &view<&Trajectory::positions>, "Positions (n, dof) [rad or m].")
      .def_prop_ro("velocities", &view<&Trajectory::velocities>,
                   "Velocities (n, dof) [rad/s or m/s]; (0, dof): not known.")
      .def_prop_ro(
          "accelerations", &view<&Trajectory::accelerations>,
          "Accelerations (n, dof) [rad/s^2 or m/s^2], where they jump: just after the row; (0, dof): not known.")
      .def_prop_ro(
          "jerks",
          [](const Trajectory& t) {
            return to_numpy_rows(t.timed() ? t.jerks() : RowMatrix(0, static_cast<Eigen::Index>(t.dof())));
          },
          R"(Jerks (n, dof) [rad/s^3 or m/s^3] of the polynomial after each row, at the last row of the one before it; (0, dof)
without times.)")
      .def_prop_ro("times", &times_view, "Times (n,) [s], strictly increasing; (0,): a path without times.")
      .def_prop_ro("waypoints", &view<&Trajectory::waypoints>,
                   "The checked path (m, dof) [rad or m], straight between rows in joint space.")
      .def_prop_ro("duration", &Trajectory::duration, "Duration [s]; 0 without times.")
      .def_prop_ro(
          "length", &Trajectory::length,
          R"(Length of the motion: sum of the Euclidean norms of joint differences of rows [rad, prismatic joints m].)")
      .def_prop_ro(
          "certificate",
          [](const Trajectory& t) { return t.certificate ? nb::cast(*t.certificate) : nb::object(nb::none()); },
          nb::sig("def certificate(self) -> Certificate | None"),
          "The Certificate of this motion; None: none was made.")
      .def(
          "save", [](const Trajectory& self, const nb::object& path) { io::save_trajectory(self, to_path(path)); },
          nb::arg("path"), nb::sig("def save(self, path: str | os.PathLike[str]) -> None"),
          R"(Writes the trajectory with its certificate (JSON), completely or not at all; numbers read back bit for bit.

Raises FileError.)")
      .def_static(
          "load",
          [](const nb::object& path) {
            const InterruptionScope interruptible(raise_interrupt);
            return io::load_trajectory(to_path(path));
          },
          nb::arg("path"), nb::sig("def load(path: str | os.PathLike[str]) -> Trajectory"),
          R"(The trajectory of a trajectory file, of a problem file (PlannerInterface.save), or of what `srmp plan -o` writes.

Raises FileError, with the line, for anything missing, misspelt or wrong, and a file that holds no trajectory.)")
      .def("__len__", &Trajectory::size)
      .def("__repr__", &repr);
  make_comparable(cls, [](const Trajectory& a, const Trajectory& b) { return same(a, b); });
  make_picklable(
      cls,
      [](nb::handle_t<Trajectory> self) {
        return nb::make_tuple(self.attr("joint_names"), self.attr("positions"), self.attr("velocities"),
                              self.attr("accelerations"), self.attr("times"), self.attr("waypoints"),
                              self.attr("certificate"));
      },
      &from_state);
}

std::string add_robot(const Trajectory& trajectory, PlannerInterface& planner) {
  if (!trajectory.robot) return "";
  const auto& [model, base, positions] = *trajectory.robot;
  planner.add_articulation(model->self_contained_description(), base);
  std::map<std::string, double> others;
  for (Eigen::Index i = 0; i < positions.size(); ++i)
    others[model->other_joints()[static_cast<std::size_t>(i)].name] = positions[i];
  planner.set_joint_positions(model->name(), others);
  return model->name();
}

/// Calls `compute` with the robot that the planner knows, or without one, for the trajectory's own.
template <class Compute>
auto of_robot(nb::handle planner, nb::handle robot, Compute&& compute) {
  if (planner.is_none() && !robot.is_none()) throw InvalidArgument("a robot is named, but no planner to find it in");
  return planner.is_none() ? compute() : compute(placed_robot(planner, robot));
}

void bind_motion(nb::class_<Trajectory>& cls) {
  cls.def(
         "sample",
         [](const Trajectory& self, const ArrayLike& t) -> nb::object {
           return states(self, t, &MotionState::position)[0];
         },
         nb::arg("t"), nb::sig("def sample(self, t: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]"),
         R"(Position [rad or m] at time t [s]: (dof,) for a number, (k, dof) for (k,). Times outside are moved to the nearest
end.

Raises InvalidArgument for NaN, and for a path without times.)")
      .def(
          "state",
          [](const Trajectory& self, const ArrayLike& t) {
            return states(self, t, &MotionState::position, &MotionState::velocity, &MotionState::acceleration,
                          &MotionState::jerk);
          },
          nb::arg("t"),
          nb::sig("def state(self, t: numpy.typing.ArrayLike) -> tuple[numpy.typing.NDArray[numpy.float64], "
                  "numpy.typing.NDArray[numpy.float64], numpy.typing.NDArray[numpy.float64], "
                  "numpy.typing.NDArray[numpy.float64]]"),
          R"(The state (position, velocity, acceleration, jerk) at time t [s], each as in sample [rad or m, /s, /s^2, /s^3];
where one jumps: just after.)")
      .def(
          "resample",
          [](const Trajectory& t, double dt, const std::optional<MotionLimits>& limits) {
            return limits ? t.resample(dt, *limits) : t.resample(dt);
          },
          nb::arg("dt"), nb::arg("limits") = nb::none(),
          R"(Rows at every multiple of dt [s] from the start that is not within 1 % of dt of the end, and at the end.

Another motion, near this one: the polynomials through the new rows. They may exceed limits that this one obeys; the
certificate, if this one has one, then says so (it says nothing of collisions: PlannerInterface.verify does).

With `limits`, rows are at multiples of dt and nowhere else, and the motion keeps these velocity and acceleration limits:
it is as much slower as that takes, everywhere. Raises InvalidArgument unless dt > 0 and there are at most ten million
rows, and for limits that are not of these joints.)")
      .def(
          "slice", &Trajectory::slice, nb::arg("from_time"), nb::arg("to_time"),
          R"(The same motion from one time to another [s], with its times; cut between rows where needed, but at a row that is
within 1 µs.

Its waypoints are its own rows. A certificate that holds is kept, for the scene it was made in: what was proved of the
motion is proved of its parts, the use of limits is found anew; the clearance is what was proved of the whole motion
unless its nearest place is in the part; deviation and goal_error are NaN. Raises InvalidArgument unless from_time < to_time and the two overlap the motion.)")
      .def(
          "followed_by", &Trajectory::followed_by, nb::arg("next"),
          R"(This motion and then `next`, whose times are moved to follow; `a + b` is the same. Where both have certificates
that hold, for the same limits, it has one: each motion's claims in the scene in which it was verified, but for path
constraints, poses and clearance, which may be of one of them only.

Raises InvalidArgument unless joint names agree and `next` starts where this ends: positions within 1e-9, velocities
within 1e-6.)")
      .def(
          "__add__", [](const Trajectory& a, const Trajectory& b) { return a.followed_by(b); }, nb::arg("next"),
          nb::is_operator(), "The same as followed_by.")
      .def(
          "of_joints", &Trajectory::of_joints, nb::arg("joints"), nb::arg("names") = std::vector<std::string>{},
          R"(The same motion of these joints (list of names) alone, in this order: for the controller of one arm of several,
which may know them by other `names` (one a joint; none: they keep theirs).

It has no certificate and no robot, which are of all joints. Raises InvalidArgument for no joint, one that is not here
(with the nearest name), one that is named twice, and another number of names.)")
      .def("__getitem__", &part, nb::arg("rows"), nb::sig("def __getitem__(self, rows: slice) -> Trajectory"),
           R"(trajectory[i:j]: rows i to j-1 and the same motion between them; waypoints and certificate as in slice.

Raises InvalidArgument for a step, and where no rows are left.)")
      .def(
          "end_effector_path",
          [](const Trajectory& self, nb::handle planner, nb::handle robot, const std::string& link) {
            return of_robot(planner, robot,
                            [&](const auto&... of) { return to_numpy_rows(self.end_effector_path(of..., link)); });
          },
          nb::arg("planner") = nb::none(), nb::arg("robot") = nb::none(), nb::arg("link") = "",
          nb::sig("def end_effector_path(self, planner: PlannerInterface | None = None, robot: str | None = None, "
                  "link: str = '') -> numpy.typing.NDArray[numpy.float64]"),
          R"(Positions (n, 3) [m], world frame, of the origin of a link (default: the end effector) at each row.

A trajectory of plan knows its robot and that robot's base pose. Others (made by hand, unpickled, read from a file)
need a planner, and `robot` by name where it has several. Joints are matched by name, in any order.

Raises InvalidArgument for an unknown robot or link, and when the joints are not its planned ones.)")
      .def(
          "end_effector_length",
          [](const Trajectory& self, nb::handle planner, nb::handle robot, const std::string& link) {
            return of_robot(planner, robot, [&](const auto&... of) { return self.end_effector_length(of..., link); });
          },
          nb::arg("planner") = nb::none(), nb::arg("robot") = nb::none(), nb::arg("link") = "",
          nb::sig("def end_effector_length(self, planner: PlannerInterface | None = None, robot: str | None = None, "
                  "link: str = '') -> float"),
          R"(Length [m] of the path of that origin: the motion is followed in steps of 10 ms, or of 0.01 rad (m) where there are
no times.

Arguments and errors as in end_effector_path.)");
}

void bind_forms(nb::class_<Trajectory>& cls) {
  cls.def(
         "to_dict", [](nb::handle_t<Trajectory> self) { return in_python("to_dict")(self); },
         nb::sig("def to_dict(self) -> dict[str, typing.Any]"),
         R"(A dictionary of lists and names, as JSON can hold them: joint_names, positions, waypoints and, where known, times,
velocities, accelerations.

The certificate is not in it: a reader makes its own with PlannerInterface.verify.)")
      .def_static(
          "from_dict", [](nb::handle dictionary) { return in_python("from_dict")(dictionary); },
          nb::arg("dictionary").none(),
          nb::sig("def from_dict(dictionary: collections.abc.Mapping[str, typing.Any]) -> Trajectory"),
          R"(The trajectory of a dictionary that to_dict made; it equals the original.

Raises InvalidArgument for unknown or missing keys (with the nearest), and as the constructor does.)")
      .def(
          "to_csv", [](nb::handle_t<Trajectory> self, nb::handle path) { in_python("to_csv")(self, path); },
          nb::arg("path"), nb::sig("def to_csv(self, path: str | os.PathLike[str]) -> None"),
          R"(Writes a table, one line for each row: time [s], then <joint>_position [rad or m] of each joint, and, where known,
<joint>_velocity and <joint>_acceleration.

Numbers read back bit for bit. Waypoints and certificate are not in it. Raises FileError when it cannot be written.)")
      .def_static(
          "from_csv", [](nb::handle path) { return in_python("from_csv")(path); }, nb::arg("path"),
          nb::sig("def from_csv(path: str | os.PathLike[str]) -> Trajectory"),
          R"(The trajectory of a table as to_csv writes it; columns in any order, joints in that of their positions; the
waypoints are the rows.

Raises FileError, naming the line, for a missing file, unknown or missing columns, cells that are not numbers, and
what the constructor refuses.)")
      .def(
          "to_numpy", [](nb::handle_t<Trajectory> self) { return in_python("to_numpy")(self); },
          nb::sig("def to_numpy(self) -> numpy.typing.NDArray[numpy.void]"),
          R"(A structured array (n,) with the fields position (dof,) and, where known, time, velocity, acceleration, jerk: for
numpy.save, pandas and the like.)")
      .def(
          "to_joint_trajectory",
          [](nb::handle_t<Trajectory> self, bool accelerations) {
            return in_python("to_joint_trajectory")(self, accelerations);
          },
          nb::kw_only(), nb::arg("accelerations") = false,
          nb::sig("def to_joint_trajectory(self, *, accelerations: bool = False) -> dict[str, typing.Any]"),
          R"(A dictionary laid out like ROS 2's trajectory_msgs/JointTrajectory: header, joint_names, points of positions,
velocities, accelerations, effort (empty) and time_from_start (sec, nanosec) since the first row.

Accelerations are left out by default: with positions and velocities alone a joint_trajectory_controller follows the
cubics that this motion is; given accelerations too, it follows quintics, another motion, which nobody has checked.

Raises InvalidArgument without times, and for rows less than a nanosecond apart.)")
      .def(
          "to_ros",
          [](nb::handle_t<Trajectory> self, const std::string& message, bool accelerations) {
            return in_python("to_ros")(self, message, accelerations);
          },
          nb::arg("message") = "JointTrajectory", nb::kw_only(), nb::arg("accelerations") = false,
          nb::sig("def to_ros(self, message: str = 'JointTrajectory', *, accelerations: bool = False) -> typing.Any"),
          R"(A ROS message of the trajectory: a trajectory_msgs/JointTrajectory, or with message="RobotTrajectory" a
moveit_msgs/RobotTrajectory that holds it. Where that package cannot be imported: the dictionary laid out like the
message. No node is needed, and ROS 1 and ROS 2 will do. Times and accelerations are as in to_joint_trajectory.

Raises InvalidArgument for another message, without times, and for rows less than a nanosecond apart.)")
      .def_static(
          "from_joint_trajectory", [](nb::handle message) { return in_python("from_joint_trajectory")(message); },
          nb::arg("message").none(),
          nb::sig("def from_joint_trajectory(message: collections.abc.Mapping[str, typing.Any]) -> Trajectory"),
          R"(The trajectory of a dictionary laid out like that; times are the times from start, the waypoints are the rows, the
header is not used.

Raises InvalidArgument, naming the point, for unknown or missing keys, for efforts, for points of which only some
have velocities or accelerations, and as the constructor does.)")
      .def(
          "plot",
          [](nb::handle_t<Trajectory> self, nb::handle path, nb::handle limits, const std::string& title) {
            return in_python("plot")(self, path, limits, title);
          },
          nb::arg("path") = nb::none(), nb::arg("limits") = nb::none(), nb::arg("title") = "",
          nb::sig("def plot(self, path: str | os.PathLike[str] | None = None, limits: MotionLimits | None = None, "
                  "title: str = '') -> typing.Any"),
          R"(Draws position, velocity, acceleration and jerk of every joint over time, as a matplotlib Figure, which is
returned, and written where there is a path (PNG, PDF or SVG, by its suffix). Dashed: `limits`, default those of the
certificate.

Raises InvalidArgument without times, for limits of another number of joints and for a suffix of no figure format;
FileError when it cannot be written; ModuleNotFoundError where matplotlib is not installed.)")
      .def(
          "_add_robot_to",
          [](const Trajectory& self, PyPlannerInterface& planner) {
            return planner.use([&](PlannerInterface& p) { return add_robot(self, p); });
          },
          "Adds the robot that this was planned for, and returns its name; '': the robot is not known.");
  make_html(cls);
}

}  // namespace

void bind_trajectory(nb::module_& m) {
  nb::class_<Trajectory> cls(
      m, "Trajectory",
      R"(A motion: n rows of dof joints. Revolute joints in rad, prismatic ones in m; values of continuous joints do not jump
at ±pi.

Between two rows each joint follows the cubic polynomial that has their positions and velocities, a straight line
where there are no velocities; every claim about the motion is about these. Arrays are read-only views without a
copy. A trajectory does not change; two are equal when they have the same names and numbers, whatever is proved of
them.)");
  bind_data(cls);
  bind_motion(cls);
  bind_forms(cls);
}

}  // namespace srmp::python
