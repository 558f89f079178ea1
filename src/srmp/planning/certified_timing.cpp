#include "srmp/planning/certified_timing.hpp"

#include <algorithm>
#include <atomic>
#include <map>
#include <optional>

#include "srmp/core/interruption.hpp"
#include "srmp/core/stopping.hpp"
#include "srmp/planning/certificates/joint_certificates.hpp"
#include "srmp/planning/endpoints/close_motions.hpp"
#include "srmp/planning/obstacles/timed_motion.hpp"
#include "srmp/planning/phase_timer.hpp"
#include "srmp/planning/smoothing/joint_shortcut.hpp"
#include "srmp/planning/smoothing/preferred_clearance.hpp"
#include "srmp/trajectory/even_rows.hpp"
#include "srmp/trajectory/prove_clearance.hpp"
#include "srmp/trajectory/prove_constraints.hpp"
#include "srmp/trajectory/timing.hpp"

namespace srmp {

namespace {

const CertifiedTimingOptions tuning;

class CertifiedTiming {
 public:
  CertifiedTiming(const PlanProblem& problem, JointPaths paths, std::size_t recovery_segments, ParallelWork& work,
                  const Deadline& deadline, PlanStatistics& statistics)
      : problem_(problem),
        common_(common_options(problem.options)),
        raw_(std::move(paths.raw)),
        world_(std::move(paths.world)),
        lower_(paths.lower),
        recovery_segments_(recovery_segments),
        work_(work),
        deadline_(deadline),
        until_(with_grace_period(deadline)),
        preferred_(problem.checkers, common_, until_),
        statistics_(statistics) {
    for (JointPath& path : paths.smoothed) groups_.push_back({std::move(path)});
    if (world_) world_->stop_at(until_);
    for (const RobotProblem& robot : problem.robots) constrained_ |= robot.constraints != nullptr;
    if (!world_ && constrained_) constraints_.emplace(*problem.robots.front().constraints);
    if (paths.close_ends) close_.emplace(problem.checkers, until_);
  }

  MultiTrajectory run() {
    // Groups that are timed apart must be proved to stay clear of each other.
    if (common_.timing == "none" || !common_.certify) merge_all_groups();
    do {
      work_.run(groups_.size(), until_, [&](std::size_t k, const Deadline& deadline, PlanStatistics& statistics) {
        if (groups_[k].deviation < 0.0) time_and_certify(groups_[k], deadline, statistics);
      });
    } while (common_.certify && !all_proved_clear());
    add_proofs();
    if (merged_) record_merged_costs();
    MultiTrajectory result;
    for (Group& group : groups_)
      for (std::size_t i = 0; i < group.path.robots.size(); ++i) {
        Trajectory& trajectory = group.trajectories[i];
        if (common_.certify && common_.sample_rate > 0.0) require_valid(group.certificates[i]);
        if (common_.certify)
          attach_certificate(trajectory, std::move(group.certificates[i]), name(group.path.robots[i]), statistics_);
        result.robots.emplace(name(group.path.robots[i]), std::move(trajectory));
      }
    set_times(result);
    return result;
  }

 private:
  /// Robots that are timed together.
  struct Group {
    JointPath path;
    double deviation{-1.0};  // at the corners; below 0: not timed yet
    std::vector<Trajectory> trajectories{};
    std::vector<Certificate> certificates{};
  };

  /// Even rows leave the path a little at stops, where they may touch what it does not.
  void require_valid(const Certificate& certificate) const {
    if (certificate.holds()) return;
    throw PlanningError(Status::exhausted, "the motion with a sample_rate of " + to_text(common_.sample_rate) +
                                               " Hz is not valid (" + certificate.faults.front().text +
                                               "); use another rate, or 0");
  }

  void merge_groups(std::size_t i, std::size_t j) {
    groups_[i] = shortened_together(groups_[i].path, groups_[j].path);
    groups_.erase(groups_.begin() + static_cast<std::ptrdiff_t>(j));
    merged_ = true;
    std::erase_if(proofs_, [&](const auto& known) {
      const std::vector<std::size_t>& robots = groups_[i].path.robots;
      return std::binary_search(robots.begin(), robots.end(), known.first.first) ||
             std::binary_search(robots.begin(), robots.end(), known.first.second);
    });
  }

