#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "srmp/collision/displacements.hpp"
#include "srmp/collision/narrow_phase.hpp"
#include "srmp/collision/scene_model.hpp"

namespace srmp::detail {

struct ContactOptions {
  bool use_tables{true};  ///< may tables of pairs decide?
};

/// A lower bound of how far apart two bodies are, from volumes around them.
struct DistanceBound {
  double distance{};                  ///< [m]
  Eigen::Vector3d from_b;             ///< to a: between what the volumes are around, in the frame of `pose_b`
  double length{};                    ///< of from_b
  const Eigen::Isometry3d* pose_b{};  ///< null: the frame of all poses

  /// Where the distance is positive: a unit vector from b to a, the normal of planes that separate the two by that
  /// much.
  Eigen::Vector3d direction() const {
    if (pose_b) return pose_b->linear() * from_b / length;
    return from_b / length;
  }
};

/// A thread's scratch memory of a SceneChecker: the bodies at one configuration, and the checks that need them there.
/// Once warm, checks of configurations and motions allocate nothing.
///
/// prove_motion uses the public part for its distances and motion bounds; all that decides is_motion_free is private.
class SceneWorkspace final : public Checker::Workspace {
 public:
  explicit SceneWorkspace(const SceneModel& model);

  const SceneModel& model() const { return model_; }

  // --- one configuration

  /// Places the bodies at q: what follows is about them there.
  void place(ConstVector q);
  /// A lower bound of the pair's distance from bounding volumes; padding not counted. The moving bodies of the pair may
  /// be envelopes.
  DistanceBound bound(const Pair& pair);
  double distance_bound(const Pair& pair) { return bound(pair).distance; }
  /// The pair's distance is rarely more than this, given its distance_bound.
  double likely_max_distance(const Pair& pair, double bound) const;
  /// A lower bound of the pair's distance, padding not counted, from convex solids around the two; infinity when it
  /// exceeds `margin`. One that is more than `suffices` is not improved.
  double hull_distance(const Pair& pair, double margin, double suffices, Separation* separation = nullptr);
  /// The distance of the pair, padding not counted; infinity when it exceeds `margin`. May be the distance of any two
  /// of their primitives that is at most `enough`.
  double distance(const Pair& pair, double margin, double enough);
  /// Planes that separate a pair of solids that are no farther apart than `margin`.
  Separation separate(const Pair& pair, double margin);
  /// Are the two in contact, padding counted? By Coal; hulls and tables decide most pairs.
  bool in_contact(const Pair& pair, const ContactOptions& options = {});
  bool is_free_here();

  const Body& body_a(const Pair& pair) const { return bodies_.moving[pair.a]; }
  const Body& body_b(const Pair& pair) const { return bodies_.body(pair.b_fixed, pair.b); }
  Placed placed(bool fixed, std::size_t index);
  Contact contact(const Body& a, const Body& b, const Proximity& found, double padding) const;
  /// The deepest one of a pair that is in contact. Allocates.
  Contact contact(const Pair& pair);

  // --- any motion near a configuration, for prove_motion

  /// The actuated joints of `active` may move.
  void start_any_motion(std::uint64_t active);
  /// Places the bodies at q, from where joint j moves by `change[j]` at most: by s * linear[j] for an s in [-1, 1] that
  /// is the same for all joints, and by `rest[j]` at most besides.
  void place_in_range(ConstVector q, std::span<const double> change, std::span<const double> linear,
                      std::span<const double> rest);
  /// By how far the body can move while the actuated joints of `support` move through `half_width` of the motion around
  /// here; with a unit vector, along it.
  double displacement(std::size_t body, std::uint64_t support, double half_width = 1.0,
                      const Eigen::Vector3d* direction = nullptr);
  /// By how much the two bodies of the pair can approach each other within `half_width` of the motion around here; with
  /// a unit vector, along it.
  double approach(const Pair& pair, double half_width = 1.0, const Eigen::Vector3d* direction = nullptr);
  /// The same of the bounding spheres of the two, and so how much their bound() can lose.
  double approach_of_spheres(const Pair& pair, double half_width = 1.0, const Eigen::Vector3d* direction = nullptr);
  double displacement_of_sphere(std::size_t body, std::uint64_t support, double half_width = 1.0,
                                const Eigen::Vector3d* direction = nullptr);
  // The same two for the bounding spheres of bodies of envelopes, from where those are and how they move: looser, and
  // in a fraction of the time.
  DistanceBound bound_in_envelopes(const Pair& pair);
  double displacement_in_envelope(std::size_t body, std::uint64_t support, const Eigen::Vector3d* direction = nullptr);
  /// The clearance that the pair keeps within `half_width` of the motion around here, by planes that separate the two;
  /// negative where that proves nothing. One that is more than `enough` is not improved.
  double free_gap(const Pair& pair, const Separation& separation, double enough, double half_width = 1.0);

