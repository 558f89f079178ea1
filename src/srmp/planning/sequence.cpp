#include "srmp/planning/sequence.hpp"

namespace srmp {

std::string_view to_string(SegmentType type) {
  switch (type) {
    case SegmentType::move: return "move";
    case SegmentType::linear: return "linear";
    case SegmentType::follow: return "follow";
    case SegmentType::attach: return "attach";
    case SegmentType::detach: return "detach";
    case SegmentType::allow: return "allow";
    case SegmentType::joints: return "joints";
    case SegmentType::wait: return "wait";
    case SegmentType::gripper: return "gripper";
  }
  return "?";
}

Segment Segment::move(const Goal& goal) {
  Segment segment;
  segment.goals = {goal};
  return segment;
}

Segment Segment::linear(const Pose& goal) {
  Segment segment{.type = SegmentType::linear};
  segment.poses = {goal};
  return segment;
}

Segment Segment::linear(const Eigen::Vector3d& offset) {
  Segment segment{.type = SegmentType::linear};
  segment.offset = offset;
  return segment;
}

Segment Segment::follow(const std::vector<Pose>& poses) {
  Segment segment{.type = SegmentType::follow};
  segment.poses = poses;
  return segment;
}

Segment Segment::attach(const std::string& object, const std::string& link,
                        const std::vector<std::string>& touch_links) {
  Segment segment{.type = SegmentType::attach};
  segment.object = object;
  segment.link = link;
  segment.touch_links = touch_links;
  return segment;
}

Segment Segment::detach(const std::string& object) {
  Segment segment{.type = SegmentType::detach};
  segment.object = object;
  return segment;
}

Segment Segment::allow(const std::string& object, const std::string& other, bool allowed) {
  Segment segment{.type = SegmentType::allow};
  segment.object = object;
  segment.other = other;
  segment.allowed = allowed;
  return segment;
}

Segment Segment::joints(const std::map<std::string, double>& positions, double duration) {
  Segment segment{.type = SegmentType::joints};
  segment.positions = positions;
  segment.duration = duration;
  return segment;
}

Segment Segment::gripper(const std::string& state, const std::string& end_effector, double duration) {
  Segment segment{.type = SegmentType::gripper};
  segment.state = state;
  segment.end_effector = end_effector;
  segment.duration = duration;
  return segment;
}

Segment Segment::gripper(double width, const std::string& end_effector, double duration) {
  Segment segment = gripper("", end_effector, duration);
  segment.width = width;
  return segment;
}

Segment Segment::wait(double duration) {
  Segment segment{.type = SegmentType::wait};
  segment.duration = duration;
  return segment;
}

}  // namespace srmp
