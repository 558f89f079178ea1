#include "srmp/collision/batch/batch_checker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>
#include <numbers>
#include <tuple>
#include <utility>

#include "srmp/collision/batch/batch_model.hpp"
#include "srmp/core/error.hpp"

namespace srmp {

using batch::kLanes;

namespace {

struct FreeAligned {
  void operator()(float* p) const { ::operator delete[](p, std::align_val_t{64}); }
};
using AlignedFloats = std::unique_ptr<float[], FreeAligned>;
/// Not initialized: what no check needs takes no memory.
AlignedFloats aligned_floats(std::size_t count) { return AlignedFloats(new (std::align_val_t{64}) float[count]); }
AlignedFloats zeros(std::size_t count) {
  AlignedFloats floats = aligned_floats(count);
  std::fill_n(floats.get(), count, 0.0f);
  return floats;
}

/// Memory of this thread that a check needs while it runs, at least so many floats: what one check leaves there, in the
/// processor's caches, the next one overwrites. It is kept until the thread ends.
float* scratch_of_thread(std::size_t count) {
  thread_local AlignedFloats floats;
  thread_local std::size_t size = 0;
  if (size < count) {
    floats = aligned_floats(count);
    size = count;
  }
  return floats.get();
}

struct Interval {
  double t, half;
};

/// The full turns nearest to an angle [rad].
double whole_turns(double angle) {
  constexpr double turn = 2 * std::numbers::pi;
  return std::abs(angle) < 3.0 ? 0.0 : turn * std::nearbyint(angle / turn);  // mostly there are none
}

/// The first intervals of a motion are checked in rounds, one of each of its parts, from its end, so that collisions
/// show early. AVX2 checks a round at a time.
constexpr int kParts = 8;
constexpr std::array<int, kParts> part_order{7, 3, 5, 1, 6, 2, 4, 0};

}  // namespace

BatchChecker::BatchChecker(const BatchWorld& world, SimdBackend backend)
    : BatchChecker(std::make_shared<const BatchRobotModel>(world), world, backend) {}

BatchChecker::BatchChecker(std::shared_ptr<const BatchRobotModel> robot, const BatchPairs& pairs, SimdBackend backend)
    : impl_(std::make_unique<const BatchModel>(std::move(robot), pairs, backend)) {}

BatchChecker::BatchChecker(const BatchChecker& before, const BatchPairs& pairs, std::span<const int> known)
    : impl_(std::make_unique<const BatchModel>(*before.impl_, pairs, known)) {}

BatchChecker::~BatchChecker() = default;
BatchChecker::BatchChecker(BatchChecker&&) noexcept = default;
std::size_t BatchChecker::dof() const { return impl_->robot->dof; }
SimdBackend BatchChecker::backend() const { return impl_->backend; }
double BatchChecker::error_bound() const { return impl_->robot->error_bound; }

// --- Checks

class BatchChecker::Workspace {
 public:
  explicit Workspace(const BatchModel& impl)
      : values(zeros(impl.robot->actuated_joints.size() * kLanes + kLanes)),
        half_widths(zeros(impl.robot->actuated_joints.size() * kLanes + kLanes)),
        pair_lanes(impl.pair_obstacles.size() + impl.self_pairs.size(), 0),
        undecided_pairs(pair_lanes.size()),
        is_open(pair_lanes.size(), 0),
        is_open_body(static_cast<std::size_t>(impl.view().body_count), 0),
        start(impl.robot->actuated_joints.size()),
        delta(impl.robot->actuated_joints.size()),
        view(impl.view()) {
    undecided.reserve(1024);
    open.reserve(4096);
    next.reserve(4096);
    open_pairs.reserve(1024);
    next_open_pairs.reserve(1024);
  }

  AlignedFloats values, half_widths;
  std::vector<batch::LaneMask> pair_lanes;
  std::vector<batch::KernelPair> undecided_pairs;  // of the last run
  // Of the levels of a motion after the first: pairs to be checked at this one, and at the next, and the former's
  // bodies.
  std::vector<batch::KernelPair> open_pairs, next_open_pairs;  // a pair of several blocks is there several times
  std::vector<char> is_open, is_open_body;
  // Of each actuated joint: its value at the start, less full turns so that the motion is near 0, and its change.
  std::vector<double> start, delta;
  batch::KernelModel view;
  std::vector<UndecidedPair> undecided;
  std::vector<Interval> open, next;
  std::array<Interval, kLanes> lanes;
  static constexpr int motion_hits = 5;     // tested first for each motion: more take longer than they save
  std::array<batch::KernelHit, 64> hits{};  // the first hit_count of them; the last ones come first
  int hit_count{};
  std::ptrdiff_t next_displaced{};  // of those after the first ones, counted on
  BatchStatistics statistics;

