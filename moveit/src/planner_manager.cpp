#include <algorithm>
#include <atomic>
#include <memory>
#include <srmp/core/error.hpp>
#include <stdexcept>

#include "messages.hpp"

namespace srmp_moveit {

namespace {

/// One request. terminate() may be called by another thread; all else is called by one thread.
class PlanningContext : public planning_interface::PlanningContext {
 public:
  PlanningContext(const std::string& group, std::shared_ptr<Library> library)
      : planning_interface::PlanningContext("srmp", group), library_(std::move(library)) {}

  SolveResult solve(planning_interface::MotionPlanResponse& response) override {
    const srmp::MoveItResponse result = respond();
    planning_time_of(response) = result.planning_time;
    set_code(error_code_of(response), static_cast<int>(result.code), result.message);
    const bool solved = result.code == srmp::MoveItErrorCode::success;
    if (solved) srmp_moveit::trajectory_of(response) = trajectory_of(result.trajectory, *start_, getGroupName());
    return result_of_solve(solved);
  }

  SolveResult solve(planning_interface::MotionPlanDetailedResponse& response) override {
    const srmp::MoveItResponse result = respond();
    set_code(error_code_of(response), static_cast<int>(result.code), result.message);
    const bool solved = result.code == srmp::MoveItErrorCode::success;
    if (!solved) return result_of_solve(false);
    const srmp::PlanStatistics& times = result.statistics;
    const auto add = [&](const std::string& stage, robot_trajectory::RobotTrajectoryPtr motion, double seconds) {
      srmp_moveit::trajectory_of(response).push_back(std::move(motion));
      descriptions_of(response).push_back(stage);
      processing_times_of(response).push_back(seconds);
    };
    if (result.trajectory.waypoints.rows() > 0)
      add("plan and shortcut", path_of(result.trajectory, *start_, getGroupName()), times.plan_time_s);
    add("time parameterization and certificate", trajectory_of(result.trajectory, *start_, getGroupName()),
        times.timing_time_s + times.verification_time_s);
    return result_of_solve(true);
  }

  bool terminate() override {
    stop_ = true;
    return true;
  }

  void clear() override { stop_ = false; }

 private:
  srmp::MoveItResponse respond() {
    srmp::MoveItResponse response;
    try {
      const srmp::io::RequestFile request = request_of(*library_, getMotionPlanRequest(), *getPlanningScene());
      start_ = getPlanningScene()->getCurrentStateUpdated(getMotionPlanRequest().start_state);
      response = library_->solve(scene_of(*library_, *getPlanningScene()), request, stop_);
    } catch (const Refusal& refusal) {
      response.code = refusal.code;
      response.message = refusal.what();
    } catch (const std::exception& error) {  // of MoveIt itself
      response.code = srmp::MoveItErrorCode::failure;
      response.message = error.what();
    }
    if (response.code != srmp::MoveItErrorCode::success)
      log_warning(library_->name_of(response.code) + ": " + response.message);
    for (const std::string& note : response.notes) log_debug(note);
    return response;
  }

  std::shared_ptr<Library> library_;
  moveit::core::RobotStatePtr start_;
  std::atomic<bool> stop_{false};
};

/// The configuration of a pipeline as MoveIt keeps it: "group[configuration]", and "group" for the group's default.
planning_interface::PlannerConfigurationMap configurations_of(const Parameters& parameters,
                                                              const moveit::core::RobotModel& model) {
  const Configurations known = parameters.planner_configurations();
  planning_interface::PlannerConfigurationMap result;
  const auto add = [&](const std::string& group, const std::string& key, const std::string& name) {
    const auto options = known.find(name);
    if (options == known.end())
      throw std::runtime_error("group '" + group + "' names the planner configuration '" + name +
                               "', which planner_configs does not have");
    result[key] = {group, key, options->second};
  };
  for (const std::string& group : model.getJointModelGroupNames()) {
    for (const std::string& name : parameters.texts(group, "planner_configs"))
      add(group, group + "[" + name + "]", name);
    const std::string standard = parameters.text(group, "default_planner_config");
    if (!standard.empty()) add(group, group, standard);
  }
  return result;
}

}  // namespace

class PlannerManager : public planning_interface::PlannerManager {
 public:
#if SRMP_ROS_VERSION == 1
  bool initialize(const moveit::core::RobotModelConstPtr& model, const std::string& name_space) override {
    return set_up(model, Parameters(name_space));
  }
#else
  bool initialize(const moveit::core::RobotModelConstPtr& model, const rclcpp::Node::SharedPtr& node,
                  const std::string& name_space) override {
    return set_up(model, Parameters(node, name_space));
  }
#endif

  std::string getDescription() const override { return "SRMP"; }

  void getPlanningAlgorithms(std::vector<std::string>& ids) const override { ids = library_->planner_ids(); }

  bool canServiceRequest(const planning_interface::MotionPlanRequest& request) const override {
    const auto& path = request.path_constraints;
    return model_->hasJointModelGroup(request.group_name) && path.joint_constraints.empty() &&
           path.visibility_constraints.empty() && request.trajectory_constraints.constraints.empty();
  }

  void setPlannerConfigurations(const planning_interface::PlannerConfigurationMap& configurations) override {
    std::map<std::string, srmp::OptionMap> options;
    for (const auto& [name, settings] : configurations) {
      options[name];
      for (const auto& [option, value] : settings.config) options[name][option] = value;
    }
    try {
      library_->set_configurations(options);
      config_settings_ = configurations;
    } catch (const srmp::Error& error) {
      log_error(error.what());
    }
  }

  planning_interface::PlanningContextPtr getPlanningContext(const planning_scene::PlanningSceneConstPtr& scene,
                                                            const planning_interface::MotionPlanRequest& request,
                                                            moveit_messages::MoveItErrorCodes& code) const override {
    auto context = std::make_shared<PlanningContext>(request.group_name, library_);
    context->setPlanningScene(scene);
    context->setMotionPlanRequest(request);
    code.val = moveit_messages::MoveItErrorCodes::SUCCESS;
    return context;
  }

 private:
  bool set_up(const moveit::core::RobotModelConstPtr& model, const Parameters& parameters) {
    model_ = model;
    const std::string urdf = parameters.text("robot_description");
    const std::string srdf = parameters.text("robot_description_semantic");
    if (urdf.empty() || srdf.empty()) {
      log_error("there is no parameter 'robot_description" + std::string(urdf.empty() ? "" : "_semantic") +
                "' in the pipeline's namespace or above it; the plugin reads the robot's geometry from it");
      return false;
    }
    try {
      library_ = open_library();
      library_->start(robot_of(*model, urdf, srdf));
      setPlannerConfigurations(configurations_of(parameters, *model));
    } catch (const std::runtime_error& error) {  // srmp::Error too
      log_error(error.what());
      return false;
    }
    return true;
  }

  moveit::core::RobotModelConstPtr model_;
  std::shared_ptr<Library> library_;
};

}  // namespace srmp_moveit

PLUGINLIB_EXPORT_CLASS(srmp_moveit::PlannerManager, planning_interface::PlannerManager)
