#include "srmp/planning/coupled_post_process.hpp"

#include <algorithm>
#include <atomic>
#include <map>
#include <optional>

#include "srmp/planning/certificates/certify_together.hpp"
#include "srmp/planning/obstacles/timed_motion.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/post_process.hpp"

namespace srmp {

namespace {

class CoupledPostProcess {
 public:
  CoupledPostProcess(const MultiRobotProblem& problem, MultiRobotWorld& world, const std::vector<JointPath>& raw,
                     const std::vector<JointPath>& shortened, ParallelWork& work, const Deadline& deadline,
                     PlanStatistics& statistics)
      : problem_(problem),
        common_(common_options(problem.options)),
        world_(world),
        raw_(raw),
        work_(work),
        deadline_(deadline),
        statistics_(statistics) {
    for (const JointPath& path : shortened) clusters_.push_back({path});
  }

  MultiTrajectory run(const PathsKnown& paths_known) {
    const Deadline until(std::max(deadline_.remaining(), 0.0) + post::grace_period,
                         [this] { return deadline_.cancelled(); });
    // Arms timed apart must be proved apart.
    if (common_.timing == "none" || !common_.certify)
      while (clusters_.size() > 1) merge_clusters(0, 1);
    do {
      work_.run(clusters_.size(), until, [&](std::size_t k, const Deadline& deadline, PlanStatistics& statistics) {
        if (clusters_[k].deviation < 0.0) time_and_certify(clusters_[k], deadline, statistics);
      });
    } while (common_.certify && !all_proved_apart(until));
    add_proofs();
    std::vector<JointPath> paths;
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
    JointPath path;
    double deviation{-1.0};  // at the corners; below 0: not timed yet
    std::vector<Trajectory> trajectories{};
    std::vector<Certificate> certificates{};
  };

  /// The ways that were found for both, which do not meet, shortened together.
  void merge_clusters(std::size_t i, std::size_t j) {
    const JointPath raw = side_by_side(raw_path(clusters_[i].path.arms), raw_path(clusters_[j].path.arms));
    clusters_.erase(clusters_.begin() + static_cast<std::ptrdiff_t>(j));
    const PhaseTimer timer(deadline_, statistics_.shortcut_time_s);
    clusters_[i] = {common_.shortcut ? shortened(raw, world_, deadline_) : raw};
    std::erase_if(proofs_, [&](const auto& known) {
      const std::vector<std::size_t>& arms = clusters_[i].path.arms;
      return std::binary_search(arms.begin(), arms.end(), known.first.first) ||
             std::binary_search(arms.begin(), arms.end(), known.first.second);
    });
  }

  /// As the search found it.
  JointPath raw_path(const std::vector<std::size_t>& arms) const {
    std::optional<JointPath> raw;
    for (const JointPath& path : raw_)
      if (std::binary_search(arms.begin(), arms.end(), path.arms.front())) raw = raw ? side_by_side(*raw, path) : path;
    return *raw;
  }

  /// Corners that cannot be proved free shrink.
  void time_and_certify(Cluster& cluster, const Deadline& until, PlanStatistics& statistics) {
    for (double deviation = common_.blend_deviation;; deviation *= post::shrink) {
      if (deviation < post::min_deviation) deviation = 0.0;
      cluster.deviation = deviation;
      {
        const PhaseTimer timer(until, statistics.timing_time_s);
        cluster.trajectories = in_time(cluster.path, deviation);
      }
      if (!common_.certify) return;
      {
        const PhaseTimer timer(until, statistics.verification_time_s);
        cluster.certificates = certify_together(problem_.judges, parts_of(cluster), common_, until);
      }
      const bool proved = std::all_of(cluster.certificates.begin(), cluster.certificates.end(),
                                      [](const Certificate& c) { return c.proved_free(); });
      if (deviation == 0.0 || common_.timing != "toppra" || proved || until.stop_requested()) return;
    }
  }

  MovingPart part_of(const Cluster& cluster, std::size_t i) const {
    const std::size_t arm = cluster.path.arms[i];
    return {arm, &problem_.moving[arm], cluster.trajectories[i]};
  }
  std::vector<MovingPart> parts_of(const Cluster& cluster) const {
    std::vector<MovingPart> moving;
    for (std::size_t i = 0; i < cluster.path.arms.size(); ++i) moving.push_back(part_of(cluster, i));
    return moving;
  }

  /// An arm of a cluster.
  struct Member {
    std::size_t cluster, index;
  };
  struct MemberPair {
    Member a, b;  // a's number is the smaller one
  };