  enum class Pairs { all, not_deferred, open };
  struct RunOptions {
    bool moving{};  // within the half widths; false: exactly at the values
    bool proofs_only{};
    unsigned decisive{};
    Pairs pairs{Pairs::all};
    std::size_t used{kLanes};  // lanes that are not copies of the one before
    bool only_hits{};          // of the last ones
  };
  batch::KernelResult run(const BatchModel& impl, const RunOptions& options) {
    ++statistics.blocks;
    batch::KernelResult result{0, 0, {}, pair_lanes.data(), undecided_pairs.data(), 0};
    const bool looks_for_hits = options.only_hits || (options.moving && !options.proofs_only);
    const bool only_open = options.pairs == Pairs::open;
    const int likely = options.only_hits ? hit_count : std::min(hit_count, motion_hits);
    const char* without_deferred =
        options.pairs == Pairs::not_deferred && !impl.not_deferred.empty() ? impl.not_deferred.data() : nullptr;
    const batch::KernelRequest request{values.get(),
                                       options.moving ? half_widths.get() : nullptr,
                                       !options.moving,
                                       options.proofs_only,
                                       static_cast<batch::LaneMask>(options.decisive),
                                       only_open ? is_open.data() : without_deferred,
                                       only_open ? is_open_body.data() : nullptr,
                                       hits.data(),
                                       looks_for_hits ? likely : 0,
                                       options.only_hits,
                                       static_cast<int>(options.used)};
    impl.kernel(view, request, scratch(), result);
    if (looks_for_hits && result.colliding) note_hit(result.hit);
    return result;
  }

  float* scratch() const { return scratch_of_thread(static_cast<std::size_t>(batch::scratch_floats(view))); }

  /// To the front: motions that are checked one after the other are often stopped by the same bodies. What leaves the
  /// first ones takes the place of what joins them.
  void note_hit(const batch::KernelHit& hit) {
    const auto same = [&](const batch::KernelHit& known) {
      return known.of.pair == hit.of.pair && known.sphere == hit.sphere && known.other == hit.other;
    };
    const auto found = std::find_if(hits.begin(), hits.begin() + hit_count, same);
    auto place = found - hits.begin();
    if (place == std::ssize(hits))
      place = motion_hits + next_displaced++ % (std::ssize(hits) - motion_hits);
    else if (place == hit_count)
      ++hit_count;
    const auto last = std::min<std::ptrdiff_t>(place, motion_hits - 1);
    hits[static_cast<std::size_t>(place)] = hits[static_cast<std::size_t>(last)];
    hits[static_cast<std::size_t>(last)] = hit;
    std::rotate(hits.begin(), hits.begin() + last, hits.begin() + last + 1);
  }

  /// Moves the kernel's report into `undecided`, for those of the lanes `used` that do not collide; `at(lane)` is the
  /// interval of a lane.
  template <class At>
  void collect(const BatchModel& impl, const batch::KernelResult& result, unsigned used, At&& at) {
    used &= ~static_cast<unsigned>(result.colliding);
    for (const batch::KernelPair& undecided_pair : pairs_of(result)) {
      const unsigned lanes = take_lanes(undecided_pair) & used;
      if (lanes == 0) continue;
      const bool self = undecided_pair.body < 0;
      const int pair = self ? undecided_pair.pair - view.pair_count : impl.pair_ids[undecided_pair.pair];
      for (int lane = 0; lane < kLanes; ++lane)
        if (lanes >> lane & 1) undecided.push_back({at(lane).t, at(lane).half, self, pair});
    }
  }

  /// Forgets the kernel's report, except for which pairs are undecided in lanes `used`.
  void keep_open_pairs(const batch::KernelResult& result, unsigned used) {
    for (const batch::KernelPair& pair : pairs_of(result))
      if (take_lanes(pair) & used) next_open_pairs.push_back(pair);
  }

