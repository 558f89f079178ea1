#include "srmp/collision/checker.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "srmp/collision/batch/batch_world.hpp"
#include "srmp/collision/bodies.hpp"
#include "srmp/collision/pair_table.hpp"
#include "srmp/core/error.hpp"
#include "srmp/robot/robot_cover.hpp"

namespace srmp {

using detail::Bodies;
using detail::FixedBody;
using detail::MovingBody;
using detail::NarrowPhase;
using detail::Pair;
using detail::Placed;
using detail::Proximity;

namespace {

/// Meshes are not asked for a distance that is a smaller share of an interval's motion than this: it must be cut
/// anyway.
constexpr double rough_distance = 0.3;

/// An interval is cut into so many that the pair's distance could prove each, but no more than this.
constexpr int most_cuts = 16;

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

/// Where balls are the bodies, they may as well look closely; elsewhere they stop early, because Coal settles what they
/// leave open, pair by pair, in less time than more blocks would take.
BatchChecker::MotionOptions batch_options(const BatchWorld& world) {
  const bool exact = std::all_of(world.bodies.begin(), world.bodies.end(), [](const auto& body) { return body.exact; });
  return {.step = 0.05, .refinements = exact ? 4 : 1, .max_blocks = 64};
}

std::span<const double> as_span(const Eigen::VectorXd& v) { return {v.data(), static_cast<std::size_t>(v.size())}; }

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g mm", 1e3 * metres);
  return text;
}

const char* kind_text(BodyKind kind) {
  switch (kind) {
    case BodyKind::link: return "link '";
    case BodyKind::object: return "object '";
    case BodyKind::attached_object: return "attached object '";
  }
  return "'";
}

}  // namespace

std::string Contact::describe() const {
  const std::string pair = kind_text(kind_a) + body_a + "' and " + kind_text(kind_b) + body_b + "'";
  const double gap = distance + padding;
  if (gap <= 0.0) return pair + " overlap by " + millimetres(-gap);
  if (distance <= 0.0)
    return pair + " are " + millimetres(gap) + " apart, less than their padding of " + millimetres(padding);
  return pair + " are " + millimetres(gap) + " apart";
}

struct Checker::Impl {
  Impl(const Scene& scene, const std::string& robot, const CheckerOptions& options)
      : group(scene, with_companions(robot, options.companions)),
        tables(tables_of(group, options)),
        bodies(scene, group, addresses(tables)),
        mode(options.mode) {
    for (const Joint& joint : group.joints()) continuous.push_back(joint.kind == JointKind::continuous);
    if (mode == CheckMode::coal) return;
    const auto covers = options.covers ? options.covers : std::make_shared<CoverStore>();
    for (const auto& [name, other] : scene.robots()) ensure_covered(*other.model, *covers);
    const detail::CoverOf cover_of = [&](const auto& shape) -> const GeometryCover& { return covers->cover(shape); };
    batch_scene = detail::make_batch_scene(bodies, group, cover_of);
    batch.emplace(batch_scene.world);
    batch_options = srmp::batch_options(batch_scene.world);
    for (auto* pairs : {&batch_scene.obstacle_pairs, &batch_scene.self_pairs})
      for (auto& ids : *pairs) std::sort(ids.begin(), ids.end());
  }

  /// The pairs of bodies that an undecided pair of the batch speaks for.
  const std::vector<std::uint32_t>& pairs_of(const UndecidedPair& pair) const {
    return (pair.self ? batch_scene.self_pairs : batch_scene.obstacle_pairs)[static_cast<std::size_t>(pair.pair)];
  }

  /// The balls' bounds hold for prismatic joints up to 1 m outside their limits (BatchDrive::max_travel).
  bool balls_reach(ConstVector q) const {
    for (std::size_t i = 0; i < group.joints().size(); ++i) {
      const Joint& joint = group.joints()[i];
      const double value = q[static_cast<Eigen::Index>(i)];
      if (joint.kind == JointKind::prismatic && (value < joint.lower - 1.0 || value > joint.upper + 1.0)) return false;
    }
    return true;
  }

