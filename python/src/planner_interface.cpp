#include "srmp/planner_interface.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "bind.hpp"
#include "collision_checker.hpp"
#include "srmp/moveit_request.hpp"

namespace srmp::python {

namespace {

/// The C++ object may be used by one thread at a time, and plans run without the GIL: a second thread is refused, not
/// queued, because its answer would depend on who came first.
class PyPlannerInterface {
 public:
  PyPlannerInterface() = default;
  explicit PyPlannerInterface(PlannerInterface planner) : planner_(std::move(planner)) {}

  template <class Use>
  auto use(Use&& call) {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock)
      throw Error(
          "this PlannerInterface is planning in another thread; give each thread a PlannerInterface of its own");
    return call(planner_);
  }

  // The functions of add_heuristic live here, where the garbage collector finds them; the planner borrows them.
  void add_heuristic(const std::string& name, const nb::callable& function, bool consistent) {
    use([&](PlannerInterface& p) { p.add_heuristic(name, borrowed(name, function), consistent); });
    heuristics_[name] = function;
  }
  void remove_heuristic(const std::string& name) {
    use([&](PlannerInterface& p) { p.remove_heuristic(name); });
    heuristics_.erase(name);
  }
  void reset() {
    use([](PlannerInterface& p) { p.reset(); });
    heuristics_.clear();
    simulated_world = nb::none();
  }

  nb::object simulated_world = nb::none();  ///< what read_sim made: srmp.sim.SimulatedWorld, which refers to this

  static int traverse(PyObject* object, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(object));
    if (!nb::inst_ready(object)) return 0;
    const auto* self = nb::inst_ptr<PyPlannerInterface>(object);
    for (const auto& [name, function] : self->heuristics_) Py_VISIT(function.ptr());
    Py_VISIT(self->simulated_world.ptr());
    return 0;
  }
  static int clear(PyObject* object) {
    if (nb::inst_ready(object)) nb::inst_ptr<PyPlannerInterface>(object)->reset();
    return 0;
  }

 private:
  /// Asked by the threads that plan, which do not have the GIL.
  static HeuristicFunction borrowed(const std::string& name, nb::handle function) {
    return [name, function](ConstRows configurations, ConstRows goals) {
      const nb::gil_scoped_acquire gil;
      const nb::object values = function(to_numpy_rows(configurations), to_numpy_rows(goals));
      return ArrayLike{values}.vector("values of heuristic '" + name + "'");
    };
  }

  std::mutex mutex_;
  PlannerInterface planner_;
  std::map<std::string, nb::callable> heuristics_;
};

using Self = PyPlannerInterface;

/// Ctrl-C: asked while planning without the GIL.
bool python_interrupted() {
  const nb::gil_scoped_acquire gil;
  return PyErr_CheckSignals() != 0;
}

/// `plan` without the GIL. A Ctrl-C that ended it is raised.
template <class Plan>
auto run_interruptible(Plan&& plan) {
  auto result = [&] {
    const nb::gil_scoped_release no_gil;
    return plan();
  }();
  if (PyErr_Occurred()) throw nb::python_error();
  return result;
}

/// The same; a PlanningError says what the planner did.
template <class Plan>
auto run_plan(const PlannerInterface& planner, Plan&& plan) {
  try {
    return run_interruptible(plan);
  } catch (const PlanningError& error) {
    if (error.status() == Status::cancelled && PyErr_Occurred()) throw nb::python_error();
    raise(error, to_dict(planner.get_planning_stats()));
  }
}

std::vector<PlanResult> plan_many(PlannerInterface& planner, const std::vector<PlanRequest>& requests,
                                  std::optional<int> threads, const std::optional<nb::callable>& progress) {
  PlannerInterface::Progress report;
  if (progress)
    report = [&progress](std::size_t done, std::size_t total) {
      const nb::gil_scoped_acquire gil;
      (*progress)(done, total);
    };
  return run_interruptible([&] { return planner.plan_many(requests, threads, python_interrupted, report); });
}

std::string only_robot(nb::handle robots) {
  const std::vector<std::string> names = to_names(robots);
  if (names.size() != 1)
    throw InvalidArgument("plan is for one robot, but " + std::to_string(names.size()) +
                          " were named; use plan_multi for many");
  return names[0];
}

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

/// The callback keeps what it was given; only False stops the search.
OnSolution to_on_solution(const nb::object& callback) {
  if (callback.is_none()) return {};
  if (!PyCallable_Check(callback.ptr()))
    throw InvalidArgument("on_solution must be a function of a dict and an array, or None");
  return [&callback](const Solution& solution, ConstRows waypoints) {
    const nb::gil_scoped_acquire gil;
    const nb::object answer = callback(to_dict(solution), to_numpy_rows(RowMatrix(waypoints)));
    return answer.ptr() != Py_False;
  };
}

void bind_robots(nb::class_<Self>& cls) {
  cls.def(
         "add_articulation",
         [](Self& self, const std::string& urdf_path, const std::string& srdf_path, const std::string& name,
            const std::string& end_effector, const std::string& group, const std::vector<std::string>& joint_names,
            const std::map<std::string, double>& fixed_joints, const std::vector<std::string>& package_dirs,
            const std::string& urdf_text, const Pose& base_pose, const std::string& srdf_text,
            const std::string& urdf_directory) {
           const RobotDescription description{.urdf_path = urdf_path,
                                              .urdf_text = urdf_text,
                                              .urdf_directory = urdf_directory,
                                              .srdf_path = srdf_path,
                                              .srdf_text = srdf_text,
                                              .name = name,
                                              .end_effector = end_effector,
                                              .group = group,
                                              .joint_names = joint_names,
                                              .fixed_joints = fixed_joints,
                                              .package_dirs = package_dirs};
           self.use([&](PlannerInterface& p) { p.add_articulation(description, base_pose); });
         },
         nb::arg("urdf_path") = "", nb::arg("srdf_path") = "", nb::arg("name") = "", nb::arg("end_effector") = "",
         nb::arg("group") = "", nb::arg("joint_names") = std::vector<std::string>{},
         nb::arg("fixed_joints") = std::map<std::string, double>{},
         nb::arg("package_dirs") = std::vector<std::string>{}, nb::arg("urdf_text") = "", nb::arg("base_pose") = Pose{},
         nb::arg("srdf_text") = "", nb::arg("urdf_directory") = "",
         "Add a robot from a URDF and, where there is one, an SRDF.\n\n"
         "name: unique; default the URDF's. end_effector: the link that goals speak of. Planned joints: joint_names, "
         "else the\n"
         "SRDF group, else the chain to the end effector. fixed_joints: values [rad or m] of all other joints. "
         "package_dirs:\n"
         "where meshes are searched besides the URDF's directory. urdf_text, srdf_text: the URDF "
         "and the SRDF\n"
         "themselves instead of their files; urdf_directory: where that of urdf_text would lie, for its meshes. "
         "base_pose: "
         "of\n"
         "the root link, in the world. Without an SRDF, adjacent links may touch, and so may links that touch with all "
         "joints at 0\n"
         "and in more than 95 % of the sampled configurations (see get_always_colliding).\n\n"
         "Raises FileError (missing or broken file: line and place; a missing mesh lists every place tried) and\n"
         "InvalidArgument (unknown names, with the nearest).")
      .def(
          "remove_articulation",
          [](Self& self, const std::string& name) { self.use([&](auto& p) { p.remove_articulation(name); }); },
          nb::arg("name"), "Remove a robot, its planners and what was attached to it.")
      .def(
          "set_base_pose",
          [](Self& self, const std::string& name, const Pose& pose) {
            self.use([&](auto& p) { p.set_base_pose(name, pose); });
          },
          nb::arg("name"), nb::arg("pose"), "Place the robot's root link: its pose in the world.")
      .def(
          "set_qpos",
          [](Self& self, const std::string& name, const ArrayLike& q) {
            const Eigen::VectorXd v = q.vector("q of '" + name + "'");
            self.use([&](auto& p) { p.set_qpos(name, v); });
          },
          nb::arg("name"), nb::arg("q"),
          "Where the robot stands while others plan, and what attach_object and detach_object go by: planned joints "
          "(dof,) "
          "[rad or m].\n\n"
          "Raises InvalidArgument for a wrong size, NaN, or a joint outside its limits.")
      .def(
          "set_joint_positions",
          [](Self& self, const std::string& name, const std::map<std::string, double>& positions) {
            self.use([&](auto& p) { p.set_joint_positions(name, positions); });
          },
          nb::arg("name"), nb::arg("positions"),
          "Positions [rad or m] of any joints by name, planned or not (a gripper's, say). Joints not named stay.\n\n"
          "Raises InvalidArgument for an unknown joint, NaN, or a joint outside its limits.");
}