  /// What a part of a motion proves free is free in all parts of that part.
  void begin_level() {
    const auto set = [&](char open) {
      for (const auto& [pair, body] : open_pairs) {
        is_open[pair] = open;
        if (body >= 0) {
          is_open_body[body] = open;
        } else {
          const batch::KernelSelfPair& self_pair = view.self_pairs[pair - view.pair_count];
          is_open_body[self_pair.a] = is_open_body[self_pair.b] = open;
        }
      }
    };
    set(0);
    std::swap(open_pairs, next_open_pairs);
    next_open_pairs.clear();
    set(1);
  }

  std::span<const batch::KernelPair> pairs_of(const batch::KernelResult& result) const {
    return {undecided_pairs.data(), static_cast<std::size_t>(result.undecided_count)};
  }
  batch::LaneMask take_lanes(const batch::KernelPair& pair) {
    return std::exchange(pair_lanes[pair.pair], batch::LaneMask{0});
  }
  void forget(const batch::KernelResult& result) {
    for (const batch::KernelPair& pair : pairs_of(result)) take_lanes(pair);
  }

  void set_motion(const BatchModel& impl, std::span<const double> a, std::span<const double> difference) {
    for (std::size_t k = 0; k < start.size(); ++k) {
      const BatchActuatedJoint& actuated = impl.robot->actuated_joints[k];
      start[k] = actuated.ratio * a[actuated.joint] + actuated.offset;
      delta[k] = actuated.ratio * difference[actuated.joint];
      if (!actuated.prismatic) start[k] -= whole_turns(start[k] + 0.5 * delta[k]);
    }
  }

  /// Sets the lanes to the first of `from`, up to a full block; the last one fills what is left. Returns how many there
  /// were.
  std::size_t set_lanes(std::span<const Interval> from) {
    const std::size_t count = std::min<std::size_t>(kLanes, from.size());
    for (std::size_t i = 0; i < kLanes; ++i) lanes[i] = from[std::min(i, count - 1)];
    const bool same = std::ranges::all_of(lanes, [&](const Interval& lane) { return lane.half == lanes[0].half; });
    for (std::size_t k = 0; k < start.size(); ++k) {
      const double at = start[k], change = delta[k];
      float *to_values = values.get() + k * kLanes, *to_widths = half_widths.get() + k * kLanes;
      for (int i = 0; i < kLanes; ++i) to_values[i] = static_cast<float>(at + lanes[i].t * change);
      // A little wider: for the float rounding of this number and of the bound made of it.
      const auto half_width = [&](double half) {
        return static_cast<float>(change * half * (1 + 1e-4) + std::copysign(1e-12, change));
      };
      if (same)
        std::fill_n(to_widths, kLanes, half_width(lanes[0].half));
      else
        std::ranges::transform(lanes, to_widths, [&](const Interval& lane) { return half_width(lane.half); });
    }
    return count;
  }

