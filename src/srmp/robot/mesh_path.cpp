#include "srmp/robot/mesh_path.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> environment_directories(const char* variable, const char* below) {
  std::vector<fs::path> directories;
  const char* value = std::getenv(variable);
  std::istringstream entries(value ? value : "");
  for (std::string entry; std::getline(entries, entry, ':');)
    if (!entry.empty()) directories.push_back(*below ? fs::path(entry) / below : fs::path(entry));
  return directories;
}

std::vector<fs::path> package_directories(const std::string& urdf_directory,
                                          const std::vector<std::string>& package_dirs) {
  std::vector<fs::path> directories;
  if (!urdf_directory.empty())
    for (fs::path directory = fs::absolute(urdf_directory).lexically_normal();; directory = directory.parent_path()) {
      if (directory.has_filename() || directory == directory.root_path()) directories.push_back(directory);
      if (directory == directory.parent_path()) break;
    }
  directories.insert(directories.end(), package_dirs.begin(), package_dirs.end());
  for (const auto& directory : environment_directories("ROS_PACKAGE_PATH", "")) directories.push_back(directory);
  for (const auto& directory : environment_directories("AMENT_PREFIX_PATH", "share")) directories.push_back(directory);
  return directories;
}

std::vector<fs::path> candidates(const std::string& filename, const std::string& urdf_directory,
                                 const std::vector<std::string>& package_dirs) {
  std::vector<fs::path> places;
  if (filename.starts_with("package://")) {
    const std::string path = filename.substr(10);
    const std::size_t slash = std::min(path.find('/'), path.size());
    const std::string package = path.substr(0, slash), inner = path.substr(std::min(slash + 1, path.size()));
    for (const fs::path& directory : package_directories(urdf_directory, package_dirs)) {
      places.push_back(directory / path);
      const fs::path named = fs::absolute(directory).lexically_normal();
      if ((named.has_filename() ? named : named.parent_path()).filename() == package)
        places.push_back(directory / inner);
    }
  } else if (filename.starts_with("file://")) {
    places.push_back(filename.substr(7));
  } else if (fs::path(filename).is_absolute()) {
    places.push_back(filename);
  } else {
    if (!urdf_directory.empty()) places.push_back(fs::path(urdf_directory) / filename);
    for (const std::string& directory : package_dirs) places.push_back(fs::path(directory) / filename);
  }
  return places;
}

}  // namespace

std::string find_mesh(const std::string& filename, const std::string& urdf_directory,
                      const std::vector<std::string>& package_dirs, const std::string& where) {
  std::vector<std::string> tried;
  for (const fs::path& place : candidates(filename, urdf_directory, package_dirs)) {
    const std::string path = fs::absolute(place).lexically_normal().string();
    std::error_code ignored;
    if (fs::is_regular_file(path, ignored)) return path;
    if (std::find(tried.begin(), tried.end(), path) == tried.end()) tried.push_back(path);
  }
  throw FileError(
      where + "mesh '" + filename + "' was not found; tried " +
      (tried.empty() ? "nothing, because there is no directory to search; give package_dirs" : quoted_list(tried)));
}

}  // namespace srmp
