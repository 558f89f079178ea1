#include "fuzz/doors.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "srmp/core/cache_file.hpp"
#include "srmp/core/error.hpp"
#include "srmp/cover/cover_file.hpp"
#include "srmp/facade/problem_file.hpp"
#include "srmp/geometry/mesh_geometry.hpp"
#include "srmp/io/joint_limits.hpp"
#include "srmp/io/moveit.hpp"
#include "srmp/io/primitives.hpp"
#include "srmp/io/scene_file.hpp"
#include "srmp/io/trajectory_file.hpp"
#include "srmp/moveit_request.hpp"
#include "srmp/moveit_session.hpp"
#include "srmp/planner_interface.hpp"
#include "srmp/planning/options.hpp"
#include "srmp/trajectory/parameterize.hpp"
#include "support/robots.hpp"

namespace fuzz {

namespace {

using namespace srmp;

/// Writes the input where a reader of files finds it.
std::string file_of(const std::string& directory, const std::string& name, const std::string& input) {
  std::string path = directory + "/" + name;
  std::ofstream(path, std::ios::binary) << input;
  return path;
}

void read_mesh(const std::string& path) {
  const TriangleSoup mesh = read_mesh_file(path);
  make_mesh_geometry(mesh, MeshModel::hull_if_convex);
  Scene().add_object("mesh", Mesh{mesh.vertices, mesh.triangles, false}, {});
}

double hostile_number(Random& random) {
  constexpr std::array<double, 14> extremes{0.0, -1.0, 1e-300, 1e-160, 1e-9,   1e-6, 1e6,
                                            1e9, 1e20, 1e160,  1e300,  -1e300, 1e-3, 3.0};
  if (random.chance(15)) return random.one_of(extremes);
  return static_cast<double>(random.below(2'000'001)) * 3e-6 - 3.0;
}

RowMatrix hostile_rows(Random& random, Eigen::Index rows, Eigen::Index columns) {
  RowMatrix matrix(rows, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix.data()[i] = hostile_number(random);
  return matrix;
}

Eigen::VectorXd hostile_limits(Random& random, Eigen::Index size) {
  Eigen::VectorXd limits(size);
  for (double& x : limits)
    x = random.chance(90) ? std::pow(10.0, static_cast<double>(random.below(8)) - 4.0) : hostile_number(random);
  return limits;
}

/// A trajectory of hostile numbers, and all that can be asked of it.
void use_trajectory(Random& random) {
  const auto rows = static_cast<Eigen::Index>(random.below(6)), dof = static_cast<Eigen::Index>(1 + random.below(3));
  Trajectory t;
  for (Eigen::Index j = 0; j < dof; ++j) t.joint_names.push_back("j" + std::to_string(j));
  t.positions = hostile_rows(random, rows, dof);
  if (random.chance(80)) t.velocities = hostile_rows(random, rows, dof);
  if (random.chance(90)) {
    t.times.resize(rows);
    double time = hostile_number(random);
    for (double& x : t.times) x = time += std::abs(hostile_number(random));
  }
  const auto attempt = [](auto&& call) {
    try {
      call();
    } catch (const Error&) {
    }
  };
  attempt([&] { t.validate(); });
  attempt([&] { t.sample(hostile_number(random)); });
  attempt([&] { t.jerks(); });
  attempt([&] { t.slice(hostile_number(random), hostile_number(random)); });
  attempt([&] { t.rows(random.below(5), random.below(5)); });
  attempt([&] { t.followed_by(t); });
  if (t.times.size() > 0 && t.duration() < 1e3) attempt([&] { t.resample(std::abs(hostile_number(random))); });
}

void time_path(Random& random) {
  const auto rows = static_cast<Eigen::Index>(random.below(6)), dof = static_cast<Eigen::Index>(1 + random.below(3));
  std::vector<std::string> names;
  for (Eigen::Index j = 0; j < dof; ++j) names.push_back("j" + std::to_string(j));
  MotionLimits limits{hostile_limits(random, dof), hostile_limits(random, dof), hostile_limits(random, dof), {}};
  TimingOptions options;
  options.method = random.chance(50) ? TimingMethod::toppra : TimingMethod::ruckig;
  options.sample_period = random.chance(80) ? 1e3 : 1.0;  // few rows: their number is another matter
  if (random.chance(20)) options.blend_deviation = hostile_number(random);
  if (random.chance(20)) options.start_velocity = hostile_rows(random, 1, dof).row(0).transpose();
  time_parameterize(hostile_rows(random, rows, dof), names, limits, options);
}

void parse_hostile_options(const std::string& input, Random& random) {
  const std::vector<std::string> ids{"auto",  "wAstar", "ARAstar", "MHAstar",   "wPASE",
                                     "xECBS", "ECBS",   "CBS",     "RRTConnect"};
  static const std::vector<std::string> keys = [&] {
    std::vector<std::string> known;
    for (const std::string& id : ids)
      for (const auto& [key, value] : to_map(parse_options({{"planner_id", id}}))) known.push_back(key);
    return known;
  }();
  OptionMap map{{"planner_id", random.one_of(ids)}};
  for (std::size_t i = random.below(4); i-- > 0;) {
    std::string key = random.one_of(keys);
    if (random.chance(10)) key = input.substr(0, 40);
    switch (random.below(4)) {
      case 0: map[key] = random.chance(50); break;
      case 1: map[key] = hostile_number(random); break;
      case 2: map[key] = random.chance(50) ? input : std::string(random.one_of(hostile_words)); break;
      default: map[key] = std::vector<std::string>{input.substr(0, 20), std::string(random.one_of(hostile_words))};
    }
  }
  const PlannerOptions options = parse_options(map);
  validate(options);
  to_map(options);
}

/// A cache file whose content was damaged before its sum was made, and one damaged after.
void read_cache(const std::string& directory, const std::string& input) {
  const Sha256::Digest key = cover_key("fuzz").digest();
  write_cached(directory, ".cover", key, input);
  read_covers(directory, key);
  std::ofstream(directory + "/" + to_hex(key) + ".cover", std::ios::binary) << input;
  read_cached(directory, ".cover", key);
}

/// A request and the scene after it, of a file of the kind of session_planar.yaml.
struct Asked {
  io::RequestFile request;
  std::string scene_path;
};

Asked read_asked(const std::string& directory, const std::string& input) {
  const std::size_t at = std::min(input.find("%%%\n"), input.size());
  Asked asked;
  asked.scene_path = file_of(directory, "asked_scene.yaml", input.substr(std::min(at + 4, input.size())));
  asked.request = io::read_moveit_request(file_of(directory, "asked_request.yaml", input.substr(0, at)));
  asked.request.allowed_planning_time = std::min(asked.request.allowed_planning_time.value_or(1.0), 0.05);
  return asked;
}

/// A request in a scene, as the plugin for MoveIt answers it.
void solve_in_session(const RobotDescription& robot, const std::string& directory, const std::string& input) {
  const Asked asked = read_asked(directory, input);
  MoveItSession session({robot.urdf_text, robot.srdf_text, {}, {}});
  const MoveItResponse response = session.solve(io::read_moveit_scene(asked.scene_path), asked.request);
  if (response.code != MoveItErrorCode::success) throw Error(response.message);
  response.trajectory.validate();
}

/// The same in a world of one's own: the scene is loaded, the request is applied, and what it becomes is planned.
void apply_and_plan(const RobotDescription& robot, const std::string& directory, const std::string& input) {
  const Asked asked = read_asked(directory, input);
  PlannerInterface planner;
  planner.add_articulation(robot);
  planner.load_moveit_scene(asked.scene_path);
  const MoveItProblem problem = planner.apply_moveit_request(robot.name, asked.request);
  planner.make_planner({robot.name}, problem.options);
  planner.plan(robot.name, problem.start, problem.goals).validate();
}

}  // namespace

std::vector<Door> all_doors(const std::string& directory) {
  const auto arm = robots::planar3();
  const auto two_links = robots::planar_description();
  const auto file = [directory](const std::string& name, auto&& read) {
    return [directory, name, read](const std::string& input, Random&) { read(file_of(directory, name, input)); };
  };
  std::vector<Door> doors;
  doors.push_back({"urdf", "urdf", 8000, [](const std::string& input, Random&) {
                     RobotDescription description;
                     description.urdf_text = input;
                     RobotModel::load(description);
                   }});
  doors.push_back({"srdf", "srdf", 8000, [two_links](const std::string& input, Random&) {
                     RobotDescription description = two_links;
                     description.srdf_text = input;
                     RobotModel::load(description);
                   }});
  for (const std::string kind : {"stl", "obj", "dae", "ply", "off", "gltf"})
    doors.push_back({kind, kind, 3000, file("mesh." + kind, read_mesh)});
  RobotDescription grouped = two_links;
  grouped.name = "planar";
  grouped.group = "arm";
  grouped.srdf_text =
      "<robot name='planar'><virtual_joint name='virtual_joint' type='floating' parent_frame='odom' child_link='base'/>"
      "<group name='arm'><chain base_link='base' tip_link='tip'/></group><disable_collisions "
      "link1='base' link2='upper' reason='Adjacent'/></robot>";
  doors.push_back({"moveit_scene", "moveit_scene", 4000,
                   file("scene.yaml", [planar = RobotModel::load(grouped)](const std::string& path) {
                     Scene scene;
                     scene.add_robot(planar);
                     io::apply(io::read_moveit_scene(path), scene);
                   })});
  doors.push_back({"moveit_request", "moveit_request", 4000, file("request.yaml", io::read_moveit_request)});
  doors.push_back(
      {"moveit_session", "session", 500,
       [grouped, directory](const std::string& input, Random&) { solve_in_session(grouped, directory, input); }, true});
  doors.push_back(
      {"moveit_plan", "session", 500,
       [grouped, directory](const std::string& input, Random&) { apply_and_plan(grouped, directory, input); }, true});
  doors.push_back({"joint_limits", "joint_limits", 8000,
                   file("limits.yaml", [arm](const std::string& path) { io::read_joint_limits(path, *arm); })});
  doors.push_back({"primitives", "primitives", 8000, file("primitives.yaml", [arm](const std::string& path) {
                     io::read_primitives(path, arm->joints());
                   })});
  doors.push_back(
      {"scene", "problem", 2000, file("scene.json", [](const std::string& path) { io::load_scene(path); })});
  doors.push_back(
      {"problem", "problem", 2000, file("problem.json", [](const std::string& path) { load_problem(path); })});
  doors.push_back({"trajectory_file", "trajectory", 4000,
                   file("trajectory.json", [](const std::string& path) { io::load_trajectory(path).validate(); })});
  doors.push_back(
      {"cache", "cover", 4000, [directory](const std::string& input, Random&) { read_cache(directory, input); }});
  doors.push_back({"options", "joint_limits", 20000, parse_hostile_options});
  doors.push_back({"trajectory", "", 20000, [](const std::string&, Random& random) { use_trajectory(random); }});
  doors.push_back({"timing", "", 8000, [](const std::string&, Random& random) { time_path(random); }});
  return doors;
}

}  // namespace fuzz
