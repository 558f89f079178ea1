#include "bind.hpp"
#include "srmp/core/version.hpp"

NB_MODULE(_srmp, m) {
  using namespace srmp::python;
  m.doc() = "Search-based robot motion planning: the Python bindings of the C++ library.";
  m.attr("__version__") = std::string(srmp::version());
  bind_errors(m);
  bind_pose(m);
  bind_goal(m);
  bind_path_constraint(m);
  bind_end_effector(m);
  bind_options(m);
  bind_certificate(m);
  bind_trajectory(m);
  bind_multi_trajectory(m);
  bind_parameterize(m);
  bind_io(m);
  bind_plan_many(m);
  bind_sequence(m);
  bind_planner_interface(m);
  bind_collision_checker(m);
  bind_search_trace(m);
  bind_cover(m);
  restate_wrong_types(m);
}