void bind_objects(nb::class_<Self>& cls) {
  const auto add_doc = [](const std::string& what) {
    return what +
           " `pose` of its centre in the world; `padding` [m] is kept clear around it.\n\n"
           "Raises InvalidArgument for a name in use, or sizes that are not positive and finite.";
  };
  cls.def(
         "add_box",
         [](Self& self, const std::string& name, const ArrayLike& size, const Pose& pose, double padding) {
           const Eigen::Vector3d v = size.vector3("size of box '" + name + "'");
           self.use([&](auto& p) { p.add_box(name, v, pose, padding); });
         },
         nb::arg("name"), nb::arg("size"), nb::arg("pose") = Pose{}, nb::arg("padding") = 0.0,
         add_doc("Add a box with full edge lengths `size` (3,) [m].").c_str())
      .def(
          "add_sphere",
          [](Self& self, const std::string& name, double radius, const Pose& pose, double padding) {
            self.use([&](auto& p) { p.add_sphere(name, radius, pose, padding); });
          },
          nb::arg("name"), nb::arg("radius"), nb::arg("pose") = Pose{}, nb::arg("padding") = 0.0,
          add_doc("Add a sphere of `radius` [m].").c_str())
      .def(
          "add_cylinder",
          [](Self& self, const std::string& name, double radius, double length, const Pose& pose, double padding) {
            self.use([&](auto& p) { p.add_cylinder(name, radius, length, pose, padding); });
          },
          nb::arg("name"), nb::arg("radius"), nb::arg("length"), nb::arg("pose") = Pose{}, nb::arg("padding") = 0.0,
          add_doc("Add a cylinder along z, `radius` and `length` [m].").c_str())
      .def(
          "add_capsule",
          [](Self& self, const std::string& name, double radius, double length, const Pose& pose, double padding) {
            self.use([&](auto& p) { p.add_capsule(name, radius, length, pose, padding); });
          },
          nb::arg("name"), nb::arg("radius"), nb::arg("length"), nb::arg("pose") = Pose{}, nb::arg("padding") = 0.0,
          add_doc("Add a capsule along z: a cylinder of `length` with a half sphere on each end [m].").c_str())
      .def(
          "add_cone",
          [](Self& self, const std::string& name, double radius, double length, const Pose& pose, double padding) {
            self.use([&](auto& p) { p.add_cone(name, radius, length, pose, padding); });
          },
          nb::arg("name"), nb::arg("radius"), nb::arg("length"), nb::arg("pose") = Pose{}, nb::arg("padding") = 0.0,
          add_doc("Add a cone along z, base at -length/2, tip at +length/2 [m].").c_str())
      .def(
          "add_mesh",
          [](Self& self, const std::string& name, const std::string& path, const Pose& pose,
             const std::optional<ArrayLike>& scale, bool convex, const std::optional<ArrayLike>& vertices,
             const std::optional<ArrayLike>& triangles, double padding) {
            if (path.empty() == !vertices)
              throw InvalidArgument("mesh '" + name + "' needs either a path or vertices (with triangles)");
            if (!path.empty()) {
              const Eigen::Vector3d s =
                  scale ? scale->vector3("scale of mesh '" + name + "'") : Eigen::Vector3d(Eigen::Vector3d::Ones());
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
            self.use([&](auto& p) { p.add_mesh(name, mesh, pose, padding); });
          },
          nb::arg("name"), nb::arg("path") = "", nb::arg("pose") = Pose{}, nb::arg("scale") = nb::none(),
          nb::arg("convex") = false, nb::arg("vertices") = nb::none(), nb::arg("triangles") = nb::none(),
          nb::arg("padding") = 0.0,
          "Add a triangle mesh from a file (`path`, with `scale` (3,)) or from `vertices` (n, 3) [m] and `triangles` "
          "(m, 3) of\n"
          "vertex numbers from 0. A mesh is its surface; convex=True takes the solid convex hull instead (without "
          "`triangles`: of the\n"
          "`vertices`). `pose` of its origin in the world; `padding` [m] is kept clear around it.\n\n"
          "Raises FileError (missing, unreadable or empty file) and InvalidArgument (name in use, neither or both of "
          "path and vertices,\n"
          "NaN, vertex numbers that are not there).")
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
          "Add a point cloud (n, 3) [m]; every point fills a voxel with edges of `resolution` [m]. `pose` of its "
          "origin in the world;\n"
          "`padding` [m] is kept clear around it. A camera sees the robots too: with `self_filter_distance` [m], "
          "points "
          "no farther\n"
          "than that from a robot, where set_qpos put it, or from what it holds are left out (take at least twice the\n"
          "`resolution`, so that no voxel reaches the robot).\n\n"
          "Raises InvalidArgument for a name in use, no points (or none left), NaN, or a resolution or distance that "
          "is "
          "not above 0.")
      .def(
          "remove_object",
          [](Self& self, const std::string& name) { self.use([&](auto& p) { p.remove_object(name); }); },
          nb::arg("name"), "Remove an object, attached or not.")
      .def(
          "set_object_pose",
          [](Self& self, const std::string& name, const Pose& pose) {
            self.use([&](auto& p) { p.set_object_pose(name, pose); });
          },
          nb::arg("name"), nb::arg("pose"),
          "Move an object: its pose in the world.\n\nRaises InvalidArgument while it is attached.")
      .def(
          "set_padding",
          [](Self& self, const std::string& name, double padding) {
            self.use([&](auto& p) { p.set_padding(name, padding); });
          },
          nb::arg("name"), nb::arg("padding"),
          "Keep `padding` [m] clear around an object, or around every link of a robot.")
      .def(
          "attach_object",
          [](Self& self, const std::string& name, const std::string& robot, const std::string& link,
             const std::vector<std::string>& touch_links, const std::optional<Pose>& pose_in_link) {
            self.use([&](auto& p) { p.attach_object(name, robot, link, touch_links, pose_in_link); });
          },
          nb::arg("name"), nb::arg("robot"), nb::arg("link"), nb::arg("touch_links") = std::vector<std::string>{},
          nb::arg("pose_in_link") = nb::none(),
          "Let the object move with a link. It keeps its place relative to the link (robot at its set_qpos), or takes\n"
          "`pose_in_link`. It may touch `link` and `touch_links`.\n\n"
          "Raises InvalidArgument for unknown names or an object that is attached already.")
      .def(
          "detach_object",
          [](Self& self, const std::string& name) { self.use([&](auto& p) { p.detach_object(name); }); },
          nb::arg("name"),
          "Leave the object in the world where the robot (at its set_qpos) holds it.\n\n"
          "Raises InvalidArgument when it is not attached.")
      .def(
          "set_allowed_collision",
          [](Self& self, const std::string& a, const std::string& b, bool allowed) {
            self.use([&](auto& p) { p.set_allowed_collision(a, b, allowed); });
          },
          nb::arg("a"), nb::arg("b"), nb::arg("allowed") = true,
          "Ignore (or, with False, heed again) contact of two bodies: objects, links ('link' or 'robot/link'), whole "
          "robots.\n"
          "A later call wins over earlier ones that it covers.")
      .def(
          "allowed_collision",
          [](Self& self, const std::string& a, const std::string& b) {
            return self.use([&](auto& p) { return p.scene().allowed_collision(a, b); });
          },
          nb::arg("a"), nb::arg("b"),
          "Is contact of the two bodies ignored: by set_allowed_collision, else by the robot's self-collision rules or "
          "because one\n"
          "is held and may touch the other? Of a whole robot: for all its links.")
      .def(
          "load_moveit_scene",
          [](Self& self, const std::string& path) { self.use([&](auto& p) { p.load_moveit_scene(path); }); },
          nb::arg("path"),
          "Add the collision objects of a MoveIt scene file (YAML), all or none. Raises FileError with the line.")
      .def(
          "apply_moveit_request",
          [](Self& self, const std::string& name, const io::RequestFile& request) {
            return self.use([&](PlannerInterface& p) { return apply_moveit_request(p, name, request); });
          },
          nb::arg("name"), nb::arg("request"),
          "The request in the terms of this robot: start, goals, and the joints it names that are no movable joints of "
          "the robot.\n"
          "Movable joints that are not planned (a gripper's) are set, and held objects attached. Its planning time, "
          "speed scalings and\n"
          "workspace are not used: make_planner's options say these.\n\n"
          "Raises InvalidArgument for joints or links that a goal names and the robot does not have, NotSupported for "
          "goals that cannot\n"
          "be stated here (some of the joints only, tolerances that differ by axis).")
      .def("reset", [](Self& self) { self.reset(); }, "Remove all robots, objects, planners and heuristics.");
}

