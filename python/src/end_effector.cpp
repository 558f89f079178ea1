#include "bind.hpp"
#include "srmp/robot/robot_description.hpp"

namespace srmp::python {

void bind_end_effector(nb::module_& m) {
  nb::class_<GripperOpening> opening(m, "GripperOpening",
                                     "How far two opposed fingers open. Between the two positions the width changes in "
                                     "proportion.");
  opening.def_ro("max_width", &GripperOpening::max_width, "[m], above 0.")
      .def_ro("closed", &GripperOpening::closed,
              "Positions by joint name [m] where the fingers are nearest to each other: width 0.")
      .def_ro("opened", &GripperOpening::opened, "Positions by joint name [m] where the width is max_width.")
      .def("__repr__", [](const GripperOpening& self) { return "GripperOpening(" + to_text(self.max_width) + " m)"; });
  nb::class_<EndEffector> effector(m, "EndEffector", "An end effector of an SRDF, such as a gripper.");
  effector.def_ro("name", &EndEffector::name, "As in the SRDF.")
      .def_ro("link", &EndEffector::link, "To which it is attached: the SRDF's parent_link.")
      .def_ro("group", &EndEffector::group, "Of its own links and joints.")
      .def_ro("parent_group", &EndEffector::parent_group, "Of the arm that carries it; \"\": the SRDF does not say.")
      .def_ro("joints", &EndEffector::joints, "Of its group, with one degree of freedom, that are not mimic joints.")
      .def_ro("states", &EndEffector::states,
              "The group's states, such as \"open\": by name, then by joint name [rad or m]. A state may give some of\n"
              "the joints.")
      .def_ro(
          "opening", &EndEffector::opening,
          R"(GripperOpening of two prismatic fingers on one link that move against each other; the width is how far they have
moved apart from where they are nearest, which is the gap between them if they touch there. None: they are no such
fingers.)")
      .def("__repr__",
           [](const EndEffector& self) { return "EndEffector('" + self.name + "' at '" + self.link + "')"; });
}

}  // namespace srmp::python