  /// From the paths that were found for both, which do not collide.
  Group shortened_together(const JointPath& a, const JointPath& b) {
    std::vector<const JointPath*> found;
    for (const JointPath& path : raw_)
      for (const JointPath* part : {&a, &b})
        if (std::binary_search(part->robots.begin(), part->robots.end(), path.robots.front())) found.push_back(&path);
    const PhaseTimer timer(deadline_, statistics_.shortcut_time_s);
    const JointPath raw = side_by_side(found);
    return {common_.shortcut ? shortened(raw, *world_, deadline_) : raw};
  }

  /// On one clock. Groups whose shortened paths collide on it are shortened together.
  void merge_all_groups() {
    if (groups_.size() == 1) return;
    std::vector<Group> clear;  // of each other
    while (!groups_.empty()) {
      Group next = std::move(groups_.back());
      groups_.pop_back();
      const auto other = std::find_if(clear.begin(), clear.end(),
                                      [&](const Group& group) { return in_conflict(*world_, group.path, next.path); });
      if (other == clear.end()) {
        clear.push_back(std::move(next));
      } else {
        groups_.push_back(shortened_together(other->path, next.path));
        clear.erase(other);
      }
    }
    std::vector<const JointPath*> paths;
    for (const Group& group : clear) paths.push_back(&group.path);
    groups_.push_back({side_by_side(paths)});
    proofs_.clear();
    merged_ = true;
  }

  /// Corners that cannot be proved free shrink.
  void time_and_certify(Group& group, const Deadline& until, PlanStatistics& statistics) {
    for (double deviation = common_.blend_deviation;; deviation *= tuning.shrink) {
      if (deviation < tuning.min_deviation) deviation = 0.0;
      group.deviation = deviation;
      try {
        const PhaseTimer timer(until, statistics.timing_time_s);
        group.trajectories = in_time(group.path, deviation, until);
      } catch (const PlanningError& error) {
        if (group.certificates.empty() || error.status() != Status::timed_out) throw;
        return;  // what is timed already is kept, though not proved
      } catch (const InvalidArgument&) {
        // A rounded corner may need a speed to which the robot cannot brake from that of its start.
        if (deviation == 0.0 || !problem_.robots.front().start_in_motion) throw;
        continue;
      }
      if (!common_.certify && !constrained_) return;
      {
        const PhaseTimer timer(until, statistics.verification_time_s);
        group.certificates = joint_certificates(checkers(), with_clearance(), motions_of(group), common_, until);
      }
      const auto is_proved = [](const Certificate& c) {
        return c.proved_free() && keeps_constraints(c) && keeps_clearance(c);
      };
      const bool proved = std::all_of(group.certificates.begin(), group.certificates.end(), is_proved);
      if (deviation == 0.0 || common_.timing != "toppra" || proved || until.stop_requested()) return;
    }
  }

  const GroupCheckers& checkers() const { return problem_.checkers.verification(); }
  const GroupCheckers* with_clearance() const {
    return common_.clearance > 0.0 ? &problem_.checkers.clearance_verification() : nullptr;
  }
  const GroupCheckers& pair_checkers() const { return with_clearance() ? *with_clearance() : checkers(); }

  RobotMotion motion_of(const Group& group, std::size_t i) const {
    const std::size_t robot = group.path.robots[i];
    return {robot, &problem_.robots[robot], group.trajectories[i], recovery_segments_};
  }
  std::vector<RobotMotion> motions_of(const Group& group) const {
    std::vector<RobotMotion> motions;
    for (std::size_t i = 0; i < group.path.robots.size(); ++i) motions.push_back(motion_of(group, i));
    return motions;
  }

  /// A robot of a group.
  struct Member {
    std::size_t group, index;
  };
  struct MemberPair {
    Member a, b;  // a's number is the smaller one
  };

