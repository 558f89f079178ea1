#include <algorithm>

#include "srmp/core/error.hpp"
#include "srmp/io/moveit_objects.h"
#include "srmp/io/moveit_rules.h"
#include "srmp/robot/joint_names.hpp"
#include "srmp/robot/multi_dof_joint.hpp"

namespace srmp::io {

namespace {

/// Runs `change`; its errors name the file.
template <class Change>
auto for_file(const std::string& path, Change&& change) {
  try {
    return change();
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(path + ": " + error.what());
  } catch (const NotSupported& error) {
    throw NotSupported(path + ": " + error.what());
  }
}

/// The robot of this name, or the only one; "" where that says nothing.
std::string robot_of_file(const Scene& scene, const std::string& name) {
  if (scene.robots().contains(name)) return name;
  return scene.robots().size() == 1 ? scene.robots().begin()->first : "";
}

/// A joint that is planned or stands still, but can move; nullptr: the robot has none of this name.
const Joint* movable_joint(const RobotModel& model, const std::string& name) {
  const Joint* planned = find_joint(model.joints(), name);
  return planned ? planned : find_joint(model.other_joints(), name);
}

/// Applies a robot state to a copy of the scene.
class StateUpdate {
 public:
  StateUpdate(Scene& scene, FrameLookup& frames) : scene_(scene), frames_(frames) {}

  /// Puts the positions of planned planar and floating joints in place of their transforms, of `robot` only where that
  /// is not empty.
  RobotState with_planned_positions(RobotState state, const std::string& robot) const {
    std::erase_if(state.multi_dof_joints, [&](const auto& entry) {
      for (const auto& [name, instance] : scene_.robots()) {
        if (!robot.empty() && robot != name) continue;
        const auto positions = multi_dof_positions(*instance.model, entry.first, entry.second);
        if (positions.empty()) continue;
        require_planning_frame(state);
        for (const auto& [joint, position] : positions) state.joints.insert_or_assign(joint, position);
        return true;
      }
      return false;
    });
    return state;
  }

  /// Places the bases of robots, of `robot` only where that is not empty. Returns the joints that no robot has.
  std::vector<std::string> place_bases(const RobotState& state, const std::string& robot) {
    std::vector<std::string> unused;
    if (state.multi_dof_joints.empty()) return unused;
    frames_.require(state.multi_dof_frame, multi_dof_state);
    for (const auto& [joint, pose] : state.multi_dof_joints) {
      const std::string owner = robot_with_virtual_joint(joint, robot);
      const bool at_origin = pose.p.isZero(0.0) && pose.q.vec().isZero(0.0);
      if (owner.empty() && !at_origin)
        throw NotSupported("joint '" + joint +
                           "' is not a virtual joint of a robot's SRDF, so that it can only be at " + "its origin");
      if (owner.empty()) {
        unused.push_back(joint);
        continue;
      }
      require_planning_frame(state);
      scene_.set_base_pose(owner, frames_.planning_frame() * pose);
    }
    return unused;
  }

  /// Sets joints of the scene's robots. Returns what was not used, as sentences.
  std::vector<std::string> set_joints(const RobotState& state, const std::string& preferred) {
    std::vector<std::string> notes;
    std::map<std::string, std::map<std::string, double>> positions;
    for (const auto& [name, position] : state.joints) {
      const std::string robot = robot_with_joint(name, preferred);
      const Joint* joint = robot.empty() ? nullptr : movable_joint(*scene_.robot(robot).model, name);
      if (!joint)
        notes.push_back("joint '" + name + "' of the robot state is not a movable joint of a robot");
      else if (position < joint->lower || position > joint->upper)
        notes.push_back("joint '" + name + "' of the robot state is at " + to_text(position) +
                        ", outside of its limits, and was left where it is");
      else
        positions[robot][name] = position;
    }
    for (const auto& [robot, values] : positions) scene_.set_joint_positions(robot, values);
    return notes;
  }

 private:
  inline static const std::string multi_dof_state = "the multi-dof joint state";

