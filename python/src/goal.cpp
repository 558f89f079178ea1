#include "bind.hpp"

namespace srmp::python {

namespace {

/// One target or several: a Pose, numbers, an array with one target a row, or a list of these.
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
  if (numbers.ndim() != 2) throw InvalidArgument("goal targets must be one row of numbers, or one row a target");
  std::vector<Eigen::VectorXd> targets;
  for (std::size_t i = 0; i < numbers.shape(0); ++i)
    targets.emplace_back(Eigen::Map<const Eigen::VectorXd>(numbers.data() + i * numbers.shape(1),
                                                           static_cast<Eigen::Index>(numbers.shape(1))));
  return targets;
}

std::string text(const GoalConstraint& goal) {
  return "GoalConstraint(" + std::string(to_string(goal.type)) + ", " + std::to_string(goal.targets.size()) +
         (goal.targets.size() == 1 ? " target)" : " targets)");
}

}  // namespace

void bind_goal(nb::module_& m) {
  nb::enum_<GoalType>(m, "GoalType", "What a goal speaks of.")
      .value("JOINTS", GoalType::joints, "A configuration of the planned joints.")
      .value("POSE", GoalType::pose, "Position and orientation of the end effector, world frame.")
      .value("POSITION", GoalType::position, "Position of the end effector, world frame; any orientation.");

  nb::class_<GoalConstraint> cls(
      m, "GoalConstraint",
      "What a plan must reach: any one of several targets of one type.\n\n"
      "Joint targets are met exactly; for poses and positions inverse kinematics supplies configurations,\n"
      "to 1e-5 m and 1e-4 rad where it can and within the tolerances at worst.");
  cls.def(
         "__init__",
         [](GoalConstraint* self, GoalType type, nb::object targets, double position_tolerance,
            double rotation_tolerance) {
           GoalConstraint goal{type, to_targets(type, targets), position_tolerance, rotation_tolerance};
           goal.validate();
           new (self) GoalConstraint(std::move(goal));
         },
         nb::arg("type"), nb::arg("targets"), nb::arg("position_tolerance") = 1e-3,
         nb::arg("rotation_tolerance") = 1e-2,
         nb::sig("def __init__(self, type: GoalType, targets: Pose | numpy.typing.ArrayLike | "
                 "collections.abc.Sequence[Pose], "
                 "position_tolerance: float = 0.001, rotation_tolerance: float = 0.01) -> None"),
         "targets: JOINTS dof numbers [rad or m]; POSE x, y, z, qx, qy, qz, qw or a Pose; POSITION x, y, z [m]; or a "
         "list of\n"
         "such targets, any of which will do. Tolerances in m and rad.\n\n"
         "Raises InvalidArgument for no target, a wrong number of entries, NaN or a zero quaternion.")
      .def_ro("type", &GoalConstraint::type, "What the targets are.")
      .def_ro("position_tolerance", &GoalConstraint::position_tolerance, "[m]")
      .def_ro("rotation_tolerance", &GoalConstraint::rotation_tolerance, "[rad]")
      .def_prop_ro(
          "targets",
          [](const GoalConstraint& goal) {
            return to_numpy_rows(goal.targets,
                                 goal.targets.empty() ? 0 : static_cast<std::size_t>(goal.targets[0].size()));
          },
          "(n, k), one target a row: k = dof for JOINTS, 7 for POSE, 3 for POSITION.")
      .def("__repr__", &text);
  make_value(
      cls,
      [](const GoalConstraint& goal) {
        std::vector<std::vector<double>> targets;
        for (const auto& t : goal.targets) targets.emplace_back(t.begin(), t.end());
        return nb::make_tuple(goal.type, targets, goal.position_tolerance, goal.rotation_tolerance);
      },
      [](const nb::tuple& state) {
        std::vector<Eigen::VectorXd> targets;
        for (const auto& t : nb::cast<std::vector<std::vector<double>>>(state[1]))
          targets.emplace_back(Eigen::Map<const Eigen::VectorXd>(t.data(), static_cast<Eigen::Index>(t.size())));
        return GoalConstraint{nb::cast<GoalType>(state[0]), std::move(targets), nb::cast<double>(state[2]),
                              nb::cast<double>(state[3])};
      });
}

}  // namespace srmp::python