  static std::vector<std::string> with_companions(const std::string& robot, std::vector<std::string> names) {
    names.insert(names.begin(), robot);
    return names;
  }

  using Tables = std::vector<std::shared_ptr<const PairTables>>;
  static Tables tables_of(const detail::RobotGroup& group, const CheckerOptions& options) {
    Tables tables(group.size());
    if (options.mode != CheckMode::coal && options.pair_tables)
      for (std::size_t i = 0; i < group.size(); ++i) {
        const RobotInstance& robot = group.instance(i);
        tables[i] = options.pair_tables->tables(robot.model, robot.parts);
      }
    return tables;
  }
  static std::vector<const PairTables*> addresses(const Tables& tables) {
    std::vector<const PairTables*> result;
    for (const auto& table : tables) result.push_back(table.get());
    return result;
  }

  detail::RobotGroup group;
  Tables tables;  // by member of the group
  Bodies bodies;
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
  double gap(const Pair& pair) const;
  bool table_proves(const Pair& pair, double from, double to);
  double hull_distance(const Pair& pair, double margin, double suffices);
  double distance(const Pair& pair, double margin, double enough);
  bool in_contact(const Pair& pair);
  bool is_free_here();
  template <class Visit>
  bool for_each_fixed_near(std::size_t body, double margin, Visit&& visit);

  // --- motions
  enum class Judgement { proved, contact, undecided };
  void start_motion(ConstVector a, ConstVector b);
  void place_on_motion(double t);
  double displacement(std::size_t body, std::uint64_t movers, double half_width);
  bool is_still(const Pair& pair) const { return ((pair.movers_a | pair.movers_b) & active_) == 0; }
  Judgement judge(const Pair& pair, double half_width, int& cuts);
  bool first_sample();
  bool first_sample_of(std::size_t body);
  Verdict ask_balls();
  void cut(double t, double half_width, std::uint32_t pair, int cuts);
  void sort_open();
  bool settle();
  bool take(std::uint32_t pair, double t, double half_width);
  bool is_motion_free(bool a_is_free);
  MotionCertificate certify_motion();
  bool settle_by_coal();
  bool settle_lane(ConstVector q, std::span<const UndecidedPair> open);
  void judge_block(ConstRows q, std::span<bool> free);

  // --- reports
  Placed placed(bool fixed, std::size_t index) const;
  Contact contact(const detail::Body& a, const detail::Body& b, const Proximity& found, double padding) const;

  const Impl& impl;
  CheckStatistics statistics;

 private:
  const detail::Body& body_b(const Pair& pair) const {
    if (pair.b_fixed) return bodies_.fixed[pair.b];
    return bodies_.moving[pair.b];
  }
  double ask(const Pair& pair, const Placed& a, const Placed& b, double margin, double enough);
  double axis_reach(std::size_t body, std::size_t drive);

