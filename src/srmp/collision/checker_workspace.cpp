#include "srmp/collision/checker_workspace.hpp"

#include <algorithm>
#include <cmath>

namespace srmp {

using detail::FixedBody;
using detail::MovingBody;
using detail::NarrowPhase;
using detail::Pair;
using detail::Placed;

namespace {

/// Meshes are not asked for a distance that is a smaller share of an interval's motion than this: it must be cut
/// anyway.
constexpr double rough_distance = 0.3;

/// An interval is cut into so many that the pair's distance could prove each, but no more than this.
constexpr int max_cuts = 16;
constexpr int samples_per_look = 32;  // at the clock

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Between two configurations; angles may be anything.
bool is_free_by_table(const Pair& pair, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  std::array<double, 2> low{}, high{};
  for (std::size_t i = 0; i < 2; ++i) {
    if (pair.table->joints[i] < 0) continue;
    const auto joint = static_cast<Eigen::Index>(pair.first_joint) + pair.table->joints[i];
    low[i] = std::min(a[joint], b[joint]) - 1e-9;
    high[i] = std::max(a[joint], b[joint]) + 1e-9;
    if (!(std::abs(low[i]) < 1e3 && std::abs(high[i]) < 1e3)) return false;
  }
  return pair.table->is_free(low, high);
}

std::span<const double> as_span(const Eigen::VectorXd& v) { return {v.data(), static_cast<std::size_t>(v.size())}; }

}  // namespace

Checker::Workspace::Workspace(const Impl& checker)
    : impl(checker), bodies_(checker.bodies), data_(checker.group.make_data()), narrow_(checker.bodies.formulas) {
  if (impl.batch) batch_ = impl.batch->make_workspace();
  span_of_.assign(bodies_.pairs.size(), {1.0, 0.0});
  open_.reserve(1024);
  next_.reserve(1024);
  const std::size_t actuated_joints = impl.group.actuated_joints().size(), moving = bodies_.moving.size();
  poses_.resize(moving);
  centers_.resize(moving);
  const auto dof = static_cast<Eigen::Index>(impl.group.joints().size());
  start_ = delta_ = q_ = here_ = Eigen::VectorXd::Zero(dof);
  active_drives_.reserve(actuated_joints);
  speed_.resize(actuated_joints);
  axes_.resize(actuated_joints);
  reach_.resize(moving * actuated_joints);
  reach_known_.resize(moving);
}

void Checker::Workspace::place(ConstVector q) {
  ++statistics.configurations;
  here_ = q;
  impl.group.forward(data_, q);
  for (std::size_t i = 0; i < poses_.size(); ++i) {
    const MovingBody& body = bodies_.moving[i];
    poses_[i] = detail::pose_of(body, impl.group, data_);
    centers_[i] = poses_[i] * body.bounds.center;
  }
}

Placed Checker::Workspace::placed(bool fixed, std::size_t i) const {
  if (!fixed) {
    const MovingBody& body = bodies_.moving[i];
    return {body.geometry.get(), body.parts.bvh.get(), body.bounds, poses_[i], centers_[i]};
  }
  const FixedBody& body = bodies_.fixed[i];
  return {body.geometry.get(), body.parts.bvh.get(), body.bounds, body.pose, body.center};
}

// --- one configuration

/// A lower bound of the pair's distance: a sphere around a, and a box or a sphere around b. Padding not counted.
double Checker::Workspace::gap(const Pair& pair) const {
  const Eigen::Vector3d& center = centers_[pair.a];
  const double radius = bodies_.moving[pair.a].bounds.radius;
  if (!pair.b_fixed) return (center - centers_[pair.b]).norm() - radius - bodies_.moving[pair.b].bounds.radius;
  const FixedBody& b = bodies_.fixed[pair.b];
  const Eigen::Vector3d local = b.pose.linear().transpose() * (center - b.pose.translation()) - b.bounds.box_center;
  return (local.cwiseAbs() - b.bounds.box_half).cwiseMax(0.0).norm() - radius;
}

/// What the distance of the pair is hardly more than, from its gap: there are points of a body all around its sphere's
/// middle, or near it.
double Checker::Workspace::farthest(const Pair& pair, double gap) const {
  const double a = bodies_.moving[pair.a].bounds.radius;
  return gap + 2.0 * (pair.b_fixed ? a : a + bodies_.moving[pair.b].bounds.radius);
}

double Checker::Workspace::ask(const Pair& pair, const Placed& a, const Placed& b, double margin, double enough) {
  ++statistics.narrow_phase;
  if (!a.pieces && !b.pieces) return narrow_.solids(pair.formula, a, b, margin);
  return narrow_.pieces(a, b, margin, enough);
}

/// A lower bound of the pair's distance, padding not counted, from convex solids around the two; infinity when it
/// exceeds `margin`. One that is more than `suffices` is not improved.
double Checker::Workspace::hull_distance(const Pair& pair, double margin, double suffices) {
  const Placed a = placed(false, pair.a), b = placed(pair.b_fixed, pair.b);
  const Placed solid_a{bodies_.moving[pair.a].solid, nullptr, a.bounds, a.pose, a.center};
  const Placed solid_b{body_b(pair).solid, nullptr, b.bounds, b.pose, b.center};
  double found = 0.0;
  if (solid_a.geometry && solid_b.geometry) found = ask(pair, solid_a, solid_b, margin, suffices);
  if (!pair.in_pieces || found > suffices) return found;
  if (solid_a.geometry && !solid_b.geometry) return ask(pair, solid_a, b, margin, suffices);
  if (solid_b.geometry && !solid_a.geometry) return ask(pair, a, solid_b, margin, suffices);
  return found;
}

/// The distance of the pair, padding not counted; infinity when it exceeds `margin`. Any that two of their points have
/// will do if it is at most `enough`.
double Checker::Workspace::distance(const Pair& pair, double margin, double enough) {
  return ask(pair, placed(false, pair.a), placed(pair.b_fixed, pair.b), margin, enough);
}

/// Does the pair's table prove the part of the motion?
bool Checker::Workspace::table_proves(const Pair& pair, double from, double to) {
  if (!pair.table) return false;
  const bool proved = is_free_by_table(pair, start_ + from * delta_, start_ + to * delta_);
  statistics.by_tables += proved;
  return proved;
}

/// Coal's verdict on the pair, padding counted. The hulls answer most of the time.
bool Checker::Workspace::in_contact(const Pair& pair, bool ask_tables) {
  if (gap(pair) > pair.padding + NarrowPhase::tolerance) return false;
  if (pair.table && ask_tables && is_free_by_table(pair, here_, here_)) return false;
  if (!pair.solid && hull_distance(pair, pair.padding + NarrowPhase::tolerance, infinity) == infinity) return false;
  return distance(pair, pair.padding, pair.padding + NarrowPhase::contact_distance) < infinity;
}

/// Visits the pairs of a moving body with those fixed bodies whose boxes come within `margin` plus padding of its
/// sphere.
template <class Visit>
bool Checker::Workspace::for_each_fixed_near(std::size_t body, double margin, Visit&& visit) {
  const MovingBody& moving = bodies_.moving[body];
  const double reach =
      moving.bounds.radius + moving.padding + bodies_.max_fixed_padding + margin + NarrowPhase::tolerance;
  const std::int32_t* row = bodies_.fixed_pair.data() + body * bodies_.fixed.size();
  return bodies_.tree.for_each_near(centers_[body], reach, [&](std::size_t fixed) {
    return row[fixed] < 0 || visit(static_cast<std::uint32_t>(row[fixed]));
  });
}

bool Checker::Workspace::is_free_here() {
  for (std::size_t i = 0; i < bodies_.moving.size(); ++i)
    if (!for_each_fixed_near(i, 0.0, [&](std::uint32_t pair) { return !in_contact(bodies_.pairs[pair]); }))
      return false;
  return std::none_of(bodies_.moving_pairs.begin(), bodies_.moving_pairs.end(),
                      [&](std::uint32_t pair) { return in_contact(bodies_.pairs[pair]); });
}

// --- motions

void Checker::Workspace::start_motion(ConstVector a, ConstVector b) {
  start_ = a;
  delta_ = b - a;
  for (std::size_t i = 0; i < impl.continuous.size(); ++i)
    if (impl.continuous[i]) delta_[i] = std::remainder(delta_[i], 2.0 * std::numbers::pi);
  active_ = 0;
  active_drives_.clear();
  const std::vector<ActuatedJoint>& actuated_joints = impl.group.actuated_joints();
  for (std::size_t k = actuated_joints.size(); k-- > 0;) {  // children first
    speed_[k] = std::abs(actuated_joints[k].ratio * delta_[static_cast<Eigen::Index>(actuated_joints[k].joint)]);
    if (speed_[k] == 0.0) continue;
    active_ |= std::uint64_t{1} << k;
    active_drives_.push_back(k);
  }
}

void Checker::Workspace::start_any_motion(std::uint64_t active) {
  active_ = active;
  active_drives_.clear();
  for (std::size_t k = impl.group.actuated_joints().size(); k-- > 0;)
    if (active >> k & 1) active_drives_.push_back(k);
}

void Checker::Workspace::place_in_range(ConstVector q, std::span<const double> change) {
  const std::vector<ActuatedJoint>& actuated_joints = impl.group.actuated_joints();
  for (std::size_t k : active_drives_)
    speed_[k] = std::abs(actuated_joints[k].ratio) * change[actuated_joints[k].joint];
  place_with_axes(q);
}

void Checker::Workspace::place_on_motion(double t) {
  q_ = start_ + t * delta_;
  place_with_axes(q_);
}

void Checker::Workspace::place_with_axes(ConstVector q) {
  place(q);
  for (std::size_t k : active_drives_) axes_[k] = impl.group.actuated_joint_axis(data_, k);
  std::fill(reach_known_.begin(), reach_known_.end(), 0);
}

/// The farthest that a point of the body may be from the drive's axis, here.
double Checker::Workspace::axis_reach(std::size_t body, std::size_t drive) {
  const std::size_t actuated_joints = speed_.size();
  double* reach = reach_.data() + body * actuated_joints;
  if (!reach_known_[body]) {
    for (std::size_t k : active_drives_)
      reach[k] = (centers_[body] - axes_[k].first).cross(axes_[k].second).norm() + bodies_.moving[body].bounds.radius;
    reach_known_[body] = 1;
  }
  return reach[drive];
}

/// How far any point of the body can get from where it is here, within `half_width` of the motion's parameter, by the
/// drives in `movers` alone. The drives are undone one after the other, deepest first: a drive turns about the axis it
/// has here, since all above it still stand as they do here, a body that the deeper ones moved by `moved` at most.
double Checker::Workspace::displacement(std::size_t body, std::uint64_t support, double half_width) {
  double moved = 0.0;
  for (std::size_t k : active_drives_) {
    if (!(support >> k & 1)) continue;
    const double change = speed_[k] * half_width;
    moved += impl.group.actuated_joints()[k].prismatic ? change : change * (axis_reach(body, k) + moved);
  }
  return moved;
}

double Checker::Workspace::approach(const Pair& pair, double half_width) {
  const double motion = displacement(pair.a, pair.support_a, half_width);
  return (pair.support_b & active_) ? motion + displacement(pair.b, pair.support_b, half_width) : motion;
}

/// Judges the pair over an interval around here: `cuts` is into how many parts it is to be cut when undecided.
Checker::Workspace::Judgement Checker::Workspace::judge(const Pair& pair, double half_width, int& cuts) {
  const double motion = approach(pair, half_width);
  const double margin = pair.padding + motion + NarrowPhase::tolerance;
  const double apart = gap(pair);
  cuts = 2;
  if (apart > margin) return Judgement::proved;
  const Judgement unproved = motion < motion_floor ? Judgement::contact : Judgement::undecided;
  if (motion > farthest(pair, apart)) {  // no need to ask what cannot be proved
    if (apart > pair.padding) return unproved;
    return in_contact(pair) ? Judgement::contact : unproved;
  }
  const auto cut_by = [&](double found) {
    while (cuts < max_cuts && motion > cuts * (found - pair.padding)) cuts *= 2;
    return unproved;
  };
  if (!pair.solid) {
    const double limit = margin + NarrowPhase::tolerance, found = hull_distance(pair, limit, limit - 0.9 * motion);
    if (found == infinity) return Judgement::proved;
    // Hulls a tenth of the motion apart prove it once it is cut: cheaper than asking the meshes.
    if (found > limit - 0.9 * motion && unproved == Judgement::undecided) return cut_by(found);
  }
  const double touching = pair.padding + NarrowPhase::contact_distance, enough = pair.padding + rough_distance * motion;
  const double found = distance(pair, margin, enough);
  if (found == infinity) return Judgement::proved;
  if (found <= touching || (!pair.solid && found <= enough && distance(pair, pair.padding, touching) < infinity))
    return Judgement::contact;
  return cut_by(found);
}

/// Judges the pair over an interval around here and remembers it when undecided; false when the motion is not free.
bool Checker::Workspace::take(std::uint32_t pair, double t, double half_width) {
  failed_.pair = pair;
  if (is_still(bodies_.pairs[pair])) return start_is_free_ || !in_contact(bodies_.pairs[pair]);
  if (table_proves(bodies_.pairs[pair], t - half_width, t + half_width)) return true;
  int cuts;
  const Judgement verdict = judge(bodies_.pairs[pair], half_width, cuts);
  if (verdict == Judgement::undecided) cut(t, half_width, pair, cuts);
  return verdict != Judgement::contact;
}

/// The pair is to be judged over each of so many parts of the interval.
void Checker::Workspace::cut(double t, double half_width, std::uint32_t pair, int cuts) {
  const double part = half_width / cuts;
  for (int i = 0; i < cuts; ++i) next_.push_back({t - half_width + (2 * i + 1) * part, part, pair});
}

bool Checker::Workspace::first_sample_of(std::size_t body) {
  constexpr double half_width = 0.5;
  if (bodies_.moving[body].support & active_)
    return for_each_fixed_near(body, displacement(body, bodies_.moving[body].support, half_width),
                               [&](std::uint32_t pair) { return take(pair, 0.5, half_width); });
  if (start_is_free_) return true;
  return for_each_fixed_near(body, 0.0, [&](std::uint32_t pair) {
    failed_.pair = pair;
    return !in_contact(bodies_.pairs[pair]);
  });
}

/// The whole motion as one interval around its middle.
bool Checker::Workspace::first_sample() {
  place_on_motion(0.5);
  for (std::size_t i = 0; i < bodies_.moving.size(); ++i)
    if (!first_sample_of(i)) return false;
  return std::all_of(bodies_.moving_pairs.begin(), bodies_.moving_pairs.end(),
                     [&](std::uint32_t pair) { return take(pair, 0.5, 0.5); });
}

void Checker::Workspace::sort_open() {
  std::sort(open_.begin(), open_.end(), [](const Interval& a, const Interval& b) {
    return std::tie(a.t, a.half_width, a.pair) < std::tie(b.t, b.half_width, b.pair);
  });
}

/// Settles the open intervals, in order of t. Those of pairs still undecided are cut, level by level, so that the
/// samples of a level are placed once for all pairs and a contact shows early.
bool Checker::Workspace::settle() {
  int samples = 0;
  while (!open_.empty()) {
    next_.clear();
    sort_open();
    for (std::size_t i = 0; i < open_.size();) {
      const double t = open_[i].t;
      place_on_motion(t);
      if (deadline && ++samples % samples_per_look == 0 && deadline->expired()) throw MotionCheckStopped();
      for (; i < open_.size() && open_[i].t == t; ++i)
        if (!take(open_[i].pair, t, open_[i].half_width)) {
          failed_ = open_[i];
          return false;
        }
    }
    std::swap(open_, next_);
  }
  return true;
}

/// What the spheres prove of the motion; what they leave open goes to open_.
CollisionStatus Checker::Workspace::ask_spheres() {
  const BatchChecker& batch = *impl.batch;
  const std::uint64_t blocks = batch.statistics(*batch_).blocks;
  const CollisionStatus verdict = batch.motion(as_span(start_), as_span(delta_), *batch_, impl.batch_options);
  statistics.blocks += batch.statistics(*batch_).blocks - blocks;
  open_.clear();
  if (verdict != CollisionStatus::undecided) return verdict;
  // One interval a pair, from the first to the last that is open: Coal proves a long one as readily as a short one.
  for (const UndecidedPair& u : batch.undecided(*batch_))
    for (std::uint32_t pair : impl.pairs_of(u)) {
      if (table_proves(bodies_.pairs[pair], u.t - u.half, u.t + u.half)) continue;
      auto& [low, high] = span_of_[pair];
      if (high < low) {
        open_.push_back({0.0, 0.0, pair});
        low = u.t - u.half;
      }
      high = u.t + u.half;
    }
  for (Interval& interval : open_) {
    auto& [low, high] = span_of_[interval.pair];
    interval.t = (low + high) / 2;
    interval.half_width = (high - low) / 2;
    low = 1.0;
    high = 0.0;
  }
  statistics.undecided += batch.undecided(*batch_).size();
  return open_.empty() ? CollisionStatus::free : verdict;
}

/// Do the spheres prove the motion free?
bool Checker::Workspace::spheres_prove() {
  const std::uint64_t blocks = impl.batch->statistics(*batch_).blocks;
  const bool proved = impl.batch->proves_free(as_span(start_), as_span(delta_), *batch_, impl.batch_options);
  statistics.blocks += impl.batch->statistics(*batch_).blocks - blocks;
  return proved;
}

/// The whole motion by Coal's distances.
bool Checker::Workspace::settle_by_coal() {
  next_.clear();
  failed_ = {0.5, 0.5, 0};
  if (!first_sample()) return false;
  std::swap(open_, next_);
  return settle();
}

bool Checker::Workspace::is_motion_free(bool start_is_free, bool spheres_only) {
  start_is_free_ = start_is_free;
  if (active_ == 0) {
    if (start_is_free) return true;
    place(start_);
    return is_free_here();
  }
  if (!impl.batch || !impl.spheres_reach(start_) || !impl.spheres_reach(start_ + delta_)) return settle_by_coal();
  if (spheres_only && !impl.has_tables()) {
    ++statistics.motions_by_spheres;
    return spheres_prove();
  }
  const CollisionStatus verdict = ask_spheres();
  if (verdict == CollisionStatus::undecided && !spheres_only) return settle();
  ++statistics.motions_by_spheres;
  return verdict == CollisionStatus::free;
}

// --- many configurations

/// Are the pairs that spheres left open apart at q?
bool Checker::Workspace::settle_lane(ConstVector q, std::span<const UndecidedPair> open) {
  place(q);
  for (const UndecidedPair& u : open)
    for (std::uint32_t pair : impl.pairs_of(u))
      if (in_contact(bodies_.pairs[pair])) return false;
  return true;
}

/// Up to 16 rows.
void Checker::Workspace::judge_block(ConstRows q, std::span<bool> free, bool spheres_only) {
  const BatchChecker& batch = *impl.batch;
  const auto lanes = batch.judge_block({q.data(), static_cast<std::size_t>(q.size())}, *batch_, spheres_only);
  ++statistics.blocks;
  std::span<const UndecidedPair> open = batch.undecided(*batch_);
  if (!spheres_only) statistics.undecided += open.size();
  for (std::size_t lane = 0; lane < free.size(); ++lane) {
    std::size_t count = 0;  // open pairs of this lane; they come in order of lanes
    while (count < open.size() && open[count].t == static_cast<double>(lane)) ++count;
    const bool undecided = lanes.undecided >> lane & 1;
    free[lane] = !undecided && !(lanes.colliding >> lane & 1);
    if (undecided && !spheres_only)
      free[lane] = settle_lane(q.row(static_cast<Eigen::Index>(lane)).transpose(), open.first(count));
    else
      ++statistics.states_by_spheres;
    open = open.subspan(count);
  }
}

}  // namespace srmp