void bind_questions(nb::class_<Self>& cls) {
  const auto q_of = [](const std::string& name) { return "q of '" + name + "'"; };
  cls.def_prop_ro(
         "robot_names", [](Self& self) { return self.use([](auto& p) { return p.robot_names(); }); }, "Sorted.")
      .def_prop_ro(
          "object_names", [](Self& self) { return self.use([](auto& p) { return p.object_names(); }); },
          "Sorted; attached ones too.")
      .def(
          "get_joint_names",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) { return p.get_joint_names(name); });
          },
          nb::arg("name"), "Planned joints, in the order of q.")
      .def(
          "get_link_names",
          [](Self& self, const std::string& name) { return self.use([&](auto& p) { return p.get_link_names(name); }); },
          nb::arg("name"), "All links, the root first.")
      .def(
          "get_end_effector",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) { return p.robot(name).end_effector(); });
          },
          nb::arg("name"), "The link that goals speak of.")
      .def(
          "get_joint_limits",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) {
              std::vector<Eigen::VectorXd> rows;
              for (const Joint& joint : p.robot(name).joints())
                rows.emplace_back(Eigen::Vector3d(joint.lower, joint.upper, joint.max_velocity));
              return to_numpy_rows(rows, 3);
            });
          },
          nb::arg("name"),
          "(dof, 3): lower and upper limit [rad or m], velocity limit [rad/s or m/s]. Continuous joints: -inf, inf.")
      .def(
          "get_all_joint_limits",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) {
              std::map<std::string, std::pair<double, double>> limits;
              for (const auto* joints : {&p.robot(name).joints(), &p.robot(name).other_joints()})
                for (const Joint& joint : *joints) limits[joint.name] = {joint.lower, joint.upper};
              return limits;
            });
          },
          nb::arg("name"),
          "Of all joints that set_joint_positions moves, planned or not: name to (lower, upper) [rad or m].")
      .def(
          "get_group_states",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) {
              nb::dict states;
              for (const auto& [state, q] : p.robot(name).group_states()) states[state.c_str()] = to_numpy(q);
              return states;
            });
          },
          nb::arg("name"),
          nb::sig("def get_group_states(self, name: str) -> dict[str, numpy.typing.NDArray[numpy.float64]]"),
          "The SRDF's named configurations of the planned joints: name to (dof,) [rad or m].")
      .def(
          "get_qpos",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) { return to_numpy(p.scene().robot(name).q); });
          },
          nb::arg("name"), "Planned joints as set by set_qpos, (dof,) [rad or m]; at first the values nearest to 0.")
      .def(
          "get_object_pose",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) { return p.scene().object_pose(name); });
          },
          nb::arg("name"), "Pose in the world, attached or not.")
      .def(
          "get_always_colliding",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) { return p.robot(name).always_colliding(); });
          },
          nb::arg("name"),
          "Link pairs of a robot without SRDF that touch with all joints at 0 and in more than 95 % of the sampled "
          "configurations;\n"
          "their contact is ignored.")
      .def(
          "compute_fk",
          [q_of](Self& self, const std::string& name, const ArrayLike& q, const std::string& link) {
            const Eigen::VectorXd v = q.vector(q_of(name));
            return self.use([&](auto& p) { return p.compute_fk(name, v, link); });
          },
          nb::arg("name"), nb::arg("q"), nb::arg("link") = "",
          "World pose of a link (default: end effector) at q (dof,) [rad or m]. Limits are not looked at.")
      .def(
          "compute_jacobian",
          [q_of](Self& self, const std::string& name, const ArrayLike& q, const std::string& link) {
            const Eigen::VectorXd v = q.vector(q_of(name));
            const Eigen::MatrixXd jacobian = self.use([&](auto& p) { return p.compute_jacobian(name, v, link); });
            std::vector<Eigen::VectorXd> rows;
            for (const auto& row : jacobian.rowwise()) rows.emplace_back(row.transpose());
            return to_numpy_rows(rows, static_cast<std::size_t>(jacobian.cols()));
          },
          nb::arg("name"), nb::arg("q"), nb::arg("link") = "",
          "(6, dof): velocity of the link's origin vx, vy, vz and rotation wx, wy, wz, world axes, per joint velocity.")
      .def(
          "compute_ik",
          [q_of](Self& self, const std::string& name, const Pose& target, const std::optional<ArrayLike>& reference,
                 const std::string& link, int max_solutions, int seeds) {
            std::optional<Eigen::VectorXd> v;
            if (reference) v = reference->vector("reference of '" + name + "'");
            IkOptions options;
            options.max_solutions = max_solutions;
            options.seeds = seeds;
            return self.use([&](auto& p) {
              return to_numpy_rows(p.compute_ik(name, target, v, options, link), p.robot(name).dof());
            });
          },
          nb::arg("name"), nb::arg("target"), nb::arg("reference") = nb::none(), nb::arg("link") = "",
          nb::arg("max_solutions") = 16, nb::arg("seeds") = 64,
          "(n, dof) configurations that bring `link` (default: end effector) to the world pose `target`: within "
          "limits, nearest to\n"
          "`reference` (dof,) (default: set_qpos) first; n = 0 when none was found. The same every time. Collisions "
          "are not "
          "looked at.\n\n"
          "Damped least squares from `seeds` starts (Sugihara 2011), until `max_solutions` different ones are known; "
          "met to 1e-5 m and\n"
          "1e-4 rad. Raises InvalidArgument for an unknown link, a wrong size, or counts that are not above 0.")
      .def(
          "is_state_colliding",
          [q_of](Self& self, const std::string& name, const ArrayLike& q) {
            const Eigen::VectorXd v = q.vector(q_of(name));
            return self.use([&](auto& p) { return p.is_state_colliding(name, v); });
          },
          nb::arg("name"), nb::arg("q"),
          "Does the robot at q (dof,) [rad or m] touch itself or anything else? Limits are not looked at.")
      .def(
          "contacts",
          [q_of](Self& self, const std::string& name, const ArrayLike& q) {
            const Eigen::VectorXd v = q.vector(q_of(name));
            return self.use([&](auto& p) { return p.contacts(name, v); });
          },
          nb::arg("name"), nb::arg("q"), "Every pair in contact at q, deepest first.")
      .def(
          "is_motion_free",
          [q_of](Self& self, const std::string& name, const ArrayLike& a, const ArrayLike& b) {
            const Eigen::VectorXd from = a.vector(q_of(name)), to = b.vector(q_of(name));
            return self.use([&](auto& p) { return p.is_motion_free(name, from, to); });
          },
          nb::arg("name"), nb::arg("a"), nb::arg("b"),
          "Is the straight joint-space motion from a (dof,) to b (dof,) proved free, between samples too? Continuous "
          "joints go the\n"
          "short way. Conservative advancement (Schwarzer, Saha, Latombe 2004).")
      .def(
          "distance_to_collision",
          [q_of](Self& self, const std::string& name, const ArrayLike& q) {
            const Eigen::VectorXd v = q.vector(q_of(name));
            return self.use([&](auto& p) { return p.distance_to_collision(name, v); });
          },
          nb::arg("name"), nb::arg("q"),
          "Distance of the nearest pair [m]; negative: how deep they overlap; inf with nothing around.")
      .def(
          "nearest",
          [q_of](Self& self, const std::string& name, const ArrayLike& q) {
            const Eigen::VectorXd v = q.vector(q_of(name));
            return self.use([&](auto& p) { return p.nearest(name, v); });
          },
          nb::arg("name"), nb::arg("q"), "The nearest pair as a Contact, or None with nothing around.")
      .def(
          "collision_checker",
          [](Self& self, const std::string& name, const std::string& mode) {
            return wrap_checker(self.use([&](auto& p) { return p.collision_checker(name, to_check_mode(mode)); }));
          },
          nb::arg("name"), nb::arg("mode") = "exact",
          nb::sig("def collision_checker(self, name: str, mode: str = 'exact') -> CollisionChecker"),
          "A CollisionChecker of the scene as it is now, for many questions; later changes do not reach it.\n\n"
          "mode: 'exact' (spheres answer most of it, Coal the rest; the answer is Coal's), 'conservative' (spheres "
          "alone: never free\n"
          "wrongly) or 'coal'. The first use of a robot covers its links with spheres, which may take many seconds; "
          "later ones load\n"
          "them from the cache directory.")
      .def(
          "timed_collision_checker",
          [](Self& self, const std::string& name, nb::handle others, const std::string& mode) {
            const auto paths = to_timed_paths(others);
            return wrap_checker(
                self.use([&](auto& p) { return p.timed_collision_checker(name, paths, to_check_mode(mode)); }));
          },
          nb::arg("name"), nb::arg("others"), nb::arg("mode") = "exact",
          nb::sig("def timed_collision_checker(self, name: str, others: dict[str, tuple[numpy.typing.ArrayLike, "
                  "numpy.typing.ArrayLike]], mode: str = 'exact') -> TimedCollisionChecker"),
          "A checker of one robot among others whose motions are known: `others` maps a robot's name to its times (m,) "
          "[s] and\n"
          "configurations (m, dof) [rad or m]: straight between them, at rest before and after. Robots not named stand "
          "still.\n\n"
          "Raises InvalidArgument for unknown robots, times that do not grow, wrong sizes and NaN.");
}

