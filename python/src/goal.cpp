#include "bind.hpp"

namespace srmp::python {

namespace {

/// One target or several: a Pose, numbers, an array with one target in each row, or a list of these.
std::vector<Eigen::VectorXd> to_targets(GoalType type, nb::handle value) {
  Pose pose;
  if (nb::try_cast(value, pose)) {
    if (type != GoalType::pose)
      throw InvalidArgument("a Pose is a target for GoalType.POSE, not for " + std::string(to_string(type)));
    return GoalConstraint::pose(pose).targets;
  }
  std::vector<Pose> poses;
  if (nb::isinstance<nb::list>(value) && nb::len(value) > 0 && nb::try_cast(value, poses)) {
    std::vector<Eigen::VectorXd> targets;
    for (const Pose& each : poses) targets.push_back(to_targets(type, nb::cast(each)).front());
    return targets;
  }
  const auto numbers = to_numbers(value, "goal target");
  if (numbers.ndim() == 1)
    return {Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()))};
  if (numbers.ndim() != 2) throw InvalidArgument("goal targets must be one row of numbers, or one row for each target");
  std::vector<Eigen::VectorXd> targets;
  for (std::size_t i = 0; i < numbers.shape(0); ++i)
    targets.emplace_back(Eigen::Map<const Eigen::VectorXd>(numbers.data() + i * numbers.shape(1),
                                                           static_cast<Eigen::Index>(numbers.shape(1))));
  return targets;
}

AxisTolerance to_tolerance(const ArrayLike& value, const std::string& what) {
  const auto numbers = to_numbers(value.value, what);
  if (numbers.size() == 1) return numbers.data()[0];
  if (numbers.ndim() != 1 || numbers.size() != 3)
    throw InvalidArgument(what + " must be one number or three, for x, y and z");
  return {numbers.data()[0], numbers.data()[1], numbers.data()[2]};
}

std::string text(const GoalConstraint& goal) {
  const std::string links = goal.links.empty() ? "" : " of " + quoted_list(goal.links);
  return "GoalConstraint(" + std::string(to_string(goal.type)) + ", " + std::to_string(goal.targets.size()) +
         (goal.targets.size() == 1 ? " target" : " targets") + links + ")";
}

/// Each link with one pose.
GoalConstraint of_links(nb::handle poses, const ArrayLike& position_tolerance, const ArrayLike& rotation_tolerance) {
  GoalConstraint goal = GoalConstraint::poses(to_link_poses(poses));
  goal.position_tolerance = to_tolerance(position_tolerance, "position_tolerance");
  goal.rotation_tolerance = to_tolerance(rotation_tolerance, "rotation_tolerance");
  if (goal.links.empty()) throw InvalidArgument("a goal of links needs the pose of at least one link");
  goal.validate();
  return goal;
}

}  // namespace

