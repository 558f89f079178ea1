#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/io/moveit_messages.h"
#include "srmp/io/moveit_rules.h"

namespace srmp::io {

namespace {

using YAML::Node;

const Names constraints_keys{"name", "joint_constraints", "position_constraints", "orientation_constraints",
                             "visibility_constraints"};
const Names joint_constraint_keys{"joint_name", "position", "tolerance_above", "tolerance_below", "weight"};
const Names position_constraint_keys{"header", "link_name", "target_point_offset", "constraint_region", "weight"};
const Names region_keys{"primitives", "primitive_poses", "meshes", "mesh_poses"};
const Names orientation_constraint_keys{"header",
                                        "orientation",
                                        "link_name",
                                        "absolute_x_axis_tolerance",
                                        "absolute_y_axis_tolerance",
                                        "absolute_z_axis_tolerance",
                                        "parameterization",
                                        "weight"};
const Names workspace_keys{"header", "min_corner", "max_corner"};
const Names request_keys{"workspace_parameters",
                         "start_state",
                         "goal_constraints",
                         "path_constraints",
                         "trajectory_constraints",
                         "reference_trajectories",
                         "pipeline_id",
                         "planner_id",
                         "group_name",
                         "num_planning_attempts",
                         "allowed_planning_time",
                         "max_velocity_scaling_factor",
                         "max_acceleration_scaling_factor",
                         "cartesian_speed_limited_link",
                         "cartesian_speed_end_effector_link",
                         "max_cartesian_speed"};

class RequestReader : public MessageReader {
 public:
  using MessageReader::MessageReader;

  RequestFile read() {
    const Node& root = file_.root();
    refuse_srmp_file(root, "a MoveIt motion plan request", "srmp replay plans a saved problem again");
    file_.require_map(root, "a motion plan request", request_keys);
    RequestFile request;
    request.path = file_.path();
    request.group_name = optional_text(root, "group_name");
    request.planner_id = optional_text(root, "planner_id");
    request.pipeline_id = optional_text(root, "pipeline_id");
    request.start_state = robot_state(root["start_state"]);
    read_velocities(root["start_state"], request.start_state);
    require_base_at_rest(root["start_state"]);
    request.velocity_scaling = scaling(root, "max_velocity_scaling_factor");
    request.acceleration_scaling = scaling(root, "max_acceleration_scaling_factor");
    read_planning_time(root, request);
    read_cartesian_speed(root, request);
    read_workspace(root["workspace_parameters"], request);
    refuse_unsupported(root);
    read_path_constraints(root["path_constraints"], request);
    read_goals(root, request);
    return request;
  }

 private:
  /// Fails with the line where a rule is broken (moveit_rules.h).
  void fail_if(const std::string& fault, const Node& node) const {
    if (!fault.empty()) file_.fail(node, fault);
  }

  double scaling(const Node& root, const std::string& key) const {
    const double value = optional_number(root, key, 1.0);
    fail_if(scaling_fault(key, value), root[key]);
    return value == 0.0 ? 1.0 : value;
  }

  /// One for each joint, or none.
  void read_velocities(const Node& state, RobotState& start) const {
    if (is_empty(state) || is_empty(state["joint_state"]) || is_empty(state["joint_state"]["velocity"])) return;
    const Node list = state["joint_state"]["velocity"];
    const std::vector<double> velocities = file_.numbers(list, "the start state's velocity");
    const Names names = is_empty(state["joint_state"]["name"])
                            ? Names{}
                            : file_.texts(state["joint_state"]["name"], "the start state's joint names");
    if (velocities.size() != names.size())
      file_.fail(list, "the start state names " + std::to_string(names.size()) + " joints, but has " +
                           std::to_string(velocities.size()) + " velocities");
    for (std::size_t i = 0; i < names.size(); ++i) start.velocities[names[i]] = velocities[i];
  }

