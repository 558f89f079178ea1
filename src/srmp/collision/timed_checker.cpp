#include "srmp/collision/timed_checker.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

CheckerOptions with_other_robots(CheckerOptions options, const std::map<std::string, TimedPath>& others) {
  for (const auto& [name, path] : others) options.other_robots.push_back(name);
  return options;
}

void require_valid(const TimedPath& path, const RobotModel& model) {
  const std::string of = "path of robot '" + model.name() + "'";
  if (path.times.empty()) throw InvalidArgument(of + " is empty; it needs at least one time and configuration");
  if (path.times.size() != path.configurations.size())
    throw InvalidArgument(of + " has " + std::to_string(path.times.size()) + " times, but " +
                          std::to_string(path.configurations.size()) + " configurations");
  require_finite(path.times, "times of the " + of);
  for (std::size_t i = 1; i < path.times.size(); ++i)
    if (path.times[i] <= path.times[i - 1])
      throw InvalidArgument("times of the " + of + ": number " + std::to_string(i) + " is " + to_text(path.times[i]) +
                            " s, not after the one before (" + to_text(path.times[i - 1]) + " s)");
  for (std::size_t i = 0; i < path.configurations.size(); ++i)
    model.require_configuration(path.configurations[i], "configuration " + std::to_string(i) + " of the " + of);
}

void require_time(double time, const char* what) {
  if (!std::isfinite(time)) throw InvalidArgument(std::string(what) + " must be a finite time [s]");
}

}  // namespace

TimedChecker::TimedChecker(const Scene& scene, const std::string& robot, std::map<std::string, TimedPath> others,
                           const CheckerOptions& options, const CheckerFactory& factory)
    : checker_(factory(scene, robot, with_other_robots(options, others))) {
  for (auto& [name, path] : others) {
    const auto& model = scene.robot(name).model;
    require_valid(path, *model);
    others_.push_back({model, std::move(path)});
  }
}

Eigen::VectorXd TimedChecker::Other::at(double time) const {
  const auto next = std::upper_bound(path.times.begin(), path.times.end(), time);
  const auto i = static_cast<std::size_t>(next - path.times.begin());
  if (i == 0) return path.configurations.front();
  if (i == path.times.size()) return path.configurations.back();
  const double fraction = (time - path.times[i - 1]) / (path.times[i] - path.times[i - 1]);
  const Eigen::VectorXd& before = path.configurations[i - 1];
  return before + fraction * model->difference(before, path.configurations[i]);
}

Eigen::VectorXd TimedChecker::at(ConstVector q, double time) const {
  require_time(time, "time");
  checker_->robot().require_configuration(q, "configuration");
  Eigen::VectorXd all(static_cast<Eigen::Index>(checker_->dof()));
  all.head(q.size()) = q;
  Eigen::Index first = q.size();
  for (const Other& other : others_) {
    const Eigen::VectorXd q_other = other.at(time);
    all.segment(first, q_other.size()) = q_other;
    first += q_other.size();
  }
  return all;
}

template <class Part>
void TimedChecker::for_each_straight_part(ConstVector a, ConstVector b, double from, double to, Part&& part) const {
  require_time(from, "start time");
  require_time(to, "end time");
  if (to < from)
    throw InvalidArgument("the motion starts at " + to_text(from) + " s and ends at " + to_text(to) +
                          " s, before that");
  std::vector<double> times{from, to};
  for (const Other& other : others_)
    for (const double time : other.path.times)
      if (from < time && time < to) times.push_back(time);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin() + 1, times.end()), times.end());
  if (times.size() == 1) times.push_back(to);
  checker_->robot().require_configuration(a, "start of the motion");
  checker_->robot().require_configuration(b, "end of the motion");
  const Eigen::VectorXd difference = checker_->robot().difference(a, b);
  const auto fraction = [&](double time) { return to > from ? (time - from) / (to - from) : 0.0; };
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double s = fraction(times[i - 1]), e = i + 1 == times.size() ? 1.0 : fraction(times[i]);
    if (!part(at(a + s * difference, times[i - 1]), at(a + e * difference, times[i]), s, e)) return;
  }
}

bool TimedChecker::is_free(ConstVector q, double time, Checker::Workspace& workspace) const {
  return checker_->is_free(at(q, time), workspace);
}

bool TimedChecker::is_motion_free(ConstVector a, ConstVector b, double from, double to,
                                  Checker::Workspace& workspace) const {
  bool free = true;
  for_each_straight_part(a, b, from, to, [&](const Eigen::VectorXd& start, const Eigen::VectorXd& end, double, double) {
    return free = checker_->is_motion_free(start, end, workspace);
  });
  return free;
}

MotionCertificate TimedChecker::certify_motion(ConstVector a, ConstVector b, double from, double to,
                                               Checker::Workspace& workspace) const {
  MotionCertificate certificate{true, 0.0, 0.0, "", ""};
  for_each_straight_part(a, b, from, to,
                         [&](const Eigen::VectorXd& start, const Eigen::VectorXd& end, double low, double high) {
                           const MotionCertificate part = checker_->certify_motion(start, end, workspace);
                           if (part.proved) return true;
                           certificate = part;
                           certificate.from = low + part.from * (high - low);
                           certificate.to = low + part.to * (high - low);
                           return false;
                         });
  return certificate;
}

std::optional<Contact> TimedChecker::nearest(ConstVector q, double time, Checker::Workspace& workspace) const {
  return checker_->nearest(at(q, time), workspace);
}

}  // namespace srmp
