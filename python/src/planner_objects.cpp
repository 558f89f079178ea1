#include <cmath>

#include "planner_interface.hpp"
#include "srmp/moveit_request.hpp"

namespace srmp::python {

namespace {

using Self = PyPlannerInterface;

std::array<int, 3> to_triangle(const Eigen::Vector3d& row, const std::string& mesh) {
  std::array<int, 3> triangle{};
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (!(row[i] >= 0 && row[i] < 2e9 && row[i] == std::floor(row[i])))
      throw InvalidArgument("triangles of mesh '" + mesh + "' hold " + to_text(row[i]) +
                            "; they must be whole vertex numbers from 0");
    triangle[static_cast<std::size_t>(i)] = static_cast<int>(row[i]);
  }
  return triangle;
}

}  // namespace

void bind_objects(PlannerClass& cls) {
  cls.def(
         "add_box",
         [](Self& self, const std::string& name, const ArrayLike& size, const Pose& pose, double padding) {
           const Eigen::Vector3d v = size.vector3("size of box '" + name + "'");
           self.use([&](auto& p) { p.add_box(name, v, pose, padding); });
         },
         nb::arg("name"), nb::arg("size"), nb::arg("pose") = Pose{}, nb::arg("padding") = 0.0,
         R"(Adds a box with full edge lengths `size` (3,) [m].

`pose` is that of the centre in the world, `padding` [m] is kept clear around the object. Raises InvalidArgument for
a name in use, or sizes that are not positive and finite.)")
      .def(
          "add_sphere",
          [](Self& self, const std::string& name, double radius, const Pose& pose, double padding) {
            self.use([&](auto& p) { p.add_sphere(name, radius, pose, padding); });
          },
          nb::arg("name"), nb::arg("radius"), nb::arg("pose") = Pose{}, nb::arg("padding") = 0.0,
          R"(Adds a sphere of `radius` [m].

`pose` is that of the centre in the world, `padding` [m] is kept clear around the object. Raises InvalidArgument for
a name in use, or sizes that are not positive and finite.)")
      .def(
          "add_cylinder",
          [](Self& self, const std::string& name, double radius, double length, const Pose& pose, double padding) {
            self.use([&](auto& p) { p.add_cylinder(name, radius, length, pose, padding); });
          },
          nb::arg("name"), nb::arg("radius"), nb::arg("length"), nb::arg("pose") = Pose{}, nb::arg("padding") = 0.0,
          R"(Adds a cylinder along z, `radius` and `length` [m].

`pose` is that of the centre in the world, `padding` [m] is kept clear around the object. Raises InvalidArgument for
a name in use, or sizes that are not positive and finite.)")
      .def(
          "add_capsule",
          [](Self& self, const std::string& name, double radius, double length, const Pose& pose, double padding) {
            self.use([&](auto& p) { p.add_capsule(name, radius, length, pose, padding); });
          },
          nb::arg("name"), nb::arg("radius"), nb::arg("length"), nb::arg("pose") = Pose{}, nb::arg("padding") = 0.0,
          R"(Adds a capsule along z: a cylinder of `length` with a half sphere on each end [m].

`pose` is that of the centre in the world, `padding` [m] is kept clear around the object. Raises InvalidArgument for
a name in use, or sizes that are not positive and finite.)")
      .def(
          "add_cone",
          [](Self& self, const std::string& name, double radius, double length, const Pose& pose, double padding) {
            self.use([&](auto& p) { p.add_cone(name, radius, length, pose, padding); });
          },
          nb::arg("name"), nb::arg("radius"), nb::arg("length"), nb::arg("pose") = Pose{}, nb::arg("padding") = 0.0,
          R"(Adds a cone along z, base at -length/2, apex at +length/2 [m].

`pose` is that of the centre in the world, `padding` [m] is kept clear around the object. Raises InvalidArgument for
a name in use, or sizes that are not positive and finite.)")
      .def(
          "add_mesh",
          [](Self& self, const std::string& name, const std::string& path, const Pose& pose,
             const std::optional<ArrayLike>& scale, bool convex, const std::optional<ArrayLike>& vertices,
             const std::optional<ArrayLike>& triangles, double padding) {
            if (path.empty() == !vertices)
              throw InvalidArgument("mesh '" + name + "' needs either a path or vertices (with triangles)");
            const Eigen::Vector3d s =
                scale ? scale->vector3("scale of mesh '" + name + "'") : Eigen::Vector3d(Eigen::Vector3d::Ones());
            if (!path.empty()) {
              self.use([&](auto& p) { p.add_mesh(name, path, pose, s, convex, padding); });
              return;
            }
            Mesh mesh;
            mesh.convex = convex;
            const RowMatrix corners = vertices->rows("vertices of mesh '" + name + "'", 3);
            for (const auto& row : corners.rowwise()) mesh.vertices.emplace_back(row.transpose());
            const RowMatrix faces =
                triangles ? triangles->rows("triangles of mesh '" + name + "'", 3) : RowMatrix(0, 3);
            for (const auto& row : faces.rowwise()) mesh.triangles.push_back(to_triangle(row.transpose(), name));
            self.use([&](auto& p) { p.add_mesh(name, scale ? mesh.scaled(s) : mesh, pose, padding); });
          },
          nb::arg("name"), nb::arg("path") = "", nb::arg("pose") = Pose{}, nb::arg("scale") = nb::none(), nb::kw_only(),
          nb::arg("convex") = false, nb::arg("vertices") = nb::none(), nb::arg("triangles") = nb::none(),
          nb::arg("padding") = 0.0,
          R"(Adds a triangle mesh from the file `path` or from `vertices` (n, 3) [m] and `triangles` (m, 3) of vertex numbers from 0,
multiplied by `scale` (3,).

`pose` is that of its origin in the world, `padding` [m] is kept clear around it. A mesh is its surface; convex=True
takes its solid convex hull instead (without `triangles`: that of the `vertices`).

Raises FileError (missing, unreadable or empty file) and InvalidArgument (name in use, neither or both of path and
vertices, NaN, vertex numbers that do not exist).)")
      .def(
          "add_point_cloud",
          [](Self& self, const std::string& name, const ArrayLike& points, double resolution, const Pose& pose,
             double padding, std::optional<double> self_filter_distance) {
            const RowMatrix rows = points.rows("points of cloud '" + name + "'", 3);
            std::vector<Eigen::Vector3d> list;
            list.reserve(static_cast<std::size_t>(rows.rows()));
            for (const auto& row : rows.rowwise()) list.emplace_back(row.transpose());
            self.use([&](auto& p) { p.add_point_cloud(name, list, resolution, pose, padding, self_filter_distance); });
          },
          nb::arg("name"), nb::arg("points"), nb::arg("resolution") = 0.02, nb::arg("pose") = Pose{},
          nb::arg("padding") = 0.0, nb::arg("self_filter_distance") = nb::none(),
          R"(Adds a point cloud (n, 3) [m]; every point fills a voxel with edges of `resolution` [m].

`pose` is that of its origin in the world; `padding` [m] is kept clear around it. With `self_filter_distance` [m],
points no farther than that from a robot at its set_qpos, or from what it holds, are left out: a camera sees the
robots too (at least twice the `resolution`, so that no voxel reaches the robot).

Raises InvalidArgument for a name in use, no points (or none left), NaN, or a resolution or distance that is not
above 0.)")
      .def(
          "remove_object",
          [](Self& self, const std::string& name) { self.use([&](auto& p) { p.remove_object(name); }); },
          nb::arg("name"), "Removes an object, attached or not.")
      .def(
          "set_object_pose",
          [](Self& self, const std::string& name, const Pose& pose) {
            self.use([&](auto& p) { p.set_object_pose(name, pose); });
          },
          nb::arg("name"), nb::arg("pose"),
          R"(Moves an object to its pose in the world.

Raises InvalidArgument while it is attached.)")
      .def(
          "set_padding",
          [](Self& self, const std::string& name, double padding) {
            self.use([&](auto& p) { p.set_padding(name, padding); });
          },
          nb::arg("name"), nb::arg("padding"),
          "Keeps `padding` [m], >= 0, clear around an object, or around every link of a robot.")
      .def(
          "attach_object",
          [](Self& self, const std::string& name, const std::string& robot, const std::string& link,
             const std::vector<std::string>& touch_links, const std::optional<Pose>& pose_in_link) {
            self.use([&](auto& p) { p.attach_object(name, robot, link, touch_links, pose_in_link); });
          },
          nb::arg("name"), nb::arg("robot"), nb::arg("link"), nb::arg("touch_links") = std::vector<std::string>{},
          nb::arg("pose_in_link") = nb::none(),
          R"(Attaches the object to a link, with which it moves from now on.

It keeps its pose relative to the link (robot at its set_qpos), or takes `pose_in_link`. It may touch `link` and
`touch_links`.

Raises InvalidArgument for unknown names or an object that is attached already.)")
      .def(
          "detach_object",
          [](Self& self, const std::string& name) { self.use([&](auto& p) { p.detach_object(name); }); },
          nb::arg("name"),
          R"(Detaches the object; it stays in the world where the robot (at its set_qpos) holds it.

Raises InvalidArgument when it is not attached.)")
      .def(
          "set_allowed_collision",
          [](Self& self, const std::string& a, const std::string& b, bool allowed) {
            self.use([&](auto& p) { p.set_allowed_collision(a, b, allowed); });
          },
          nb::arg("a"), nb::arg("b"), nb::kw_only(), nb::arg("allowed") = true,
          R"(Allows (or, with False, forbids again) contact of two bodies: objects, links ('link' or 'robot/link'), whole robots.
A later call replaces earlier ones that it covers.)")
      .def(
          "allowed_collision",
          [](Self& self, const std::string& a, const std::string& b) {
            return self.use([&](auto& p) { return p.scene().allowed_collision(a, b); });
          },
          nb::arg("a"), nb::arg("b"),
          R"(Returns whether contact of the two bodies is ignored: by set_allowed_collision, else by the robot's self-collision
rules or because one is held and may touch the other. Of a whole robot: for all its links.)")
      .def(
          "load_moveit_scene",
          [](Self& self, const std::string& path) {
            return self.use([&](auto& p) { return p.load_moveit_scene(path); });
          },
          nb::arg("path"),
          R"(Changes the scene by a MoveIt scene file (YAML), wholly or not at all: robot states, objects, attached objects,
allowed collisions, padding.

docs/moveit.md says of every field what it means. A file that is not a diff replaces the objects of earlier files;
objects that were added otherwise stay. The planning frame of the file is the world. Returns what was not used, as
sentences.

Raises FileError with the line, InvalidArgument for unknown names, and NotSupported for what is valid but not supported
(planes, octomaps, scaled links).)")
      .def(
          "apply_moveit_request",
          [](Self& self, const std::string& name, const io::RequestFile& request) {
            return self.use([&](PlannerInterface& p) { return p.apply_moveit_request(name, request); });
          },
          nb::arg("name"), nb::arg("request"),
          R"(Converts a MoveIt motion plan request to a problem of this robot: start, goals, options, and the joints that it names
and the robot does not have.

docs/moveit.md says of every field what it means. Its start state is set in this world: the base (by the virtual joint),
movable joints that are not planned (a gripper's), and attached objects. Goals keep within MoveIt's tolerances. They may
be for the end effector, any link or attached object that is rigidly joined to it, subframes of these, and points beside
them.

Raises InvalidArgument for names of frames, links, joints and groups that do not exist; and NotSupported for goals that
cannot be stated here: some of the joints only, joints together with links, several constraints of one kind, links that
are not joined to the end effector, frames that move with the planned joints, and points beside the end effector's
origin without an orientation. Goals that cannot be reached are reported by plan.)")
      .def("reset", [](Self& self) { self.reset(); }, "Removes all robots, objects, planners and heuristics.");
}

void bind_moveit_problem(nb::module_& m) {
  nb::class_<MoveItProblem>(m, "MoveItProblem", "A MoveIt motion request as a planning problem of one robot.")
      .def_prop_ro(
          "start", [](const MoveItProblem& problem) { return to_numpy(problem.start); },
          "The start configuration (dof,) [rad or m]; joints that the file leaves out stand at their set_qpos.")
      .def_ro("goals", &MoveItProblem::goals, "The goals, as GoalConstraint objects; any one of them is enough.")
      .def_prop_ro(
          "options", [](const MoveItProblem& problem) { return to_dict(problem.options); },
          nb::sig("def options(self) -> dict[str, typing.Any]"),
          R"(What the request says, for make_planner: time_limit, velocity_scaling and acceleration_scaling where they are
given, and planner_id where it is an id of this library.)")
      .def_ro("link_speeds", &MoveItProblem::link_speeds,
              "For set_motion_limits: LinkSpeedLimit of the request's max_cartesian_speed; empty: there is none.")
      .def_ro("ignored_joints", &MoveItProblem::ignored_joints,
              "Joints named by the start state, but not movable joints of this robot.")
      .def_ro("constraints", &MoveItProblem::constraints,
              "PathConstraint objects, for plan: the request's path_constraints.")
      .def_prop_ro(
          "start_velocity",
          [](const MoveItProblem& problem) -> std::optional<NumpyArray> {
            if (problem.start_velocity.size() == 0) return std::nullopt;
            return to_numpy(problem.start_velocity);
          },
          "With which the motion begins, for plan: (dof,) [rad/s or m/s]; None: at rest.")
      .def("__repr__", [](const MoveItProblem& problem) {
        const std::size_t goals = problem.goals.size();
        return "MoveItProblem(" + std::to_string(goals) + (goals == 1 ? " goal)" : " goals)");
      });
}

}  // namespace srmp::python