  void require_planning_frame(const RobotState& state) const {
    const Frame header = frames_.require(state.multi_dof_frame, multi_dof_state);
    if (!header.pose.isometry().isApprox(frames_.planning_frame().isometry(), 1e-9))
      throw NotSupported(multi_dof_state + " is in frame '" + state.multi_dof_frame +
                         "'; only the planning frame is supported");
  }

  std::string robot_with_virtual_joint(const std::string& joint, const std::string& robot) const {
    for (const auto& [name, instance] : scene_.robots()) {
      const auto& virtual_joint = instance.model->virtual_joint();
      if (virtual_joint && virtual_joint->name == joint && (robot.empty() || robot == name)) return name;
    }
    return "";
  }

  std::string robot_with_joint(const std::string& joint, const std::string& preferred) const {
    std::vector<std::string> owners;
    for (const auto& [name, instance] : scene_.robots())
      if (movable_joint(*instance.model, joint)) owners.push_back(name);
    if (std::find(owners.begin(), owners.end(), preferred) != owners.end()) return preferred;
    if (owners.size() > 1)
      throw InvalidArgument("joint '" + joint + "' is in the robots " + quoted_list(owners) +
                            "; robot_model_name must name one of them");
    return owners.empty() ? "" : owners.front();
  }

  Scene& scene_;
  FrameLookup& frames_;
};

/// The rules of an allowed collision matrix, as MoveIt reads them.
class MatrixUpdate {
 public:
  MatrixUpdate(Scene& scene, const FrameLookup& frames, const SceneFile& file)
      : scene_(scene), frames_(frames), objects_(scene, frames), matrix_(file.allowed_collisions), file_(file) {}

  /// Returns what was not used, as sentences.
  std::vector<std::string> run() {
    const Names& names = matrix_.names;
    for (std::size_t i = 0; i < names.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) set(names[i], names[k], matrix_.entries[i][k]);
    for (const auto& [name, allowed] : matrix_.defaults)
      if (allowed) allow_by_default(name);
    return std::move(notes_);
  }

 private:
  using Names = std::vector<std::string>;

  /// Names of bodies of the scene; none if it has none of this name.
  Names bodies(const std::string& name) const {
    Names shapes = objects_.shapes_of(name);
    if (!shapes.empty()) return shapes;
    const auto frame = frames_.find(name);
    return frame && !frame->link.empty() ? Names{frame->robot + "/" + frame->link} : Names{};
  }

  bool is_added(const std::string& id) const {
    const auto has_id = [&](const CollisionObject& object) { return object.id == id; };
    return std::any_of(file_.objects.begin(), file_.objects.end(), has_id) ||
           std::any_of(file_.robot_state.attached.begin(), file_.robot_state.attached.end(),
                       [&](const AttachedObject& attached) { return has_id(attached.object); });
  }

  void set(const std::string& name_a, const std::string& name_b, bool allowed) {
    const Names a = bodies(name_a), b = bodies(name_b);
    if (allowed && (a.empty() || b.empty()))
      require_irrelevant(a.empty() ? name_a : name_b, a.empty() ? name_b : name_a);
    for (const std::string& body_a : a)
      for (const std::string& body_b : b) set_bodies(body_a, body_b, allowed);
  }

  /// MoveIt keeps entries of bodies that it does not know, but one with an object of this file is a mistake.
  void require_irrelevant(const std::string& unknown, const std::string& other) const {
    if (!is_added(other)) return;
    Names known = scene_.object_names();
    for (const auto& [name, robot] : scene_.robots())
      known.insert(known.end(), robot.model->link_names().begin(), robot.model->link_names().end());
    throw InvalidArgument("the allowed collision matrix allows object '" + other + "' contact with '" + unknown +
                          "', which is neither a link nor an object" + did_you_mean(unknown, known));
  }