  void require_base_at_rest(const Node& state) const {
    if (is_empty(state) || is_empty(state["multi_dof_joint_state"]) ||
        is_empty(state["multi_dof_joint_state"]["twist"]))
      return;
    for (const Node& twist : state["multi_dof_joint_state"]["twist"])
      for (const char* part : {"linear", "angular"}) {
        if (!twist.IsMap() || is_empty(twist[part])) continue;
        if (vector(twist[part], "a twist").norm() > rest_speed)
          file_.unsupported(twist, "the start state's twist is not zero; bases must be at rest at the start");
      }
  }

  /// Names have changed: `cartesian_speed_end_effector_link` was the older one.
  void read_cartesian_speed(const Node& root, RequestFile& request) const {
    request.max_cartesian_speed = optional_number(root, "max_cartesian_speed", 0.0);
    request.cartesian_speed_limited_link = optional_text(root, "cartesian_speed_limited_link");
    if (request.cartesian_speed_limited_link.empty())
      request.cartesian_speed_limited_link = optional_text(root, "cartesian_speed_end_effector_link");
  }

  void read_planning_time(const Node& root, RequestFile& request) const {
    const double time = optional_number(root, "allowed_planning_time", 0.0);
    fail_if(time_fault(time), root["allowed_planning_time"]);
    if (time > 0.0) request.allowed_planning_time = time;
    const double attempts = optional_number(root, "num_planning_attempts", 0.0);
    fail_if(attempts_fault(attempts), root["num_planning_attempts"]);
    request.attempts = static_cast<int>(attempts);
  }

  void read_workspace(const Node& node, RequestFile& request) const {
    if (is_empty(node)) return;
    const std::string what = "workspace_parameters";
    file_.require_map(node, what, workspace_keys);
    const WorkspaceBounds bounds{frame_of(node), vector(file_.require(node, "min_corner", what), "min_corner"),
                                 vector(file_.require(node, "max_corner", what), "max_corner")};
    fail_if(workspace_fault(bounds), node);
    request.workspace = bounds;
  }

  void refuse_unsupported(const Node& root) const {
    const Node trajectory = root["trajectory_constraints"];
    if (!is_empty(trajectory)) {
      file_.require_map(trajectory, "trajectory_constraints", Names{"constraints"});
      if (!is_empty(trajectory["constraints"])) file_.unsupported(trajectory, unsupported("trajectory_constraints"));
    }
    if (!is_empty(root["reference_trajectories"]))
      file_.unsupported(root["reference_trajectories"], unsupported("reference_trajectories"));
  }

  void read_goals(const Node& root, RequestFile& request) const {
    const Node goals = root["goal_constraints"];
    if (is_empty(goals)) file_.fail(root, "a motion plan request has no goal_constraints");
    file_.require_list(goals, "goal_constraints");
    for (const Node& goal : goals) request.goals.push_back(read_goal(goal));
  }

  void read_path_constraints(const Node& node, RequestFile& request) const {
    if (is_empty(node)) return;
    request.path_constraints = read_constraints(node, "path_constraints");
    if (const std::string fault = path_constraints_fault(request.path_constraints); !fault.empty())
      file_.unsupported(node, fault);
  }

  GoalAlternative read_goal(const Node& node) const {
    GoalAlternative goal = read_constraints(node, "a goal");
    if (goal.joints.empty() && goal.positions.empty() && goal.orientations.empty())
      file_.fail(node, "a goal holds no constraints");
    return goal;
  }

  GoalAlternative read_constraints(const Node& node, const std::string& what) const {
    file_.require_map(node, what, constraints_keys);
    if (!is_empty(node["visibility_constraints"]))
      file_.unsupported(node["visibility_constraints"], unsupported("visibility_constraints"));
    GoalAlternative goal;
    goal.name = optional_text(node, "name");
    for_each(node["joint_constraints"], "joint_constraints",
             [&](const Node& entry) { goal.joints.push_back(joint_constraint(entry, goal)); });
    for_each(node["position_constraints"], "position_constraints",
             [&](const Node& entry) { goal.positions.push_back(position_constraint(entry)); });
    for_each(node["orientation_constraints"], "orientation_constraints",
             [&](const Node& entry) { goal.orientations.push_back(orientation_constraint(entry)); });
    return goal;
  }

  template <class Read>
  void for_each(const Node& list, const std::string& what, Read&& read) const {
    if (is_empty(list)) return;
    file_.require_list(list, what);
    for (const Node& entry : list) read(entry);
  }