bool is_number(nb::handle value) {
  if (nb::isinstance<nb::str>(value) || nb::isinstance<nb::bool_>(value)) return false;
  return nb::hasattr(value, "__float__") && nb::cast<int>(nb::module_::import_("numpy").attr("ndim")(value)) == 0;
}

/// Limits as users give them: None keeps what is, a number is for every joint, a dictionary for the joints it names.
Eigen::VectorXd to_limits(nb::handle value, const Eigen::VectorXd& now, const std::vector<std::string>& joints,
                          const std::string& what) {
  const auto text = [](nb::handle any) { return nb::cast<std::string>(nb::repr(any)); };
  const auto number = [](nb::handle any) { return nb::cast<double>(nb::float_(any)); };
  Eigen::VectorXd limits = now;
  if (value.is_none()) return limits;
  if (is_number(value)) return limits.setConstant(number(value));
  if (nb::isinstance<nb::str>(value) || nb::isinstance<nb::bool_>(value))
    throw InvalidArgument(what + " limits must be a number, one a joint, or a dictionary of joints, but are " +
                          text(value));
  if (!nb::hasattr(value, "keys")) return ArrayLike{nb::borrow<nb::object>(value)}.vector(what + " limits");
  for (const auto [key, item] : nb::cast<nb::dict>(nb::module_::import_("builtins").attr("dict")(value))) {
    const std::string name = nb::cast<std::string>(nb::str(key));
    const auto joint = std::find(joints.begin(), joints.end(), name);
    if (joint == joints.end()) {
      const std::string nearest = did_you_mean(name, joints);
      throw InvalidArgument(what + " limits name '" + name + "', which is no planned joint" +
                            (nearest.empty() ? "; these are " + quoted_list(joints) : nearest));
    }
    if (!is_number(item))
      throw InvalidArgument(name + ": the " + what + " limit is " + text(item) + "; it must be a number");
    limits[joint - joints.begin()] = number(item);
  }
  return limits;
}

