#include "srmp/planning/group_checkers.hpp"

#include "srmp/core/interruption.hpp"
#include "srmp/core/jobs.hpp"
#include "srmp/core/stopping.hpp"

namespace srmp {

namespace {

/// Runs make(i) for each i. Long parts of it are interrupted too.
template <class Make>
void make_all(Jobs& jobs, std::size_t count, const Deadline& deadline, Make&& make) {
  jobs.run(count, deadline, [&](std::size_t i, const Deadline& until) {
    const auto stop = [&until] { stop_if_late(until, "collision checkers were made"); };
    const InterruptionScope scope(stop);
    if (i > 0) stop();
    make(i);
  });
}

}  // namespace

RowMatrix side_by_side(const RowMatrix& robot, const RowMatrix& other, bool other_first) {
  RowMatrix both(robot.rows(), robot.cols() + other.cols());
  both << (other_first ? other : robot), (other_first ? robot : other);
  return both;
}

GroupCheckers::GroupCheckers(const Scene& scene, std::vector<std::string> robots, const CheckerOptions& options,
                             std::size_t threads, const CheckerFactory& backend, const Deadline& deadline)
    : scene_(scene), names_(std::move(robots)), options_(options), backend_(backend), alone_(names_.size()) {
  if (!backend_) own_.resize(size());
  Jobs jobs(threads);
  make_all(jobs, size(), deadline, [&](std::size_t i) {
    CheckerOptions alone = options_;
    for (const std::string& other : names_)
      if (other != names_[i]) alone.excluded_robots.push_back(other);
    if (backend_)
      alone_[i] = backend_(scene_, names_[i], alone);
    else
      alone_[i] = own_[i] = std::make_shared<SceneChecker>(scene_, names_[i], alone);
  });
  if (size() == 1) return;
  std::vector<PlacedSphere> ranges;
  for (const auto& checker : alone_) ranges.push_back(checker->range());
  for (std::size_t i = 0; i < size(); ++i)
    for (std::size_t j = i + 1; j < size(); ++j)
      if ((ranges[i].center - ranges[j].center).norm() <= ranges[i].radius + ranges[j].radius) pairs_[{i, j}] = nullptr;
  std::vector<Pairs::value_type*> pairs;
  for (auto& pair : pairs_) pairs.push_back(&pair);
  make_all(jobs, pairs.size(), deadline, [&](std::size_t k) {
    auto& [numbers, checker] = *pairs[k];
    checker = make_pair(numbers.first, numbers.second, options_);
  });
}

std::unique_ptr<const Checker> GroupCheckers::make_pair(std::size_t i, std::size_t j, CheckerOptions options) const {
  options.other_robots = {names_[j]};
  options.other_robots_only = true;
  return make(names_[i], options);
}

std::unique_ptr<const Checker> GroupCheckers::make(const std::string& robot, const CheckerOptions& options) const {
  return backend_ ? backend_(scene_, robot, options) : make_checker(scene_, robot, options);
}

void GroupCheckers::follow(const Scene& scene, const SceneChanges& changes) {
  scene_.follow_objects(scene, changes.objects);
  for (const std::string& name : names_)
    if (changes.robots.contains(name)) scene_.set_qpos(name, scene.robot(name).q);
  for (const auto& checker : own_)
    checker->follow_objects(scene_, changes.objects);  // pairs of robots leave objects out
}

const Checker* GroupCheckers::pair_by_spheres(std::size_t i, std::size_t j) const {
  if (!pairs_.contains({i, j}) || options_.mode == CheckMode::coal) return pair(i, j);
  const std::lock_guard lock(mutex_);
  std::unique_ptr<const Checker>& checker = pairs_by_spheres_[{i, j}];
  if (!checker) {
    CheckerOptions options = options_;
    options.quick_covers = true;
    checker = make_pair(i, j, std::move(options));
  }
  return checker.get();
}

void ProblemCheckers::follow(const Scene& scene, const SceneChanges& changes) {
  planning.follow(scene, changes);
  if (verification_) verification_->follow(scene, changes);
  if (clearance_verification_) clearance_verification_->follow(scene, changes);
  with_clearance_.clear();
}

const GroupCheckers& ProblemCheckers::verification() const {
  std::call_once(made_, [this] { verification_ = made_by_coal(0.0); });
  return *verification_;
}

const GroupCheckers& ProblemCheckers::clearance_verification() const {
  std::call_once(clearance_made_, [this] { clearance_verification_ = made_by_coal(options.clearance); });
  return *clearance_verification_;
}

const Checker& ProblemCheckers::with_clearance(double clearance) const {
  const std::lock_guard lock(mutex_);
  std::unique_ptr<const Checker>& checker = with_clearance_[clearance];
  if (!checker) {
    CheckerOptions changed = options;
    changed.clearance = clearance;
    checker = planning.make(planning.names().front(), changed);
  }
  return *checker;
}

ProblemCheckers::Made ProblemCheckers::made_by_coal(double clearance) const {
  const CheckerOptions options{.mode = CheckMode::coal, .clearance = clearance};
  return std::make_unique<GroupCheckers>(planning.scene(), planning.names(), options, threads_);
}

}  // namespace srmp