  const Bodies& bodies_;
  detail::RobotGroup::Data data_;
  NarrowPhase narrow_;
  std::vector<Eigen::Isometry3d> poses_;  // of moving bodies
  std::vector<Eigen::Vector3d> centers_;  // of their bounding spheres
  Eigen::VectorXd start_, delta_, q_, here_;
  bool ask_tables_{true};
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

Checker::Workspace::Workspace(const Impl& checker)
    : impl(checker), bodies_(checker.bodies), data_(checker.group.make_data()), narrow_(checker.bodies.formulas) {
  if (impl.batch) batch_ = impl.batch->make_workspace();
  span_of_.assign(bodies_.pairs.size(), {1.0, 0.0});
  open_.reserve(1024);
  next_.reserve(1024);
  const std::size_t drives = impl.group.drives().size(), moving = bodies_.moving.size();
  poses_.resize(moving);
  centers_.resize(moving);
  const auto dof = static_cast<Eigen::Index>(impl.group.joints().size());
  start_ = delta_ = q_ = here_ = Eigen::VectorXd::Zero(dof);
  active_drives_.reserve(drives);
  speed_.resize(drives);
  axes_.resize(drives);
  reach_.resize(moving * drives);
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
    return {body.geometry.get(), body.parts.pieces.get(), body.bounds, poses_[i], centers_[i]};
  }
  const FixedBody& body = bodies_.fixed[i];
  return {body.geometry.get(), body.parts.pieces.get(), body.bounds, body.pose, body.center};
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

double Checker::Workspace::ask(const Pair& pair, const Placed& a, const Placed& b, double margin, double enough) {
  ++statistics.narrow_phase;
  if (!a.pieces && !b.pieces) return narrow_.solids(pair.formula, a, b, margin);
  return narrow_.pieces(a, b, margin, enough);
}

/// A lower bound of the pair's distance, padding not counted, from convex solids around the two; infinity when it
/// exceeds `margin`. One that is more than `suffices` is not improved.
double Checker::Workspace::hull_distance(const Pair& pair, double margin, double suffices) {
  const Placed a = placed(false, pair.a), b = placed(pair.b_fixed, pair.b);
  const Placed solid_a{bodies_.moving[pair.a].solid(), nullptr, a.bounds, a.pose, a.center};
  const Placed solid_b{body_b(pair).solid(), nullptr, b.bounds, b.pose, b.center};
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
  if (!pair.table || !ask_tables_) return false;
  const bool proved = is_free_by_table(pair, start_ + from * delta_, start_ + to * delta_);
  statistics.by_tables += proved;
  return proved;
}

/// Coal's verdict on the pair, padding counted. The hulls answer most of the time.
bool Checker::Workspace::in_contact(const Pair& pair) {
  if (gap(pair) > pair.padding + NarrowPhase::tolerance) return false;
  if (pair.table && ask_tables_ && is_free_by_table(pair, here_, here_)) return false;
  if (!pair.solid && hull_distance(pair, pair.padding + NarrowPhase::tolerance, infinity) == infinity) return false;
  return distance(pair, pair.padding, pair.padding + NarrowPhase::contact_distance) < infinity;
}

/// Visits the pairs of a moving body with those fixed bodies whose boxes come within `margin` plus padding of its
/// sphere.
template <class Visit>
bool Checker::Workspace::for_each_fixed_near(std::size_t body, double margin, Visit&& visit) {
  const MovingBody& moving = bodies_.moving[body];
  const double reach =
      moving.bounds.radius + moving.padding + bodies_.most_fixed_padding + margin + NarrowPhase::tolerance;
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
  const std::vector<Drive>& drives = impl.group.drives();
  for (std::size_t k = drives.size(); k-- > 0;) {  // children first
    speed_[k] = std::abs(drives[k].ratio * delta_[static_cast<Eigen::Index>(drives[k].joint)]);
    if (speed_[k] == 0.0) continue;
    active_ |= std::uint64_t{1} << k;
    active_drives_.push_back(k);
  }
}

void Checker::Workspace::place_on_motion(double t) {
  q_ = start_ + t * delta_;
  place(q_);
  for (std::size_t k : active_drives_) axes_[k] = impl.group.drive_axis(data_, k);
  std::fill(reach_known_.begin(), reach_known_.end(), 0);
}

/// The farthest that a point of the body may be from the drive's axis, here.
double Checker::Workspace::axis_reach(std::size_t body, std::size_t drive) {
  const std::size_t drives = speed_.size();
  double* reach = reach_.data() + body * drives;
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
double Checker::Workspace::displacement(std::size_t body, std::uint64_t movers, double half_width) {
  double moved = 0.0;
  for (std::size_t k : active_drives_) {
    if (!(movers >> k & 1)) continue;
    const double change = speed_[k] * half_width;
    moved += impl.group.drives()[k].prismatic ? change : change * (axis_reach(body, k) + moved);
  }
  return moved;
}

/// Judges the pair over an interval around here: `cuts` is into how many parts it is to be cut when undecided.
Checker::Workspace::Judgement Checker::Workspace::judge(const Pair& pair, double half_width, int& cuts) {
  double motion = displacement(pair.a, pair.movers_a, half_width);
  if (pair.movers_b & active_) motion += displacement(pair.b, pair.movers_b, half_width);
  const double margin = pair.padding + motion + NarrowPhase::tolerance;
  const double apart = gap(pair);
  cuts = 2;
  if (apart > margin) return Judgement::proved;
  const Judgement unproved = motion < motion_floor ? Judgement::contact : Judgement::undecided;
  // The middle of a body is hardly farther than this; no need to ask what cannot be proved.
  if (motion > apart + 2 * bodies_.moving[pair.a].bounds.radius) {
    if (apart > pair.padding) return unproved;
    return in_contact(pair) ? Judgement::contact : unproved;
  }
  const auto cut_by = [&](double found) {
    while (cuts < most_cuts && motion > cuts * (found - pair.padding)) cuts *= 2;
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
  if (bodies_.moving[body].movers & active_)
    return for_each_fixed_near(body, displacement(body, bodies_.moving[body].movers, half_width),
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
  while (!open_.empty()) {
    next_.clear();
    sort_open();
    for (std::size_t i = 0; i < open_.size();) {
      const double t = open_[i].t;
      place_on_motion(t);
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

/// What the balls prove of the motion; what they leave open goes to open_.
Verdict Checker::Workspace::ask_balls() {
  const BatchChecker& batch = *impl.batch;
  const std::uint64_t blocks = batch.statistics(*batch_).blocks;
  const Verdict verdict = batch.motion(as_span(start_), as_span(delta_), *batch_, impl.batch_options);
  statistics.blocks += batch.statistics(*batch_).blocks - blocks;
  open_.clear();
  if (verdict != Verdict::undecided) return verdict;
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
  return open_.empty() ? Verdict::free : verdict;
}

/// The whole motion by Coal's distances.
bool Checker::Workspace::settle_by_coal() {
  next_.clear();
  failed_ = {0.5, 0.5, 0};
  if (!first_sample()) return false;
  std::swap(open_, next_);
  return settle();
}

bool Checker::Workspace::is_motion_free(bool a_is_free) {
  start_is_free_ = a_is_free;
  if (active_ == 0) {
    if (a_is_free) return true;
    place(start_);
    return is_free_here();
  }
  if (!impl.batch || !impl.balls_reach(start_) || !impl.balls_reach(start_ + delta_)) return settle_by_coal();
  const Verdict verdict = ask_balls();
  if (verdict == Verdict::undecided && impl.mode != CheckMode::conservative) return settle();
  ++statistics.motions_by_balls;
  return verdict == Verdict::free;
}

MotionCertificate Checker::Workspace::certify_motion() {
  start_is_free_ = false;
  ask_tables_ = false;
  MotionCertificate certificate;
  certificate.proved = settle_by_coal();
  ask_tables_ = true;
  if (certificate.proved) return certificate;
  const Pair& pair = bodies_.pairs[failed_.pair];
  certificate.from = failed_.t - failed_.half_width;
  certificate.to = failed_.t + failed_.half_width;
  certificate.body_a = bodies_.moving[pair.a].name;
  certificate.body_b = pair.b_fixed ? bodies_.fixed[pair.b].name : bodies_.moving[pair.b].name;
  return certificate;
}

// --- many configurations

/// Are the pairs that balls left open apart at q?
bool Checker::Workspace::settle_lane(ConstVector q, std::span<const UndecidedPair> open) {
  place(q);
  for (const UndecidedPair& u : open)
    for (std::uint32_t pair : impl.pairs_of(u))
      if (in_contact(bodies_.pairs[pair])) return false;
  return true;
}

/// Up to 16 rows.
void Checker::Workspace::judge_block(ConstRows q, std::span<bool> free) {
  const BatchChecker& batch = *impl.batch;
  const auto lanes = batch.judge_block({q.data(), static_cast<std::size_t>(q.size())}, *batch_);
  ++statistics.blocks;
  std::span<const UndecidedPair> open = batch.undecided(*batch_);
  statistics.undecided += open.size();
  for (std::size_t lane = 0; lane < free.size(); ++lane) {
    std::size_t count = 0;  // open pairs of this lane; they come in order of lanes
    while (count < open.size() && open[count].t == static_cast<double>(lane)) ++count;
    const bool undecided = lanes.undecided >> lane & 1;
    free[lane] = !undecided && !(lanes.colliding >> lane & 1);
    if (undecided && impl.mode == CheckMode::exact)
      free[lane] = settle_lane(q.row(static_cast<Eigen::Index>(lane)).transpose(), open.first(count));
    else
      ++statistics.states_by_balls;
    open = open.subspan(count);
  }
}

// --- the public face

Checker::Checker(const Scene& scene, const std::string& robot, const CheckerOptions& options)
    : impl_(std::make_unique<const Impl>(scene, robot, options)) {}
Checker::~Checker() = default;

const RobotModel& Checker::robot() const { return impl_->group.model(0); }
std::size_t Checker::dof() const { return impl_->group.joints().size(); }
const Pose& Checker::base() const { return impl_->group.instance(0).base; }
CheckMode Checker::mode() const { return impl_->mode; }

void Checker::WorkspaceDeleter::operator()(Workspace* workspace) const { delete workspace; }

Checker::WorkspacePtr Checker::make_workspace() const { return WorkspacePtr(new Workspace(*impl_)); }

const CheckStatistics& Checker::statistics(const Workspace& workspace) const { return workspace.statistics; }

bool Checker::is_free(ConstVector q, Workspace& workspace) const {
  impl_->group.require_configuration(q, "configuration");
  ++workspace.statistics.states;
  if (!impl_->bodies.overlaps.empty()) return false;
  workspace.place(q);
  return workspace.is_free_here();
}

bool Checker::is_motion_free(ConstVector a, ConstVector b, Workspace& workspace, bool a_is_free) const {
  impl_->group.require_configuration(a, "start of the motion");
  impl_->group.require_configuration(b, "end of the motion");
  ++workspace.statistics.motions;
  if (!impl_->bodies.overlaps.empty()) return false;
  workspace.start_motion(a, b);
  return workspace.is_motion_free(a_is_free);
}

void Checker::are_free(ConstRows q, std::span<bool> free, Workspace& workspace) const {
  if (free.size() != static_cast<std::size_t>(q.rows()))
    throw InvalidArgument("are_free: there are " + std::to_string(q.rows()) + " configurations, but room for " +
                          std::to_string(free.size()) + " answers");
  for (Eigen::Index i = 0; i < q.rows(); ++i)
    if (q.cols() != static_cast<Eigen::Index>(dof()) || !q.row(i).allFinite())
      impl_->group.require_configuration(q.row(i).transpose(), "configuration " + std::to_string(i));
  workspace.statistics.states += free.size();
  if (!impl_->bodies.overlaps.empty()) {
    std::fill(free.begin(), free.end(), false);
    return;
  }
  bool by_balls = impl_->batch.has_value();
  for (Eigen::Index i = 0; i < q.rows() && by_balls; ++i) by_balls = impl_->balls_reach(q.row(i).transpose());
  if (!by_balls) {
    for (std::size_t i = 0; i < free.size(); ++i) {
      workspace.place(q.row(static_cast<Eigen::Index>(i)).transpose());
      free[i] = workspace.is_free_here();
    }
    return;
  }
  for (std::size_t first = 0; first < free.size(); first += BatchChecker::block) {
    const std::size_t count = std::min<std::size_t>(BatchChecker::block, free.size() - first);
    workspace.judge_block(q.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count)),
                          free.subspan(first, count));
  }
}

MotionCertificate Checker::certify_motion(ConstVector a, ConstVector b, Workspace& workspace) const {
  impl_->group.require_configuration(a, "start of the motion");
  impl_->group.require_configuration(b, "end of the motion");
  ++workspace.statistics.motions;
  if (!impl_->bodies.overlaps.empty()) {
    const std::vector<Contact> rigid = contacts(a, workspace);
    return {false, 0.0, 1.0, rigid.front().body_a, rigid.front().body_b};
  }
  workspace.start_motion(a, b);
  return workspace.certify_motion();
}

Contact Checker::Workspace::contact(const detail::Body& a, const detail::Body& b, const Proximity& found,
                                    double padding) const {
  const Pose& base = impl.group.instance(0).base;
  return {a.name, b.name, found.distance - padding, base * found.point_a, base * found.point_b, padding,
          a.kind, b.kind};
}

namespace {

const detail::Body& body_of(const Bodies& bodies, bool fixed, std::size_t index) {
  if (fixed) return bodies.fixed[index];
  return bodies.moving[index];
}

/// One entry a pair of bodies, the deepest; deepest first, then by name.
void tidy(std::vector<Contact>& contacts) {
  const auto names = [](const Contact& c) { return std::tie(c.body_a, c.body_b); };
  std::stable_sort(contacts.begin(), contacts.end(), [&](const Contact& a, const Contact& b) {
    return names(a) != names(b) ? names(a) < names(b) : a.distance < b.distance;
  });
  const auto same = [&](const Contact& a, const Contact& b) { return names(a) == names(b); };
  contacts.erase(std::unique(contacts.begin(), contacts.end(), same), contacts.end());
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const Contact& a, const Contact& b) { return a.distance < b.distance; });
}

}  // namespace

std::vector<Contact> Checker::contacts(ConstVector q, Workspace& workspace) const {
  impl_->group.require_configuration(q, "configuration");
  const Bodies& bodies = impl_->bodies;
  workspace.place(q);
  std::vector<Contact> contacts;
  const auto add = [&](bool a_fixed, std::size_t a, bool b_fixed, std::size_t b, double padding) {
    const Proximity found = NarrowPhase::deepest(workspace.placed(a_fixed, a), workspace.placed(b_fixed, b), padding);
    contacts.push_back(workspace.contact(body_of(bodies, a_fixed, a), body_of(bodies, b_fixed, b), found, padding));
  };
  for (const detail::RigidOverlap& overlap : bodies.overlaps)
    add(overlap.a_fixed, overlap.a, overlap.b_fixed, overlap.b, 0.0);
  for (const Pair& pair : bodies.pairs)
    if (workspace.in_contact(pair)) add(false, pair.a, pair.b_fixed, pair.b, pair.padding);
  tidy(contacts);
  return contacts;
}

std::optional<Contact> Checker::nearest(ConstVector q, Workspace& workspace) const {
  std::vector<Contact> in_contact = contacts(q, workspace);
  if (!in_contact.empty()) return in_contact.front();
  const Bodies& bodies = impl_->bodies;
  std::vector<std::pair<double, std::size_t>> order;  // by the lower bound, so that most are never asked
  for (std::size_t i = 0; i < bodies.pairs.size(); ++i)
    order.emplace_back(workspace.gap(bodies.pairs[i]) - bodies.pairs[i].padding, i);
  std::sort(order.begin(), order.end());
  double least = infinity;
  const Pair* pair = nullptr;
  for (const auto& [bound, i] : order) {
    if (bound > least) break;
    const Pair& next = bodies.pairs[i];
    const double apart = workspace.distance(next, least + next.padding, 0.0) - next.padding;
    if (apart >= least) continue;
    least = apart;
    pair = &next;
  }
  if (!pair) return std::nullopt;
  const Proximity found =
      NarrowPhase::distance(workspace.placed(false, pair->a), workspace.placed(pair->b_fixed, pair->b));
  return workspace.contact(bodies.moving[pair->a], body_of(bodies, pair->b_fixed, pair->b), found, pair->padding);
}

}  // namespace srmp