void set_motion_limits(PlannerInterface& planner, const std::string& robot, nb::handle velocity,
                       nb::handle acceleration, nb::handle jerk) {
  const std::vector<std::string> joints = planner.get_joint_names(robot);
  MotionLimits limits = planner.motion_limits(robot);
  limits.velocity = to_limits(velocity, limits.velocity, joints, "velocity");
  limits.acceleration = to_limits(acceleration, limits.acceleration, joints, "acceleration");
  limits.jerk = to_limits(jerk, limits.jerk, joints, "jerk");
  planner.set_motion_limits(robot, limits);
}

/// What srmp/sim does, with a simulator.
void bind_simulators(nb::class_<Self>& cls) {
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
         "Read a simulator's scene: its robots, and every collision shape of everything else, as they stand.\n\n"
         "sim: for kind \"mujoco\" (MjModel, MjData); \"sapien\" a Scene; \"genesis\" a built Scene; \"pybullet\" a "
         "client's number.\n"
         "articulations: which of the simulator's articulations are robots, default all. A list names those that "
         "are planned with the\n"
         "simulator's own model; a dict by robot name says more of each: urdf_path, srdf_path and whatever "
         "add_articulation is told,\n"
         "and `articulation`, its name in the simulator where that is another. exclude: objects or bodies to leave "
         "out. Contacts that the\n"
         "simulator filters are allowed collisions here; among the links of a robot from a URDF, the URDF's and SRDF's "
         "rules count\n"
         "(`self_collisions`: True takes the simulator's).\n\n"
         "Returns the srmp.sim.SimulatedWorld, also in `simulated_world`: refresh, grasp, release, execute. Raises "
         "InvalidArgument (a\n"
         "robot or joint that is not there, with the nearest name), NotSupported (a shape or joint that cannot be "
         "read; a package that\n"
         "is missing); then nothing was read. See docs/simulators.md.")
      .def_prop_rw(
          "simulated_world", [](Self& self) { return self.simulated_world; },
          [](Self& self, const nb::object& world) { self.simulated_world = world; }, nb::arg("world").none(),
          nb::for_getter(nb::sig("def simulated_world(self) -> typing.Any")),
          "What read_sim returned; None before, and after reset.");
}

void bind_proofs(nb::class_<Self>& cls) {
  cls.def(
         "motion_limits",
         [](Self& self, const std::string& robot) {
           return self.use([&](const PlannerInterface& p) { return p.motion_limits(robot); });
         },
         nb::arg("robot"),
         "What the joints may do, as MotionLimits: velocities of the URDF, and default_limits for the rest, until "
         "set_motion_limits.")
      .def(
          "set_motion_limits",
          [](Self& self, const std::string& robot, nb::handle velocity, nb::handle acceleration, nb::handle jerk) {
            self.use([&](PlannerInterface& p) { set_motion_limits(p, robot, velocity, acceleration, jerk); });
          },
          nb::arg("robot"), nb::arg("velocity") = nb::none(), nb::arg("acceleration") = nb::none(),
          nb::arg("jerk") = nb::none(),
          nb::sig("def set_motion_limits(self, robot: str, "
                  "velocity: numpy.typing.ArrayLike | collections.abc.Mapping[str, float] | None = None, "
                  "acceleration: numpy.typing.ArrayLike | collections.abc.Mapping[str, float] | None = None, "
                  "jerk: numpy.typing.ArrayLike | collections.abc.Mapping[str, float] | None = None) -> None"),
          "Limits for all plans that follow: velocity [rad/s or m/s], acceleration [rad/s^2 or m/s^2], jerk [rad/s^3 "
          "or "
          "m/s^3].\n"
          "Each: a number for all joints, (dof,) numbers, or a dictionary {joint name: number}. What is not named "
          "stays.\n\n"
          "Raises InvalidArgument for an unknown robot or joint (with the nearest), a wrong size, and limits that are "
          "not above 0 and finite.")
      .def(
          "load_joint_limits",
          [](Self& self, const std::string& robot, const nb::object& path) {
            return self.use([&](PlannerInterface& p) { return p.load_joint_limits(robot, to_path(path)); });
          },
          nb::arg("robot"), nb::arg("path"),
          nb::sig("def load_joint_limits(self, robot: str, path: str | os.PathLike[str]) -> list[str]"),
          "Limits of a MoveIt joint_limits.yaml (rad, m, s) in place of those that were set: max_velocity, "
          "max_acceleration, max_jerk\n"
          "where has_…_limits is not false; default_velocity_scaling_factor and default_acceleration_scaling_factor "
          "multiply those of\n"
          "all joints, the latter jerks too. What the file does not say is as in default_limits. Returns the joints in "
          "it that are no\n"
          "planned ones: they were not used.\n\n"
          "Raises FileError, with the line, for a missing file, unknown keys (with the nearest), and values out of "
          "range; NotSupported\n"
          "for position limits narrower than the URDF's, limits of deceleration or effort, and soft limits.")
      .def(
          "verify",
          [](Self& self, const std::string& robot, const Trajectory& trajectory, const std::optional<ArrayLike>& start,
             nb::handle goals, const std::optional<MotionLimits>& limits, bool jerk,
             std::optional<double> max_deviation, double gap_tolerance) {
            VerifyOptions options{
                .limits = limits, .jerk = jerk, .max_deviation = max_deviation, .gap_tolerance = gap_tolerance};
            if (start) options.start = start->vector("start of '" + robot + "'");
            if (!goals.is_none()) options.goals = to_goals(goals);
            return self.use([&](const PlannerInterface& p) {
              const nb::gil_scoped_release no_gil;
              return p.verify(robot, trajectory, options);
            });
          },
          nb::arg("robot"), nb::arg("trajectory"), nb::arg("start") = nb::none(), nb::arg("goals") = nb::none(),
          nb::arg("limits") = nb::none(), nb::arg("jerk") = false, nb::arg("max_deviation") = nb::none(),
          nb::arg("gap_tolerance") = 0.5,
          nb::sig("def verify(self, robot: str, trajectory: Trajectory, start: numpy.typing.ArrayLike | None = None, "
                  "goals: GoalConstraint | collections.abc.Sequence[GoalConstraint] | None = None, "
                  "limits: MotionLimits | None = None, jerk: bool = False, max_deviation: float | None = None, "
                  "gap_tolerance: float = 0.5) -> Certificate"),
          "A Certificate of any trajectory of the robot, whoever planned it, in the scene as it is, made by code that "
          "plans nothing:\n"
          "limits at every instant, collisions between rows too, whether it is at rest at both ends. Faults are found, "
          "not raised.\n\n"
          "start: (dof,) [rad or m] where it should begin. goals: it should reach one of them. limits: default "
          "motion_limits(robot).\n"
          "jerk: hold it against the jerk limits too. max_deviation: [m] that it may leave its waypoints by. "
          "gap_tolerance: in (0, 1), the\n"
          "part of the clearance that is proved. The GIL is released.\n\n"
          "Raises InvalidArgument for an unknown robot and options out of range.")
      .def(
          "verify_multi",
          [](Self& self, nb::handle trajectory, nb::handle starts, nb::handle goals, nb::handle obstacles, bool jerk,
             std::optional<double> max_deviation, double gap_tolerance) {
            const MultiTrajectory motions{to_trajectories(trajectory, "the trajectories")};
            const nb::dict none;
            const auto given = [&](nb::handle mapping) { return mapping.is_none() ? nb::handle(none) : mapping; };
            MultiPlanRequest r = to_multi_request(given(starts), given(goals), obstacles);
            const MultiVerifyOptions options{std::move(r.starts), std::move(r.goals), std::move(r.obstacles), jerk,
                                             max_deviation,       gap_tolerance};
            return self.use([&](const PlannerInterface& p) {
              const nb::gil_scoped_release no_gil;
              return p.verify_multi(motions, options);
            });
          },
          nb::arg("trajectory").none(), nb::arg("starts") = nb::none(), nb::arg("goals") = nb::none(),
          nb::arg("obstacles") = nb::none(), nb::arg("jerk") = false, nb::arg("max_deviation") = nb::none(),
          nb::arg("gap_tolerance") = 0.5,
          nb::sig("def verify_multi(self, trajectory: MultiTrajectory | collections.abc.Mapping[str, Trajectory], "
                  "starts: collections.abc.Mapping[str, numpy.typing.ArrayLike] | None = None, "
                  "goals: collections.abc.Mapping[str, GoalConstraint] | None = None, "
                  "obstacles: collections.abc.Mapping[str, Trajectory] | None = None, jerk: bool = False, "
                  "max_deviation: float | None = None, gap_tolerance: float = 0.5) -> dict[str, Certificate]"),
          "verify of many robots that move on one clock: a Certificate of each, by name, held against the others too, "
          "which rest\n"
          "where their motions end. Robots not named stand still.\n\n"
          "starts: (dof,) [rad or m] by robot name: where they should begin. goals: by robot name: what they should "
          "reach; one that\n"
          "holds should end where it should begin, or does if that is not said. obstacles: motions of further robots, "
          "which are not judged "
          "themselves. The rest as\n"
          "for verify. The GIL is released.\n\n"
          "Raises InvalidArgument for an unknown robot, starts and goals of robots without a trajectory, and options "
          "out of range.");
}

