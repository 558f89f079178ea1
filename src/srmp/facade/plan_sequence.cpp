// PlannerInterface::plan_sequence: motions, grasps and waits in a row.
#include <algorithm>

#include "srmp/core/error.hpp"
#include "srmp/facade/grippers.hpp"
#include "srmp/facade/planner_impl.hpp"
#include "srmp/facade/sequence_search.hpp"

namespace srmp {

namespace {

/// The motion's rows between two times, with times from 0.
Trajectory part_of(const Trajectory& motion, double begin, double end) {
  Trajectory part = motion.slice(begin, end);
  part.times.array() -= part.times[0];
  return part;
}

/// When the motion is nearest to a configuration, from a time on.
double passing_time(const Trajectory& motion, const Eigen::VectorXd& q, double from) {
  double best = std::numeric_limits<double>::infinity(), time = from;
  for (Eigen::Index row = 0; row < motion.times.size(); ++row) {
    if (motion.times[row] <= from) continue;
    const double distance = (motion.positions.row(row).transpose() - q).norm();
    if (distance < best) best = distance, time = motion.times[row];
  }
  return time;
}

SequenceResult joined(const std::vector<Segment>& segments, std::vector<Trajectory> motions) {
  SequenceResult result;
  double time = 0.0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    Trajectory& motion = motions[i];
    SequencePart part{segments[i].type, time, time};
    if (motion.size() > 1) {
      if (result.trajectory.size() == 0)
        result.trajectory = motion;
      else
        result.trajectory = result.trajectory.followed_by(motion);
      part.end = time = result.trajectory.times[result.trajectory.times.size() - 1];
    }
    part.motion = std::move(motion);
    result.parts.push_back(std::move(part));
  }
  return result;
}

/// The last of the moves that are blended into each other from this segment on; the segment itself: none. `may_pass`:
/// whether the motion need not stop where a segment ends.
std::size_t last_blended(const std::vector<Segment>& segments, std::size_t first,
                         const std::function<bool(std::size_t)>& may_pass) {
  std::size_t last = first;
  while (last + 1 < segments.size() && segments[last].blend_radius > 0.0 &&
         segments[last + 1].type == SegmentType::move && may_pass(last))
    ++last;
  return last;
}

/// The paths of motions in a row.
RowMatrix joined_paths(const std::vector<Trajectory>& motions, std::size_t first, std::size_t last) {
  RowMatrix path = motions[first].waypoints;
  for (std::size_t i = first + 1; i <= last; ++i) {
    const RowMatrix& next = motions[i].waypoints;
    RowMatrix longer(path.rows() + next.rows() - 1, path.cols());
    longer << path, next.bottomRows(next.rows() - 1);
    path = std::move(longer);
  }
  return path;
}

/// The smallest radius of the moves that are blended.
double blend_radius_of(const std::vector<Segment>& segments, std::size_t first, std::size_t last, double largest) {
  for (std::size_t i = first; i < last; ++i) largest = std::min(largest, segments[i].blend_radius);
  return largest;
}

/// Cuts a motion through the ends of others where it is nearest to them, in their place.
void cut_in_place(const Trajectory& whole, std::vector<Trajectory>& motions, std::size_t first, std::size_t last) {
  double time = whole.times[0];
  for (std::size_t i = first; i <= last; ++i) {
    const Eigen::VectorXd via = motions[i].positions.bottomRows(1).transpose();
    const double end = i < last ? passing_time(whole, via, time) : whole.times[whole.times.size() - 1];
    motions[i] = part_of(whole, time, end);
    time = end;
  }
}

std::vector<Segment> with_gripper_positions(const RobotModel& robot, std::vector<Segment> segments) {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (segments[i].type != SegmentType::gripper) continue;
    try {
      segments[i].positions = gripper_positions(robot, segments[i]);
    } catch (const InvalidArgument& error) {
      throw InvalidArgument("segment " + std::to_string(i) + " (gripper): " + error.what());
    }
  }
  return segments;
}

}  // namespace

SequenceResult PlannerInterface::plan_sequence(const std::string& robot, ConstVector start,
                                               const std::vector<Segment>& given, const Interrupt& interrupt) {
  impl_->require_state(robot, start);
  const std::vector<Segment> segments = with_gripper_positions(this->robot(robot), given);
  if (segments.empty()) throw InvalidArgument("the sequence has no segments");
  const PlannerOptions& options = planner_options({robot});
  impl_->require_backend_keeps_clearance(options);
  const CommonOptions& common = common_options(options);
  if (common.timing == "none") throw InvalidArgument("timing is 'none', but a sequence is a motion in time");
  require_planner_for_one(options);
  const Scene before = impl_->scene;
  const SequenceSearch::SetScene set_scene = [this](const Scene& scene) {
    impl_->change([&](Scene& now) { now = scene; });
  };
  struct Restore {
    const std::function<void()> run;
    ~Restore() { run(); }
  };
  const Restore restore{[&] {
    set_scene(before);
    impl_->request.reset();
  }};
  SequenceSearch search(*this, robot, segments, set_scene, common.time_limit, interrupt);
  search.require_segments(start);
  if (std::none_of(segments.begin(), segments.end(), [](const Segment& s) { return s.moves() || s.duration != 0.0; }))
    throw InvalidArgument("no segment of the sequence moves the robot or waits");
  set_scene(before);
  search.run(start);

  std::vector<Trajectory> motions = search.motions();
  const auto keeps_clearance_at_end = [&](std::size_t i) {
    if (common.clearance == 0.0) return true;
    set_scene(search.scenes()[i]);
    const auto checkers = impl_->checkers.of_one(impl_->scene, robot, common.clearance);
    const Checker& checker = checkers->planning.alone(0);
    return checker.is_free(motions[i].positions.bottomRows(1).transpose(), *checker.make_workspace());
  };
  for (std::size_t first = 0; first < segments.size(); ++first) {
    const std::size_t last = last_blended(segments, first, keeps_clearance_at_end);
    if (last == first) continue;
    set_scene(search.scenes()[first]);
    const RowMatrix path = joined_paths(motions, first, last);
    const PlanRequest request{.robot = robot,
                              .start = path.row(0).transpose(),
                              .goals = {GoalConstraint::joints(path.bottomRows(1).transpose())}};
    const double radius = blend_radius_of(segments, first, last, common.blend_deviation);
    cut_in_place(impl_->timed(request, path, radius, interrupt), motions, first, last);
    first = last;
  }
  return joined(segments, std::move(motions));
}

SequenceResult PlannerInterface::plan_sequence(ConstVector start, const std::vector<Segment>& segments,
                                               const Interrupt& interrupt) {
  return plan_sequence(only_robot(), start, segments, interrupt);
}

}  // namespace srmp
