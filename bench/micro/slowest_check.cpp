// The slowest single motion check of a saved problem: plans it again, with its planner, and times every check that this
// makes. Prints JSON. bench/micro/slowest_check.py makes the problems and starts it.
//   bench_slowest_check PROBLEM.srmp.json
// CPU time of the thread. The slowest check is repeated; the best of six counts, so that what the machine did meanwhile
// does not.

#include <algorithm>
#include <cstdio>
#include <memory>
#include <mutex>

#include "cpu_seconds.hpp"
#include "srmp/collision/checker.hpp"
#include "srmp/planner_interface.hpp"

using namespace srmp;
using bench::cpu_seconds;

namespace {

struct Motion {
  const Checker* checker{};
  Eigen::VectorXd a, b;
  MotionQuery query;
};

/// Of all checkers of a planner; threads share it.
class Slowest {
 public:
  void add(double seconds, const Motion& motion) {
    const std::lock_guard lock(mutex_);
    ++checks_;
    if (seconds <= seconds_) return;
    seconds_ = seconds;
    motion_ = motion;
  }

  /// Of the slowest check, done again by a warm workspace.
  double best_of(int repeats) const {
    double best = seconds_;
    if (!motion_.checker) return best;
    const auto workspace = motion_.checker->make_workspace();
    for (int i = 0; i < repeats; ++i) {
      const double start = cpu_seconds();
      motion_.checker->is_motion_free(motion_.a, motion_.b, *workspace, motion_.query);
      best = std::min(best, cpu_seconds() - start);
    }
    return best;
  }

  std::uint64_t checks() const { return checks_; }

 private:
  std::mutex mutex_;
  double seconds_{};
  Motion motion_;
  std::uint64_t checks_{};
};

/// The library's own checker, whose motion checks are timed.
class TimedMotions final : public Checker {
 public:
  TimedMotions(const Scene& scene, const std::string& robot, const CheckerOptions& options, Slowest& slowest)
      : Checker(scene, robot, options), own_(make_checker(scene, robot, options)), slowest_(slowest) {}

 private:
  struct Timed : Workspace {
    explicit Timed(WorkspacePtr workspace) : own(std::move(workspace)) {}
    WorkspacePtr own;
  };

  static Workspace& own(Workspace& workspace) {
    auto& timed = static_cast<Timed&>(workspace);
    timed.own->deadline = timed.deadline;
    return *timed.own;
  }

  WorkspacePtr do_make_workspace() const override { return std::make_unique<Timed>(own_->make_workspace()); }
  bool do_is_free(ConstVector q, Workspace& workspace) const override { return own_->is_free(q, own(workspace)); }
  std::vector<Contact> do_contacts(ConstVector q, Workspace& workspace) const override {
    return own_->contacts(q, own(workspace));
  }
  std::optional<Contact> do_nearest(ConstVector q, Workspace& workspace) const override {
    return own_->nearest(q, own(workspace));
  }
  std::optional<Contact> do_nearest_fixed() const override { return own_->nearest_fixed(); }
  void do_are_free(ConstRows q, std::span<bool> free, Workspace& workspace, const StateQuery& query) const override {
    own_->are_free(q, free, own(workspace), query);
  }
  MotionCertificate do_certify_motion(ConstVector a, ConstVector b, Workspace& workspace) const override {
    return own_->certify_motion(a, b, own(workspace));
  }
  Eigen::VectorXd do_reach() const override { return own_->reach(); }
  PlacedSphere do_range() const override { return own_->range(); }

  bool do_is_motion_free(ConstVector a, ConstVector b, Workspace& workspace, const MotionQuery& query) const override {
    const double start = cpu_seconds();
    const bool free = own_->is_motion_free(a, b, own(workspace), query);
    slowest_.add(cpu_seconds() - start, {own_.get(), a, b, query});
    return free;
  }

  const std::unique_ptr<const Checker> own_;
  Slowest& slowest_;
};

void plan_again(PlannerInterface& planner) {
  if (!planner.last_request()) return;
  const LastRequest request = *planner.last_request();
  try {
    if (const auto* one = std::get_if<PlanRequest>(&request))
      planner.plan(*one);
    else
      planner.plan_multi(std::get<MultiPlanRequest>(request));
  } catch (const PlanningError&) {
    // its checks count all the same
  }
}

void report(const std::string& file) {
  Slowest slowest;
  PlannerInterface planner = PlannerInterface::load(file);
  planner.set_collision_backend([&](const Scene& scene, const std::string& robot, const CheckerOptions& options) {
    return std::make_unique<const TimedMotions>(scene, robot, options, slowest);
  });
  planner.prepare();
  plan_again(planner);
  std::printf("{\"checks\": %llu, \"seconds\": %.9f}\n", static_cast<unsigned long long>(slowest.checks()),
              slowest.best_of(5));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: bench_slowest_check PROBLEM.srmp.json\n");
    return 1;
  }
  try {
    report(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