void bind_planning(nb::class_<Self>& cls) {
  cls.def(
         "make_planner",
         [](Self& self, nb::handle robots, nb::handle options) {
           const auto names = to_names(robots);
           const OptionMap map = to_option_map(options);
           self.use([&](auto& p) { p.make_planner(names, map); });
         },
         nb::arg("names"), nb::arg("options"),
         nb::sig("def make_planner(self, names: str | collections.abc.Sequence[str], options: dict | object) -> None"),
         "Choose the planner of these robots: a dictionary such as {'planner_id': 'wAstar', 'time_limit': 5, 'weight': "
         "10} (numbers\n"
         "may be strings) or a typed object such as srmp.WAStar(weight=10). Options left out have their defaults.\n\n"
         "Astar    A* (Hart, Nilsson, Raphael 1968)\n"
         "wAstar   weighted A* (Pohl 1970) with lazy edges (Cohen, Phillips, Likhachev 2014)\n"
         "ARAstar  ARA* (Likhachev, Gordon, Thrun 2003), anytime\n"
         "MHAstar  MHA* (Aine et al. 2016), several heuristics\n"
         "wPASE    ePA*SE (Mukherjee, Aine, Likhachev 2022), parallel\n"
         "auto     two trees and guided searches in turns, from both ends; the default\n"
         "CBS      conflict-based search (Sharon et al. 2015), many robots: optimal on their lattices\n"
         "ECBS     (Barer et al. 2014), many robots: within a bound\n"
         "xECBS    (Shaoul, Mishani, Likhachev, Li 2024), many robots: ECBS with experience; quick\n"
         "prioritised  priority-based search (Ma et al. 2019), many robots: quick, nothing is proved\n\n"
         "Raises InvalidArgument for an unknown robot, planner or option (with the nearest name) or a value out of "
         "range.")
      .def(
          "add_heuristic",
          [](Self& self, const std::string& name, const nb::callable& function, bool consistent) {
            self.add_heuristic(name, function, consistent);
          },
          nb::arg("name"), nb::arg("function"), nb::arg("consistent") = false,
          nb::sig("def add_heuristic(self, name: str, function: collections.abc.Callable[[numpy.typing.NDArray"
                  "[numpy.float64], numpy.typing.NDArray[numpy.float64]], numpy.typing.ArrayLike], "
                  "consistent: bool = False) -> None"),
          "A heuristic of your own: from now on `name` may stand where options ask for one, for any robot.\n\n"
          "function(configurations, goals): (n, dof) and (m, dof) [rad or m] to (n,) estimates of the joint-space way "
          "to the nearest\n"
          "goal, each finite and >= 0; goals themselves are 0 and not asked. A search from the goals is on its way to "
          "the start: that\n"
          "is what `goals` holds then. The same question must have the same answer. It must not use this "
          "PlannerInterface, which is\n"
          "planning; what it raises ends the plan and is raised there. consistent: your word that h(a) <= |b - a| + "
          "h(b) for all\n"
          "configurations; without it no bound counts as proven (but that of `auto`).\n\n"
          "Raises InvalidArgument for a name in use, empty, or with spaces, commas or brackets; plan raises it for "
          "values that are no\n"
          "such numbers, with the value and the configuration.")
      .def(
          "remove_heuristic", [](Self& self, const std::string& name) { self.remove_heuristic(name); }, nb::arg("name"),
          "Forget a heuristic of add_heuristic; planners that name it refuse to plan.\n\nRaises InvalidArgument for an "
          "unknown name.")
      .def_prop_ro(
          "heuristic_names",
          [](Self& self) { return self.use([](const PlannerInterface& p) { return p.heuristic_names(); }); },
          "Names of add_heuristic, sorted.")
      .def(
          "plan",
          [](Self& self, nb::handle robot, const ArrayLike& start, nb::handle goal, const nb::object& on_solution) {
            const std::string name = only_robot(robot);
            const OnSolution tell = to_on_solution(on_solution);
            const Eigen::VectorXd q = start.vector("start of '" + name + "'");
            const std::vector<GoalConstraint> goals = to_goals(goal);
            return self.use([&](PlannerInterface& p) {
              return run_plan(p, [&] { return p.plan(name, q, goals, python_interrupted, tell); });
            });
          },
          nb::arg("name"), nb::arg("start"), nb::arg("goal"), nb::arg("on_solution") = nb::none(),
          nb::sig("def plan(self, name: str | collections.abc.Sequence[str], start: numpy.typing.ArrayLike, "
                  "goal: GoalConstraint | collections.abc.Sequence[GoalConstraint], "
                  "on_solution: collections.abc.Callable[[dict[str, typing.Any], "
                  "numpy.typing.NDArray[numpy.float64]], bool | None] | None = None) -> Trajectory"),
          "A timed, collision-free Trajectory of one robot from `start` (dof,) [rad or m] to the goal (any one of "
          "several). The same\n"
          "question gives the same answer, bit for bit. Other robots stand still. The GIL is released; Ctrl-C stops "
          "the plan.\n\n"
          "on_solution(solution, waypoints) sees every path that is better than those before, while planners that "
          "improve theirs run:\n"
          "solution has time_s, cost_rad, bound and graph (see get_planning_stats), waypoints (n, dof) [rad or m], "
          "from "
          "the end of an\n"
          "escape on (option recover_start: only there is the way not free). When it returns False, that path is good "
          "enough. It must not use this planner; what it raises ends the plan.\n\n"
          "Raises PlanningError when there is none: its status is timed_out, exhausted, start_invalid, goal_invalid or "
          "cancelled, its text\n"
          "says why, its statistics are those of get_planning_stats. Raises InvalidArgument for a wrong question: "
          "unknown robot, no make_planner, wrong size, NaN.")
      .def(
          "plan_many",
          [](Self& self, const std::vector<PlanRequest>& requests, std::optional<int> threads,
             const std::optional<nb::callable>& progress) {
            return self.use([&](PlannerInterface& p) { return plan_many(p, requests, threads, progress); });
          },
          nb::arg("requests"), nb::arg("threads") = nb::none(), nb::arg("progress") = nb::none(),
          nb::sig("def plan_many(self, requests: collections.abc.Sequence[PlanRequest], threads: int | None = None, "
                  "progress: collections.abc.Callable[[int, int], object] | None = None) -> list[PlanResult]"),
          "Many plans at once in the scene as it is, each by itself; `threads` (> 0; default: one a core) share them "
          "out.\n\n"
          "Results are in the order of the requests, and each is what plan alone would have found, bit for bit, for "
          "any number of\n"
          "threads. A request that has no trajectory does not disturb the others: its PlanResult says why. Every "
          "request has its own\n"
          "time limit, which begins with its own plan; only a limit that cuts a plan short can make a difference, the "
          "sooner the more\n"
          "threads share a core. `progress` is called with (requests done, requests in all). The GIL is released; "
          "Ctrl-C, or an\n"
          "exception of `progress`, stops all plans and is raised. get_planning_stats stays as it was.\n\n"
          "Raises InvalidArgument for a wrong request, as plan does, with its number; before anything is planned where "
          "it can.")
      .def(
          "plan_multi",
          [](Self& self, nb::handle starts, nb::handle goals, nb::handle obstacles) {
            const MultiPlanRequest r = to_multi_request(starts, goals, obstacles);
            return self.use([&](PlannerInterface& p) {
              return run_plan(p, [&] { return p.plan_multi(r.starts, r.goals, r.obstacles, python_interrupted); });
            });
          },
          nb::arg("starts").none(), nb::arg("goals").none(), nb::arg("obstacles") = nb::none(),
          nb::sig("def plan_multi(self, starts: collections.abc.Mapping[str, numpy.typing.ArrayLike], "
                  "goals: collections.abc.Mapping[str, GoalConstraint], "
                  "obstacles: collections.abc.Mapping[str, Trajectory] | None = None) -> MultiTrajectory"),
          "Motions of many robots together, on one clock, collision-free among each other too.\n\n"
          "starts: (dof,) [rad or m] by robot name; goals: by robot name. A robot with a start and no goal holds still "
          "(GoalConstraint.hold()\n"
          "says so), one with GoalConstraint.aside() may move out of the way; robots without a start stand where "
          "set_qpos put them. Every\n"
          "trajectory has a certificate that covers the others, those of robots that hold too.\n"
          "Planned by the planner that make_planner chose for the robots of `starts`. The GIL is released; Ctrl-C "
          "stops "
          "it.\n\n"
          "obstacles: timed Trajectory by robot name, that other robots of the scene are committed to. They begin at "
          "time 0 too, the\n"
          "robots rest where they end, and are not asked to move. The planned motions end among them so. They begin "
          "together as\n"
          "soon as they get by, in steps of 0.1 s, at rest at the starts until then; or, where that fails or is late, "
          "each robot\n"
          "moves and waits as suits the others (not complete). Certificates cover the obstacles.\n\n"
          "Raises PlanningError, with a status and a reason, when there are none (a start where an obstacle begins is "
          "start_invalid,\n"
          "one where it ends too unless the robot can leave before; exhausted names links and time when no motions are "
          "found);\n"
          "InvalidArgument for a goal "
          "without a start,\n"
          "wrong sizes and NaN, when no robot is to move, and for an obstacle that has a start, has no times, does not "
          "begin at time\n"
          "0, leaves the joint limits or has not the robot's joints.")
      .def(
          "get_planning_stats",
          [](Self& self) { return self.use([](auto& p) { return to_dict(p.get_planning_stats()); }); },
          nb::sig("def get_planning_stats(self) -> dict[str, typing.Any]"),
          "What the last plan did, solved or not.\n\n"
          "status, reason, note; plan_time_s (until the path is ready), total_time_s, and of these ik_time_s, "
          "heuristic_time_s,\n"
          "search_time_s, shortcut_time_s, timing_time_s, verification_time_s [s]; expansions, generated, states, "
          "edge_checks,\n"
          "edges_free_by_spheres, edges_colliding_by_spheres, edges_free_by_coal, edges_colliding_by_coal (their sum "
          "is "
          "edge_checks),\n"
          "configurations, narrow_phase (counts); memory_bytes; recovery_waypoints (the path is free from this "
          "waypoint "
          "on: above 0,\n"
          "it began in collision, see recover_start) and recovery_cost_rad, its length up to there, which no other "
          "cost "
          "counts;\n"
          "search_cost_rad and path_cost_rad, before and after "
          "the shortcut "
          "[rad, prismatic\n"
          "joints m]; bound (path_cost_rad is at most this times the optimum of bound_graph; inf: none proven); "
          "solutions (a list:\n"
          "the time_s, cost_rad, bound and graph of every path that was better than those before); goal_index (which "
          "target was\n"
          "reached, counted over all goals; -1: none). After plan_multi also robot_cost_rad (by robot; path_cost_rad "
          "is "
          "their sum),\n"
          "tree_nodes (of the constraint tree), makespan_s and flow_time_s (sum of the robots' times of arrival) [s].")
      .def(
          "print_available_planners",
          [](Self&) {
            nb::object print = nb::module_::import_("builtins").attr("print");
            for (const PlannerInfo& info : available_planners())
              print((info.id + std::string(13 - info.id.size(), ' ') + info.summary).c_str());
          },
          "Print the planner ids and what each is for.");
}