  void set_bodies(const std::string& a, const std::string& b, bool allowed) {
    if (a == b || scene_.allowed_collision(a, b) == allowed) return;
    const auto explicitly = scene_.allowed_settings().find(a < b ? std::pair(a, b) : std::pair(b, a));
    if (allowed || explicitly != scene_.allowed_settings().end()) return scene_.set_allowed_collision(a, b, allowed);
    const bool links = !scene_.objects().contains(a) && !scene_.objects().contains(b);
    if (links)
      notes_.push_back("the allowed collision matrix forbids contact of '" + a + "' and '" + b +
                       "', which the robot's own rules allow: these hold");
  }

  /// Every body of the scene, and its name in a matrix: of a shape its object's id, of a link without its robot.
  std::map<std::string, std::string> all_bodies() const {
    std::map<std::string, std::string> names;
    for (const auto& [name, object] : scene_.objects()) names.emplace(name, name);
    for (const auto& [id, group] : scene_.groups())
      for (const std::string& shape : group.objects) names[shape] = id;
    for (const auto& [robot, instance] : scene_.robots())
      for (const std::string& link : instance.model->link_names()) names.emplace(robot + "/" + link, link);
    return names;
  }

  /// Contact with all bodies that the matrix has no entry for and that have no default of their own against it.
  void allow_by_default(const std::string& name) {
    const auto in_matrix = [&](const std::string& entry) {
      return std::find(matrix_.names.begin(), matrix_.names.end(), entry) != matrix_.names.end();
    };
    const Names own = bodies(name);
    for (const auto& [body, entry] : all_bodies()) {
      const auto other = matrix_.defaults.find(entry);
      const bool forbidden = other != matrix_.defaults.end() && !other->second;
      if (entry == name || forbidden || (in_matrix(name) && in_matrix(entry))) continue;
      for (const std::string& one : own) set_bodies(one, body, true);
    }
  }