  /// Arms of different clusters that may meet and are not proved apart yet.
  std::vector<MemberPair> open_pairs() const {
    std::vector<MemberPair> open;
    for (std::size_t i = 0; i < clusters_.size(); ++i)
      for (std::size_t j = i + 1; j < clusters_.size(); ++j)
        for (std::size_t k = 0; k < clusters_[i].path.arms.size(); ++k)
          for (std::size_t l = 0; l < clusters_[j].path.arms.size(); ++l) {
            MemberPair pair{{i, k}, {j, l}};
            if (number(pair.a) > number(pair.b)) std::swap(pair.a, pair.b);
            if (problem_.judges.may_conflict(number(pair.a), number(pair.b)) &&
                !proofs_.contains({number(pair.a), number(pair.b)}))
              open.push_back(pair);
          }
    return open;
  }
  std::size_t number(const Member& arm) const { return clusters_[arm.cluster].path.arms[arm.index]; }
  MovingPart part_of(const Member& arm) const { return part_of(clusters_[arm.cluster], arm.index); }

  /// Proves arms of different clusters apart; false: the first two that are not have become one cluster.
  bool all_proved_apart(const Deadline& until) {
    const std::vector<MemberPair> open = open_pairs();
    std::vector<MotionProof> found(open.size());
    std::atomic<std::size_t> first{open.size()};  // that is not proved
    work_.run(open.size(), until, [&](std::size_t k, const Deadline& deadline, PlanStatistics& statistics) {
      if (k > first) return;
      const PhaseTimer timer(deadline, statistics.verification_time_s);
      found[k] = *prove_pair(problem_.judges, part_of(open[k].a), part_of(open[k].b), deadline);
      if (found[k].free && found[k].unproved.empty()) return;
      for (std::size_t known = first; k < known && !first.compare_exchange_weak(known, k);) {
      }
    });
    for (std::size_t k = 0; k < first; ++k)
      proofs_.emplace(std::pair(number(open[k].a), number(open[k].b)), std::move(found[k]));
    if (first == open.size()) return true;
    const auto [i, j] = std::minmax(open[first].a.cluster, open[first].b.cluster);
    merge_clusters(i, j);
    return false;
  }

  void add_proofs() {
    std::map<std::size_t, Member> members;
    for (std::size_t i = 0; i < clusters_.size(); ++i)
      for (std::size_t k = 0; k < clusters_[i].path.arms.size(); ++k) members[clusters_[i].path.arms[k]] = {i, k};
    for (const auto& [numbers, proof] : proofs_) {
      const Member a = members.at(numbers.first), b = members.at(numbers.second);
      add_pair_proof(problem_.judges, proof, part_of(a), clusters_[a.cluster].certificates[a.index], part_of(b),
                     clusters_[b.cluster].certificates[b.index]);
    }
  }

  std::vector<Trajectory> in_time(const JointPath& path, double deviation) {
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
  bool is_motion_free(const JointPath& path, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    Eigen::Index first = 0;
    std::vector<Eigen::VectorXd> from, to;
    for (const RowMatrix& q : path.positions) {
      from.emplace_back(a.segment(first, q.cols()));
      to.emplace_back(b.segment(first, q.cols()));
      first += q.cols();
    }
    for (std::size_t i = 0; i < path.arms.size(); ++i)
      if (!world_.is_free_for_one(path.arms[i], from[i]) || !world_.is_free_for_one(path.arms[i], from[i], to[i]))
        return false;
    for (std::size_t i = 0; i < path.arms.size(); ++i)
      for (std::size_t j = i + 1; j < path.arms.size(); ++j)
        if (!world_.are_collision_free(path.arms[i], from[i], to[i], path.arms[j], from[j], to[j])) return false;
    return true;
  }

  /// What each arm does.
  std::vector<Trajectory> parts(const Trajectory& all, const JointPath& path) const {
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
    for (const auto& [robot, trajectory] : result.robots) statistics_.flow_time_s += arrival_time(trajectory);
  }

  const std::string& name(std::size_t i) const { return problem_.moving[i].robot; }

  const MultiRobotProblem& problem_;
  const CommonOptions& common_;
  MultiRobotWorld& world_;
  const std::vector<JointPath>& raw_;
  ParallelWork& work_;
  const Deadline& deadline_;
  PlanStatistics& statistics_;
  std::vector<Cluster> clusters_;
  std::map<std::pair<std::size_t, std::size_t>, MotionProof> proofs_;  // of arms of different clusters, by number
};

}  // namespace

MultiTrajectory coupled_post_process(const MultiRobotProblem& problem, MultiRobotWorld& world,
                                     const std::vector<JointPath>& raw, const std::vector<JointPath>& shortened,
                                     const PathsKnown& paths_known, ParallelWork& work, const Deadline& deadline,
                                     PlanStatistics& statistics) {
  return CoupledPostProcess(problem, world, raw, shortened, work, deadline, statistics).run(paths_known);
}

}  // namespace srmp
