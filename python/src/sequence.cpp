#include "srmp/planning/sequence.hpp"

#include "bind.hpp"

namespace srmp::python {

namespace {

Segment along(Segment segment, const CartesianOptions& options) {
  segment.cartesian = options;
  return segment;
}

void bind_factories(nb::class_<Segment>& cls) {
  cls.def_static(
         "move",
         [](nb::handle goal, const std::vector<PathConstraint>& constraints, double blend_radius) {
           Segment segment;
           segment.goals = to_goals(goal);
           segment.constraints = constraints;
           segment.blend_radius = blend_radius;
           return segment;
         },
         nb::arg("goal"), nb::kw_only(), nb::arg("constraints") = std::vector<PathConstraint>(),
         nb::arg("blend_radius") = 0.0,
         nb::sig("def move(goal: " SRMP_GOALS ", *, constraints: collections.abc.Sequence[PathConstraint] = (), "
                 "blend_radius: float = 0.0) -> Segment"),
         R"(A motion to a goal, or to any one of several, as PlannerInterface.plan.

blend_radius: [m]; above 0, and with a move to follow, the motion does not stop at its end but passes it at a distance
of at most this, and of the planner's blend_deviation, of any point of the robot.)")
      .def_static(
          "linear",
          [](const std::optional<Pose>& goal, const std::optional<ArrayLike>& offset, const std::string& link,
             double max_deviation, double max_rotation, const std::vector<PathConstraint>& constraints) {
            Segment segment{.type = SegmentType::linear};
            if (goal) segment.poses = {*goal};
            if (offset) segment.offset = offset->vector3("offset");
            return along(segment, {link, max_deviation, max_rotation, constraints});
          },
          nb::arg("goal") = nb::none(), nb::kw_only(), nb::arg("offset") = nb::none(), SRMP_CARTESIAN,
          nb::sig("def linear(goal: Pose | None = None, *, offset: numpy.typing.ArrayLike | None = "
                  "None, " SRMP_CARTESIAN_SIG ") -> Segment"),
          "A straight line of a link (default: the end effector) to a pose in the world frame, or by an offset (3,) "
          "[m]\n"
          "in the world frame without a turn, as PlannerInterface.plan_linear. The PathConstraints hold all along.")
      .def_static(
          "follow",
          [](const std::vector<Pose>& poses, const std::string& link, double max_deviation, double max_rotation,
             const std::vector<PathConstraint>& constraints) {
            return along(Segment::follow(poses), {link, max_deviation, max_rotation, constraints});
          },
          nb::arg("poses"), nb::kw_only(), SRMP_CARTESIAN,
          nb::sig("def follow(poses: collections.abc.Sequence[Pose], *, " SRMP_CARTESIAN_SIG ") -> Segment"),
          "A link (default: the end effector) passes poses in the world frame, as PlannerInterface.follow.\n"
          "The PathConstraints hold all along.")
      .def_static(
          "attach",
          [](const std::string& object, const std::string& link, const std::vector<std::string>& touch_links,
             const std::optional<Pose>& pose_in_link) {
            Segment segment = Segment::attach(object, link, touch_links);
            segment.pose_in_link = pose_in_link;
            return segment;
          },
          nb::arg("object"), nb::arg("link"), nb::kw_only(), nb::arg("touch_links") = std::vector<std::string>(),
          nb::arg("pose_in_link") = nb::none(),
          "Attaches an object to a link, where it is then or at a pose in the link, as PlannerInterface.attach_object.")
      .def_static("detach", &Segment::detach, nb::arg("object"), "Detaches an object: it stays where it is then.")
      .def_static("allow", &Segment::allow, nb::arg("object"), nb::arg("other"), nb::kw_only(),
                  nb::arg("allowed") = true,
                  "Two objects or links may touch from here on, such as an object and what it stands on, or may no\n"
                  "longer, as PlannerInterface.set_allowed_collision.")
      .def_static("joints", &Segment::joints, nb::arg("positions"), nb::kw_only(), nb::arg("duration") = 0.5,
                  "Sets joints that are not planned, such as a gripper's, by name [rad or m]; the robot rests for\n"
                  "`duration` [s] meanwhile.")
      .def_static("wait", &Segment::wait, nb::arg("duration"), "The robot rests for `duration` [s].")
      .def_static(
          "gripper",
          [](const std::variant<std::string, double>& target, const std::string& end_effector, double duration) {
            return std::visit([&](const auto& to) { return Segment::gripper(to, end_effector, duration); }, target);
          },
          nb::arg("target"), nb::kw_only(), nb::arg("end_effector") = "", nb::arg("duration") = 0.5,
          nb::sig("def gripper(target: str | float, *, end_effector: str = '', duration: float = 0.5) -> Segment"),
          R"(Moves an end effector of the SRDF (default: the only one, see PlannerInterface.end_effectors) to a state of its
group, such as "open", or its fingers to an opening width [m], while the robot rests for `duration` [s].

"open" and "close" exist where there is an opening width, also without states of these names.)");
}

void bind_segment(nb::module_& m) {
  nb::enum_<SegmentType>(m, "SegmentType", "What a segment of a sequence does.")
      .value("move", SegmentType::move, "Moves to a goal.")
      .value("linear", SegmentType::linear, "Moves a link along a straight line.")
      .value("follow", SegmentType::follow, "Moves a link along poses.")
      .value("attach", SegmentType::attach, "Attaches an object.")
      .value("detach", SegmentType::detach, "Detaches an object.")
      .value("allow", SegmentType::allow, "Allows collisions of two, or forbids them again.")
      .value("joints", SegmentType::joints, "Sets joints that are not planned.")
      .value("wait", SegmentType::wait, "The robot stands still.")
      .value("gripper", SegmentType::gripper, "Moves an end effector to a state or an opening width.");
  nb::class_<Segment> segment(m, "Segment", "A segment of a sequence: PlannerInterface.plan_sequence.");
  bind_factories(segment);
  segment.def_ro("type", &Segment::type, "What it does.")
      .def_ro("object", &Segment::object, "The object of attach, detach and allow; otherwise \"\".")
      .def_ro("other", &Segment::other, "The other object or link of allow; otherwise \"\".")
      .def_ro("allowed", &Segment::allowed, "Of allow: False forbids.")
      .def_ro("link", &Segment::link, "The link of attach; otherwise \"\".")
      .def_ro("touch_links", &Segment::touch_links, "The links of attach that the object may touch besides.")
      .def_ro("positions", &Segment::positions, "Of joints [rad or m], by name.")
      .def_ro("end_effector", &Segment::end_effector, "Of gripper; \"\": the only one.")
      .def_ro("state", &Segment::state, "Of gripper; \"\": a width is given.")
      .def_ro("width", &Segment::width, "Of gripper [m]; None: a state is given.")
      .def_ro("duration", &Segment::duration, "How long the robot rests [s].")
      .def_ro("blend_radius", &Segment::blend_radius, "Of a move [m]; 0: it stops at its end.")
      .def("__repr__", [](const Segment& self) {
        const std::string object = self.object.empty() ? "" : "'" + self.object + "'";
        return "Segment." + std::string(to_string(self.type)) + "(" + object + ")";
      });
}

void bind_result(nb::module_& m) {
  nb::class_<SequencePart> part(m, "SequencePart", "What a segment of a sequence became.");
  part.def_ro("type", &SequencePart::type, "Of the segment.")
      .def_ro("begin", &SequencePart::begin, "When it begins [s of the whole motion].")
      .def_ro("end", &SequencePart::end, "When it ends [s]; the same for what takes no time.")
      .def_prop_ro(
          "motion",
          [](const SequencePart& self) { return self.motion.size() > 0 ? std::optional(self.motion) : std::nullopt; },
          "The motion by itself: a Trajectory with times from 0 and its own certificate, in the scene as it is then;\n"
          "None for what takes no time.")
      .def("__repr__", [](const SequencePart& self) {
        return "SequencePart(" + std::string(to_string(self.type)) + ", " + to_text(self.begin) + " to " +
               to_text(self.end) + " s)";
      });
  make_value(
      part,
      [](const SequencePart& p) {
        return nb::make_tuple(static_cast<int>(p.type), p.begin, p.end,
                              p.motion.size() > 0 ? nb::cast(p.motion) : nb::none());
      },
      [](const State& state) {
        SequencePart p{static_cast<SegmentType>(nb::cast<int>(state[0])), nb::cast<double>(state[1]),
                       nb::cast<double>(state[2])};
        if (!state[3].is_none()) p.motion = nb::cast<Trajectory>(state[3]);
        return p;
      });
  nb::class_<SequenceResult> result(m, "SequenceResult", "The result of PlannerInterface.plan_sequence.");
  result
      .def_ro("trajectory", &SequenceResult::trajectory,
              "All motions and rests in a row, with a certificate: the claims of each part in the scene as it is then.")
      .def_ro("parts", &SequenceResult::parts, "One SequencePart for each segment.")
      .def("__len__", [](const SequenceResult& self) { return self.parts.size(); })
      .def("__repr__", [](const SequenceResult& self) {
        return "SequenceResult(" + std::to_string(self.parts.size()) + " segments, " +
               to_text(self.trajectory.duration()) + " s)";
      });
  make_value(
      result, [](const SequenceResult& r) { return nb::make_tuple(r.trajectory, r.parts); },
      [](const State& state) {
        return SequenceResult{nb::cast<Trajectory>(state[0]), nb::cast<std::vector<SequencePart>>(state[1])};
      });
}

}  // namespace

void bind_sequence(nb::module_& m) {
  bind_segment(m);
  bind_result(m);
}

}  // namespace srmp::python
