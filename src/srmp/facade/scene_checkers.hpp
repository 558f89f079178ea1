#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "srmp/facade/robot_preparation.hpp"
#include "srmp/planning/group_checkers.hpp"

namespace srmp {

/// Checkers of a scene as it is now, each made when it is first needed. The library's own follow the scene where only
/// objects change that no robot holds, and where the robots stand that they plan; others are made again. What they know
/// of robots (sphere covers, tables of pairs of links) stays. Not thread-safe.
class SceneCheckers {
 public:
  SceneCheckers();

  /// Of one robot. Throws InvalidArgument with the nearest name when there is none of that name. The reference is good
  /// until the scene changes.
  const Checker& of(const Scene& scene, const std::string& robot, CheckMode mode);
  /// With the covers and tables known here, for a checker that its user keeps.
  CheckerOptions options(CheckMode mode) const {
    return {.mode = mode, .covers = covers_, .pair_tables = pair_tables_, .batch_robots = batch_robots_};
  }

  /// Of one robot that moves while the others stand as in `scene`, whose state this must be, and that keeps a clearance
  /// [m]; of clearances above 0, the last one's are kept. Throws as `of`.
  std::shared_ptr<const ProblemCheckers> of_one(const Scene& scene, const std::string& robot, double clearance = 0.0);
  /// Of robots that move together while the others stand as in `placed`, which differs from `scene` in nothing else,
  /// and that keep a clearance [m]; the last ones are kept. Throws PlanningError once the deadline has passed before
  /// all are made.
  std::shared_ptr<const ProblemCheckers> of(const Scene& scene, const Scene& placed,
                                            const std::vector<std::string>& robots, double clearance,
                                            std::size_t threads, const Deadline& deadline);

  /// Has the scene's robots prepared in the background, and makes checkers again that this makes faster. Takes
  /// milliseconds for a robot seen for the first time, nothing otherwise.
  void prepare_in_background(const Scene& scene);
  /// Prepares them now. What `progress` throws ends it and passes through.
  void prepare(const Scene& scene, const StepProgress& progress);
  /// Makes the checkers that plan, from now on; those that verify are always the library's own.
  void set_backend(CheckerFactory backend);
  /// Whether that was done.
  bool has_other_backend() const { return static_cast<bool>(backend_); }
  /// The scene may have changed: what did is found when checkers are next needed.
  void scene_changed() { is_followed_ = false; }
  /// Forgets all checkers.
  void clear();

 private:
  void follow(const Scene& scene);
  void forget_unused();

  CheckerFactory backend_;  // the user's; none: the library's own
  std::shared_ptr<CoverStore> covers_;
  std::shared_ptr<PairTableStore> pair_tables_;
  std::shared_ptr<BatchRobotStore> batch_robots_;
  RobotPreparation preparation_;
  std::map<std::pair<std::string, CheckMode>, std::unique_ptr<SceneChecker>> alone_;
  std::map<std::pair<std::string, bool>, std::shared_ptr<ProblemCheckers>> single_;  // with a clearance or not
  std::shared_ptr<ProblemCheckers> together_;  // of the last robots that moved together
  std::vector<Eigen::VectorXd> others_;        // where the robots that stand still did for `together_`
  Scene seen_;                                 // the scene that the checkers are of
  bool is_followed_{};                         // it has not changed since
};

}  // namespace srmp
