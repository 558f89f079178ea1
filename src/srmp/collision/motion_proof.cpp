#include "srmp/collision/motion_proof.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "srmp/collision/cubic_segments.hpp"
#include "srmp/collision/pair_groups.hpp"
#include "srmp/collision/scene_workspace.hpp"
#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"

namespace srmp {

using detail::CubicSegments;
using detail::DistanceBound;
using detail::infinity;
using detail::NarrowPhase;
using detail::Pair;
using detail::PairGroups;
using detail::SceneModel;
using detail::SceneWorkspace;
using detail::Separation;

namespace {

constexpr double rough_distance =
    0.3;                           // of an interval's motion: smaller distances are not refined, it is halved anyway
constexpr double much_less = 0.9;  // times a distance of meshes
constexpr double likely_gain =
    0.1;  // of an interval's motion: by so much its parts may be farther apart in the middle than it is
constexpr double finest_motion = Checker::motion_floor / 4.0;  // [m]; shorter intervals are left unproved
constexpr int max_levels = 3;                                  // of halving at once
/// A group that moves by less than this multiple of the room between its envelopes is halved; others are taken apart.
constexpr double longest_group_motion = 3.0;
constexpr double likely_looseness = 0.1;  // of what two envelopes measure across
constexpr int max_samples = 200'000;      // configurations: the proof of an endless motion ends too
constexpr int max_sharpening = 256;       // checks of each pass that raises the proved clearance
constexpr unsigned visits_per_look = 8;   // of intervals, between two looks at the clock
constexpr double largest = 1e100;         // [rad or m] beyond it, squares overflow

/// Branch and bound over the time of one motion: first until the motion is proved free, by the clearance that is to be
/// known where that takes few more checks; then, where least is proved, until it is known well enough.
class Prover {
 public:
  Prover(const SceneModel& model, const CubicMotion& motion, SceneWorkspace& workspace, const ProofOptions& options)
      : model_(model),
        motion_(motion),
        groups_(model.pair_groups()),
        segments_(motion),
        workspace_(workspace),
        fraction_(1.0 - options.gap_tolerance),
        deadline_(options.deadline),
        range_(motion.positions.cols()) {
    displacements_.resize(model.bodies.moving.size());
    sphere_displacements_.resize(model.bodies.moving.size() + model.bodies.envelopes.size());
    in_envelopes_.resize(model.bodies.moving.size());
    open_.reserve(4 * groups_.size());
  }

  MotionProof run();

 private:
  using Interval = CubicSegments::Interval;

  struct Open {
    std::uint32_t pair;  // or a group: a number of groups_
    int levels;          // of halving before it is worth another check
    double bound{-1.0};  // a clearance that the pair is proved to keep, less than the goal; below 0: none
  };
  /// A pair that is proved to keep a clearance of `bound` over an interval.
  struct Proved {
    double bound;
    Interval interval;
    std::uint32_t pair;
    bool measured;  // by its distance in the middle: only halves can improve the bound
    bool operator<(const Proved& other) const { return bound > other.bound; }  // in a heap, the least on top
  };
  /// What the distance of a pair in the middle of an interval says of all of it.
  struct Check {
    CollisionStatus status;
    double bound{};  // free: a clearance that the pair keeps over the interval
    bool measured{true};
    double room{};  // undecided: shorter intervals are proved free where their motion is no more than this
  };

  /// How far the actuated joints of `support` can move a body.
  struct Displacement {
    int sample{};
    std::uint64_t support{};
    double motion{};
  };