  /// Appends the four parts of each of those lanes.
  void subdivide(unsigned undecided_lanes, std::vector<Interval>& parts) const {
    for (std::size_t i = 0; i < kLanes; ++i)
      if (undecided_lanes >> i & 1)
        for (int part : {-3, -1, 1, 3})
          parts.push_back({lanes[i].t + 0.25 * part * lanes[i].half, 0.25 * lanes[i].half});
  }
};

void BatchChecker::WorkspaceDeleter::operator()(Workspace* workspace) const { delete workspace; }
BatchChecker::WorkspacePtr BatchChecker::make_workspace() const { return WorkspacePtr(new Workspace(*impl_)); }
const std::vector<UndecidedPair>& BatchChecker::undecided(const Workspace& workspace) const {
  return workspace.undecided;
}
const BatchStatistics& BatchChecker::statistics(const Workspace& workspace) const { return workspace.statistics; }

namespace {

void require_size(std::size_t size, std::size_t dof, const char* what) {
  if (size != dof)
    throw InvalidArgument(std::string(what) + " has " + std::to_string(size) + " entries, the robot has " +
                          std::to_string(dof) + " joints");
}

bool by_time_and_pair(const UndecidedPair& a, const UndecidedPair& b) {
  return std::tie(a.t, a.self, a.pair) < std::tie(b.t, b.self, b.pair);
}

}  // namespace

/// Sets the lanes to the configurations; the last one fills what is left. Returns how many there are.
std::size_t BatchChecker::set_block(std::span<const double> configurations, Workspace& w) const {
  const std::size_t n = dof(), count = n ? configurations.size() / n : 0;
  if (n == 0 || count * n != configurations.size() || count == 0 || count > block)
    throw InvalidArgument("batch checker: a block holds 1 to 16 configurations of " + std::to_string(n) + " entries");
  for (std::size_t k = 0; k < impl_->robot->actuated_joints.size(); ++k) {
    const BatchActuatedJoint& actuated = impl_->robot->actuated_joints[k];
    for (std::size_t i = 0; i < kLanes; ++i) {
      double value = actuated.ratio * configurations[std::min(i, count - 1) * n + actuated.joint] + actuated.offset;
      if (!actuated.prismatic) value -= whole_turns(value);
      w.values[k * kLanes + i] = static_cast<float>(value);
    }
  }
  return count;
}

std::uint16_t BatchChecker::find_likely_hits(std::span<const double> configurations, Workspace& w) const {
  if (w.hit_count == 0) return 0;
  const std::size_t count = set_block(configurations, w);
  const unsigned used = (1u << count) - 1;
  return static_cast<std::uint16_t>(w.run(*impl_, {.used = count, .only_hits = true}).colliding & used);
}

BatchChecker::Lanes BatchChecker::check_block(std::span<const double> configurations, Workspace& w,
                                              const BlockOptions& options) const {
  w.undecided.clear();
  const std::size_t count = set_block(configurations, w);
  const unsigned used = (1u << count) - 1;
  const batch::KernelResult result = w.run(*impl_, {.proofs_only = options.proofs_only, .used = count});
  w.collect(*impl_, result, used, [](int lane) { return Interval{static_cast<double>(lane), 0}; });
  std::sort(w.undecided.begin(), w.undecided.end(), by_time_and_pair);
  const unsigned colliding = result.colliding & used;
  return {static_cast<std::uint16_t>(colliding), static_cast<std::uint16_t>(result.undecided & used & ~colliding)};
}

CollisionStatus BatchChecker::motion_block(std::span<const double> a, std::span<const double> difference,
                                           Workspace& w) const {
  return motion(a, difference, w, {.step = std::numeric_limits<double>::infinity(), .refinements = 0, .max_blocks = 1});
}

/// Sets up the first intervals, all of one length.
void BatchChecker::begin_motion(std::span<const double> a, std::span<const double> difference, Workspace& w,
                                const MotionOptions& options) const {
  require_size(a.size(), dof(), "batch checker: start of the motion");
  require_size(difference.size(), dof(), "batch checker: difference of the motion");
  ++w.statistics.motions;
  w.undecided.clear();
  w.next_open_pairs.clear();
  w.set_motion(*impl_, a, difference);
  double length = 0;
  for (std::size_t k = 0; k < w.delta.size(); ++k) length += std::abs(w.delta[k]) * impl_->robot->actuated_reach[k];
  const int rounds = static_cast<int>(std::clamp(std::ceil(length / (2 * options.step * kParts)), 1.0, 128.0));
  const double half = 0.5 / (rounds * kParts);
  w.open.resize(static_cast<std::size_t>(rounds * kParts));
  auto next = w.open.begin();
  for (int round = rounds - 1; round >= 0; --round)
    for (const int part : part_order) *next++ = {(2 * (part * rounds + round) + 1) * half, half};
}

CollisionStatus BatchChecker::motion(std::span<const double> a, std::span<const double> difference, Workspace& w,
                                     const MotionOptions& options) const {
  begin_motion(a, difference, w, options);
  return check_levels(w, options, false);
}

CollisionStatus BatchChecker::motion_of_pairs(std::span<const double> a, std::span<const double> difference,
                                              Workspace& w, const MotionOptions& options,
                                              std::span<const int> self_pairs) const {
  begin_motion(a, difference, w, options);
  for (const int pair : self_pairs) {
    if (pair < 0 || pair >= w.view.self_pair_count)
      throw InvalidArgument("batch checker: there is no self pair " + std::to_string(pair) + "; there are " +
                            std::to_string(w.view.self_pair_count));
    w.next_open_pairs.push_back({w.view.pair_count + pair, -1});
  }
  return check_levels(w, options, true);
}

/// Of the motion that begin_motion set up: of all pairs that are not deferred, or of those in next_open_pairs.
CollisionStatus BatchChecker::check_levels(Workspace& w, const MotionOptions& options, bool only_open) const {
  int blocks = 0;
  for (int level = 0; !w.open.empty(); ++level) {
    w.next.clear();
    const bool of_open = only_open || level > 0;
    if (of_open) w.begin_level();
    const bool last = level >= options.refinements || blocks >= options.max_blocks;
    for (std::size_t first = 0; first < w.open.size(); first += kLanes) {
      const std::size_t count = w.set_lanes(std::span(w.open).subspan(first));
      const unsigned used = (1u << count) - 1;
      ++blocks;
      const auto pairs = of_open ? Workspace::Pairs::open : Workspace::Pairs::not_deferred;
      const batch::KernelResult result = w.run(*impl_, {.moving = true, .pairs = pairs, .used = count});
      if (result.colliding) {
        w.forget(result);
        w.undecided.clear();
        ++w.statistics.motions_colliding;
        return CollisionStatus::colliding;
      }
      if (last) {
        w.collect(*impl_, result, used, [&](int lane) { return w.lanes[lane]; });
        continue;
      }
      if (result.undecided == 0) continue;
      w.keep_open_pairs(result, used);
      w.subdivide(result.undecided & used, w.next);
    }
    if (last) break;
    std::swap(w.open, w.next);
  }
  std::sort(w.undecided.begin(), w.undecided.end(), by_time_and_pair);
  const bool free = w.undecided.empty();
  ++(free ? w.statistics.motions_free : w.statistics.motions_undecided);
  return free ? CollisionStatus::free : CollisionStatus::undecided;
}

bool BatchChecker::proves_free(std::span<const double> a, std::span<const double> difference, Workspace& w,
                               const MotionOptions& options) const {
  begin_motion(a, difference, w, options);
  // The parts subdivided last are checked first, so that a part that cannot be proved is found early.
  std::reverse(w.open.begin(), w.open.end());
  const double first = w.open.front().half, finest = 1.5 * first * std::pow(0.25, options.refinements);
  for (int blocks = 0; !w.open.empty(); ++blocks) {
    const bool over_budget = blocks >= options.max_blocks;
    const std::size_t count = w.set_lanes(std::span(w.open).last(std::min<std::size_t>(kLanes, w.open.size())));
    w.open.resize(w.open.size() - count);
    unsigned whole = 0;  // lanes that are not subdivided any more
    for (std::size_t i = 0; i < kLanes; ++i)
      if (w.lanes[i].half < (over_budget ? first : finest)) whole |= 1u << i;
    const batch::KernelResult result =
        w.run(*impl_, {.moving = true, .proofs_only = true, .decisive = whole, .used = count});
    w.forget(result);
    if (result.colliding || (result.undecided & whole)) {
      ++w.statistics.motions_undecided;
      return false;
    }
    w.subdivide(result.undecided & ((1u << count) - 1), w.open);
  }
  ++w.statistics.motions_free;
  return true;
}

Eigen::Isometry3d BatchChecker::actuated_joint_pose(std::span<const double> q, std::size_t k, Workspace& w) const {
  require_size(q.size(), dof(), "batch checker: configuration");
  if (k >= impl_->robot->actuated_joints.size())
    throw InvalidArgument("batch checker: there is no actuated joint " + std::to_string(k) + "; there are " +
                          std::to_string(impl_->robot->actuated_joints.size()));
  check_block(q, w);
  // The kernel leaves lane 0 of the last slice's frames at the front of its scratch memory; all lanes are equal here.
  const int width = impl_->backend == SimdBackend::avx512 ? 16 : impl_->backend == SimdBackend::avx2 ? 8 : 4;
  const float* frame = w.scratch() + static_cast<std::size_t>(12 * width) * (k + 1);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pose.linear()(r, c) = frame[(3 * r + c) * width];
    pose.translation()[r] = frame[(9 + r) * width];
  }
  return pose;
}

}  // namespace srmp
