#include "srmp/robot/mesh_path.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

namespace fs = std::filesystem;

std::vector<fs::path> environment_folders(const char* variable, const char* below) {
  std::vector<fs::path> folders;
  const char* value = std::getenv(variable);
  std::istringstream entries(value ? value : "");
  for (std::string entry; std::getline(entries, entry, ':');)
    if (!entry.empty()) folders.push_back(*below ? fs::path(entry) / below : fs::path(entry));
  return folders;
}

std::vector<fs::path> package_folders(const std::string& urdf_folder, const std::vector<std::string>& package_dirs) {
  std::vector<fs::path> folders;
  if (!urdf_folder.empty())
    for (fs::path folder = fs::absolute(urdf_folder).lexically_normal();; folder = folder.parent_path()) {
      if (folder.has_filename() || folder == folder.root_path()) folders.push_back(folder);
      if (folder == folder.parent_path()) break;
    }
  folders.insert(folders.end(), package_dirs.begin(), package_dirs.end());
  for (const auto& folder : environment_folders("ROS_PACKAGE_PATH", "")) folders.push_back(folder);
  for (const auto& folder : environment_folders("AMENT_PREFIX_PATH", "share")) folders.push_back(folder);
  return folders;
}

std::vector<fs::path> candidates(const std::string& filename, const std::string& urdf_folder,
                                 const std::vector<std::string>& package_dirs) {
  std::vector<fs::path> places;
  if (filename.starts_with("package://")) {
    const std::string rest = filename.substr(10);
    const std::size_t slash = std::min(rest.find('/'), rest.size());
    const std::string package = rest.substr(0, slash), inner = rest.substr(std::min(slash + 1, rest.size()));
    for (const fs::path& folder : package_folders(urdf_folder, package_dirs)) {
      places.push_back(folder / rest);
      const fs::path named = fs::absolute(folder).lexically_normal();
      if ((named.has_filename() ? named : named.parent_path()).filename() == package) places.push_back(folder / inner);
    }
  } else if (filename.starts_with("file://")) {
    places.push_back(filename.substr(7));
  } else if (fs::path(filename).is_absolute()) {
    places.push_back(filename);
  } else {
    if (!urdf_folder.empty()) places.push_back(fs::path(urdf_folder) / filename);
    for (const std::string& folder : package_dirs) places.push_back(fs::path(folder) / filename);
  }
  return places;
}

}  // namespace

std::string find_mesh(const std::string& filename, const std::string& urdf_folder,
                      const std::vector<std::string>& package_dirs, const std::string& where) {
  std::vector<std::string> tried;
  for (const fs::path& place : candidates(filename, urdf_folder, package_dirs)) {
    const std::string path = fs::absolute(place).lexically_normal().string();
    std::error_code ignored;
    if (fs::is_regular_file(path, ignored)) return path;
    if (std::find(tried.begin(), tried.end(), path) == tried.end()) tried.push_back(path);
  }
  throw FileError(
      where + "mesh '" + filename + "' was not found; tried " +
      (tried.empty() ? "nothing, for there is no folder to search: give package_dirs" : quoted_list(tried)));
}

}  // namespace srmp
