#include "srmp/trajectory/parameterize.hpp"

#include "bind.hpp"
#include "interrupt.hpp"
#include "srmp/core/run_interruptibly.hpp"

namespace srmp::python {

namespace {

constexpr Eigen::Index long_path = 1000;  // waypoints: TOPP-RA has steps that cannot be stopped

TimingMethod to_method(const std::string& method) {
  const std::vector<std::string> known{"toppra", "ruckig"};
  if (method == known[0]) return TimingMethod::toppra;
  if (method == known[1]) return TimingMethod::ruckig;
  throw InvalidArgument("method is '" + method + "'; it must be one of " + quoted_list(known) +
                        did_you_mean(method, known));
}

Trajectory in_time(const ArrayLike& waypoints, nb::handle joint_names, const MotionLimits& limits,
                   const std::string& method, double sample_period, double blend_deviation,
                   const std::optional<ArrayLike>& reach, const std::optional<nb::callable>& is_free,
                   const std::optional<ArrayLike>& start_velocity, const std::optional<ArrayLike>& end_velocity,
                   const std::optional<ArrayLike>& start_acceleration, nb::handle planner, nb::handle robot) {
  const std::vector<std::string> names = to_names(joint_names, "joint_names");
  const RowMatrix rows = waypoints.rows("waypoints", static_cast<Eigen::Index>(names.size()));
  TimingOptions options{.method = to_method(method),
                        .sample_period = sample_period,
                        .blend_deviation = blend_deviation,
                        .reach = vector_or_none(reach, "reach"),
                        .start_velocity = vector_or_none(start_velocity, "start_velocity"),
                        .end_velocity = vector_or_none(end_velocity, "end_velocity"),
                        .start_acceleration = vector_or_none(start_acceleration, "start_acceleration")};
  if (is_free)
    options.is_free = [&is_free](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
      const nb::gil_scoped_acquire gil;
      return nb::cast<bool>(nb::bool_((*is_free)(to_numpy(a), to_numpy(b))));
    };
  if (planner.is_none() && !robot.is_none()) throw InvalidArgument("a robot is named, but no planner to find it in");
  if (!planner.is_none()) options.robot = std::make_shared<const PlacedRobot>(placed_robot(planner, robot));
  const InterruptionScope interruptible(raise_interrupt);
  const nb::gil_scoped_release no_gil;
  if (rows.rows() < long_path || is_free) return time_parameterize(rows, names, limits, options);
  return run_interruptibly([=] { return time_parameterize(rows, names, limits, options); });
}

}  // namespace

void bind_parameterize(nb::module_& m) {
  m.def(
      "time_parameterize", &in_time, nb::arg("waypoints"), nb::arg("joint_names"), nb::arg("limits"),
      nb::arg("method") = "toppra", nb::arg("sample_period") = 0.02, nb::arg("blend_deviation") = 0.005,
      nb::arg("reach") = nb::none(), nb::arg("is_free") = nb::none(), nb::arg("start_velocity") = nb::none(),
      nb::arg("end_velocity") = nb::none(), nb::arg("start_acceleration") = nb::none(), nb::kw_only(),
      nb::arg("planner") = nb::none(), nb::arg("robot") = nb::none(),
      nb::sig("def time_parameterize(waypoints: numpy.typing.ArrayLike, joint_names: collections.abc.Sequence[str], "
              "limits: MotionLimits, method: str = 'toppra', sample_period: float = 0.02, "
              "blend_deviation: float = 0.005, reach: numpy.typing.ArrayLike | None = None, "
              "is_free: collections.abc.Callable[[numpy.typing.NDArray[numpy.float64], "
              "numpy.typing.NDArray[numpy.float64]], bool] | None = None, "
              "start_velocity: numpy.typing.ArrayLike | None = None, "
              "end_velocity: numpy.typing.ArrayLike | None = None, "
              "start_acceleration: numpy.typing.ArrayLike | None = None, *, planner: PlannerInterface | None = None, "
              "robot: str | None = None) -> Trajectory"),
      "A path in time: the straight lines between waypoints (m, dof) [rad or m] as fast as the limits allow, at every "
      "instant.\n\n"
      "method: 'toppra' rounds the corners and keeps velocities and accelerations (Pham, Pham 2018); 'ruckig' stops at "
      "each corner and\n"
      "keeps jerks too (Berscheid, Kröger 2021). sample_period [s]: a row at every multiple of it. blend_deviation "
      "[m]: "
      "no point of the\n"
      "robot leaves the path by more where corners are rounded; 0: a stop at each. reach (dof,): how far a unit of "
      "each "
      "joint moves any\n"
      "point of the robot [m/rad, prismatic joints 1], as CollisionChecker.reach knows it; default 1 each. is_free(a, "
      "b): is the\n"
      "straight motion from a (dof,) to b free? Called for the chords of rounded corners, which shrink until it says "
      "yes; "
      "default: all is.\n"
      "start_velocity, end_velocity (dof,) [rad/s or m/s]: along the first and last segment; default: at rest.\n"
      "start_acceleration (dof,) [rad/s^2 or m/s^2]: along the first segment, for 'ruckig'; default: 0.\n"
      "planner, robot: whose joints these are, where the limits have link_speeds; `robot` by name where it has "
      "several.\n\n"
      "First and last row are the first and last waypoint, bit for bit. Raises InvalidArgument for no waypoints, NaN, "
      "wrong sizes,\n"
      "limits and options out of range, continuous joints that do not go the short way, and end velocities that "
      "cannot be; what\n"
      "is_free raises is raised.");
}

}  // namespace srmp::python
