#include "srmp/collision/scene_workspace.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "srmp/core/interruption.hpp"

namespace srmp::detail {

namespace {

/// Distances of meshes below this fraction of an interval's motion are not refined: the interval is subdivided anyway.
constexpr double rough_distance = 0.3;

constexpr std::size_t max_stored_candidates = 1 << 20;  // of one motion: further parts have those of the whole

/// An interval is subdivided into so many parts that the pair's distance could prove each, but no more than this.
constexpr int max_parts = 16;
constexpr int samples_per_deadline_check = 32;

/// An interval is divided until this fraction of the gap in its middle would be left: elsewhere the gap may be smaller.
constexpr double likely_gap = 0.5;

/// A level of more intervals than this is not resolved as one.
constexpr std::size_t many_intervals = 32;

/// What proves a part of a motion free while spheres, tables or an arbitrary subdivision may have chosen the part: the
/// pair must stay farther apart than this [m]. The whole motion, subdivided down to Checker::motion_floor, is then
/// proved free as well, so the result does not depend on which spheres and tables there are.
constexpr double proof_reserve = PairTable::reserve;
static_assert(proof_reserve >= Checker::motion_floor + 2.5 * NarrowPhase::tolerance);

}  // namespace

SceneWorkspace::SceneWorkspace(const SceneModel& model)
    : model_(model),
      bodies_(model.bodies),
      data_(model.group.make_data()),
      narrow_(model.bodies.formulas),
      displacements_(model) {
  narrow_.poll_with([this] {
    if (deadline && deadline->expired()) throw MotionCheckStopped();
    interruption_point();
  });
  if (model_.batch) batch_ = model_.batch->make_workspace();
  span_of_.assign(bodies_.pairs.size(), {1.0, 0.0});
  open_.reserve(1024);
  next_.reserve(1024);
  places_.resize(bodies_.moving.size() + bodies_.envelopes.size());
  carried_.resize(bodies_.moving.size());
  const auto dof = static_cast<Eigen::Index>(model_.group.joints().size());
  start_ = delta_ = q_ = here_ = Eigen::VectorXd::Zero(dof);
}

void SceneWorkspace::place(ConstVector q) {
  ++statistics.configurations;
  here_ = q;
  model_.group.forward(data_, q);
  ++placements_;
}

const Place& SceneWorkspace::place_of(std::size_t body) {
  Place& place = places_[body];
  if (place.number == placements_) return place;
  const MovingBody& moving = bodies_.moving_body(body);
  place.pose = pose_of(moving, model_.group, data_);
  place.center = place.pose * moving.bounds.center;
  place.number = placements_;
  return place;
}

const SceneWorkspace::Carried& SceneWorkspace::carried(std::size_t body) {
  Carried& carried = carried_[body];
  if (carried.number == placements_) return carried;
  const Place& envelope = place_of(bodies_.envelope_of[body]);
  carried.offset = envelope.pose.linear() * bodies_.in_envelope[body];
  carried.center = envelope.center + carried.offset;
  carried.number = placements_;
  return carried;
}

Placed SceneWorkspace::placed(bool fixed, std::size_t i) {
  if (!fixed) {
    const MovingBody& body = bodies_.moving[i];
    const Place& place = place_of(i);
    return {body.geometry.get(), body.parts.bvh.get(), body.bounds, place.pose, place.center};
  }
  const FixedBody& body = bodies_.fixed[i];
  return {body.geometry.get(), body.parts.bvh.get(), body.bounds, body.pose, body.center};
}

Contact SceneWorkspace::contact(const Body& a, const Body& b, const Proximity& found, double padding) const {
  const Pose& base = model_.group.instance(0).base;
  return {a.name, b.name, found.distance - padding, base * found.point_a, base * found.point_b, padding,
          a.kind, b.kind};
}

Contact SceneWorkspace::contact(const Pair& pair) {
  const Proximity found = NarrowPhase::deepest(placed(false, pair.a), placed(pair.b_fixed, pair.b),
                                               pair.padding + NarrowPhase::contact_distance);
  return contact(body_a(pair), body_b(pair), found, pair.padding);
}

// --- one configuration

DistanceBound SceneWorkspace::bound(const Pair& pair) {
  const Eigen::Vector3d& center = place_of(pair.a).center;
  return bound(pair, center, pair.b_fixed ? center : place_of(pair.b).center);
}

DistanceBound SceneWorkspace::bound_in_envelopes(const Pair& pair) {
  const Eigen::Vector3d& center = carried(pair.a).center;
  return bound(pair, center, pair.b_fixed ? center : carried(pair.b).center);
}

/// From a sphere around a, and a box or a sphere around b: between these centres, a fixed b has its own.
DistanceBound SceneWorkspace::bound(const Pair& pair, const Eigen::Vector3d& center,
                                    const Eigen::Vector3d& center_b) const {
  const double radius = bodies_.moving_body(pair.a).bounds.radius;
  if (!pair.b_fixed) {
    const Eigen::Vector3d apart = center - center_b;
    const double length = apart.norm();
    return {length - radius - bodies_.moving_body(pair.b).bounds.radius, apart, length, nullptr};
  }
  const FixedBody& b = bodies_.fixed[pair.b];
  const Eigen::Vector3d local = b.pose.linear().transpose() * (center - b.pose.translation()) - b.bounds.box_center;
  const Eigen::Vector3d outside = (local.cwiseAbs() - b.bounds.box_half).cwiseMax(0.0);
  const double length = outside.norm();
  return {length - radius, outside.cwiseProduct(local.cwiseSign()), length, &b.pose};
}

/// A body usually has points on all sides of its bounding sphere's centre, or near it.
double SceneWorkspace::likely_max_distance(const Pair& pair, double bound) const {
  const double a = bodies_.moving_body(pair.a).bounds.radius;
  return bound + 2.0 * (pair.b_fixed ? a : a + bodies_.moving_body(pair.b).bounds.radius);
}

double SceneWorkspace::query_distance(const Pair& pair, const Placed& a, const Placed& b, double margin, double enough,
                                      Separation* separation) {
  ++statistics.narrow_phase;
  if (!a.bvh && !b.bvh) return narrow_.solids(pair.formula, a, b, margin, separation);
  return narrow_.primitives(a, b, {.margin = margin, .enough = enough});
}

std::pair<Placed, Placed> SceneWorkspace::solids_of(const Pair& pair) {
  const Placed a = placed(false, pair.a), b = placed(pair.b_fixed, pair.b);
  return {Placed{bodies_.moving[pair.a].solid, nullptr, a.bounds, a.pose, a.center},
          Placed{body_b(pair).solid, nullptr, b.bounds, b.pose, b.center}};
}

double SceneWorkspace::hull_distance(const Pair& pair, double margin, double suffices, Separation* separation) {
  const auto [solid_a, solid_b] = solids_of(pair);
  double found = 0.0;
  if (solid_a.geometry && solid_b.geometry)
    found = query_distance(pair, solid_a, solid_b, margin, suffices, separation);
  if (!pair.both_meshes || found > suffices) return found;
  if (solid_a.geometry && !solid_b.geometry)
    return query_distance(pair, solid_a, placed(pair.b_fixed, pair.b), margin, suffices);
  if (solid_b.geometry && !solid_a.geometry)
    return query_distance(pair, placed(false, pair.a), solid_b, margin, suffices);
  return found;
}

double SceneWorkspace::distance(const Pair& pair, double margin, double enough) {
  return query_distance(pair, placed(false, pair.a), placed(pair.b_fixed, pair.b), margin, enough);
}

Separation SceneWorkspace::separate(const Pair& pair, double margin) {
  constexpr int none = -1;  // formulas give no planes
  ++statistics.narrow_phase;
  Separation separation;
  narrow_.solids(none, placed(false, pair.a), placed(pair.b_fixed, pair.b), margin, &separation);
  return separation;
}

/// Does the pair's table prove the two apart over this part of the motion?
bool SceneWorkspace::table_proves(const Pair& pair, double from, double to) {
  if (!pair.table) return false;
  const bool proved = pair.is_free_by_table(start_, delta_, from, to);
  statistics.by_tables += proved;
  return proved;
}

bool SceneWorkspace::in_contact(const Pair& pair, const ContactOptions& options) {
  if (distance_bound(pair) > pair.padding + NarrowPhase::tolerance) return false;
  if (pair.table && options.use_tables && pair.is_free_by_table(here_, here_, 0.0, 0.0)) return false;
  if (!pair.solid && hull_distance(pair, pair.padding + NarrowPhase::tolerance, infinity) == infinity) return false;
  return distance(pair, pair.padding, pair.padding + NarrowPhase::contact_distance) < infinity;
}

/// Visits the pairs of a moving body with those fixed bodies whose boxes come within `margin` plus padding of its
/// sphere.
template <class Visit>
bool SceneWorkspace::for_each_fixed_near(std::size_t body, double margin, Visit&& visit) {
  const MovingBody& moving = bodies_.moving[body];
  const double reach =
      moving.bounds.radius + moving.padding + bodies_.max_fixed_padding + margin + NarrowPhase::tolerance;
  const std::int32_t* row = bodies_.fixed_pair.data() + body * bodies_.fixed.size();
  return bodies_.tree.for_each_near(place_of(body).center, reach, [&](std::size_t fixed) {
    return row[fixed] < 0 || visit(static_cast<std::uint32_t>(row[fixed]));
  });
}

bool SceneWorkspace::is_free_here() {
  for (std::size_t i = 0; i < bodies_.moving.size(); ++i)
    if (!for_each_fixed_near(i, 0.0, [&](std::uint32_t pair) { return !in_contact(bodies_.pairs[pair]); }))
      return false;
  return std::none_of(bodies_.moving_pairs.begin(), bodies_.moving_pairs.end(),
                      [&](std::uint32_t pair) { return in_contact(bodies_.pairs[pair]); });
}

// --- motions

void SceneWorkspace::start_motion(ConstVector a, ConstVector b) {
  start_ = a;
  delta_ = b - a;
  for (std::size_t i = 0; i < model_.group.continuous().size(); ++i)
    if (model_.group.continuous()[i]) delta_[i] = std::remainder(delta_[i], 2.0 * std::numbers::pi);
}

void SceneWorkspace::start_any_motion(std::uint64_t active) { displacements_.start_any(active); }

void SceneWorkspace::place_in_range(ConstVector q, std::span<const double> change, std::span<const double> linear,
                                    std::span<const double> rest) {
  displacements_.limit(change, linear, rest);
  place_with_axes(q);
}

void SceneWorkspace::place_on_motion(double t) {
  q_ = start_ + t * delta_;
  place_with_axes(q_);
}

void SceneWorkspace::place_with_axes(ConstVector q) {
  place(q);
  displacements_.place(data_);
}

double SceneWorkspace::displacement(std::size_t body, std::uint64_t support, double half_width,
                                    const Eigen::Vector3d* direction) {
  return displacements_.of(body, place_of(body), support, half_width, direction);
}

double SceneWorkspace::displacement_in_envelope(std::size_t body, std::uint64_t support,
                                                const Eigen::Vector3d* direction) {
  const std::uint32_t envelope = bodies_.envelope_of[body];
  return displacements_.of_point(envelope, place_of(envelope), support, carried(body).offset, direction);
}

double SceneWorkspace::approach(const Pair& pair, double half_width, const Eigen::Vector3d* direction) {
  return pair.sum(
      [&](std::uint32_t body, std::uint64_t support) { return displacement(body, support, half_width, direction); });
}

double SceneWorkspace::displacement_of_sphere(std::size_t body, std::uint64_t support, double half_width,
                                              const Eigen::Vector3d* direction) {
  return displacements_.of_center(body, place_of(body), support, half_width, direction);
}

double SceneWorkspace::approach_of_spheres(const Pair& pair, double half_width, const Eigen::Vector3d* direction) {
  return pair.sum([&](std::uint32_t body, std::uint64_t support) {
    return displacement_of_sphere(body, support, half_width, direction);
  });
}

/// Does the sum of both bodies' displacements say how near the two come? So it is of one point that moves.
bool SceneWorkspace::is_of_one_point(const Pair& pair) const {
  const bool a_moves = (pair.support_a & displacements_.active()) != 0,
             b_moves = (pair.support_b & displacements_.active()) != 0;
  if (a_moves == b_moves) return !a_moves;
  return bodies_.moving[a_moves ? pair.a : pair.b].core.is_point();
}

double SceneWorkspace::free_gap(const Pair& pair, const Separation& separation, double enough, double half_width) {
  if (!(separation.gap > 0.0)) return -infinity;
  const Eigen::Vector3d direction = place_of(pair.a).pose.linear() * separation.direction.normalized();
  const double needed = pair.padding + NarrowPhase::tolerance,
               left = separation.gap - approach(pair, half_width, &direction) - needed;
  if (left > enough || is_of_one_point(pair)) return left;
  // Not all points of a body come nearer, and most that do so fastest are far from the planes.
  const auto [solid_a, solid_b] = solids_of(pair);
  const DirectedMotion of_a = displacements_.along(pair.a, place_of(pair.a), pair.support_a, half_width, direction);
  DirectedMotion of_b;
  if (!pair.b_fixed) of_b = displacements_.along(pair.b, place_of(pair.b), pair.support_b, half_width, direction);
  return std::max(left, narrow_.gap_in_motion(solid_a, solid_b, direction, of_a, of_b) - needed);
}

/// Checks the pair over an interval around here. Below motion_floor, what is not proved free counts as colliding if the
/// intervals are those of the whole motion.
CollisionStatus SceneWorkspace::check_pair(const Interval& interval, Undecided& undecided) {
  const Pair& pair = bodies_.pairs[interval.pair];
  const double needed = pair.padding + NarrowPhase::tolerance + reserve_, bound = distance_bound(pair);
  if (bound > needed + approach_of_spheres(pair, interval.half_width)) return CollisionStatus::free;
  const double motion = approach(pair, interval.half_width), margin = needed + motion;
  const bool at_floor = motion < Checker::motion_floor;
  undecided = {at_floor ? 0 : 2, bound, interval.candidates};
  int& parts = undecided.parts;
  const CollisionStatus unproved =
      at_floor && reserve_ == 0.0 ? CollisionStatus::colliding : CollisionStatus::undecided;
  if (motion > likely_max_distance(pair, bound)) {  // no distance could prove it
    if (bound > pair.padding) return unproved;
    return in_contact(pair) ? CollisionStatus::colliding : unproved;
  }
  Separation separation;  // of the two, or of hulls around them; none is known yet
  const auto proves_parts = [&](double distance) {
    if (motion <= parts * (distance - pair.padding)) return true;
    const double left = free_gap(pair, separation, separation.gap, interval.half_width / parts);
    return left > std::max(reserve_, likely_gap * (separation.gap - pair.padding));
  };
  const auto subdivide_for = [&](double distance) {
    undecided.distance = distance;
    while (parts > 0 && parts < max_parts && !proves_parts(distance)) parts *= 2;
    return unproved;
  };
  if (!pair.solid && interval.candidates.count == 0) {
    const double limit = margin + NarrowPhase::tolerance;
    const double found = hull_distance(pair, limit, limit - 0.9 * motion, &separation);
    if (found == infinity) return CollisionStatus::free;
    if (free_gap(pair, separation, reserve_, interval.half_width) > reserve_) return CollisionStatus::free;
    // Hulls a tenth of the motion apart prove the parts: that is cheaper than the distance of the meshes.
    if (found > limit - 0.9 * motion && !at_floor) return subdivide_for(found);
  }
  const double touching = pair.padding + NarrowPhase::contact_distance, enough = pair.padding + rough_distance * motion;
  const PrimitiveQuery query{.margin = margin, .enough = enough};
  const double found = pair.solid         ? distance(pair, margin, enough)
                       : interval.is_part ? distance_of_part(interval, query, undecided.candidates)
                                          : distance_left(interval, query);
  if (found == infinity) return CollisionStatus::free;
  if (found <= touching || (!pair.solid && found <= enough && distance(pair, pair.padding, touching) < infinity))
    return CollisionStatus::colliding;
  if (found - pair.padding <= reserve_) {  // no part of the motion around here can be proved with it
    parts = 0;
    return unproved;
  }
  if (pair.solid) separation = separate(pair, margin);
  if (pair.solid && free_gap(pair, separation, reserve_, interval.half_width) > reserve_) return CollisionStatus::free;
  return subdivide_for(found);
}

/// The distance of the interval's pair here, of those primitives that the interval does not keep apart.
double SceneWorkspace::distance_left(const Interval& interval, PrimitiveQuery query) {
  const Pair& pair = bodies_.pairs[interval.pair];
  const auto motion_of = [&](std::size_t body, std::uint64_t support, const Eigen::Vector3d& direction,
                             std::span<const Eigen::Vector3d> part) {
    const Place& place = place_of(body);
    return part.empty() ? displacements_.of(body, place, support, interval.half_width, &direction)
                        : displacements_.of(body, place, support, interval.half_width, direction, part);
  };
  const auto stays_separated = [&](const SeparatedParts& parts) {
    const double needed = pair.padding + NarrowPhase::tolerance + reserve_;
    const double left = parts.gap - needed - motion_of(pair.a, pair.support_a, parts.direction, parts.a);
    return left > 0.0 && (pair.b_fixed || left > motion_of(pair.b, pair.support_b, parts.direction, parts.b));
  };
  ++statistics.narrow_phase;
  query.stays_separated = std::cref(stays_separated);
  return narrow_.primitives(placed(false, pair.a), placed(pair.b_fixed, pair.b), query);
}

/// The same of a part of an interval, which checks only what is left of the whole's candidates, or of all if it has
/// none; what is `left` is for its own parts. Without that, two meshes that pass each other closely would be searched
/// again and again.
double SceneWorkspace::distance_of_part(const Interval& part, const PrimitiveQuery& query, Candidates& left) {
  const Candidates& known = part.candidates;
  PrimitiveQuery collecting = query;
  collecting.among = std::span(candidates_).subspan(known.first, known.count);
  collecting.candidates = &new_candidates_;
  const double found = distance_left(part, collecting);
  const std::size_t count = new_candidates_.size();
  if (count == 0 || candidates_.size() > max_stored_candidates) return found;
  if (known.count > 0 && 2 * count > known.count) return found;  // those of the whole will do
  left.first = static_cast<std::uint32_t>(candidates_.size());
  left.count = static_cast<std::uint32_t>(count);
  candidates_.insert(candidates_.end(), new_candidates_.begin(), new_candidates_.end());
  return found;
}

/// Checks the interval's pair around here, and subdivides the interval when that is undecided. False: the motion is not
/// free.
bool SceneWorkspace::process(const Interval& interval) {
  const Pair& pair = bodies_.pairs[interval.pair];
  if (is_still(pair)) return start_is_free_ || !in_contact(pair);
  if (reserve_ > 0.0 && std::ranges::find(close_, interval.pair, &ClosePair::number) != close_.end())
    return true;  // decided later
  if (reserve_ > 0.0 && table_proves(pair, interval.t - interval.half_width, interval.t + interval.half_width))
    return true;
  Undecided undecided;
  const CollisionStatus status = check_pair(interval, undecided);
  if (status == CollisionStatus::undecided) {
    if (undecided.parts > 0)
      subdivide(interval, undecided);
    else
      close_.push_back({interval.pair, interval.t});
  }
  return status != CollisionStatus::colliding;
}

/// Leaves the parts of the interval, each with its distance, for later.
void SceneWorkspace::subdivide(const Interval& whole, const Undecided& undecided) {
  const double part = whole.half_width / undecided.parts;
  for (int i = 0; i < undecided.parts; ++i) {
    const double from_start = (2 * i + 1) * part;
    next_.push_back({.t = whole.t - whole.half_width + from_start,
                     .half_width = part,
                     .pair = whole.pair,
                     .is_part = true,
                     .distance = undecided.distance,
                     .offset = std::abs(from_start - whole.half_width),
                     .candidates = undecided.candidates});
  }
}

bool SceneWorkspace::process_whole_motion_of(std::size_t body) {
  constexpr double half_width = 0.5;
  if (bodies_.moving[body].support & displacements_.active())
    return for_each_fixed_near(body, displacement_of_sphere(body, bodies_.moving[body].support, half_width),
                               [&](std::uint32_t pair) { return process({0.5, half_width, pair}); });
  if (start_is_free_) return true;
  return for_each_fixed_near(body, 0.0, [&](std::uint32_t pair) { return !in_contact(bodies_.pairs[pair]); });
}

/// Processes all pairs over the whole motion as one interval around its middle.
bool SceneWorkspace::process_whole_motion() {
  place_on_motion(0.5);
  for (std::size_t i = 0; i < bodies_.moving.size(); ++i)
    if (!process_whole_motion_of(i)) return false;
  return std::all_of(bodies_.moving_pairs.begin(), bodies_.moving_pairs.end(),
                     [&](std::uint32_t pair) { return process({0.5, 0.5, pair}); });
}

void SceneWorkspace::sort_open() {
  std::sort(open_.begin(), open_.end(), [](const Interval& a, const Interval& b) {
    return std::tie(a.t, a.half_width, a.pair) < std::tie(b.t, b.half_width, b.pair);
  });
}

/// Resolves the open intervals with Coal, then the pairs that come too close for these intervals.
bool SceneWorkspace::resolve_open() { return is_end_free() && resolve_intervals() && resolve_close(); }

/// Are the pairs that are open there apart at the end of the motion? Many a motion that is not free ends in contact.
bool SceneWorkspace::is_end_free() {
  constexpr double end = 1.0 - 1e-9;
  const auto is_open = [&](const Interval& interval) { return interval.t + interval.half_width > end; };
  if (std::none_of(open_.begin(), open_.end(), is_open)) return true;
  q_ = start_ + delta_;
  place(q_);
  return std::none_of(open_.begin(), open_.end(), [&](const Interval& interval) {
    return is_open(interval) && in_contact(bodies_.pairs[interval.pair]);
  });
}

/// Resolves the open intervals in order of t. Those of pairs still undecided are subdivided, level by level, so that
/// the samples of a level are placed once for all pairs and a contact is found early.
bool SceneWorkspace::resolve_intervals() {
  while (!open_.empty()) {
    if (open_.size() > many_intervals) return resolve_nearest_first();
    next_.clear();
    sort_open();
    for (std::size_t i = 0; i < open_.size();) {
      const double t = open_[i].t;
      place_sample(t);
      for (; i < open_.size() && open_[i].t == t; ++i)
        if (!process(open_[i])) return false;
    }
    std::swap(open_, next_);
  }
  return true;
}

/// Where two bodies pass each other within micrometres, a motion takes hundreds of intervals to prove, but few to
/// refute, or to see that the two come too close for these intervals, if those where they are nearest come first: the
/// one that holds `first`, then those nearest to where the distance is smallest.
bool SceneWorkspace::resolve_nearest_first(std::optional<double> first) {
  const auto order = [&](const Interval& one) {
    const bool holds_first = first && std::abs(one.t - *first) <= one.half_width;
    return std::tuple(!holds_first, one.distance, one.offset, one.t, one.half_width, one.pair);
  };
  const auto later = [&](const Interval& a, const Interval& b) { return order(a) > order(b); };
  std::make_heap(open_.begin(), open_.end(), later);
  while (!open_.empty()) {
    std::pop_heap(open_.begin(), open_.end(), later);
    const Interval interval = open_.back();
    open_.pop_back();
    place_sample(interval.t);
    next_.clear();
    if (!process(interval)) return false;
    for (const Interval& part : next_) {
      open_.push_back(part);
      std::push_heap(open_.begin(), open_.end(), later);
    }
  }
  return true;
}

void SceneWorkspace::place_sample(double t) {
  place_on_motion(t);
  interruption_point();
  if (deadline && ++samples_ % samples_per_deadline_check == 0 && deadline->expired()) throw MotionCheckStopped();
}

/// Decides pairs that come within proof_reserve of contact: by Coal alone, from the whole motion downwards.
bool SceneWorkspace::resolve_close() {
  reserve_ = 0.0;
  return std::ranges::all_of(close_, [&](const ClosePair& pair) {
    candidates_.clear();
    open_.assign(1, {0.5, 0.5, pair.number});
    return resolve_nearest_first(pair.t);
  });
}

/// Checks the whole motion by Coal's distances.
bool SceneWorkspace::resolve_with_coal() {
  displacements_.start_straight(delta_);
  next_.clear();
  if (!process_whole_motion()) return false;
  std::swap(open_, next_);
  return resolve_open();
}

bool SceneWorkspace::is_motion_free(const MotionQuery& query) {
  start_is_free_ = query.start_is_free;
  candidates_.clear();
  reserve_ = proof_reserve;
  close_.clear();
  if ((delta_.array() == 0.0).all()) {
    if (query.start_is_free) return true;
    place(start_);
    return is_free_here();
  }
  q_ = start_ + delta_;
  if (!model_.batch || !model_.spheres_reach(start_) || !model_.spheres_reach(q_)) return resolve_with_coal();
  if (query.spheres_only) {
    ++statistics.motions_by_spheres;
    return prove_with_spheres();
  }
  const CollisionStatus status = check_with_spheres();
  if (status == CollisionStatus::undecided) {
    displacements_.start_straight(delta_);
    return resolve_open();
  }
  ++statistics.motions_by_spheres;
  return status == CollisionStatus::free;
}

}  // namespace srmp::detail