  double tolerance(const Node& node, const std::string& key) const {
    const double value = optional_number(node, key, 0.0);
    fail_if(tolerance_fault(key, value), node[key]);
    return value;
  }

  JointConstraint joint_constraint(const Node& node, const GoalAlternative& goal) const {
    const std::string what = "a joint constraint";
    file_.require_map(node, what, joint_constraint_keys);
    JointConstraint constraint;
    constraint.joint = file_.text(file_.require(node, "joint_name", what), "joint_name");
    constraint.position = file_.number(file_.require(node, "position", what), constraint.joint + "'s position");
    constraint.tolerance_above = tolerance(node, "tolerance_above");
    constraint.tolerance_below = tolerance(node, "tolerance_below");
    optional_number(node, "weight", 1.0);
    for (const JointConstraint& other : goal.joints)
      if (other.joint == constraint.joint) file_.fail(node, twice_fault(constraint.joint));
    return constraint;
  }

  PositionConstraint position_constraint(const Node& node) const {
    const std::string what = "a position constraint";
    file_.require_map(node, what, position_constraint_keys);
    const std::string link = file_.text(file_.require(node, "link_name", what), "link_name");
    PositionConstraint constraint{.link = link, .frame = frame_of(node)};
    if (const Node offset = node["target_point_offset"]; !is_empty(offset))
      constraint.offset = vector(offset, "target_point_offset");
    const Node region = file_.require(node, "constraint_region", what);
    file_.require_map(region, "a constraint region", region_keys);
    for (const char* key : {"meshes", "mesh_poses"})
      if (!is_empty(region[key]))
        file_.unsupported(region[key], std::string("a constraint region has ") + key +
                                           ", which are not supported; use boxes, spheres or cylinders");
    const Node primitives = region["primitives"];
    if (is_empty(primitives)) file_.fail(region, "a constraint region has no primitives");
    file_.require_list(primitives, "a constraint region's primitives");
    const std::vector<Pose> placed = poses(region, "primitive_poses", primitives.size(), false, "a constraint region");
    for (std::size_t i = 0; i < placed.size(); ++i) {
      const Shape shape = primitive(primitives[i], "a constraint region");
      if (std::holds_alternative<Cone>(shape))
        file_.unsupported(primitives[i], "a constraint region that is a cone is not supported, nor is it by MoveIt");
      constraint.regions.push_back({shape, placed[i]});
    }
    optional_number(node, "weight", 1.0);
    return constraint;
  }

  /// MoveIt takes a quaternion that is not of unit length for a mistake, and the identity in its place.
  Eigen::Quaterniond unit_quaternion(const Node& node) const {
    const std::array<double, 4> numbers = xyzw(node, "orientation");
    fail_if(length_fault(Eigen::Map<const Eigen::Vector4d>(numbers.data()).norm()), node);
    return quaternion(node, "orientation");
  }

  OrientationConstraint orientation_constraint(const Node& node) const {
    const std::string what = "an orientation constraint";
    file_.require_map(node, what, orientation_constraint_keys);
    OrientationConstraint constraint;
    constraint.link = file_.text(file_.require(node, "link_name", what), "link_name");
    constraint.frame = frame_of(node);
    constraint.orientation = unit_quaternion(file_.require(node, "orientation", what));
    constraint.tolerance = {tolerance(node, "absolute_x_axis_tolerance"), tolerance(node, "absolute_y_axis_tolerance"),
                            tolerance(node, "absolute_z_axis_tolerance")};
    const double parameterization = optional_number(node, "parameterization", 0.0);
    if (parameterization != 0.0 && parameterization != 1.0)
      file_.fail(node["parameterization"], "parameterization is " + to_text(parameterization) +
                                               "; it must be 0 (x, y, z angles) or 1 (rotation vector)");
    constraint.rotation_vector = parameterization == 1.0;
    optional_number(node, "weight", 1.0);
    return constraint;
  }
};

}  // namespace

RequestFile read_moveit_request(const std::string& path) { return RequestReader(path).read(); }

}  // namespace srmp::io