void bind_files(nb::class_<Self>& cls) {
  cls.def(
         "save",
         [](Self& self, const nb::object& path) { self.use([&](PlannerInterface& p) { p.save(to_path(path)); }); },
         nb::arg("path"), nb::sig("def save(self, path: str | os.PathLike[str]) -> None"),
         "Write the whole problem into one file (JSON, by custom *.srmp.json): the scene with its robots, planners, "
         "and "
         "the request of\n"
         "the last plan or plan_multi with its result, if nothing was changed since. Whole or not at all; numbers read "
         "back bit for "
         "bit.\n\n"
         "Raises FileError when the file cannot be written, and InvalidArgument when a planner names a heuristic of "
         "add_heuristic.")
      .def_static(
          "load",
          [](const nb::object& path, const std::vector<std::string>& package_dirs) {
            return new Self(PlannerInterface::load(to_path(path), package_dirs));
          },
          nb::arg("path"), nb::arg("package_dirs") = std::vector<std::string>{}, nb::rv_policy::take_ownership,
          nb::sig("def load(path: str | os.PathLike[str], package_dirs: collections.abc.Sequence[str] = []) -> "
                  "PlannerInterface"),
          "A problem as it was saved: planning again gives the same trajectory, get_planning_stats and last_result are "
          "the saved\n"
          "ones. A scene file gives the scene alone. Only meshes of robots are other files: they are looked for where "
          "they "
          "were, and\n"
          "in `package_dirs`.\n\n"
          "Raises FileError, with the line, for anything missing, misspelt or wrong, another format, and newer "
          "versions.")
      .def(
          "save_scene",
          [](Self& self, const nb::object& path) {
            self.use([&](PlannerInterface& p) { p.save_scene(to_path(path)); });
          },
          nb::arg("path"), nb::sig("def save_scene(self, path: str | os.PathLike[str]) -> None"),
          "Write the scene alone: robots, objects, attachments, allowed collisions. Raises FileError.")
      .def(
          "load_scene",
          [](Self& self, const nb::object& path, const std::vector<std::string>& package_dirs) {
            self.use([&](PlannerInterface& p) { p.load_scene(to_path(path), package_dirs); });
          },
          nb::arg("path"), nb::arg("package_dirs") = std::vector<std::string>{},
          nb::sig("def load_scene(self, path: str | os.PathLike[str], package_dirs: collections.abc.Sequence[str] = "
                  "[]) -> None"),
          "Put the scene of a scene or problem file in place of this one; planners of robots that it has too stay.\n\n"
          "Raises FileError, as load, and changes nothing.")
      .def_prop_ro(
          "last_request", [](Self& self) { return self.use([](const auto& p) { return p.last_request(); }); },
          "What the last plan was asked, as a PlanRequest without options (those of make_planner count), or "
          "plan_multi, "
          "as a\n"
          "MultiPlanRequest; None before the first, and once one of its robots or the scene was replaced.")
      .def_prop_ro(
          "last_result", [](Self& self) { return self.use([](const auto& p) { return p.last_result(); }); },
          "What became of it, as a PlanResult, or a MultiPlanResult of plan_multi; None before the first plan, and "
          "once scene or\n"
          "planner were changed: then it may be another one.");
}

}  // namespace

