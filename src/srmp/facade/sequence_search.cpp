#include "srmp/facade/sequence_search.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"
#include "srmp/facade/grippers.hpp"
#include "srmp/facade/poses_to_follow.hpp"
#include "srmp/planning/constraints/place_constraints.hpp"
#include "srmp/planning/endpoints/goal_configurations.hpp"

namespace srmp {

namespace {

std::string name_of(const std::vector<Segment>& segments, std::size_t i) {
  return "segment " + std::to_string(i) + " (" + std::string(to_string(segments[i].type)) + ")";
}

/// What is wrong with a segment of its own, as the end of a sentence; "": nothing.
std::string fault_of(const Segment& segment, const Segment* next, double max_duration) {
  if (!(segment.blend_radius >= 0.0 && std::isfinite(segment.blend_radius)))
    return "blend_radius is " + to_text(segment.blend_radius) + "; it must be 0 m or above";
  if (!(segment.duration >= 0.0 && segment.duration <= max_duration))
    return "duration is " + to_text(segment.duration) + "; it must be 0 s or above, and at most " +
           to_text(max_duration) + " s";
  if (segment.blend_radius > 0.0 && segment.type != SegmentType::move)
    return "only moves are blended; follow() passes poses without a stop";
  const bool next_constrained = next && next->type == SegmentType::move && !next->constraints.empty();
  if (segment.blend_radius > 0.0 && (!segment.constraints.empty() || next_constrained))
    return "moves with path constraints are not blended";
  if (segment.type == SegmentType::move && segment.goals.empty()) return "it has no goal";
  if (segment.type == SegmentType::linear && segment.poses.size() + segment.offset.has_value() != 1)
    return "it needs a pose or an offset, and not both";
  if (segment.type == SegmentType::linear && segment.offset && !segment.offset->allFinite())
    return "its offset is not finite";
  return "";
}

/// The robot at rest.
Trajectory rest_of(const std::vector<std::string>& joint_names, const Eigen::VectorXd& q, double duration,
                   double sample_rate) {
  Eigen::VectorXd times = Eigen::Vector2d(0.0, duration);
  if (sample_rate > 0.0)  // not shorter than asked
    times = Eigen::VectorXd::NullaryExpr(static_cast<Eigen::Index>(std::ceil(duration * sample_rate - 1e-9)) + 1,
                                         [&](Eigen::Index k) { return static_cast<double>(k) / sample_rate; });
  const RowMatrix rows = q.transpose().replicate(times.size(), 1), zero = RowMatrix::Zero(times.size(), q.size());
  Trajectory rest{joint_names, rows, zero, zero, times, rows.topRows(1)};
  return rest;
}

/// Work of a segment: errors begin with the segment's name.
template <class Work>
void with_name(const std::vector<Segment>& segments, std::size_t i, Work&& work) {
  try {
    work();
  } catch (const NotSupported& error) {
    throw NotSupported(name_of(segments, i) + ": " + error.what());
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(name_of(segments, i) + ": " + error.what());
  }
}

}  // namespace

SequenceSearch::SequenceSearch(PlannerInterface& planner, const std::string& robot,
                               const std::vector<Segment>& segments, const SetScene& set_scene, double time_limit,
                               const PlannerInterface::Interrupt& interrupt, const SequenceSearchOptions& options)
    : planner_(planner),
      robot_(robot),
      segments_(segments),
      set_scene_(set_scene),
      options_(options),
      deadline_(time_limit * static_cast<double>(segments.size()), interrupt),
      interrupt_(interrupt),
      motions_(segments.size()),
      scenes_(segments.size()) {}

void SequenceSearch::require_segments(const Eigen::VectorXd& start) {
  for (std::size_t i = 0; i < segments_.size(); ++i) {
    const Segment* next = i + 1 < segments_.size() ? &segments_[i + 1] : nullptr;
    const std::string fault = fault_of(segments_[i], next, options_.max_duration);
    if (!fault.empty()) throw InvalidArgument(name_of(segments_, i) + ": " + fault);
    require_not_planned(i);
    with_name(segments_, i, [&] {
      for (const Goal& goal : segments_[i].goals) planner_.goal(robot_, goal, start);
      place_constraints(planner_.scene(), robot_, segments_[i].constraints);
      if (segments_[i].type == SegmentType::linear || segments_[i].type == SegmentType::follow)
        require_poses(segments_[i], start);
      change_scene(segments_[i], start);
    });
  }
}

void SequenceSearch::require_poses(const Segment& segment, const Eigen::VectorXd& start) const {
  const RobotInstance& robot = planner_.scene().robot(robot_);
  if (segment.offset) require_position(*segment.offset, "offset");
  const std::vector<Pose> poses = segment.offset ? std::vector<Pose>(1) : segment.poses;
  poses_to_follow({robot.model, robot.base, robot.other_positions}, start, poses, segment.cartesian);
  place_constraints(planner_.scene(), robot_, segment.cartesian.constraints);
}

void SequenceSearch::run(const Eigen::VectorXd& start) {
  if (solve(0, start)) return;
  const std::string others =
      alternatives_ == 0 ? "" : "; " + std::to_string(alternatives_) + " other ends of motions before it were tried";
  throw PlanningError(status_, name_of(segments_, deepest_) + ": " + reason_ + others);
}

void SequenceSearch::require_not_planned(std::size_t i) const {
  for (const std::string& joint : planner_.get_joint_names(robot_))
    if (segments_[i].positions.contains(joint))
      throw InvalidArgument(name_of(segments_, i) + ": joint '" + joint +
                            "' is planned; a segment of the type 'move' moves it");
}

bool SequenceSearch::solve(std::size_t i, const Eigen::VectorXd& q) {
  if (i == segments_.size()) return true;
  const Segment& segment = segments_[i];
  scenes_[i] = planner_.scene();
  if (segment.type == SegmentType::move) return solve_move(i, q);
  if (segment.moves()) return attempt(i, [&] { return along_poses(segment, q); }) && solve(i + 1, end_of(i));
  motions_[i] = {};
  bool free = false;
  with_name(segments_, i, [&] { free = act(i, q); });
  return free && solve(i + 1, q);
}

bool SequenceSearch::solve_move(std::size_t i, const Eigen::VectorXd& q) {
  PlanRequest request{.robot = robot_, .start = q, .constraints = segments_[i].constraints};
  for (const Goal& goal : segments_[i].goals) request.goals.push_back(planner_.goal(robot_, goal, q));
  const auto plan = [&] { return planner_.plan(request, interrupt_); };
  if (!attempt(i, plan)) return false;
  std::vector<Eigen::VectorXd> tried{end_of(i)};
  if (solve(i + 1, tried.back())) return true;
  for (const Eigen::VectorXd& other : ends(request.goals, q)) {
    if (attempts_ >= options_.max_attempts || deadline_.stop_requested()) return false;
    const auto near = [&](const Eigen::VectorXd& end) {
      return (end - other).cwiseAbs().maxCoeff() < options_.distinct;
    };
    if (std::any_of(tried.begin(), tried.end(), near)) continue;
    tried.push_back(other);
    ++alternatives_;
    set_scene_(scenes_[i]);
    request.goals = {GoalConstraint::joints(other)};
    if (attempt(i, plan) && solve(i + 1, end_of(i))) return true;
  }
  return false;
}

/// Configurations that meet the goals, those near q first.
std::vector<Eigen::VectorXd> SequenceSearch::ends(const std::vector<GoalConstraint>& goals,
                                                  const Eigen::VectorXd& q) const {
  std::vector<Eigen::VectorXd> found;
  for (const GoalConstraint& goal : goals)
    for (const Eigen::VectorXd& target : goal.targets) {
      if (goal.type == GoalType::joints) {
        found.push_back(target);
        continue;
      }
      if (!goal.links.empty()) {
        const RobotInstance& robot = planner_.scene().robot(robot_);
        std::string why;
        auto solutions = goal_configurations({robot.model, robot.base, robot.other_positions}, nullptr, goal, target, q,
                                             IkOptions{}.max_solutions, deadline_, why);
        solutions.resize(std::min(solutions.size(), static_cast<std::size_t>(IkOptions{}.max_solutions)));
        found.insert(found.end(), solutions.begin(), solutions.end());
        continue;
      }
      IkOptions options;
      if (goal.type == GoalType::position) options.rotation_tolerance = std::numeric_limits<double>::infinity();
      Pose pose;
      if (goal.type == GoalType::pose)
        pose = Pose::from_list({target.data(), static_cast<std::size_t>(target.size())});
      else
        pose.p = target.head<3>();
      for (Eigen::VectorXd& solution : planner_.compute_ik(robot_, pose, q, options))
        found.push_back(std::move(solution));
    }
  return found;
}

Trajectory SequenceSearch::along_poses(const Segment& segment, const Eigen::VectorXd& q) {
  std::vector<Pose> poses = segment.poses;
  if (segment.offset) {
    Pose goal = planner_.compute_fk(robot_, q, segment.cartesian.link);
    goal.p += *segment.offset;
    poses = {goal};
  }
  CartesianOptions options = segment.cartesian;
  options.constraints.insert(options.constraints.end(), segment.constraints.begin(), segment.constraints.end());
  return planner_.follow(robot_, q, poses, options, interrupt_);
}

bool SequenceSearch::attempt(std::size_t i, const std::function<Trajectory()>& plan) {
  ++attempts_;
  try {
    with_name(segments_, i, [&] { motions_[i] = plan(); });
    return true;
  } catch (const PlanningError& error) {
    if (error.status() == Status::cancelled) throw;
    fail(i, error.status(), error.what());
    return false;
  }
}

void SequenceSearch::fail(std::size_t i, Status status, const std::string& reason) {
  if (failed_ && i <= deepest_) return;
  failed_ = true;
  deepest_ = i;
  status_ = status;
  reason_ = reason;
}

/// A segment in which the planned joints rest; false: something is touched.
bool SequenceSearch::act(std::size_t i, const Eigen::VectorXd& q) {
  const Segment& segment = segments_[i];
  planner_.set_qpos(robot_, q);
  const bool sets_joints = segment.type == SegmentType::joints || segment.type == SegmentType::gripper;
  if (sets_joints && !set_joints(i, q)) return false;
  if (!sets_joints) change_scene(segment, q);
  if (!(segment.duration > 0.0)) return true;
  Trajectory rest = rest_of(planner_.get_joint_names(robot_), q, segment.duration,
                            common_options(planner_.planner_options({robot_})).sample_rate);
  const Certificate certificate = planner_.verify(robot_, rest, {.start = q});
  if (!certificate.holds()) {
    fail(i, Status::start_invalid, certificate.faults.front().text);
    return false;
  }
  rest.certificate = std::make_shared<const Certificate>(certificate);
  motions_[i] = std::move(rest);
  return true;
}

/// Sets joints, whose motion from where they are is proved free.
bool SequenceSearch::set_joints(std::size_t i, const Eigen::VectorXd& q) {
  const std::map<std::string, double>& positions = segments_[i].positions;
  const Scene before = planner_.scene();
  const RobotInstance& robot = before.robot(robot_);
  const std::vector<Joint>& others = robot.model->other_joints();
  std::map<std::string, double> from;
  std::vector<std::string> moving;
  for (std::size_t j = 0; j < others.size(); ++j) {
    const auto to = positions.find(others[j].name);
    if (to == positions.end() || to->second == robot.other_positions[static_cast<Eigen::Index>(j)]) continue;
    from[to->first] = robot.other_positions[static_cast<Eigen::Index>(j)];
    moving.push_back(to->first);
  }
  for (int k = 1; k <= options_.gripper_samples; ++k) {
    std::map<std::string, double> between = positions;
    for (const auto& [joint, start] : from)
      between[joint] = start + (positions.at(joint) - start) * k / options_.gripper_samples;
    planner_.set_joint_positions(robot_, k == options_.gripper_samples ? positions : between);
    const std::vector<Contact> contacts = planner_.contacts(robot_, q);
    if (contacts.empty()) continue;
    fail(i, Status::start_invalid, contacts.front().describe());
    return false;
  }
  if (moving.empty()) return true;
  std::shared_ptr<const RobotModel>& model = models_[moving];
  if (!model) model = with_planned_joints(*robot.model, moving);
  if (is_finger_motion_free(before, robot_, model, positions)) return true;
  fail(i, Status::start_invalid, "the motion of " + quoted_list(moving) + " cannot be proved free");
  return false;
}

void SequenceSearch::change_scene(const Segment& segment, const Eigen::VectorXd& q) {
  switch (segment.type) {
    case SegmentType::attach:
      planner_.set_qpos(robot_, q);
      return planner_.attach_object(segment.object, robot_, segment.link, segment.touch_links, segment.pose_in_link);
    case SegmentType::detach: return planner_.detach_object(segment.object);
    case SegmentType::allow: return planner_.set_allowed_collision(segment.object, segment.other, segment.allowed);
    case SegmentType::joints:
    case SegmentType::gripper: return planner_.set_joint_positions(robot_, segment.positions);
    default: return;
  }
}

}  // namespace srmp