  /// Robots of different groups that can reach each other and are not proved to stay clear of each other yet.
  std::vector<MemberPair> open_pairs() const {
    std::vector<MemberPair> open;
    for (std::size_t i = 0; i < groups_.size(); ++i)
      for (std::size_t j = i + 1; j < groups_.size(); ++j)
        for (std::size_t k = 0; k < groups_[i].path.robots.size(); ++k)
          for (std::size_t l = 0; l < groups_[j].path.robots.size(); ++l) {
            MemberPair pair{{i, k}, {j, l}};
            if (number(pair.a) > number(pair.b)) std::swap(pair.a, pair.b);
            if (pair_checkers().may_conflict(number(pair.a), number(pair.b)) &&
                !proofs_.contains({number(pair.a), number(pair.b)}))
              open.push_back(pair);
          }
    return open;
  }
  std::size_t number(const Member& robot) const { return groups_[robot.group].path.robots[robot.index]; }
  RobotMotion motion_of(const Member& robot) const { return motion_of(groups_[robot.group], robot.index); }

  /// Proves that robots of different groups stay clear of each other; false: the groups of the first two of which that
  /// cannot be proved have become one, or all groups, where no time is left to prove more.
  bool all_proved_clear() {
    const std::vector<MemberPair> open = open_pairs();
    std::vector<MotionProof> found(open.size());
    std::atomic<std::size_t> first{open.size()};  // that is not proved
    work_.run(open.size(), until_, [&](std::size_t k, const Deadline& deadline, PlanStatistics& statistics) {
      if (k > first) return;
      const PhaseTimer timer(deadline, statistics.verification_time_s);
      found[k] = *prove_pair(pair_checkers(), motion_of(open[k].a), motion_of(open[k].b), deadline);
      if (found[k].free && found[k].unproved.empty()) return;
      for (std::size_t known = first; k < known && !first.compare_exchange_weak(known, k);) {
      }
    });
    for (std::size_t k = 0; k < first; ++k)
      proofs_.emplace(std::pair(number(open[k].a), number(open[k].b)), std::move(found[k]));
    if (first == open.size()) return true;
    if (until_.stop_requested()) {
      merge_all_groups();
    } else {
      const auto [i, j] = std::minmax(open[first].a.group, open[first].b.group);
      merge_groups(i, j);
    }
    return false;
  }

  void add_proofs() {
    std::map<std::size_t, Member> members;
    for (std::size_t i = 0; i < groups_.size(); ++i)
      for (std::size_t k = 0; k < groups_[i].path.robots.size(); ++k) members[groups_[i].path.robots[k]] = {i, k};
    for (const auto& [numbers, proof] : proofs_) {
      const Member a = members.at(numbers.first), b = members.at(numbers.second);
      add_pair_proof(pair_checkers(), proof, motion_of(a), groups_[a.group].certificates[a.index], motion_of(b),
                     groups_[b.group].certificates[b.index]);
    }
  }

