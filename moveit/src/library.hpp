#pragma once

#include <srmp/moveit_session.hpp>

namespace srmp_moveit {

/// What the plugin calls of the planning library.
///
/// The library and MoveIt depend on different versions of the same libraries (tinyxml2, assimp, octomap, Boost,
/// urdfdom), whose symbols have the same names. So the plugin does not link the planning library: it opens a small
/// library of its own that does, with RTLD_DEEPBIND, so that each side finds its own versions. All calls go through
/// these functions.
struct Library {
  virtual ~Library() = default;
  virtual void start(srmp::MoveItRobot robot) = 0;  ///< a new session; first
  virtual void set_configurations(const std::map<std::string, srmp::OptionMap>& configurations) = 0;
  virtual std::vector<std::string> planner_ids() const = 0;
  virtual srmp::MoveItResponse solve(const srmp::io::SceneFile& scene, const srmp::io::RequestFile& request,
                                     const std::atomic<bool>& stop) = 0;
  virtual srmp::Shape solid_primitive(int type, const std::vector<double>& dimensions) const = 0;
  virtual std::string name_of(srmp::MoveItErrorCode code) const = 0;
  /// The readers of files, for tests.
  virtual srmp::io::SceneFile read_scene(const std::string& path) const = 0;
  virtual srmp::io::RequestFile read_request(const std::string& path) const = 0;
};

/// Opens libsrmp_moveit_session.so, which lies beside the library or program that calls this. Throws
/// std::runtime_error, with the linker's words.
std::shared_ptr<Library> open_library();

}  // namespace srmp_moveit
