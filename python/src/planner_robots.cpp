#include <algorithm>

#include "planner_interface.hpp"

namespace srmp::python {

using Self = PyPlannerInterface;

namespace {

/// Adds the robot and issues its warnings. Where the user made errors of them, the robot is not added.
void add(PlannerInterface& planner, const RobotDescription& description, const Pose& base) {
  const std::vector<std::string> before = planner.robot_names();
  planner.add_articulation(description, base);
  for (const std::string& name : planner.robot_names()) {
    if (std::find(before.begin(), before.end(), name) != before.end()) continue;
    const std::vector<std::string> warnings = planner.warnings(name);
    try {
      for (const std::string& warning : warnings) warn_of_robot("robot '" + name + "': " + warning);
    } catch (const nb::python_error&) {
      planner.remove_articulation(name);
      throw;
    }
    return;
  }
}

/// PlanarBounds or FloatingBounds, from their corners; `names` are those of the coordinates.
template <class Bounds>
std::optional<Bounds> bounds_of(const std::optional<ArrayLike>& corners, const char* argument, const char* names) {
  if (!corners) return std::nullopt;
  const RowMatrix rows = corners->rows(argument, decltype(Bounds::lower)::RowsAtCompileTime);
  if (rows.rows() != 2)
    throw InvalidArgument(std::string(argument) + " has " + std::to_string(rows.rows()) +
                          " rows; it takes two, the smallest " + names + " and the largest");
  return Bounds{rows.row(0).transpose(), rows.row(1).transpose()};
}

}  // namespace

void bind_robots(PlannerClass& cls) {
  cls.def(
         "add_articulation",
         [](Self& self, const std::string& urdf_path, const std::string& srdf_path, const std::string& name,
            const std::string& end_effector, const std::string& group, const std::vector<std::string>& joint_names,
            const std::map<std::string, double>& fixed_joints, const std::vector<std::string>& package_dirs,
            const std::string& urdf_text, const Pose& base_pose, const std::string& srdf_text,
            const std::string& urdf_directory, const std::optional<ArrayLike>& planar_bounds,
            const std::optional<ArrayLike>& floating_bounds, bool strict) {
           if (name.ends_with(".urdf"))
             throw InvalidArgument("name of the robot is '" + name +
                                   "', the path of a URDF: the arguments are urdf_path, "
                                   "srdf_path, name and end_effector, in this order; give them by name");
           const RobotDescription description{
               .urdf_path = urdf_path,
               .urdf_text = urdf_text,
               .urdf_directory = urdf_directory,
               .srdf_path = srdf_path,
               .srdf_text = srdf_text,
               .name = name,
               .end_effector = end_effector,
               .group = group,
               .joint_names = joint_names,
               .fixed_joints = fixed_joints,
               .package_dirs = package_dirs,
               .planar_bounds = bounds_of<PlanarBounds>(planar_bounds, "planar_bounds", "x and y"),
               .floating_bounds = bounds_of<FloatingBounds>(floating_bounds, "floating_bounds", "x, y and z"),
               .strict = strict};
           self.use([&](PlannerInterface& p) { add(p, description, base_pose); });
         },
         nb::arg("urdf_path") = "", nb::arg("srdf_path") = "", nb::arg("name") = "", nb::arg("end_effector") = "",
         nb::arg("group") = "", nb::arg("joint_names") = std::vector<std::string>{},
         nb::arg("fixed_joints") = std::map<std::string, double>{},
         nb::arg("package_dirs") = std::vector<std::string>{}, nb::arg("urdf_text") = "", nb::arg("base_pose") = Pose{},
         nb::arg("srdf_text") = "", nb::arg("urdf_directory") = "", nb::kw_only(),
         nb::arg("planar_bounds") = nb::none(), nb::arg("floating_bounds") = nb::none(), nb::arg("strict") = false,
         R"(Adds a robot from a URDF and, where there is one, an SRDF; `base_pose` is the pose of its root link in the world.

name: unique; default the URDF's. end_effector: the link that goals refer to. Planned joints: joint_names, else the
SRDF group, else the chain to the end effector. fixed_joints: values [rad or m] of all other joints. package_dirs:
directories where meshes are searched besides the URDF's. urdf_text, srdf_text: the URDF and the SRDF themselves
instead of their files; urdf_directory: where the file of urdf_text would lie, for its meshes.

The planned joints stand at the values nearest to 0 within their limits. Without an SRDF, adjacent links may touch,
and so may links that touch with all joints at 0 and in more than 95 % of the sampled configurations
(get_always_colliding).

planar_bounds: [[x, y], [x, y]], the smallest and the largest [m], of a robot that drives: its planar joint (of the
URDF, or the virtual joint of the SRDF; otherwise one called 'base' that moves the root link) becomes '<joint>/x',
'<joint>/y' and '<joint>/theta' [rad], which are planned before the other joints. The base is taken to move in any
direction.

floating_bounds: [[x, y, z], [x, y, z]] [m], instead, of a robot that flies: its floating joint, found in the same way,
becomes '<joint>/x', '<joint>/y', '<joint>/z', '<joint>/yaw', '<joint>/pitch' and '<joint>/roll' [rad]. Pitch is within
±pi/2, so that every orientation is reached once; near ±pi/2 yaw and roll turn about the same axis.

What was read but not used is issued as RobotWarning and listed by warnings(name): unknown tags, names in the SRDF
that the URDF does not have, planar and floating joints without these bounds, which are not planned. With `strict`,
mistakes among these raise FileError.

Raises FileError (missing or broken file: line and place; a missing mesh lists every place tried) and
InvalidArgument (a name in use; unknown group, joint or link, with the nearest name; bounds that are not finite, empty
or beyond 1000 m, or both kinds of bounds).)")
      .def(
          "add_robot",
          [](nb::handle self, const nb::object& robot, const nb::kwargs& arguments) {
            return nb::module_::import_("srmp.robots").attr("add_robot")(self, robot, **arguments);
          },
          nb::arg("robot").none(), nb::arg("arguments"),
          nb::sig("def add_robot(self, robot: str, **arguments: typing.Any) -> typing.Any"),
          R"(Adds a robot by its name in the list of known robots (`srmp robots`, srmp.robots.available()).

robot: such as "arm7", or "panda" of the package example-robot-data. arguments: those of add_articulation that shall
be other than the list's: name (default: `robot`), group, end_effector, joint_names, fixed_joints, base_pose,
package_dirs, planar_bounds, floating_bounds, strict. Groups, end effector, positions of other joints, allowed
collisions and motion limits are the list's.

Returns the srmp.robots.Robot, which has the joints of its gripper too. Raises InvalidArgument (unknown name, with
the nearest; an argument that it does not take), FileError (a broken file) and NotSupported (a package that is not
installed); then nothing was added. See docs/robots.md.)")
      .def_prop_ro(
          "only_robot", [](Self& self) { return self.use([](const PlannerInterface& p) { return p.only_robot(); }); },
          R"(The name of the only robot.

Raises InvalidArgument where there is not exactly one.)")
      .def(
          "warnings",
          [](Self& self, const std::string& robot) {
            return self.use([&](const PlannerInterface& p) { return p.warnings(robot); });
          },
          nb::arg("robot"),
          R"(What was read but not used when the robot was added, as sentences: unknown tags and attributes of the URDF and SRDF,
names in the SRDF that the URDF does not have, an SRDF with another robot name; planar and floating joints without
bounds, which stay at their origin; angles that look like degrees.)")
      .def(
          "remove_articulation",
          [](Self& self, const std::string& name) { self.use([&](auto& p) { p.remove_articulation(name); }); },
          nb::arg("name"), "Removes a robot, its planners and its attachments: what it held stays in the world.")
      .def(
          "join_robots",
          [](Self& self, const std::string& name, const std::vector<std::string>& robots) {
            self.use([&](auto& p) { p.join_robots(name, robots); });
          },
          nb::arg("name"), nb::arg("robots"),
          R"(Makes one robot, `name`, of several that stand in the scene (list of names), to plan what they do together, such as
holding one object in two hands: its joints and links are theirs, called "<robot>_<joint>" and "<robot>_<link>", one
robot after the other.

It stands as they did, holds what they held, may touch what they might, and has their motion limits; goals name their
link. Planners of the robots are forgotten. Trajectory.of_joints gives each controller its part of a motion.

Raises InvalidArgument for fewer than two robots, unknown or repeated ones, a name that another robot or an object has,
joined names that are the same, different paddings, and more than one payload; then nothing has changed.)")
      .def(
          "set_base_pose",
          [](Self& self, const std::string& name, const Pose& pose) {
            self.use([&](auto& p) { p.set_base_pose(name, pose); });
          },
          nb::arg("name"), nb::arg("pose"), "Places the robot's root link at its pose in the world.")
      .def(
          "set_qpos",
          [](Self& self, const std::string& name, const ArrayLike& q) {
            const Eigen::VectorXd v = q.vector("q of '" + name + "'");
            self.use([&](auto& p) { p.set_qpos(name, v); });
          },
          nb::arg("name"), nb::arg("q"),
          R"(Sets the planned joints (dof,) [rad or m]: the robot stands there while others plan, and attach_object and
detach_object use it.

Raises InvalidArgument for a wrong size, NaN, or a joint outside its limits.)")
      .def(
          "set_joint_positions",
          [](Self& self, const std::string& name, const std::map<std::string, double>& positions) {
            self.use([&](auto& p) { p.set_joint_positions(name, positions); });
          },
          nb::arg("name"), nb::arg("positions"),
          R"(Sets positions [rad or m] of any joints by name, planned or not (a gripper's, say); joints not named stay.

Raises InvalidArgument for an unknown joint, NaN, or a joint outside its limits.)");
}

}  // namespace srmp::python