  std::vector<Trajectory> in_time(const JointPath& path, double deviation, const Deadline& until) {
    std::vector<std::string> names;
    MotionLimits limits;
    RobotBounds bounds;
    Eigen::VectorXd reach;
    const bool timed = common_.timing != "none";
    for (const std::size_t i : path.robots) {
      const MotionLimits own = scaled(problem_.robots[i].limits, common_);
      bounds.add(*problem_.robots[i].placed, own, names.size());
      for (const std::string& joint : model(i).joint_names()) names.push_back(world_ ? name(i) + "/" + joint : joint);
      append(limits.velocity, own.velocity);
      append(limits.acceleration, own.acceleration);
      append(limits.jerk, own.jerk);
      if (timed) append(reach, checker(i).reach());
      limits.continuous.insert(limits.continuous.end(), own.continuous.begin(), own.continuous.end());
    }
    RowMatrix waypoints(static_cast<Eigen::Index>(path.size()), limits.velocity.size());
    Eigen::Index first = 0;
    for (const RowMatrix& q : path.positions) {
      waypoints.middleCols(first, q.cols()) = q;
      first += q.cols();
    }
    if (!timed) {
      const RowMatrix none(0, waypoints.cols());
      return parts({names, waypoints, none, none, {}, waypoints}, path);
    }
    TimingOptions options = timing_options(common_, deviation);
    options.reach = reach;
    if (const auto& begin = problem_.robots.front().start_in_motion) {
      options.start_velocity = begin->velocity;
      options.start_acceleration = begin->acceleration;
      limits.velocity = limits.velocity.cwiseMax(begin->velocity.cwiseAbs());  // it may miss them by 1e-6
    }
    options.deadline = &until;
    options.is_free = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return is_motion_free(path, a, b); };
    const InterruptionScope stoppable([&until] { stop_if_late(until, "the path was timed"); });
    try {
      const Trajectory motion = detail::time_parameterize(waypoints, names, limits, options, bounds);
      if (common_.sample_rate == 0.0) return parts(motion, path);
      return parts(with_even_rows(motion, common_.sample_rate, limits, bounds, options), path);
    } catch (const Overload& why) {
      throw PlanningError(Status::exhausted,
                          "no timing of the path that was found keeps the torque limits: " + std::string(why.what()));
    } catch (const MotionCheckStopped&) {
      throw PlanningError(Status::timed_out, "the time limit of " + to_text(common_.time_limit) +
                                                 " s passed while corners of the path were rounded");
    }
  }

  static void append(Eigen::VectorXd& to, const Eigen::VectorXd& more) {
    to.conservativeResize(to.size() + more.size());
    to.tail(more.size()) = more;
  }

  /// The straight motion of all robots of a path.
  bool is_motion_free(const JointPath& path, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    if (constraints_ && !constraints_->keeps(a, b, 1.0)) return false;
    if (close_)
      if (const auto corner = close_corner(path, a, b))
        return is_near_start(path, *corner) ? close_->withdraws(a, b) : close_->withdraws(b, a);
    if (!world_) return is_motion_of_one_free(a, b) && keeps_preferred_clearance(path, a, b);
    rare_interruption_point();
    if (deadline_.expired()) return false;  // too late to check the motions of several robots: corners are stops
    Eigen::Index first = 0;
    std::vector<Eigen::VectorXd> from, to;
    for (const RowMatrix& q : path.positions) {
      from.emplace_back(a.segment(first, q.cols()));
      to.emplace_back(b.segment(first, q.cols()));
      first += q.cols();
    }
    for (std::size_t i = 0; i < path.robots.size(); ++i)
      if (!world_->is_free_for_one(path.robots[i], from[i]) ||
          !world_->is_free_for_one(path.robots[i], from[i], to[i], 1.0))
        return false;
    for (std::size_t i = 0; i < path.robots.size(); ++i) {
      rare_interruption_point();
      for (std::size_t j = i + 1; j < path.robots.size(); ++j)
        if (!world_->are_collision_free(path.robots[i], from[i], to[i], path.robots[j], from[j], to[j])) return false;
    }
    return true;
  }

  /// The corner of one robot's path that a motion is beside, if it does not keep the clearance.
  std::optional<Eigen::Index> close_corner(const JointPath& path, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    const RowMatrix& waypoints = path.positions.front();
    if (waypoints.rows() <= 2) return std::nullopt;
    const Eigen::Index corner = corner_near(waypoints, a, b);
    return close_->is_clear(waypoints.row(corner).transpose()) ? std::nullopt : std::optional(corner);
  }

  /// Has no waypoint before such a corner the clearance? Otherwise the corner is near the goal.
  bool is_near_start(const JointPath& path, Eigen::Index corner) {
    for (Eigen::Index i = corner - 1; i >= 0; --i)
      if (close_->is_clear(path.positions.front().row(i).transpose())) return false;
    return true;
  }

  bool is_motion_of_one_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    if (!workspace_) checker(0).stop_at(until_, *(workspace_ = checker(0).make_workspace()));
    return checker(0).is_motion_free(a, b, *workspace_);
  }

