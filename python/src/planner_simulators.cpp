#include "planner_interface.hpp"

namespace srmp::python {

using Self = PyPlannerInterface;

/// What srmp/sim does, with a simulator.
void bind_simulators(PlannerClass& cls) {
  cls.def(
         "read_sim",
         [](nb::handle self, const nb::object& sim, const nb::object& kind, const nb::object& articulations,
            const nb::object& exclude) {
           return nb::module_::import_("srmp.sim").attr("read_sim")(self, sim, kind, articulations, exclude);
         },
         nb::arg("sim").none(), nb::arg("kind").none(), nb::arg("articulations") = nb::none(),
         nb::arg("exclude").none() = nb::make_tuple(),
         nb::sig("def read_sim(self, sim: object, kind: str, articulations: object = None, exclude: "
                 "collections.abc.Sequence[str] = ()) -> typing.Any"),
         R"(Reads a simulator's scene: its robots, and every collision shape of everything else, at their current poses.

sim: for kind "mujoco" (MjModel, MjData); "sapien" a Scene; "genesis" a built Scene; "pybullet" a client's number.
articulations: which of the simulator's articulations are robots, default all. A list names those that are planned
with the simulator's own model; a dict by robot name says more of each: urdf_path, srdf_path and the other arguments
of add_articulation, and `articulation`, its name in the simulator where that is another. exclude: objects or bodies
to leave out.

Contacts that the simulator filters are allowed collisions here; among the links of a robot from a URDF, the rules
of the URDF and SRDF apply (`self_collisions`: True takes the simulator's).

Returns the srmp.sim.SimulatedWorld, also in `simulated_world`: refresh, grasp, release, execute. Raises
InvalidArgument (a robot or joint that does not exist, with the nearest name) and NotSupported (a shape or joint
that cannot be read; a package that is missing); then nothing was read. See docs/simulators.md.)")
      .def_prop_rw(
          "simulated_world", [](Self& self) { return self.simulated_world; },
          [](Self& self, const nb::object& world) { self.simulated_world = world; }, nb::arg("world").none(),
          nb::for_getter(nb::sig("def simulated_world(self) -> typing.Any")),
          "The SimulatedWorld that read_sim returned; None before, and after reset.");
}

}  // namespace srmp::python
