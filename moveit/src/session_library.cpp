// The only source that is linked to the planning library; it includes nothing of ROS.

#include <optional>

#include "library.hpp"

namespace {

class SessionLibrary : public srmp_moveit::Library {
 public:
  void start(srmp::MoveItRobot robot) override { session_.emplace(std::move(robot)); }
  void set_configurations(const std::map<std::string, srmp::OptionMap>& configurations) override {
    session_->set_configurations(configurations);
  }
  std::vector<std::string> planner_ids() const override { return session_->planner_ids(); }
  srmp::MoveItResponse solve(const srmp::io::SceneFile& scene, const srmp::io::RequestFile& request,
                             const std::atomic<bool>& stop) override {
    return session_->solve(scene, request, &stop);
  }
  srmp::Shape solid_primitive(int type, const std::vector<double>& dimensions) const override {
    return srmp::io::solid_primitive(type, dimensions);
  }
  std::string name_of(srmp::MoveItErrorCode code) const override { return std::string(to_string(code)); }
  srmp::io::SceneFile read_scene(const std::string& path) const override { return srmp::io::read_moveit_scene(path); }
  srmp::io::RequestFile read_request(const std::string& path) const override {
    return srmp::io::read_moveit_request(path);
  }

 private:
  std::optional<srmp::MoveItSession> session_;
};

}  // namespace

extern "C" srmp_moveit::Library* srmp_moveit_make_library() { return new SessionLibrary; }