PlacedRobot placed_robot(nb::handle planner, nb::handle robot) {
  if (!nb::isinstance<Self>(planner))
    throw InvalidArgument("planner must be a PlannerInterface, but is " + nb::cast<std::string>(nb::repr(planner)));
  return nb::cast<Self&>(planner).use([&](const PlannerInterface& p) -> PlacedRobot {
    const std::vector<std::string> known = p.scene().robot_names();
    if (robot.is_none() && known.size() != 1)
      throw InvalidArgument("robot must be named where there is not exactly one; there are " + quoted_list(known));
    const RobotInstance& instance = p.scene().robot(robot.is_none() ? known[0] : to_names(robot).at(0));
    return {instance.model, instance.base, instance.other_positions};
  });
}

void bind_planner_interface(nb::module_& m) {
  nb::class_<Contact> contact(m, "Contact", "Two bodies in contact, or the nearest two.");
  contact.def_ro("body_a", &Contact::body_a, "Link (or attached object) of the robot asked about.")
      .def_ro("body_b", &Contact::body_b, "Object, link of the same robot, or 'robot/link' of another.")
      .def_ro("distance", &Contact::distance, "[m], less the padding; negative: how deep the two overlap.")
      .def_prop_ro(
          "point_a", [](const Contact& c) { return to_numpy(c.point_a); }, "On body_a, world frame [m].")
      .def_prop_ro(
          "point_b", [](const Contact& c) { return to_numpy(c.point_b); }, "On body_b, world frame [m].")
      .def("__repr__", &Contact::describe);
  using Point = std::array<double, 3>;
  make_value(
      contact,
      [](const Contact& c) {
        const Point a{c.point_a[0], c.point_a[1], c.point_a[2]}, b{c.point_b[0], c.point_b[1], c.point_b[2]};
        return nb::make_tuple(c.body_a, c.body_b, c.distance, a, b, c.padding, static_cast<int>(c.kind_a),
                              static_cast<int>(c.kind_b));
      },
      [](const State& s) {
        const auto a = nb::cast<Point>(s[3]), b = nb::cast<Point>(s[4]);
        return Contact{nb::cast<std::string>(s[0]),
                       nb::cast<std::string>(s[1]),
                       nb::cast<double>(s[2]),
                       {a[0], a[1], a[2]},
                       {b[0], b[1], b[2]},
                       nb::cast<double>(s[5]),
                       static_cast<BodyKind>(nb::cast<int>(s[6])),
                       static_cast<BodyKind>(nb::cast<int>(s[7]))};
      });

  nb::class_<MoveItProblem>(m, "MoveItProblem", "A MoveIt motion request in the terms of one robot.")
      .def_prop_ro(
          "start", [](const MoveItProblem& problem) { return to_numpy(problem.start); }, "(dof,) [rad or m]")
      .def_ro("goals", &MoveItProblem::goals, "GoalConstraints; any one will do.")
      .def_ro("ignored_joints", &MoveItProblem::ignored_joints,
              "Named by the start state, but no movable joints of this robot.");

  static PyType_Slot slots[] = {{Py_tp_traverse, reinterpret_cast<void*>(&Self::traverse)},
                                {Py_tp_clear, reinterpret_cast<void*>(&Self::clear)},
                                {0, nullptr}};
  nb::class_<Self> cls(m, "PlannerInterface", nb::type_slots(slots),
                       "A world of robots and objects, and planners for them.\n\n"
                       "Poses are in the world frame; metres, radians, seconds; quaternions [x, y, z, w]; objects are "
                       "solid. A refused call raises and\n"
                       "changes nothing: InvalidArgument for unknown robots, objects or links (with the nearest name), "
                       "wrong sizes, NaN and infinity.\n"
                       "One thread at a time; a second one is refused with Error.");
  cls.def(nb::init<>());
  bind_robots(cls);
  bind_objects(cls);
  bind_questions(cls);
  bind_simulators(cls);
  bind_proofs(cls);
  bind_planning(cls);
  bind_files(cls);
}

}  // namespace srmp::python
