#include "planner_interface.hpp"

namespace srmp::python {

using Self = PyPlannerInterface;

PlacedRobot placed_robot(nb::handle planner, nb::handle robot) {
  if (!nb::isinstance<Self>(planner))
    throw InvalidArgument("planner must be a PlannerInterface, but is " + nb::cast<std::string>(nb::repr(planner)));
  return nb::cast<Self&>(planner).use([&](const PlannerInterface& p) -> PlacedRobot {
    const std::vector<std::string> known = p.scene().robot_names();
    if (robot.is_none() && known.size() != 1)
      throw InvalidArgument("robot must be named where there is not exactly one; there are " + quoted_list(known));
    const RobotInstance& instance = p.scene().robot(robot.is_none() ? known[0] : to_names(robot, "robot").at(0));
    return {instance.model, instance.base, instance.other_positions};
  });
}

void bind_planner_interface(nb::module_& m) {
  bind_contact(m);
  bind_moveit_problem(m);

  static PyType_Slot slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(&Self::traverse)},
                                {Py_tp_clear, reinterpret_cast<void*>(&Self::clear)},
                                {0, nullptr}};
  nb::class_<Self> cls(m, "PlannerInterface", nb::type_slots(slots),
                       R"(A world of robots and objects, and the planners for them: the entry point of the library.

Poses are in the world frame; lengths are in metres, angles in radians, times in seconds; quaternions are [x, y, z,
w]; objects are solid. A configuration q has the robot's dof entries [rad or m], in the order of get_joint_names. A
call that is refused raises and changes nothing: InvalidArgument for unknown robots, objects or links (with the
nearest known name), wrong sizes, NaN and infinity. One thread at a time; a second one is refused with Error.)");
  cls.def(nb::init<>());
  bind_robots(cls);
  bind_objects(cls);
  bind_queries(cls);
  bind_simulators(cls);
  bind_verification(cls);
  bind_planning(cls);
  bind_files(cls);
  bind_drawing(cls);
}

}  // namespace srmp::python
