#pragma once

#include <atomic>
#include <map>
#include <string>
#include <utility>

#include "bind.hpp"
#include "interrupt.hpp"
#include "srmp/planner_interface.hpp"

namespace srmp::python {

/// The C++ object may be used by one thread at a time, and plans run without the GIL: a second thread is refused, not
/// queued, because its result would depend on which came first.
class PyPlannerInterface {
 public:
  PyPlannerInterface() = default;
  explicit PyPlannerInterface(PlannerInterface planner) : planner_(std::move(planner)) {}

  template <class Use>
  auto use(Use&& call) {
    const OnlyUse in_use(in_use_);
    if (!in_use.first)
      throw Error(
          "this PlannerInterface is planning: no other thread may use it, nor what it calls meanwhile, such as a "
          "heuristic; give each a PlannerInterface of its own");
    const InterruptionScope interruptible(raise_interrupt);
    return call(planner_);
  }

  // The functions of add_heuristic live here, where the garbage collector finds them; the planner borrows them.
  void add_heuristic(const std::string& name, const nb::callable& function, bool consistent) {
    use([&](PlannerInterface& p) { p.add_heuristic(name, borrowed(name, function), consistent); });
    heuristics_[name] = function;
  }
  void remove_heuristic(const std::string& name) {
    use([&](PlannerInterface& p) { p.remove_heuristic(name); });
    heuristics_.erase(name);
  }
  void reset() {
    use([](PlannerInterface& p) { p.reset(); });
    heuristics_.clear();
    simulated_world = nb::none();
  }

  /// By any thread: plans end as cancelled within some 5 ms, those under way and those that begin, until it is false.
  void stop_plans(bool stop) { stops_plans_ = stop; }
  bool stops_plans() const { return stops_plans_; }

  nb::object simulated_world = nb::none();  ///< the srmp.sim.SimulatedWorld of read_sim, which refers to this object

  static int traverse(PyObject* object, visitproc visit, void* arg) {
    Py_VISIT(Py_TYPE(object));
    if (!nb::inst_ready(object)) return 0;
    const auto* self = nb::inst_ptr<PyPlannerInterface>(object);
    for (const auto& [name, function] : self->heuristics_) Py_VISIT(function.ptr());
    Py_VISIT(self->simulated_world.ptr());
    return 0;
  }
  static int clear(PyObject* object) {
    if (nb::inst_ready(object)) nb::inst_ptr<PyPlannerInterface>(object)->reset();
    return 0;
  }

 private:
  /// Called by the threads that plan, which do not hold the GIL.
  static HeuristicFunction borrowed(const std::string& name, nb::handle function) {
    return [name, function](ConstRows configurations, ConstRows goals) {
      const nb::gil_scoped_acquire gil;
      const nb::object values = function(to_numpy_rows(configurations), to_numpy_rows(goals));
      return ArrayLike{values}.vector("values of heuristic '" + name + "'");
    };
  }

  /// Marks the planner as in use, unless it is already: then this is not the `first`.
  struct OnlyUse {
    explicit OnlyUse(std::atomic_flag& in_use) : in_use(in_use), first(!in_use.test_and_set()) {}
    ~OnlyUse() {
      if (first) in_use.clear();
    }
    std::atomic_flag& in_use;
    const bool first;
  };

  std::atomic_flag in_use_;
  std::atomic<bool> stops_plans_{false};
  PlannerInterface planner_;
  std::map<std::string, nb::callable> heuristics_;
};

/// Goals in any form are those of robots of the planner.
inline ToConstraint constraints_of(const PlannerInterface& planner) {
  return [&planner](const std::string& robot, const Goal& goal, const std::optional<Eigen::VectorXd>& start) {
    return planner.goal(robot, goal, start);
  };
}

// The class PlannerInterface, section by section; each is a file of its own.
using PlannerClass = nb::class_<PyPlannerInterface>;
void bind_robots(PlannerClass& cls);
void bind_objects(PlannerClass& cls);
void bind_queries(PlannerClass& cls);
void bind_simulators(PlannerClass& cls);
void bind_verification(PlannerClass& cls);
void bind_planning(PlannerClass& cls);
void bind_files(PlannerClass& cls);
void bind_drawing(PlannerClass& cls);

void bind_contact(nb::module_& m);
void bind_moveit_problem(nb::module_& m);

}  // namespace srmp::python