  bool stopped() { return late_ = late_ || (deadline_ && deadline_->stop_requested()); }
  /// Looks at the clock after 64 checks of solids, or 8 of meshes: that takes longer than a check by bounds.
  bool seldom_stopped(const Pair& pair) {
    checks_ += pair.solid ? 1 : 8;
    if (checks_ < 64) return false;
    checks_ = 0;
    return stopped();
  }
  void place_at(const Interval& interval);
  void find_nearest_at(Eigen::Index row);
  void note_if_nearer(const Pair& pair);
  bool prove(const Interval& interval, std::size_t first, std::size_t count);
  bool prove_halves(const Interval& interval, std::size_t first, std::size_t count);
  bool prove_group(const Open& open, const Interval& interval);
  bool prove_member(std::uint32_t member, const Interval& interval);
  bool prove_pair(Open open, const Interval& interval);
  void close(const Open& open, const Interval& interval, bool measured);
  bool sharpen();
  double bound_left(const Pair& pair, double motion, const DistanceBound& bound, double required);
  Check check(const Pair& pair, double sphere_approach, double required);
  Check measure(const Pair& pair, double motion, double required);
  static int levels_for(double room, double motion) {
    int levels = 0;
    for (double part = motion / 2.0; levels < max_levels && part >= room; part /= 2.0) ++levels;
    return levels;
  }
  double approach(const Pair& pair);
  template <class Compute>
  double remembered(Displacement& known, std::uint64_t support, Compute&& compute);
  double displacement(std::uint32_t body, std::uint64_t support);
  double approach_of_spheres(const Pair& pair);
  double displacement_of_sphere(std::uint32_t body, std::uint64_t support);
  double displacement_in_envelope(std::uint32_t body, std::uint64_t support);
  Separation& separation_of(const Pair& pair) {
    if (separations_.empty()) separations_.resize(model_.bodies.pairs.size());
    return separations_[static_cast<std::size_t>(&pair - model_.bodies.pairs.data())];
  }
  /// The clearance that is to be proved of every pair.
  double goal() const { return fraction_ > 0.0 ? fraction_ * clearance_ : 0.0; }
  void note_proved(const Proved& proved);
  bool note_distance(const Pair& pair, double distance, bool exact);
  bool in_contact() const { return clearance_ <= NarrowPhase::contact_distance; }
  bool is_single_row() const { return motion_.positions.rows() == 1; }
  void leave_unproved(const Interval& interval, std::uint32_t pair);
  bool refine_nearest();
  MotionProof report(bool free) const;
  const SceneModel& model_;
  const CubicMotion& motion_;
  const PairGroups& groups_;
  CubicSegments segments_;
  SceneWorkspace& workspace_;
  double fraction_;  // of the clearance that is to be proved
  const Deadline* deadline_;
  double clearance_{infinity};  // the smallest distance found, less padding
  bool is_exact_{true};         // false: that of any two near primitives of nearest_, not its own
  const Pair* nearest_{};
  double nearest_time_{};
  Eigen::VectorXd nearest_configuration_;
  double proved_{infinity};
  int samples_{};      // the number of the current one
  bool late_{};        // was the deadline seen to have passed?
  unsigned visits_{};  // of intervals
  unsigned checks_{};  // that bounds did not decide, since the last look at the clock
  int raising_{};      // of pairs that were proved free, but less than the goal
  CubicSegments::Range range_;
  std::vector<Displacement> displacements_;         // by moving body, in an interval
  std::vector<Displacement> sphere_displacements_;  // of bounding spheres, by moving body and envelope
  std::vector<Displacement> in_envelopes_;          // the same of moving bodies, from those of their envelopes
  std::vector<Separation> separations_;             // by pair; empty until one is needed
  std::vector<Open> open_;                          // a stack: those of the current interval on top
  std::vector<Proved> to_sharpen_;                  // a heap: less than the goal is proved of these
  std::vector<std::pair<std::uint32_t, std::pair<double, double>>> unproved_;
  std::vector<std::pair<double, std::uint32_t>> order_;
};

/// Notes that the pair has this distance at the current configuration, or, if that is not `exact`, at most this; false:
/// it is in contact.
bool Prover::note_distance(const Pair& pair, double distance, bool exact) {
  const double clearance = distance - pair.padding;
  if (clearance < clearance_) {
    clearance_ = clearance;
    is_exact_ = exact;
    nearest_ = &pair;
    nearest_time_ = range_.time;
    nearest_configuration_ = range_.middle;
  }
  return clearance > NarrowPhase::contact_distance;
}

/// Keeps what is less than the goal, for sharpen().
void Prover::note_proved(const Proved& proved) {
  if (proved.bound >= goal()) {
    proved_ = std::min(proved_, proved.bound);
    return;
  }
  to_sharpen_.push_back(proved);
  std::push_heap(to_sharpen_.begin(), to_sharpen_.end());
}

/// Notes the distance of the pair at the current configuration if it is less than what was found before. Of meshes,
/// distances of any two primitives will do until there are none that are much less: the pair's own takes far longer.
void Prover::note_if_nearer(const Pair& pair) {
  const bool exact = pair.solid || is_single_row();
  const auto margin = [&] { return (exact ? 1.0 : much_less) * clearance_ + pair.padding; };
  if (!pair.solid && margin() < infinity && workspace_.hull_distance(pair, margin(), infinity) == infinity) return;
  do {
    const double found = workspace_.distance(pair, margin(), exact ? 0.0 : infinity);
    if (!(found - pair.padding < clearance_)) return;  // it may exceed the margin by contact_distance
    note_distance(pair, found, exact);
  } while (!exact && !in_contact() && !stopped());
}

/// Finds a pair that is about the nearest at a row, so that pairs farther away need no distance later. Once the
/// deadline has passed, the pair that may be the nearest is checked alone.
void Prover::find_nearest_at(Eigen::Index row) {
  range_.time = motion_.times[row];
  range_.middle = motion_.positions.row(row).transpose();
  workspace_.place(range_.middle);
  order_.clear();
  const auto nearest_first = std::greater<>();  // of a heap
  const auto add = [&](std::uint32_t number) {
    const double bound = workspace_.distance_bound(groups_.pair_of(number)) - groups_.pair_of(number).padding;
    if (bound >= clearance_) return;
    order_.emplace_back(bound, number);
    std::push_heap(order_.begin(), order_.end(), nearest_first);
  };
  for (std::size_t i = 0; i < groups_.size(); ++i) add(groups_.number(i));
  for (bool first = true; !order_.empty();) {
    std::pop_heap(order_.begin(), order_.end(), nearest_first);
    const auto [bound, i] = order_.back();
    order_.pop_back();
    if (bound >= clearance_ || (!is_single_row() && !first && stopped())) return;  // a single row has no other check
    if (groups_.is_group(i)) {
      for (const std::uint32_t member : groups_.members_of(i)) add(member);
      continue;
    }
    first = false;
    note_if_nearer(groups_.pair_of(i));
  }
}

/// How far the pair can approach each other.
double Prover::approach(const Pair& pair) {
  return pair.sum([this](std::uint32_t body, std::uint64_t support) { return displacement(body, support); });
}

/// How far the bounding spheres of the pair, or of a group, can.
double Prover::approach_of_spheres(const Pair& pair) {
  return pair.sum([this](std::uint32_t body, std::uint64_t support) { return displacement_of_sphere(body, support); });
}

/// What is known at this sample for these joints, which are often those of the pair before, or what `compute` finds.
template <class Compute>
double Prover::remembered(Displacement& known, std::uint64_t support, Compute&& compute) {
  if (known.sample != samples_ || known.support != support) known = {samples_, support, compute()};
  return known.motion;
}

/// How far the joints of `support` can move the body.
double Prover::displacement(std::uint32_t body, std::uint64_t support) {
  return remembered(displacements_[body], support, [&] { return workspace_.displacement(body, support); });
}

double Prover::displacement_of_sphere(std::uint32_t body, std::uint64_t support) {
  return remembered(sphere_displacements_[body], support,
                    [&] { return workspace_.displacement_of_sphere(body, support); });
}

/// The same from how its envelope moves.
double Prover::displacement_in_envelope(std::uint32_t body, std::uint64_t support) {
  return remembered(in_envelopes_[body], support, [&] { return workspace_.displacement_in_envelope(body, support); });
}

void Prover::place_at(const Interval& interval) {
  ++samples_;
  segments_.range(interval, range_);
  workspace_.place_in_range(range_.middle, range_.change, range_.linear, range_.rest);
}

/// A clearance that the pair keeps over the interval around the current configuration, from the bound here. No more
/// than `required` where that does not prove as much.
double Prover::bound_left(const Pair& pair, double motion, const DistanceBound& bound, double required) {
  const double apart = bound.distance - pair.padding - NarrowPhase::tolerance;
  if (apart - motion > required || apart <= required) return apart - motion;
  const Eigen::Vector3d direction = bound.direction();
  return apart - workspace_.approach_of_spheres(pair, 1.0, &direction);
}

/// Checks a pair over the interval around the current configuration. A clearance of `required` will do, though
/// distances are computed as far as the goal.
Prover::Check Prover::check(const Pair& pair, double sphere_approach, double required) {
  const DistanceBound bounds = workspace_.bound(pair);
  const double bound = bounds.distance, left = bound_left(pair, sphere_approach, bounds, required);
  if (left > required) return {CollisionStatus::free, left, false};
  if (seldom_stopped(pair)) return {CollisionStatus::undecided, 0.0, false};
  const double motion = approach(pair);
  if (motion < Checker::motion_floor || motion <= workspace_.likely_max_distance(pair, bound))
    return measure(pair, motion, required);
  // No distance could prove it.
  if (bound > pair.padding || !workspace_.in_contact(pair, {.use_tables = false}))
    return {CollisionStatus::undecided, 0.0, false, bound + likely_gain * motion - pair.padding};
  note_distance(pair, pair.padding, true);
  return {CollisionStatus::colliding};
}

/// The same by distances: of hulls, and of the pair itself where those are too near.
Prover::Check Prover::measure(const Pair& pair, double motion, double required) {
  const bool finest = motion < Checker::motion_floor;
  const double least = pair.padding + motion + NarrowPhase::tolerance, margin = least + goal();
  if (!pair.solid) {
    const double suffices = least + required - 0.9 * motion,
                 hulls = workspace_.hull_distance(pair, margin, suffices, &separation_of(pair));
    if (hulls == infinity) return {CollisionStatus::free, goal()};
    double bound = hulls - least;
    // Much of a motion is often along the planes that separate the two.
    if (bound < goal()) bound = std::max(bound, workspace_.free_gap(pair, separation_of(pair), goal()));
    if (bound > required) return {CollisionStatus::free, bound, false};
    // Hulls a tenth of the motion apart prove the halves: that is cheaper than the distance of the meshes.
    if (!finest && hulls > suffices) return {CollisionStatus::undecided, 0.0, true, hulls - pair.padding - required};
  }
  const double touching = pair.padding + NarrowPhase::contact_distance;
  double enough = pair.padding + rough_distance * motion, found = workspace_.distance(pair, margin, enough);
  if (found == infinity) return {CollisionStatus::free, goal()};
  if (finest && found > touching && !pair.solid) {
    enough = touching;
    found = workspace_.distance(pair, margin, enough);
  }
  if (!note_distance(pair, found, pair.solid || found > enough)) return {CollisionStatus::colliding};
  // What passes is the pair's distance: one that is only of two of its primitives is less than the motion.
  if (found > least) return {CollisionStatus::free, found - least};
  if (pair.solid) {
    const double gap = workspace_.free_gap(pair, workspace_.separate(pair, margin), required);
    if (gap > required) return {CollisionStatus::free, gap, false};
  }
  return {CollisionStatus::undecided, 0.0, true, found - pair.padding};
}

void Prover::leave_unproved(const Interval& interval, std::uint32_t pair) {
  const std::pair<double, double> part{segments_.time_of(interval, false), segments_.time_of(interval, true)};
  proved_ = 0.0;
  for (auto& [known, known_part] : unproved_)
    if (known == pair && known_part.second >= part.first) {
      known_part.second = part.second;
      return;
    }
  unproved_.emplace_back(pair, part);
}

/// Notes what is proved of the pair over the interval, which is not halved for it.
void Prover::close(const Open& open, const Interval& interval, bool measured) {
  if (groups_.is_group(open.pair))
    for (const std::uint32_t member : groups_.members_of(open.pair)) leave_unproved(interval, member);
  else if (open.bound >= 0.0)
    note_proved({open.bound, interval, open.pair, measured});
  else
    leave_unproved(interval, open.pair);
}

/// Proves the pairs of a group over the interval around the current configuration, together if their envelopes are far
/// enough apart, or leaves them open; false at a contact.
bool Prover::prove_group(const Open& open, const Interval& interval) {
  const Pair& around = groups_.pair_of(open.pair);
  const DistanceBound bound = workspace_.bound(around);
  const double motion = approach_of_spheres(around), left = bound_left(around, motion, bound, goal());
  if (left > goal()) {
    note_proved({left, interval, open.pair, false});
    return true;
  }
  // Members are rarely farther apart than the envelopes by more than `looseness`: over longer motions they are not
  // tried.
  const double room = bound.distance - around.padding - NarrowPhase::tolerance - goal(),
               looseness = likely_looseness * workspace_.likely_max_distance(around, 0.0),
               longest = std::max(room, 0.0) + looseness;
  const bool is_halved = motion > longest || motion < longest_group_motion * room;
  if (is_halved && motion >= finest_motion && !interval.is_indivisible()) {
    open_.push_back({open.pair, levels_for(longest, motion)});
    return true;
  }
  return std::ranges::all_of(groups_.members_of(open.pair),
                             [&](std::uint32_t member) { return prove_member(member, interval); });
}

/// As prove_pair, of a pair of a group: most of them are far enough apart by the quick bounds.
bool Prover::prove_member(std::uint32_t member, const Interval& interval) {
  const Pair& pair = model_.bodies.pairs[member];
  const DistanceBound bound = workspace_.bound_in_envelopes(pair);
  const double apart = bound.distance - pair.padding - NarrowPhase::tolerance;
  double left = apart - displacement_in_envelope(pair.a, pair.support_a);
  if (!pair.b_fixed) left -= displacement_in_envelope(pair.b, pair.support_b);
  if (left <= goal() && apart > goal()) {
    const Eigen::Vector3d direction = bound.direction();
    left = apart - workspace_.displacement_in_envelope(pair.a, pair.support_a, &direction);
    if (!pair.b_fixed) left -= workspace_.displacement_in_envelope(pair.b, pair.support_b, &direction);
  }
  if (left > goal()) {
    note_proved({left, interval, member, false});
    return true;
  }
  return prove_pair({.pair = member, .levels = 0}, interval);
}

/// Proves the pair over the interval around the current configuration, or leaves it open; false at a contact. While
/// the bodies are placed, more is proved of solids than that they are free: the goal, as long as that takes few more
/// checks. Distances of meshes take long, so those come later, the nearest first.
bool Prover::prove_pair(Open open, const Interval& interval) {
  const Pair& pair = model_.bodies.pairs[open.pair];
  const double sphere_approach = approach_of_spheres(pair);
  const bool raises = pair.solid && raising_ < max_sharpening && sphere_approach >= Checker::motion_floor;
  const Check found = check(pair, sphere_approach, raises ? goal() : 0.0);
  if (found.status == CollisionStatus::colliding) return false;
  const bool free = found.status == CollisionStatus::free;
  if (free) open.bound = std::max(open.bound, found.bound);
  raising_ += open.bound >= 0.0 && open.bound < goal();
  const bool proved = open.bound >= 0.0 && (open.bound >= goal() || !raises);
  const double motion = proved ? 0.0 : approach(pair);
  if (proved || motion < finest_motion || interval.is_indivisible())
    close(open, interval, found.measured);
  else
    open_.push_back({open.pair, levels_for(free ? open.bound + motion - goal() : found.room, motion), open.bound});
  return true;
}

/// Proves the pairs open_[first, first + count) over the interval; false at a contact.
bool Prover::prove(const Interval& interval, std::size_t first, std::size_t count) {
  const bool looks_at_clock = visits_++ % visits_per_look == 0;
  if (looks_at_clock) rare_interruption_point();
  if (samples_ >= max_samples || (looks_at_clock ? stopped() : late_)) {
    for (std::size_t i = first; i < first + count; ++i) close(open_[i], interval, false);
    return true;
  }
  const auto due = [](const Open& open) { return open.levels == 0; };
  const auto begin = open_.begin() + static_cast<std::ptrdiff_t>(first);
  if (std::any_of(begin, begin + static_cast<std::ptrdiff_t>(count), due)) place_at(interval);
  const std::size_t kept = open_.size();
  for (std::size_t i = first; i < first + count; ++i) {
    const Open open = open_[i];
    if (open.levels > 0)
      open_.push_back({open.pair, open.levels - 1, open.bound});
    else if (!(groups_.is_group(open.pair) ? prove_group(open, interval) : prove_pair(open, interval)))
      return false;
  }
  const std::size_t still_open = open_.size() - kept;
  if (still_open > 0 && !prove_halves(interval, kept, still_open)) return false;
  open_.resize(kept);
  return true;
}

bool Prover::prove_halves(const Interval& interval, std::size_t first, std::size_t count) {
  const auto [left, right] = interval.halves();
  return prove(left, first, count) && prove(right, first, count);
}

/// Raises the clearance that is proved, where it is least, until the goal is reached or enough distances are computed.
/// False at a contact.
bool Prover::sharpen() {
  int distances = 0;
  while (!to_sharpen_.empty() && to_sharpen_.front().bound < goal() && distances < max_sharpening && !stopped()) {
    std::pop_heap(to_sharpen_.begin(), to_sharpen_.end());
    Proved least = to_sharpen_.back();
    to_sharpen_.pop_back();
    if (least.measured) {
      const auto [left, right] = least.interval.halves();
      for (const Interval& half : {left, right}) note_proved({least.bound, half, least.pair, false});
      continue;
    }
    ++distances;
    place_at(least.interval);
    const Pair& pair = model_.bodies.pairs[least.pair];
    const Check found = check(pair, approach_of_spheres(pair), goal());
    if (found.status == CollisionStatus::colliding) return false;
    note_proved({std::max(least.bound, found.bound), least.interval, least.pair, true});
    if (approach(pair) < Checker::motion_floor) break;
  }
  if (!to_sharpen_.empty()) proved_ = std::min(proved_, to_sharpen_.front().bound);
  return true;
}

/// The distance noted of the nearest pair may be that of any two near primitives: computes the pair's own. False: they
/// are in contact. After the deadline, what was noted has to do.
bool Prover::refine_nearest() {
  if (!is_exact_ && !stopped()) {
    workspace_.place(nearest_configuration_);
    const double found = workspace_.distance(*nearest_, clearance_ + nearest_->padding, 0.0) - nearest_->padding;
    clearance_ = std::min(clearance_, found);
    is_exact_ = true;
  }
  return !in_contact();
}

MotionProof Prover::run() {
  const Eigen::Index last = motion_.positions.rows() - 1;
  std::uint64_t active = 0;
  for (std::size_t k = 0; k < model_.group.actuated_joints().size(); ++k) active |= std::uint64_t{1} << k;
  workspace_.start_any_motion(active);
  if (fraction_ > 0.0 || last == 0)
    for (const Eigen::Index row : {last / 2, Eigen::Index{0}, last})
      if (!in_contact()) find_nearest_at(row);
  bool free = !in_contact();
  if (free && last > 0) {
    open_.clear();
    for (std::size_t i = 0; i < groups_.size(); ++i) open_.push_back({.pair = groups_.number(i), .levels = 0});
    free = prove({0, last}, 0, groups_.size()) && (!unproved_.empty() || (refine_nearest() && sharpen()));
  }
  return report(refine_nearest() && free);
}

MotionProof Prover::report(bool free) const {
  // A motion of one row is proved to have the clearance that was found.
  const double most = std::max(clearance_ - NarrowPhase::tolerance, 0.0);
  MotionProof proof{free, clearance_, nearest_time_, "", "", free ? std::min(proved_, most) : 0.0, {}};
  if (nearest_) {
    proof.body_a = workspace_.body_a(*nearest_).name;
    proof.body_b = workspace_.body_b(*nearest_).name;
  }
  for (const auto& [number, part] : unproved_) {
    const Pair& pair = model_.bodies.pairs[number];
    proof.unproved.push_back({part.first, part.second, workspace_.body_a(pair).name, workspace_.body_b(pair).name});
  }
  return proof;
}

void require_motion(const CubicMotion& motion, std::size_t dof) {
  const Eigen::Index n = motion.positions.rows();
  if (n == 0) throw InvalidArgument("motion: it has no rows");
  if (motion.times.size() != n || (motion.velocities.rows() != 0 && motion.velocities.rows() != n))
    throw InvalidArgument("motion: it has " + std::to_string(n) + " rows of positions, but " +
                          std::to_string(motion.velocities.rows()) + " of velocities and " +
                          std::to_string(motion.times.size()) + " times");
  if (static_cast<std::size_t>(motion.positions.cols()) != dof)
    throw InvalidArgument("motion: its rows have " + std::to_string(motion.positions.cols()) + " joints, but " +
                          std::to_string(dof) + " are planned");
  if (motion.velocities.rows() > 0 && motion.velocities.cols() != motion.positions.cols())
    throw InvalidArgument("motion: its velocities have " + std::to_string(motion.velocities.cols()) +
                          " joints, but its positions " + std::to_string(motion.positions.cols()));
  if (motion.arrivals &&
      (motion.arrivals->rows() != motion.velocities.rows() || motion.arrivals->cols() != motion.velocities.cols()))
    throw InvalidArgument("motion: its arrivals have not the shape of its velocities");
  const auto require_finite = [](bool finite) {
    if (!finite) throw InvalidArgument("motion: it holds NaN, infinity or numbers that overflow");
  };
  const auto small = [](const auto& rows) { return (rows.array().abs() < largest).all(); };  // NaN is not
  require_finite(motion.times.allFinite() && small(motion.positions) && motion.velocities.allFinite());
  for (Eigen::Index i = 1; i < n; ++i)
    if (motion.times[i] <= motion.times[i - 1])
      throw InvalidArgument("motion: time " + std::to_string(i) + " is " + to_text(motion.times[i]) +
                            " s, not after the one before (" + to_text(motion.times[i - 1]) + " s)");
  for (Eigen::Index i = 1; i < motion.velocities.rows(); ++i) {
    const double duration = motion.times[i] - motion.times[i - 1];
    require_finite(small(duration * motion.velocities.middleRows(i - 1, 2)));
    if (motion.arrivals) require_finite(small(duration * motion.arrivals->row(i)));
  }
}

}  // namespace

MotionProof prove_motion(const Checker& checker, const CubicMotion& motion, Checker::Workspace& workspace,
                         const ProofOptions& options) {
  require_motion(motion, checker.dof());
  if (!(options.gap_tolerance > 0.0 && options.gap_tolerance <= 1.0))
    throw InvalidArgument("motion proof: gap_tolerance is " + to_text(options.gap_tolerance) +
                          "; it must be in (0, 1]");
  checker.require_own(workspace);
  auto* scene_workspace = dynamic_cast<SceneWorkspace*>(&workspace);
  if (!scene_workspace)
    throw InvalidArgument("motion proof: it needs the library's own checker (make_checker), not another backend");
  const SceneModel& model = scene_workspace->model();
  if (!model.bodies.overlaps.empty()) {
    const Contact rigid = checker.contacts(motion.positions.row(0).transpose(), workspace).front();
    return {false, rigid.distance, motion.times[0], rigid.body_a, rigid.body_b, 0.0, {}};
  }
  return Prover(model, motion, *scene_workspace, options).run();
}

}  // namespace srmp
