#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "srmp/collision/checker.hpp"
#include "srmp/collision/scene_checker.hpp"
#include "srmp/scene/scene_changes.hpp"

namespace srmp {

/// Checkers of robots that move together: of each robot alone in the scene, the others left out; and of each two that
/// can reach each other, by themselves. Where all of these say free, nothing collides.
class GroupCheckers {
 public:
  /// Robots of the scene that are not named stand still. `threads`: checkers that are made at the same time, by
  /// `backend`; none: the library's own. Throws PlanningError once the deadline has passed before all are made.
  GroupCheckers(const Scene& scene, std::vector<std::string> robots, const CheckerOptions& options,
                std::size_t threads = 1, const CheckerFactory& backend = {}, const Deadline& deadline = {});

  /// Another checker of the scene, by the same backend.
  std::unique_ptr<const Checker> make(const std::string& robot, const CheckerOptions& options) const;
  /// Only objects, and where robots stand that are planned here, have changed: all is as if made anew. Not with a
  /// backend of the user's.
  void follow(const Scene& scene, const SceneChanges& changes);

  const Scene& scene() const { return scene_; }
  const std::vector<std::string>& names() const { return names_; }
  std::size_t size() const { return names_.size(); }
  double clearance() const { return options_.clearance; }     ///< [m] CheckerOptions::clearance
  const CheckerFactory& backend() const { return backend_; }  ///< none: the library's own
  const Checker& alone(std::size_t i) const { return *alone_[i]; }
  /// i < j: collisions between i and j; a configuration is i's, then j's. Null: they cannot reach each other.
  const Checker* pair(std::size_t i, std::size_t j) const {
    const auto found = pairs_.find({i, j});
    return found == pairs_.end() ? nullptr : found->second.get();
  }
  /// The same for StateQuery::spheres_only, with quick covers, so that its results do not depend on which covers are
  /// known. Made when it is first needed.
  const Checker* pair_by_spheres(std::size_t i, std::size_t j) const;
  bool may_conflict(std::size_t i, std::size_t j) const { return pair(std::min(i, j), std::max(i, j)) != nullptr; }

 private:
  using Pairs = std::map<std::pair<std::size_t, std::size_t>, std::unique_ptr<const Checker>>;
  std::unique_ptr<const Checker> make_pair(std::size_t i, std::size_t j, CheckerOptions options) const;

  Scene scene_;
  std::vector<std::string> names_;
  const CheckerOptions options_;
  const CheckerFactory backend_;
  std::vector<std::shared_ptr<SceneChecker>> own_;  // those of alone_ that are the library's own
  std::vector<std::shared_ptr<const Checker>> alone_;
  Pairs pairs_;
  mutable std::mutex mutex_;  // of what follows
  mutable Pairs pairs_by_spheres_;
};

/// The checkers of one problem: those that plan, and those that verify what was planned, by Coal alone, which are made
/// when they are first needed. Threads share it.
class ProblemCheckers {
 public:
  ProblemCheckers(const Scene& scene, const std::vector<std::string>& robots, const CheckerOptions& options,
                  std::size_t threads = 1, const CheckerFactory& backend = {}, const Deadline& deadline = {})
      : options(options), planning(scene, robots, options, threads, backend, deadline), threads_(threads) {}

  /// As GroupCheckers::follow, of all of them.
  void follow(const Scene& scene, const SceneChanges& changes);

  const CheckerOptions options;  ///< of those that plan
  GroupCheckers planning;
  const GroupCheckers& verification() const;  ///< without CheckerOptions::clearance
  /// As those that verify, with the clearance of `options`.
  const GroupCheckers& clearance_verification() const;
  /// Of the first robot, as it plans, with another clearance [m]; made when it is first needed.
  const Checker& with_clearance(double clearance) const;

 private:
  using Made = std::unique_ptr<GroupCheckers>;
  Made made_by_coal(double clearance) const;

  const std::size_t threads_;
  mutable std::once_flag made_, clearance_made_;
  mutable Made verification_, clearance_verification_;
  mutable std::mutex mutex_;  // of what follows
  mutable std::map<double, std::unique_ptr<const Checker>> with_clearance_;
};

/// Configurations of two robots as their pair's checker has them, one below the other: rows of `robot` and as many of
/// `other`, whose joints stand first or last.
RowMatrix side_by_side(const RowMatrix& robot, const RowMatrix& other, bool other_first);

}  // namespace srmp