  // --- straight motions and blocks, for SceneChecker

  void start_motion(ConstVector a, ConstVector b);
  /// Of the motion started last.
  bool is_motion_free(const MotionQuery& query);
  /// Checks up to 16 configurations, the rows of q.
  void check_block(ConstRows q, std::span<bool> free, const StateQuery& query);
  /// Of such a block: which configurations collide where spheres within bodies stopped the last motions?
  void find_colliding(ConstRows q, std::span<bool> colliding);

 private:
  /// Primitives of a pair, in candidates_, that alone may come into contact in a part of the motion; none: all may.
  struct Candidates {
    std::uint32_t first{}, count{};
  };
  /// A part of the motion around t, over which a pair is still to be checked.
  struct Interval {
    double t, half_width;
    std::uint32_t pair;
    bool is_part{};     // of another interval, which was undecided
    double distance{};  // about that of the pair in the middle of that one
    double offset{};    // |t - t of that one|
    Candidates candidates{};
  };
  struct Undecided {
    int parts{};        // into which an interval is to be subdivided; 0: into none
    double distance{};  // about that of the pair
    Candidates candidates{};
  };
  struct ClosePair {
    std::uint32_t number;
    double t;  // where it was found close
  };

  /// A body's bounding sphere, as its envelope carries it.
  struct Carried {
    std::uint64_t number{};  // as Place::number
    Eigen::Vector3d offset;  // of its centre, from the envelope's
    Eigen::Vector3d center;
  };

  const Place& place_of(std::size_t body);
  const Carried& carried(std::size_t body);
  DistanceBound bound(const Pair& pair, const Eigen::Vector3d& center, const Eigen::Vector3d& center_b) const;
  /// The pair's solids, or convex solids around the two where there are.
  std::pair<Placed, Placed> solids_of(const Pair& pair);
  double query_distance(const Pair& pair, const Placed& a, const Placed& b, double margin, double enough,
                        Separation* separation = nullptr);
  void place_with_axes(ConstVector q);
  void place_on_motion(double t);
  /// Does the motion leave the two where they are relative to each other?
  bool is_still(const Pair& pair) const { return (pair.support() & displacements_.active()) == 0; }
  template <class Visit>
  bool for_each_fixed_near(std::size_t body, double margin, Visit&& visit);

  bool is_of_one_point(const Pair& pair) const;
  bool table_proves(const Pair& pair, double from, double to);
  double distance_left(const Interval& interval, PrimitiveQuery query);
  double distance_of_part(const Interval& part, const PrimitiveQuery& query, Candidates& left);
  CollisionStatus check_pair(const Interval& interval, Undecided& undecided);
  bool process(const Interval& interval);
  void subdivide(const Interval& whole, const Undecided& undecided);
  bool process_whole_motion();
  bool process_whole_motion_of(std::size_t body);
  void sort_open();
  bool resolve_open();
  bool is_end_free();
  bool resolve_intervals();
  bool resolve_close();
  bool resolve_nearest_first(std::optional<double> first = std::nullopt);
  void place_sample(double t);
  bool resolve_with_coal();
  CollisionStatus check_with_spheres();
  void find_open_deferred();
  void open_undecided();
  bool prove_with_spheres();
  bool resolve_lane(ConstVector q, std::span<const UndecidedPair> open);

  const SceneModel& model_;
  const Bodies& bodies_;
  RobotGroup::Data data_;
  NarrowPhase narrow_;
  std::vector<Place> places_;     // of moving bodies and envelopes
  std::vector<Carried> carried_;  // of moving bodies
  std::uint64_t placements_{1};   // the number of the current one
  Eigen::VectorXd start_, delta_, q_, here_;
  Displacements displacements_;
  BatchChecker::WorkspacePtr batch_;
  bool start_is_free_{};          // pairs that the motion does not move need no check
  double reserve_{};              // farther than this must a pair stay apart to be proved free
  std::vector<ClosePair> close_;  // pairs that this motion's intervals proved neither free nor in contact
  std::vector<Interval> open_, next_;
  std::vector<int> open_deferred_;  // pairs of the batch that tables left open, of the last motion that asked them
  std::vector<PrimitivePair> candidates_, new_candidates_;
  int samples_{};                                   // placed, for looks at the deadline
  std::vector<std::pair<double, double>> span_of_;  // [pair] part of the motion that is open; empty between motions
};

}  // namespace srmp::detail
