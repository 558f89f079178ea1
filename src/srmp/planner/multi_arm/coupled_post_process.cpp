#include "srmp/planner/multi_arm/coupled_post_process.hpp"

#include <algorithm>
#include <optional>

#include "srmp/planner/multi_arm/certify_together.hpp"
#include "srmp/planner/multi_arm/timed_motion.hpp"
#include "srmp/planner/phase_timer.hpp"
#include "srmp/planner/post_process.hpp"

namespace srmp {

namespace {

class CoupledPostProcess {
 public:
  CoupledPostProcess(const MultiRobotProblem& problem, ArmWorld& world, const std::vector<CoupledPath>& raw,
                     const std::vector<CoupledPath>& shortened, const Deadline& deadline, PlanStatistics& statistics)
      : problem_(problem),
        common_(common_options(problem.options)),
        world_(world),
        raw_(raw),
        deadline_(deadline),
        statistics_(statistics) {
    for (const CoupledPath& path : shortened) clusters_.push_back({path});
  }

  MultiTrajectory run(const PathsKnown& paths_known) {
    const Deadline until(std::max(deadline_.remaining(), 0.0) + post::mercy, [this] { return deadline_.cancelled(); });
    // Arms timed apart must be proved apart.
    if (common_.timing == "none" || !common_.certify)
      while (clusters_.size() > 1) merge_clusters(0, 1);
    do {
      for (Cluster& cluster : clusters_)
        if (cluster.deviation < 0.0) time_and_certify(cluster, until);
    } while (common_.certify && !certify_clusters(until));
    std::vector<CoupledPath> paths;
    for (const Cluster& cluster : clusters_) paths.push_back(cluster.path);
    paths_known(paths);
    MultiTrajectory result;
    for (Cluster& cluster : clusters_)
      for (std::size_t i = 0; i < cluster.path.arms.size(); ++i) {
        Trajectory& trajectory = cluster.trajectories[i];
        if (common_.certify)
          seal(trajectory, std::move(cluster.certificates[i]), name(cluster.path.arms[i]), statistics_);
        result.robots.emplace(name(cluster.path.arms[i]), std::move(trajectory));
      }
    set_times(result);
    return result;
  }

 private:
  /// Groups of arms that are timed together, so that what one does while another does something stays so.
  struct Cluster {
    CoupledPath path;
    double deviation{-1.0};  // at the corners; below 0: not timed yet
    std::vector<Trajectory> trajectories{};
    std::vector<Certificate> certificates{};
  };

  /// The ways that were found for both, which do not meet, shortened together.
  void merge_clusters(std::size_t i, std::size_t j) {
    const CoupledPath raw = side_by_side(raw_path(clusters_[i].path.arms), raw_path(clusters_[j].path.arms));
    clusters_.erase(clusters_.begin() + static_cast<std::ptrdiff_t>(j));
    const PhaseTimer timer(deadline_, statistics_.shortcut_time_s);
    clusters_[i] = {common_.shortcut ? shortened(raw, world_, deadline_) : raw};
  }

  /// As the search found it.
  CoupledPath raw_path(const std::vector<std::size_t>& arms) const {
    std::optional<CoupledPath> raw;
    for (const CoupledPath& path : raw_)
      if (std::binary_search(arms.begin(), arms.end(), path.arms.front())) raw = raw ? side_by_side(*raw, path) : path;
    return *raw;
  }

  /// Corners that cannot be proved free shrink.
  void time_and_certify(Cluster& cluster, const Deadline& until) {
    for (double deviation = common_.blend_deviation;; deviation *= post::shrink) {
      if (deviation < post::least_deviation) deviation = 0.0;
      cluster.deviation = deviation;
      cluster.trajectories = in_time(cluster.path, deviation);
      if (!common_.certify) return;
      {
        const PhaseTimer timer(deadline_, statistics_.verification_time_s);
        cluster.certificates = certify_together(problem_.judges, parts_of(cluster), common_, until);
      }
      const bool proved = std::all_of(cluster.certificates.begin(), cluster.certificates.end(),
                                      [](const Certificate& c) { return c.proved_free(); });
      if (deviation == 0.0 || common_.timing != "toppra" || proved || until.stop_requested()) return;
    }
  }

  std::vector<MovingPart> parts_of(const Cluster& cluster) const {
    std::vector<MovingPart> moving;
    for (std::size_t i = 0; i < cluster.path.arms.size(); ++i) {
      const std::size_t arm = cluster.path.arms[i];
      moving.push_back({arm, &problem_.moving[arm], cluster.trajectories[i]});
    }
    return moving;
  }

  /// Proves arms of different clusters apart; false: two that are not have become one.
  bool certify_clusters(const Deadline& until) {
    for (std::size_t i = 0; i < clusters_.size(); ++i)
      for (std::size_t j = i + 1; j < clusters_.size(); ++j) {
        Cluster &a = clusters_[i], &b = clusters_[j];
        std::vector<Certificate> of_a = a.certificates, of_b = b.certificates;
        const bool apart = certify_clusters(parts_of(a), of_a, parts_of(b), of_b, until);
        if (!apart) {
          merge_clusters(i, j);
          return false;
        }
        a.certificates = std::move(of_a);
        b.certificates = std::move(of_b);
      }
    return true;
  }

