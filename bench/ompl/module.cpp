#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "../../python/src/planner_interface.hpp"
#include "../micro/plain_coal.hpp"
#include "cone.hpp"
#include "planners.hpp"
#include "srmp/facade/scene_checkers.hpp"

// The module _srmp_ompl: OMPL's planners on a scene of srmp.PlannerInterface, with its collision checker or with plain
// Coal.
namespace srmp::python {

void raise_interrupt() {
  const nb::gil_scoped_acquire gil;
  if (PyErr_CheckSignals() != 0) throw nb::python_error();
}

}  // namespace srmp::python

namespace bench {

namespace nb = nanobind;
using Eigen::VectorXd;
using srmp::python::PyPlannerInterface;

/// The library's own checker, of all robots together: each pair of robots is checked once.
class OwnChecker final : public Validity {
 public:
  OwnChecker(const srmp::Scene& scene, const std::vector<std::string>& robots, const srmp::CheckerOptions& shared) {
    Eigen::Index first = 0, all = 0;
    for (const std::string& robot : robots) all += dof(scene, robot);
    for (std::size_t k = 0; k < robots.size(); ++k) {
      srmp::CheckerOptions options = shared;
      options.excluded_robots.assign(robots.begin(), robots.begin() + static_cast<std::ptrdiff_t>(k));
      options.other_robots.assign(robots.begin() + static_cast<std::ptrdiff_t>(k) + 1, robots.end());
      auto checker = srmp::make_checker(scene, robots[k], options);
      auto workspace = checker->make_workspace();
      parts_.push_back({std::move(checker), std::move(workspace), first, all - first});
      first += dof(scene, robots[k]);
    }
  }

  bool is_free(const VectorXd& q) override {
    return std::all_of(parts_.begin(), parts_.end(), [&](Part& part) {
      return part.checker->is_free(q.segment(part.first, part.count), *part.workspace);
    });
  }
  bool is_motion_free(const VectorXd& a, const VectorXd& b) override {
    return std::all_of(parts_.begin(), parts_.end(), [&](Part& part) {
      return part.checker->is_motion_free(a.segment(part.first, part.count), b.segment(part.first, part.count),
                                          *part.workspace, {.start_is_free = true});
    });
  }

 private:
  struct Part {
    std::unique_ptr<const srmp::Checker> checker;
    srmp::Checker::WorkspacePtr workspace;
    Eigen::Index first, count;  // of the configuration of all
  };
  static Eigen::Index dof(const srmp::Scene& scene, const std::string& robot) {
    return static_cast<Eigen::Index>(scene.robot(robot).model->dof());
  }
  std::vector<Part> parts_;
};

/// Pinocchio and Coal, for one robot.
class CoalChecker final : public Validity {
 public:
  CoalChecker(const srmp::Scene& scene, const std::string& robot) : coal_(scene, robot, PlainCoal::BroadPhase::boxes) {}
  bool is_free(const VectorXd& q) override { return coal_.is_free(q); }
  bool is_motion_free(const VectorXd& a, const VectorXd& b) override { return coal_.is_motion_free(a, b - a, 0.01); }

 private:
  PlainCoal coal_;
};

std::vector<Dimension> dimensions(const srmp::Scene& scene, const std::vector<std::string>& robots) {
  std::vector<Dimension> found;
  for (const std::string& robot : robots)
    for (const srmp::Joint& joint : scene.robot(robot).model->joints())
      found.push_back({joint.lower, joint.upper, joint.kind == srmp::JointKind::continuous});
  return found;
}

/// Sphere covers and tables of robots, which are loaded once a process.
srmp::CheckerOptions prepared_options(const srmp::Scene& scene) {
  static srmp::SceneCheckers known;
  known.prepare(scene, {});
  return known.options(srmp::CheckMode::exact);
}

nb::dict plan_in_scene(PyPlannerInterface& planner, const std::vector<std::string>& robots,
                       const std::vector<double>& start, const std::vector<double>& goal, const std::string& planner_id,
                       double time_limit, unsigned seed, const std::string& checker,
                       const std::optional<srmp::PathConstraint>& cone, bool sampled) {
  const auto vector = [](const std::vector<double>& values) {
    return VectorXd(VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size())));
  };
  const bool plain = checker == "coal";
  if (!plain && checker != "srmp") throw srmp::InvalidArgument("checker '" + checker + "' is neither srmp nor coal");
  if (plain && robots.size() != 1) throw srmp::InvalidArgument("plain Coal is for one robot");
  if (cone && robots.size() != 1) throw srmp::InvalidArgument("a cone is for one robot");
  const Answer answer = planner.use([&](const srmp::PlannerInterface& p) {
    const nb::gil_scoped_release no_gil;
    const srmp::Scene& scene = p.scene();
    std::shared_ptr<Validity> validity;
    if (plain)
      validity = std::make_shared<CoalChecker>(scene, robots[0]);
    else
      validity = std::make_shared<OwnChecker>(scene, robots, prepared_options(scene));
    return plan({.space = dimensions(scene, robots),
                 .start = vector(start),
                 .goal = vector(goal),
                 .planner = planner_id,
                 .time_limit = time_limit,
                 .seed = seed,
                 .motions = plain || sampled ? Motions::sampled : Motions::by_validity,
                 .constraint = cone ? std::make_shared<Cone>(scene, robots[0], *cone) : nullptr},
                validity);
  });
  nb::dict result;
  result["status"] = answer.status;
  result["search_time_s"] = answer.search_time_s;
  result["plan_time_s"] = answer.plan_time_s;
  nb::list waypoints;
  for (const VectorXd& q : answer.waypoints) waypoints.append(std::vector<double>(q.begin(), q.end()));
  result["waypoints"] = waypoints;
  return result;
}

}  // namespace bench

NB_MODULE(_srmp_ompl, m) {
  nb::module_::import_("srmp._srmp");  // whose PlannerInterface is an argument
  m.attr("version") = bench::ompl_version();
  m.attr("planners") = bench::ompl_planners();
  using namespace nanobind::literals;
  m.def("plan", bench::plan_in_scene, "planner"_a, "robots"_a, "start"_a, "goal"_a, "planner_id"_a, "time_limit"_a,
        "seed"_a, "checker"_a = "srmp", "cone"_a = nb::none(), "sampled"_a = false,
        "A path of one or several robots of the scene, their configurations one after the other: a dict of status, "
        "search_time_s, plan_time_s and waypoints. With a PathConstraint.cone, the path of one robot keeps it. "
        "With sampled, OMPL checks motions at samples; our checker else proves them free.");
}