  Scene& scene_;
  const FrameLookup& frames_;
  ObjectUpdate objects_;
  const AllowedCollisionMatrix& matrix_;
  const SceneFile& file_;
  Names notes_;
};

/// Padding is kept by whole robots: either every link with collision geometry has it, or none.
void set_padding(Scene& scene, const FrameLookup& frames, const std::map<std::string, double>& paddings) {
  if (paddings.empty()) return;
  std::map<std::string, std::map<std::string, double>> by_robot;
  for (const auto& [link, padding] : paddings) by_robot[frames.robot_of(link, "the file pads")][link] = padding;
  for (const auto& [robot, links] : by_robot) {
    std::optional<double> common;
    for (const LinkGeometry& geometry : scene.robot(robot).model->geometries()) {
      const auto given = links.find(geometry.link);
      const double padding = given == links.end() ? 0.0 : given->second;
      if (common.value_or(padding) != padding)
        throw NotSupported("link '" + geometry.link + "' has the padding " + to_text(padding) +
                           ", and other links of robot '" + robot + "' have " + to_text(*common) +
                           "; only one padding for all links of a robot is supported");
      common = padding;
    }
    scene.set_robot_padding(robot, common.value_or(0.0));
  }
}

std::vector<std::string> apply_state(const SceneFile& file, Scene& scene, FrameLookup& frames,
                                     const std::string& robot) {
  StateUpdate update(scene, frames);
  const RobotState state = update.with_planned_positions(file.robot_state, "");
  std::vector<std::string> notes;
  for (const std::string& joint : update.place_bases(state, ""))
    notes.push_back("joint '" + joint + "' of the robot state is not a virtual joint of a robot");
  for (std::string& note : update.set_joints(state, robot)) notes.push_back(std::move(note));
  return notes;
}

std::vector<std::string> apply_to(const SceneFile& file, Scene& scene, const Pose& planning_frame) {
  const std::string robot = robot_of_file(scene, file.robot_model_name);
  FrameLookup frames(scene, planning_frame, robot);
  ObjectUpdate objects(scene, frames);
  if (!file.is_diff) objects.remove_all();
  std::vector<std::string> notes = apply_state(file, scene, frames, robot);
  frames.define(file.fixed_frames);
  for (const CollisionObject& object : file.objects) objects.apply(object);
  for (const AttachedObject& attached : file.robot_state.attached) objects.apply(attached);
  for (std::string& note : MatrixUpdate(scene, frames, file).run()) notes.push_back(std::move(note));
  set_padding(scene, frames, file.link_padding);
  return notes;
}

/// Are the names the same but for two letters in a row?
bool nearly_same(const std::string& a, const std::string& b) {
  const auto common = [](auto begin, auto end, auto other, auto other_end) {
    return static_cast<std::size_t>(std::mismatch(begin, end, other, other_end).first - begin);
  };
  const std::size_t ends =
      common(a.begin(), a.end(), b.begin(), b.end()) + common(a.rbegin(), a.rend(), b.rbegin(), b.rend());
  return ends + 2 >= std::max(a.size(), b.size());
}

/// A name of no joint that nearly is that of a planned joint which the state leaves out.
void refuse_misspelt(const RequestFile& file, const RobotModel& model, const std::string& name) {
  for (const std::string& joint : model.joint_names())
    if (!file.start_state.joints.contains(joint) && nearly_same(name, joint))
      throw InvalidArgument("the start state names the unknown joint '" + name + "', did you mean '" + joint + "'?");
}

/// Of a state that is not a diff, MoveIt drops what it leaves out, so that the robot would move it through the world.
void require_all_attached(const RequestFile& file, const Scene& scene, const ObjectUpdate& objects,
                          const std::string& robot) {
  const RobotState& state = file.start_state;
  if (state.is_diff || (state.joints.empty() && state.multi_dof_joints.empty())) return;
  std::vector<std::string> listed;
  for (const AttachedObject& attached : state.attached)
    for (const std::string& shape : objects.shapes_of(attached.object.id)) listed.push_back(shape);
  for (const auto& [object, attachment] : scene.attachments())
    if (attachment.robot == robot && std::find(listed.begin(), listed.end(), object) == listed.end())
      throw NotSupported("the robot holds '" + object +
                         "', which the start state leaves out although it is not a diff; list it, detach it, or set "
                         "start_state.is_diff");
}

StartState apply_start_to(const RequestFile& file, Scene& scene, const std::string& robot, const Pose& planning_frame) {
  FrameLookup frames(scene, planning_frame, robot);
  ObjectUpdate objects(scene, frames);
  const RobotModel& model = *scene.robot(robot).model;
  StateUpdate update(scene, frames);
  const RobotState state = update.with_planned_positions(file.start_state, robot);
  StartState start{scene.robot(robot).q, start_velocity(state, model), update.place_bases(state, robot)};
  std::map<std::string, double> others;
  for (const auto& [name, position] : state.joints) {
    const auto planned = std::find(model.joint_names().begin(), model.joint_names().end(), name);
    if (planned != model.joint_names().end()) {
      start.q[planned - model.joint_names().begin()] = position;
    } else if (find_joint(model.other_joints(), name)) {
      others[name] = position;
    } else {
      refuse_misspelt(file, model, name);
      start.unused_joints.push_back(name);
    }
  }
  if (!others.empty()) scene.set_joint_positions(robot, others);
  frames.set_configuration(robot, start.q);
  require_all_attached(file, scene, objects, robot);
  for (const AttachedObject& attached : file.start_state.attached) {
    if (attached.object.operation == ObjectOperation::remove)
      throw NotSupported("the start state detaches object '" + attached.object.id + "'; detach it in the scene");
    objects.apply(attached);
  }
  return start;
}

}  // namespace

std::vector<std::string> apply(const SceneFile& file, Scene& scene, const Pose& planning_frame) {
  Scene changed = scene;
  std::vector<std::string> notes = for_file(file.path, [&] { return apply_to(file, changed, planning_frame); });
  scene = std::move(changed);
  return notes;
}

StartState apply_start(const RequestFile& file, Scene& scene, const std::string& robot, const Pose& planning_frame) {
  Scene changed = scene;
  StartState start = for_file(file.path, [&] { return apply_start_to(file, changed, robot, planning_frame); });
  scene = std::move(changed);
  return start;
}

}  // namespace srmp::io