void bind_goal(nb::module_& m) {
  nb::enum_<GoalType>(m, "GoalType", "The kind of a goal: what its targets are.")
      .value("JOINTS", GoalType::joints, "A configuration of the planned joints.")
      .value("POSE", GoalType::pose, "Position and orientation of the end effector, or of links, world frame.")
      .value("POSITION", GoalType::position, "Position of the end effector, or of links, world frame; any orientation.")
      .value("HOLD", GoalType::hold, "With plan_multi: the robot stays where it starts.")
      .value("ANY", GoalType::any, "With plan_multi: the robot may move out of the others' way and end anywhere.");

  nb::class_<GoalConstraint> cls(m, "GoalConstraint",
                                 R"(A goal of a plan: any one of several targets of one type.

Joint targets are reached exactly; for poses and positions inverse kinematics supplies configurations, to 1e-5 m and
1e-4 rad where it can and within the tolerances otherwise.)");
  cls.def(
         "__init__",
         [](GoalConstraint* self, GoalType type, nb::object targets, const ArrayLike& position_tolerance,
            const ArrayLike& rotation_tolerance, const std::string& link) {
           GoalConstraint goal{type, to_targets(type, targets), to_tolerance(position_tolerance, "position_tolerance"),
                               to_tolerance(rotation_tolerance, "rotation_tolerance"),
                               link.empty() ? std::vector<std::string>() : std::vector{link}};
           goal.validate();
           new (self) GoalConstraint(std::move(goal));
         },
         nb::arg("type"), nb::arg("targets"), nb::arg("position_tolerance") = 1e-3,
         nb::arg("rotation_tolerance") = 1e-2, nb::kw_only(), nb::arg("link") = "",
         nb::sig("def __init__(self, type: GoalType, targets: Pose | numpy.typing.ArrayLike | "
                 "collections.abc.Sequence[Pose], "
                 "position_tolerance: numpy.typing.ArrayLike = 0.001, rotation_tolerance: numpy.typing.ArrayLike = "
                 "0.01, *, link: str = '') -> None"),
         R"(A goal with these targets, any one of which is enough.

targets: JOINTS dof numbers [rad or m]; POSE x, y, z [m], qx, qy, qz, qw or a Pose, world frame; POSITION x, y, z
[m], world frame; or a list of such targets. Tolerances [m] and [rad]: one number, or three, for x, y and z of the
target's own frame (POSITION: of the world); infinity: that axis is free. link: of the robot, whose poses or positions
the targets are; "": the end effector.

Raises InvalidArgument for no target, a wrong size, NaN, a zero quaternion, a tolerance that is not above 0, when all
axes are free, and for a link of a goal without poses. Whether the robot has the link is checked where it is used.)")
      .def_static(
          "of_links", &of_links, nb::arg("poses"), nb::kw_only(), nb::arg("position_tolerance") = 1e-3,
          nb::arg("rotation_tolerance") = 1e-2,
          nb::sig("def of_links(poses: collections.abc.Mapping[str, Pose], *, position_tolerance: "
                  "numpy.typing.ArrayLike = 0.001, rotation_tolerance: numpy.typing.ArrayLike = 0.01) -> "
                  "GoalConstraint"),
          R"(Poses of links in the world frame, by link name, which are reached at the same time: both hands on a box.

Tolerances are those of the constructor, for each link. Raises InvalidArgument as it does, and for no link.)")
      .def_static("hold", &GoalConstraint::hold, "With plan_multi: the robot stays where it starts.")
      .def_static("any", &GoalConstraint::any,
                  "With plan_multi: the robot may move out of the others' way and end anywhere.")
      .def_ro("type", &GoalConstraint::type, "The kind of the goal: what the targets are.")
      .def_ro("links", &GoalConstraint::links,
              "Whose poses or positions the targets are, in the order of a target's numbers; []: the end effector's.")
      .def_prop_ro(
          "position_tolerance", [](const GoalConstraint& goal) { return to_numpy(goal.position_tolerance.axes); },
          "Tolerances (3,) [m] along x, y, z; infinity: that axis is free.")
      .def_prop_ro(
          "rotation_tolerance", [](const GoalConstraint& goal) { return to_numpy(goal.rotation_tolerance.axes); },
          "Tolerances (3,) [rad] about x, y, z; infinity: that axis is free.")
      .def_prop_ro(
          "targets",
          [](const GoalConstraint& goal) {
            return to_numpy_rows(goal.targets,
                                 goal.targets.empty() ? 0 : static_cast<std::size_t>(goal.targets[0].size()));
          },
          R"(The targets (n, k), one in each row: k = dof for JOINTS, 7 for POSE and 3 for POSITION, for each of the links, n = 0
for HOLD and ANY.)")
      .def("__repr__", &text);
  make_value(
      cls,
      [](const GoalConstraint& goal) {
        std::vector<std::vector<double>> targets;
        for (const auto& t : goal.targets) targets.emplace_back(t.begin(), t.end());
        const auto &p = goal.position_tolerance.axes, &r = goal.rotation_tolerance.axes;
        return nb::make_tuple(goal.type, targets, std::array{p[0], p[1], p[2]}, std::array{r[0], r[1], r[2]},
                              goal.links);
      },
      [](const State& state) {
        std::vector<Eigen::VectorXd> targets;
        for (const auto& t : nb::cast<std::vector<std::vector<double>>>(state[1]))
          targets.emplace_back(Eigen::Map<const Eigen::VectorXd>(t.data(), static_cast<Eigen::Index>(t.size())));
        const auto p = nb::cast<std::array<double, 3>>(state[2]), r = nb::cast<std::array<double, 3>>(state[3]);
        GoalConstraint goal{nb::cast<GoalType>(state[0]), std::move(targets), Eigen::Vector3d(p.data()),
                            Eigen::Vector3d(r.data()), nb::cast<std::vector<std::string>>(state[4])};
        goal.validate();
        return goal;
      });
}

}  // namespace srmp::python