  bool certify_clusters(const std::vector<MovingPart>& a, std::vector<Certificate>& of_a,
                        const std::vector<MovingPart>& b, std::vector<Certificate>& of_b, const Deadline& until) const {
    const PhaseTimer timer(deadline_, statistics_.verification_time_s);
    bool apart = true;
    for (std::size_t k = 0; k < a.size() && apart; ++k)
      for (std::size_t l = 0; l < b.size() && apart; ++l)
        apart = certify_pair(problem_.judges, a[k], of_a[k], b[l], of_b[l], until);
    return apart;
  }

  std::vector<Trajectory> in_time(const CoupledPath& path, double deviation) {
    const PhaseTimer timer(deadline_, statistics_.timing_time_s);
    std::vector<std::string> names;
    MotionLimits limits;
    Eigen::VectorXd reach;
    for (const std::size_t i : path.arms) {
      const MotionLimits own = scaled(problem_.moving[i].limits, common_);
      for (const std::string& joint : world_.robot(i).joint_names()) names.push_back(name(i) + "/" + joint);
      append(limits.velocity, own.velocity);
      append(limits.acceleration, own.acceleration);
      append(limits.jerk, own.jerk);
      append(reach, problem_.checkers.alone(i).reach());
      limits.continuous.insert(limits.continuous.end(), own.continuous.begin(), own.continuous.end());
    }
    RowMatrix waypoints(static_cast<Eigen::Index>(path.size()), limits.velocity.size());
    Eigen::Index first = 0;
    for (const RowMatrix& q : path.positions) {
      waypoints.middleCols(first, q.cols()) = q;
      first += q.cols();
    }
    if (common_.timing == "none") {
      const RowMatrix none(0, waypoints.cols());
      return parts({names, waypoints, none, none, {}, waypoints}, path);
    }
    TimingOptions options = timing_options(common_, deviation);
    options.reach = reach;
    options.is_free = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return is_motion_free(path, a, b); };
    return parts(time_parameterize(waypoints, names, limits, options), path);
  }

  static void append(Eigen::VectorXd& to, const Eigen::VectorXd& more) {
    to.conservativeResize(to.size() + more.size());
    to.tail(more.size()) = more;
  }

  /// Of all robots of a path.
  bool is_motion_free(const CoupledPath& path, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    Eigen::Index first = 0;
    std::vector<Eigen::VectorXd> from, to;
    for (const RowMatrix& q : path.positions) {
      from.emplace_back(a.segment(first, q.cols()));
      to.emplace_back(b.segment(first, q.cols()));
      first += q.cols();
    }
    for (std::size_t i = 0; i < path.arms.size(); ++i)
      if (!world_.is_free_alone(path.arms[i], from[i]) || !world_.is_free_alone(path.arms[i], from[i], to[i]))
        return false;
    for (std::size_t i = 0; i < path.arms.size(); ++i)
      for (std::size_t j = i + 1; j < path.arms.size(); ++j)
        if (!world_.are_apart(path.arms[i], from[i], to[i], path.arms[j], from[j], to[j])) return false;
    return true;
  }

  /// What each arm does.
  std::vector<Trajectory> parts(const Trajectory& all, const CoupledPath& path) const {
    std::vector<Trajectory> result;
    Eigen::Index first = 0;
    for (std::size_t i = 0; i < path.arms.size(); ++i) {
      const Eigen::Index columns = path.positions[i].cols();
      const auto part = [&](const RowMatrix& of) -> RowMatrix { return of.middleCols(first, columns); };
      Trajectory one{world_.robot(path.arms[i]).joint_names(),
                     part(all.positions),
                     part(all.velocities),
                     part(all.accelerations),
                     all.times,
                     part(all.waypoints)};
      one.robot = problem_.moving[path.arms[i]].placed;
      result.push_back(std::move(one));
      first += columns;
    }
    return result;
  }

  void set_times(const MultiTrajectory& result) {
    statistics_.makespan_s = result.duration();
    statistics_.flow_time_s = 0.0;
    for (const auto& [robot, trajectory] : result.robots) statistics_.flow_time_s += arrival(trajectory);
  }

  const std::string& name(std::size_t i) const { return problem_.moving[i].robot; }

  const MultiRobotProblem& problem_;
  const CommonOptions& common_;
  ArmWorld& world_;
  const std::vector<CoupledPath>& raw_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::vector<Cluster> clusters_;
};

}  // namespace

MultiTrajectory coupled_post_process(const MultiRobotProblem& problem, ArmWorld& world,
                                     const std::vector<CoupledPath>& raw, const std::vector<CoupledPath>& shortened,
                                     const PathsKnown& paths_known, const Deadline& deadline,
                                     PlanStatistics& statistics) {
  return CoupledPostProcess(problem, world, raw, shortened, deadline, statistics).run(paths_known);
}

}  // namespace srmp
