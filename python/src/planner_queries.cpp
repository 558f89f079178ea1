#include "collision_checker.hpp"
#include "planner_interface.hpp"

namespace srmp::python {

using Self = PyPlannerInterface;

void bind_queries(PlannerClass& cls) {
  const auto q_of = [](const std::string& name) { return "q of '" + name + "'"; };
  cls.def_prop_ro(
         "robot_names", [](Self& self) { return self.use([](auto& p) { return p.robot_names(); }); },
         "Names of the robots, sorted.")
      .def_prop_ro(
          "object_names", [](Self& self) { return self.use([](auto& p) { return p.object_names(); }); },
          "Names of the objects, attached ones too, sorted.")
      .def(
          "get_joint_names",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) { return p.get_joint_names(name); });
          },
          nb::arg("name"), "Names of the planned joints, in the order of q.")
      .def(
          "get_link_names",
          [](Self& self, const std::string& name) { return self.use([&](auto& p) { return p.get_link_names(name); }); },
          nb::arg("name"), "Names of all links, the root first.")
      .def(
          "get_end_effector",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) { return p.robot(name).end_effector(); });
          },
          nb::arg("name"),
          "Name of the end effector, the link that goals refer to; where none was given and several links are at an "
          "end, one of these, and goals are to name theirs.")
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
          R"(Limits of the planned joints (dof, 3): lower and upper limit [rad or m], velocity limit [rad/s or m/s]. Continuous
joints: -inf, inf.)")
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
          R"(Limits of all joints that set_joint_positions moves, planned or not: name to (lower, upper) [rad or m].)")
      .def(
          "get_end_links",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) { return p.robot(name).end_links(); });
          },
          nb::arg("name"),
          R"(The link that was given as end effector, or the last link of the planned joints' chain. Where none was given and
the planned joints branch: the links of the SRDF's end effectors that they move, or else the last link of each branch.
With several of these, goals have to name their link.)")
      .def(
          "end_effectors",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) { return p.robot(name).end_effectors(); });
          },
          nb::arg("name"), "The end effectors of the SRDF, such as grippers, in its order. Empty without an SRDF.")
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
          nb::arg("name"),
          R"(Positions of the planned joints, as set by set_qpos, (dof,) [rad or m]; at first the values nearest to 0 within
limits.)")
      .def(
          "get_object_pose",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) { return p.scene().object_pose(name); });
          },
          nb::arg("name"), "Pose of the object in the world, attached or not.")
      .def(
          "get_always_colliding",
          [](Self& self, const std::string& name) {
            return self.use([&](auto& p) { return p.robot(name).always_colliding(); });
          },
          nb::arg("name"),
          R"(Pairs of links of a robot without SRDF that touch with all joints at 0 and in more than 95 % of the sampled
configurations; their contact is ignored.)")
      .def(
          "compute_fk",
          [q_of](Self& self, const std::string& name, const ArrayLike& q, const std::string& link) {
            const Eigen::VectorXd v = q.vector(q_of(name));
            return self.use([&](auto& p) { return p.compute_fk(name, v, link); });
          },
          nb::arg("name"), nb::arg("q"), nb::arg("link") = "",
          R"(World pose of a link (default: the end effector) at q (dof,) [rad or m]. Joint limits are not checked.)")
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
          R"(Jacobian (6, dof) of a link (default: the end effector) at q (dof,): velocity vx, vy, vz of its origin and angular
velocity wx, wy, wz, in world axes, per joint velocity.)")
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
          R"(Configurations (n, dof) that bring `link` (default: the end effector) to the world pose `target`: within limits,
nearest to `reference` (dof,) (default: set_qpos) first; n = 0 when none was found. The same every time. Collisions
are not checked.

Damped least squares from `seeds` starts (Sugihara 2011), until `max_solutions` different ones are known; to 1e-5 m
and 1e-4 rad.

