#include "srmp/io/trajectory_file.hpp"

#include "srmp/io/trajectory_archive.h"

namespace srmp::io {

namespace {

const std::vector<std::string> trajectory_formats{trajectory_format, problem_format};

/// Results of `srmp plan -o` (python/srmp/result.py) have no format field; only their trajectory is read.
Trajectory result_trajectory(const YamlFile& file) {
  const YAML::Node& root = file.root();
  if (!root["positions"].IsDefined())
    file.fail(root, "it holds no trajectory; its status is '" + file.text(root["status"], "status") + "'");
  JsonReader reader(file, root, "");
  Trajectory trajectory;
  reader("joint_names", trajectory.joint_names);
  reader("times", trajectory.times);
  reader("positions", trajectory.positions);
  reader("velocities", trajectory.velocities);
  reader("accelerations", trajectory.accelerations);
  reader("path", trajectory.waypoints);
  reader("certificate", trajectory.certificate);
  give_columns(trajectory);
  if (const std::string text = misfit(trajectory); !text.empty()) reader.fail(text);
  return trajectory;
}

bool is_result(const YAML::Node& root) {
  return root.IsMap() && !root["format"].IsDefined() && root["status"].IsDefined() && root["joint_names"].IsDefined();
}

std::string rows_and_columns(const RowMatrix& matrix) {
  return std::to_string(matrix.rows()) + " rows of " + std::to_string(matrix.cols());
}

}  // namespace

std::string misfit(const Trajectory& t) {
  const auto dof = static_cast<Eigen::Index>(t.dof()), n = t.positions.rows();
  const auto check = [&](const char* name, const RowMatrix& matrix, bool as_positions) -> std::string {
    if (matrix.rows() == 0 || (matrix.cols() == dof && (!as_positions || matrix.rows() == n))) return "";
    return std::string(name) + " has " + rows_and_columns(matrix) + " numbers; there are " + std::to_string(n) +
           " rows of positions and " + std::to_string(dof) + " joints";
  };
  if (t.times.size() != 0 && t.times.size() != n)
    return "times has " + std::to_string(t.times.size()) + " numbers; there are " + std::to_string(n) +
           " rows of positions";
  for (const auto& [name, matrix, as_positions] :
       {std::tuple("positions", &t.positions, true), std::tuple("velocities", &t.velocities, true),
        std::tuple("accelerations", &t.accelerations, true), std::tuple("waypoints", &t.waypoints, false)})
    if (std::string text = check(name, *matrix, as_positions); !text.empty()) return text;
  return "";
}

void give_columns(Trajectory& t) {
  for (RowMatrix* matrix : {&t.positions, &t.velocities, &t.accelerations, &t.waypoints})
    if (matrix->rows() == 0) matrix->resize(0, static_cast<Eigen::Index>(t.dof()));
}

void save_trajectory(const Trajectory& trajectory, const std::string& path) {
  if (const std::string text = misfit(trajectory); !text.empty()) throw InvalidArgument("trajectory: " + text);
  JsonWriter writer(trajectory_format);
  describe(writer, trajectory);
  writer.save(path);
}

std::string to_json(const Certificate& certificate) {
  JsonWriter writer;
  describe(writer, certificate);
  return writer.text();
}

Trajectory load_trajectory(const std::string& path) {
  YamlFile yaml(path, "JSON");
  if (is_result(yaml.root())) return result_trajectory(yaml);
  const JsonFile file(std::move(yaml), trajectory_formats);
  JsonReader root = file.root();
  Trajectory trajectory;
  if (file.format() == trajectory_format) {
    describe(root, trajectory);
    root.finish();
    return trajectory;
  }
  if (root.has("result") && root.inner("result").has("trajectories"))
    root.fail(
        "it holds the trajectories of a plan_multi, not one; load the file as a PlannerInterface, whose last_result "
        "has them");
  if (!root.has("result") || !root.inner("result").has("trajectory"))
    root.fail("it holds no trajectory: nothing was planned, or planning failed");
  root.inner("result")("trajectory", trajectory);
  return trajectory;
}

}  // namespace srmp::io
