#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "srmp/collision/batch/batch_world.hpp"
#include "srmp/collision/bodies.hpp"
#include "srmp/collision/checker.hpp"
#include "srmp/collision/pair_table.hpp"

// What a checker is made of, for the files of this directory.
namespace srmp {

struct Checker::Impl {
  Impl(const Scene& scene, const std::string& robot, const CheckerOptions& options);

  /// The pairs of bodies that an undecided pair of the batch speaks for.
  std::span<const std::uint32_t> pairs_of(const UndecidedPair& pair) const {
    return (pair.self ? batch_scene.self_pairs : batch_scene.obstacle_pairs)[static_cast<std::size_t>(pair.pair)];
  }

  /// The spheres' bounds hold for prismatic joints up to 1 m outside their limits (BatchActuatedJoint::max_travel).
  bool spheres_reach(ConstVector q) const {
    for (std::size_t i = 0; i < group.joints().size(); ++i) {
      const Joint& joint = group.joints()[i];
      const double value = q[static_cast<Eigen::Index>(i)];
      if (joint.kind == JointKind::prismatic && (value < joint.lower - 1.0 || value > joint.upper + 1.0)) return false;
    }
    return true;
  }

  bool has_tables() const {
    return std::any_of(tables.begin(), tables.end(), [](const auto& of_member) { return of_member != nullptr; });
  }

  template <class AtAxis>
  void for_each_axis(AtAxis&& at_axis) const;
  double travel(const ActuatedJoint& drive) const;

  detail::RobotGroup group;
  std::vector<std::shared_ptr<const PairTables>> tables;  // by member of the group
  detail::Bodies bodies;
  CheckMode mode;
  detail::BatchScene batch_scene;
  std::optional<BatchChecker> batch;
  BatchChecker::MotionOptions batch_options;
  std::vector<char> continuous;
};

/// The bodies at one configuration, and the scratch memory of the queries.
class Checker::Workspace {
 public:
  explicit Workspace(const Impl& impl);

  void place(ConstVector q);
  double gap(const detail::Pair& pair) const;
  double farthest(const detail::Pair& pair, double gap) const;
  bool table_proves(const detail::Pair& pair, double from, double to);
  double hull_distance(const detail::Pair& pair, double margin, double suffices);
  double distance(const detail::Pair& pair, double margin, double enough);
  bool in_contact(const detail::Pair& pair, bool ask_tables = true);
  bool is_free_here();
  template <class Visit>
  bool for_each_fixed_near(std::size_t body, double margin, Visit&& visit);

  // --- motions
  enum class Judgement { proved, contact, undecided };
  void start_motion(ConstVector a, ConstVector b);
  void place_on_motion(double t);
  double displacement(std::size_t body, std::uint64_t support, double half_width);
  bool is_still(const detail::Pair& pair) const { return ((pair.support_a | pair.support_b) & active_) == 0; }
  Judgement judge(const detail::Pair& pair, double half_width, int& cuts);
  bool first_sample();
  bool first_sample_of(std::size_t body);
  CollisionStatus ask_spheres();
  bool spheres_prove();
  void cut(double t, double half_width, std::uint32_t pair, int cuts);
  void sort_open();
  bool settle();
  bool take(std::uint32_t pair, double t, double half_width);
  bool is_motion_free(bool start_is_free, bool spheres_only);
  bool settle_by_coal();
  bool settle_lane(ConstVector q, std::span<const UndecidedPair> open);
  void judge_block(ConstRows q, std::span<bool> free, bool spheres_only);

  // --- any motion near a configuration
  void start_any_motion(std::uint64_t active);
  /// Places the bodies at q, from where joint j moves by `change[j]` at most.
  void place_in_range(ConstVector q, std::span<const double> change);
  /// How far the two bodies of the pair can get towards each other.
  double approach(const detail::Pair& pair, double half_width = 1.0);

  // --- reports
  const detail::Body& body_a(const detail::Pair& pair) const { return bodies_.moving[pair.a]; }
  const detail::Body& body_b(const detail::Pair& pair) const {
    if (pair.b_fixed) return bodies_.fixed[pair.b];
    return bodies_.moving[pair.b];
  }
  detail::Placed placed(bool fixed, std::size_t index) const;
  Contact contact(const detail::Body& a, const detail::Body& b, const detail::Proximity& found, double padding) const;

  const Impl& impl;
  CheckStatistics statistics;
  const Deadline* deadline{nullptr};  ///< of Checker::stop_at

 private:
  double ask(const detail::Pair& pair, const detail::Placed& a, const detail::Placed& b, double margin, double enough);
  double axis_reach(std::size_t body, std::size_t drive);
  void place_with_axes(ConstVector q);

  const detail::Bodies& bodies_;
  detail::RobotGroup::Data data_;
  detail::NarrowPhase narrow_;
  std::vector<Eigen::Isometry3d> poses_;  // of moving bodies
  std::vector<Eigen::Vector3d> centers_;  // of their bounding spheres
  Eigen::VectorXd start_, delta_, q_, here_;
  std::uint64_t active_{};                                         // drives that this motion moves
  std::vector<std::size_t> active_drives_;                         // deepest first
  std::vector<double> speed_;                                      // of each drive [rad or m over the whole motion]
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> axes_;  // of active drives, here
  std::vector<double> reach_;      // [body * drives + drive]: farthest point of the body from the drive's axis
  std::vector<char> reach_known_;  // of this body, here
  BatchChecker::WorkspacePtr batch_;
  bool start_is_free_{};  // pairs that the motion leaves alone need no look
  struct Interval {
    double t, half_width;
    std::uint32_t pair;
  };
  std::vector<Interval> open_, next_;
  Interval failed_{};                               // where the last motion could not be proved
  std::vector<std::pair<double, double>> span_of_;  // [pair] part of the motion that is open; empty between motions
};

}  // namespace srmp