Raises InvalidArgument for an unknown link, a wrong size, or counts that are not above 0.)")
      .def(
          "is_state_colliding",
          [q_of](Self& self, const std::string& name, const ArrayLike& q) {
            const Eigen::VectorXd v = q.vector(q_of(name));
            return self.use([&](auto& p) { return p.is_state_colliding(name, v); });
          },
          nb::arg("name"), nb::arg("q"),
          R"(Returns whether the robot at q (dof,) [rad or m] touches itself or anything else. Joint limits are not checked.)")
      .def(
          "contacts",
          [q_of](Self& self, const std::string& name, const ArrayLike& q) {
            const Eigen::VectorXd v = q.vector(q_of(name));
            return self.use([&](auto& p) { return p.contacts(name, v); });
          },
          nb::arg("name"), nb::arg("q"), "Every pair in contact at q (dof,) [rad or m], deepest first.")
      .def(
          "is_motion_free",
          [q_of](Self& self, const std::string& name, const ArrayLike& a, const ArrayLike& b) {
            const Eigen::VectorXd from = a.vector(q_of(name)), to = b.vector(q_of(name));
            return self.use([&](auto& p) { return p.is_motion_free(name, from, to); });
          },
          nb::arg("name"), nb::arg("a"), nb::arg("b"),
          R"(Returns whether the straight joint-space motion from a (dof,) to b (dof,) is proved free, between samples too;
continuous joints take the short way round. Conservative advancement (Schwarzer, Saha, Latombe 2004).)")
      .def(
          "distance_to_collision",
          [q_of](Self& self, const std::string& name, const ArrayLike& q) {
            const Eigen::VectorXd v = q.vector(q_of(name));
            return self.use([&](auto& p) { return p.distance_to_collision(name, v); });
          },
          nb::arg("name"), nb::arg("q"),
          R"(Distance of the nearest pair at q (dof,) [m]; negative is the depth of penetration; inf when there is nothing to
collide with. The base and other links that no planned joint moves count too, unless they stand on the other (within
10 µm).)")
      .def(
          "nearest",
          [q_of](Self& self, const std::string& name, const ArrayLike& q) {
            const Eigen::VectorXd v = q.vector(q_of(name));
            return self.use([&](auto& p) { return p.nearest(name, v); });
          },
          nb::arg("name"), nb::arg("q"),
          "The pair of distance_to_collision at q (dof,) as a Contact; None when there is nothing to collide with.")
      .def(
          "collision_checker",
          [](Self& self, const std::string& name, const std::string& mode) {
            return wrap_checker(self.use([&](auto& p) { return p.collision_checker(name, to_check_mode(mode)); }));
          },
          nb::arg("name"), nb::arg("mode") = "exact",
          nb::sig("def collision_checker(self, name: str, mode: str = 'exact') -> CollisionChecker"),
          R"(A checker of the scene as it is now, for many queries; later changes of the scene do not reach it.

mode: 'exact' (spheres decide most queries, Coal the others; the result is Coal's), 'conservative' (spheres alone:
never free wrongly) or 'coal'. The first use of a robot computes sphere covers of its links, which may take many
seconds; later ones load them from the cache directory.)")
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
          R"(A checker of one robot among others whose motions are known: straight between the configurations of `others`, at
rest before and after. Robots not named stand still.

others: by robot name, its times (m,) [s] and configurations (m, dof) [rad or m].

Raises InvalidArgument for unknown robots, times that do not increase, wrong sizes and NaN.)");
}

void bind_contact(nb::module_& m) {
  nb::class_<Contact> contact(m, "Contact", "Two bodies in contact, or the nearest two.");
  contact
      .def_ro("body_a", &Contact::body_a,
              "Name of the first body: a link of the queried robot, or an object attached to it.")
      .def_ro("body_b", &Contact::body_b,
              "Name of the second body: an object, a link of the same robot, or 'robot/link' of another.")
      .def_ro("distance", &Contact::distance, "Distance [m], less the padding; negative is the depth of penetration.")
      .def_prop_ro(
          "point_a", [](const Contact& c) { return to_numpy(c.point_a); },
          "The point on body_a, (3,), world frame [m].")
      .def_prop_ro(
          "point_b", [](const Contact& c) { return to_numpy(c.point_b); },
          "The point on body_b, (3,), world frame [m].")
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
}

}  // namespace srmp::python