  /// The waypoint between others that is nearest to a motion beside it; at least three.
  static Eigen::Index corner_near(const RowMatrix& waypoints, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    Eigen::Index corner{};
    (waypoints.rowwise() - 0.5 * (a + b).transpose()).rowwise().squaredNorm().minCoeff(&corner);
    return std::clamp<Eigen::Index>(corner, 1, waypoints.rows() - 2);
  }

  /// Does a motion beside a corner of one robot's path keep what is preferred of the clearance of the two halves of
  /// segments that meet there? The corner is the waypoint that is nearest.
  bool keeps_preferred_clearance(const JointPath& path, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    const RowMatrix& waypoints = path.positions.front();
    if (preferred_.size() == 0 || waypoints.rows() < 3) return true;
    const Eigen::Index corner = corner_near(waypoints, a, b);
    const auto [known, is_new] = corner_levels_.try_emplace(corner, preferred_.size());
    if (is_new) {
      const auto level_to = [&](Eigen::Index other) {
        return preferred_.level_of(waypoints.row(corner).transpose(),
                                   0.5 * (waypoints.row(corner) + waypoints.row(other)).transpose());
      };
      known->second = std::max(level_to(corner - 1), level_to(corner + 1));
    }
    return known->second == preferred_.size() || preferred_.keeps(known->second, a, b);
  }

  /// The motion of each robot.
  std::vector<Trajectory> parts(const Trajectory& all, const JointPath& path) const {
    std::vector<Trajectory> result;
    Eigen::Index first = 0;
    for (std::size_t i = 0; i < path.robots.size(); ++i) {
      const Eigen::Index columns = path.positions[i].cols();
      const auto part = [&](const RowMatrix& of) -> RowMatrix { return of.middleCols(first, columns); };
      Trajectory one{model(path.robots[i]).joint_names(),
                     part(all.positions),
                     part(all.velocities),
                     part(all.accelerations),
                     all.times,
                     part(all.waypoints)};
      one.robot = problem_.robots[path.robots[i]].placed;
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

  const std::string& name(std::size_t i) const { return problem_.robots[i].robot; }
  const Checker& checker(std::size_t i) const { return problem_.checkers.planning.alone(i); }
  const RobotModel& model(std::size_t i) const { return checker(i).robot(); }

  void record_merged_costs() {
    std::vector<JointPath> paths;
    for (const Group& group : groups_) paths.push_back(group.path);
    record_costs(problem_, paths, lower_, deadline_, statistics_);
  }

  const PlanProblem& problem_;
  const CommonOptions& common_;
  const std::vector<JointPath> raw_;
  const std::unique_ptr<MultiRobotWorld> world_;  // null: one robot
  const double lower_;
  const std::size_t recovery_segments_;
  ParallelWork& work_;
  const Deadline& deadline_;
  const Deadline until_;
  PreferredClearance preferred_;  // of one robot
  PlanStatistics& statistics_;
  Checker::WorkspacePtr workspace_;                    // of one robot, made when it is first needed
  std::optional<ConstraintChecker> constraints_;       // of one robot
  std::optional<CloseMotions> close_;                  // of JointPaths::close_ends
  bool constrained_{};                                 // has any robot path constraints?
  std::map<Eigen::Index, std::size_t> corner_levels_;  // of preferred clearance, by waypoint of one robot
  std::vector<Group> groups_;
  bool merged_{false};
  std::map<std::pair<std::size_t, std::size_t>, MotionProof> proofs_;  // of robots of different groups, by index
};

}  // namespace

MultiTrajectory certified_timing(const PlanProblem& problem, JointPaths paths, std::size_t recovery_segments,
                                 ParallelWork& work, const Deadline& deadline, PlanStatistics& statistics) {
  return CertifiedTiming(problem, std::move(paths), recovery_segments, work, deadline, statistics).run();
}

Deadline with_grace_period(const Deadline& deadline) { return deadline.extended(tuning.grace_period); }

TimingOptions timing_options(const CommonOptions& options, double deviation) {
  return {.method = options.timing == "ruckig" ? TimingMethod::ruckig : TimingMethod::toppra,
          .sample_period = options.sample_period,
          .max_rows = tuning.max_rows,
          .blend_deviation = deviation};
}

}  // namespace srmp
