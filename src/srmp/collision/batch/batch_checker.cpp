#include "srmp/collision/batch/batch_checker.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <numbers>
#include <tuple>
#include <utility>

#include "srmp/collision/batch/kernel.hpp"
#include "srmp/core/error.hpp"
#include "srmp/geometry/distance_field.hpp"

namespace srmp {

using batch::kLanes;

namespace {

constexpr double kUnit = 0x1p-24;  // half a unit in the last place of float32, relative

constexpr std::size_t kMaxPairs = 4'000'000;

bool cpu_has([[maybe_unused]] SimdBackend backend) {
  if (backend == SimdBackend::portable) return true;
#if defined(__x86_64__) && !defined(SRMP_PORTABLE_ONLY)
  if (backend == SimdBackend::avx2) return __builtin_cpu_supports("avx2");
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
#else
  return false;
#endif
}

batch::KernelFunction kernel_of([[maybe_unused]] SimdBackend backend) {
#if defined(__x86_64__) && !defined(SRMP_PORTABLE_ONLY)
  if (backend == SimdBackend::avx512) return batch::run_avx512;
  if (backend == SimdBackend::avx2) return batch::run_avx2;
#endif
  return batch::run_portable;
}

/// float32 numbers on the sound side of a double.
float above(double x) {
  const auto f = static_cast<float>(x);
  return f >= x ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}
float below(double x) { return -above(-x); }

struct FreeAligned {
  void operator()(float* p) const { ::operator delete[](p, std::align_val_t{64}); }
};
using AlignedFloats = std::unique_ptr<float[], FreeAligned>;
AlignedFloats aligned_floats(std::size_t count) {
  auto* p = new (std::align_val_t{64}) float[count];
  std::fill(p, p + count, 0.0f);
  return AlignedFloats(p);
}

struct Interval {
  double t, half;
};

}  // namespace

std::string to_string(SimdBackend backend) {
  switch (backend) {
    case SimdBackend::portable: return "portable";
    case SimdBackend::avx2: return "avx2";
    case SimdBackend::avx512: return "avx512";
  }
  return "unknown";
}

std::vector<SimdBackend> available_simd_backends() {
  std::vector<SimdBackend> result;
  for (auto backend : {SimdBackend::portable, SimdBackend::avx2, SimdBackend::avx512})
    if (cpu_has(backend)) result.push_back(backend);
  return result;
}

SimdBackend default_simd_backend() {
  const char* wanted = std::getenv("SRMP_SIMD");
  if (wanted == nullptr || *wanted == '\0') return available_simd_backends().back();
  std::vector<std::string> known;
  for (auto backend : {SimdBackend::portable, SimdBackend::avx2, SimdBackend::avx512}) {
    known.push_back(to_string(backend));
    if (known.back() != wanted) continue;
    if (cpu_has(backend)) return backend;
    throw InvalidArgument("SRMP_SIMD is '" + known.back() + "', which this CPU does not have");
  }
  const std::string suggestion = did_you_mean(wanted, known);
  throw InvalidArgument("SRMP_SIMD is '" + std::string(wanted) + "'" +
                        (suggestion.empty() ? "; it may be " + quoted_list(known) : suggestion));
}

// --- Model

struct BatchChecker::Impl {
  BatchWorld world;
  SimdBackend backend{};
  batch::KernelFunction kernel{};
  double slack{};

  std::vector<batch::KernelNode> nodes;
  std::vector<batch::KernelBody> bodies;
  std::vector<batch::KernelSphere> spheres;
  std::vector<int> children;
  std::vector<batch::KernelObstacle> obstacles;
  std::vector<int> pair_obstacles, pair_ids;
  std::vector<batch::KernelSelfPair> self_pairs;
  int stage_count{}, coarse_count{}, max_children{};
  std::vector<double> drive_reach;  // [m per rad, or 1] how far anything beyond the drive can be from its axis

  // Of each node: bounds on rotation error (operator norm), position error and distance from the base.
  std::vector<double> rotation_error, position_error, node_reach;
  double arm_reach{};  // bound on the distance of any body's point from the base

  batch::KernelModel view() const {
    return {nodes.data(),          static_cast<int>(nodes.size()),
            bodies.data(),         static_cast<int>(bodies.size()),
            stage_count,           spheres.data(),
            coarse_count,          children.data(),
            max_children,          obstacles.data(),
            pair_obstacles.data(), static_cast<int>(pair_obstacles.size()),
            self_pairs.data(),     static_cast<int>(self_pairs.size())};
  }

  void require_valid() const;
  void add_nodes();
  void add_bodies();
  void add_obstacles();
  void add_pairs();
  void add_self_pairs();
  double body_slack(const BatchBody& body) const;
  bool reachable(const BatchBody& body, const BatchObstacle& obstacle) const;
};

namespace {

/// A part of the world; names are made only for what is refused.
struct Part {
  const char* kind;
  std::size_t number;
  std::string name() const { return std::string("batch checker: ") + kind + " " + std::to_string(number); }
};

void require(bool fine, const Part& part, const char* what) {
  if (!fine) throw InvalidArgument(part.name() + what);
}

void require_index(int index, std::size_t size, const Part& part, const char* what) {
  if (index < 0 || static_cast<std::size_t>(index) >= size)
    throw InvalidArgument(part.name() + ": its " + what + " is " + std::to_string(index) + "; there are " +
                          std::to_string(size));
}

void require_spheres(std::span<const PlacedSphere> spheres, const Part& part) {
  for (const PlacedSphere& sphere : spheres)
    require(sphere.center.allFinite() && std::isfinite(sphere.radius) && sphere.radius >= 0, part,
            ": a sphere is not finite, or its radius is negative");
}

void copy_rotation(const Eigen::Matrix3d& rotation, float* out) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out[3 * r + c] = static_cast<float>(rotation(r, c));
}

batch::KernelSphere kernel_sphere(const PlacedSphere& sphere, bool inner = false) {
  return {static_cast<float>(sphere.center.x()),
          static_cast<float>(sphere.center.y()),
          static_cast<float>(sphere.center.z()),
          inner ? below(sphere.radius) : above(sphere.radius),
          0,
          0};
}

batch::KernelField kernel_field(const DistanceField& field) {
  const auto& n = field.size();
  return {field.squared().data(),
          static_cast<float>(n[0]),
          static_cast<float>(n[0]) * static_cast<float>(n[1]),
          {static_cast<float>(n[0] - 1), static_cast<float>(n[1] - 1), static_cast<float>(n[2] - 1)},
          static_cast<float>(field.cell()),
          static_cast<float>(1 / field.cell()),
          above(field.error_bound()),
          below(0.99 * field.reach())};
}

double extent(const BatchObstacle& o) {
  switch (o.kind) {
    case BatchObstacle::Kind::sphere: return o.size[0];
    case BatchObstacle::Kind::box:
    case BatchObstacle::Kind::field: return o.size.norm() / 2;
    case BatchObstacle::Kind::cylinder: return std::hypot(o.size[0], o.size[1] / 2);
    case BatchObstacle::Kind::capsule: return o.size[0] + o.size[1] / 2;
  }
  return 0;
}

/// A lower bound of the diameter of what is in one piece, padding left out.
double diameter(const BatchObstacle& o) {
  if (!o.connected) return 1e-9;
  switch (o.kind) {
    case BatchObstacle::Kind::field: return o.size.maxCoeff();
    case BatchObstacle::Kind::sphere: return 2 * o.size[0];
    case BatchObstacle::Kind::box: return o.size.norm();
    case BatchObstacle::Kind::cylinder: return std::hypot(2 * o.size[0], o.size[1]);
    case BatchObstacle::Kind::capsule: return 2 * o.size[0] + o.size[1];
  }
  return 0;
}

}  // namespace

void BatchChecker::Impl::require_valid() const {
  for (std::size_t k = 0; k < world.actuated_joints.size(); ++k) {
    const BatchActuatedJoint& d = world.actuated_joints[k];
    const Part part{"drive", k};
    require(d.parent < static_cast<int>(k) && d.parent >= -1, part, " comes before its parent");
    require_index(d.joint, world.dof, part, "joint");
    require(d.frame.matrix().allFinite(), part, ": its frame is not finite");
    require(std::isfinite(d.ratio) && std::isfinite(d.offset) && std::isfinite(d.max_travel), part,
            ": ratio, offset and travel must be finite");
  }
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    const BatchBody& b = world.bodies[i];
    const Part part{"body", i};
    if (b.drive != -1) require_index(b.drive, world.actuated_joints.size(), part, "drive");
    require_spheres({&b.bound, 1}, part);
    require_spheres(b.coarse, part);
    require_spheres(b.fine, part);
    require_spheres(b.inner, part);
    require(!b.coarse.empty(), part, " has no spheres");
    require(std::isfinite(b.padding) && b.padding >= 0, part, ": its padding must be 0 or more");
    require(b.children.size() == (b.fine.empty() ? 0 : b.coarse.size()), part,
            ": children must be given for each coarse sphere when there are fine ones");
    for (const auto& list : b.children)
      for (const std::uint32_t child : list) require_index(static_cast<int>(child), b.fine.size(), part, "child");
  }
  for (std::size_t i = 0; i < world.obstacles.size(); ++i) {
    const BatchObstacle& o = world.obstacles[i];
    const Part part{"obstacle", i};
    require(o.size.allFinite() && (o.size.array() >= 0).all() && o.pose.matrix().allFinite() &&
                std::isfinite(o.padding) && o.padding >= 0 && o.field_center.allFinite(),
            part, ": size, pose and padding must be finite and not negative");
    require((o.kind == BatchObstacle::Kind::field) == (o.field != nullptr), part,
            ": a field is needed where, and only where, the kind says so");
  }
  for (std::size_t i = 0; i < world.obstacle_pairs.size(); ++i) {
    const Part part{"pair", i};
    require_index(world.obstacle_pairs[i].first, world.bodies.size(), part, "body");
    require_index(world.obstacle_pairs[i].second, world.obstacles.size(), part, "obstacle");
  }
  for (std::size_t i = 0; i < world.self_pairs.size(); ++i) {
    const Part part{"self pair", i};
    require_index(world.self_pairs[i].a, world.bodies.size(), part, "first body");
    require_index(world.self_pairs[i].b, world.bodies.size(), part, "second body");
  }
  if (world.obstacle_pairs.size() + world.self_pairs.size() > kMaxPairs)
    throw InvalidArgument("batch checker: there are more than 4 million pairs");
}

void BatchChecker::Impl::add_nodes() {
  nodes.push_back({-1, -1, 0, {1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}});
  rotation_error.push_back(0);
  position_error.push_back(0);
  node_reach.push_back(0);
  for (std::size_t k = 0; k < world.actuated_joints.size(); ++k) {
    const BatchActuatedJoint& drive = world.actuated_joints[k];
    batch::KernelNode node{drive.parent + 1, static_cast<int>(k), drive.prismatic, {}, {}};
    copy_rotation(drive.frame.linear(), node.rotation);
    for (int i = 0; i < 3; ++i) node.translation[i] = static_cast<float>(drive.frame.translation()[i]);
    nodes.push_back(node);
    // Rounding of one joint: each entry of a product of rotations errs by at most 3 units, the constants by 1, the turn
    // by 3 more; sine and cosine by 2.5e-7; the angle (at most 2 pi) by 2 pi units. 9 entries: 3 times that in norm,
    // doubled for good measure.
    const double step = drive.frame.translation().norm() + drive.max_travel;
    const double reach = node_reach[node.parent] + step;
    rotation_error.push_back(rotation_error[node.parent] + 80 * kUnit);
    position_error.push_back(position_error[node.parent] + rotation_error[node.parent] * step + 12 * kUnit * reach);
    node_reach.push_back(reach);
  }
}

double BatchChecker::Impl::body_slack(const BatchBody& body) const {
  const std::size_t node = static_cast<std::size_t>(body.drive + 1);
  double far = body.bound.center.norm() + body.bound.radius;
  for (const auto* spheres : {&body.coarse, &body.fine, &body.inner})
    for (const PlacedSphere& b : *spheres) far = std::max(far, b.center.norm());
  return position_error[node] + rotation_error[node] * far + 12 * kUnit * (node_reach[node] + far);
}

void BatchChecker::Impl::add_bodies() {
  for (const BatchBody& body : world.bodies) {
    batch::KernelBody kernel{};
    kernel.node = body.drive + 1;
    for (int n = kernel.node; n >= 0; n = nodes[n].parent) ++kernel.depth;
    kernel.first_stage = stage_count;
    stage_count += kernel.depth;
    const batch::KernelSphere bound = kernel_sphere(body.bound);
    kernel.x = bound.x, kernel.y = bound.y, kernel.z = bound.z, kernel.radius = bound.radius;
    kernel.reach_radius = above(body.bound.radius + 2 * body_slack(body));
    kernel.padding = above(body.padding);
    kernel.exact = body.exact;
    kernel.capacity = body.hollow ? above(2 * body.bound.radius + 1e-3) : 0.0f;
    kernel.first_sphere = static_cast<int>(spheres.size());
    kernel.spheres = static_cast<int>(body.coarse.size());
    for (const PlacedSphere& sphere : body.coarse) spheres.push_back(kernel_sphere(sphere));
    bodies.push_back(kernel);
    slack = std::max(slack, body_slack(body));
    arm_reach = std::max(arm_reach, node_reach[kernel.node] + body.bound.center.norm() + body.bound.radius);
  }
  coarse_count = static_cast<int>(spheres.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const BatchBody& body = world.bodies[i];
    const int first_fine = static_cast<int>(spheres.size());
    for (const PlacedSphere& sphere : body.fine) spheres.push_back(kernel_sphere(sphere));
    for (std::size_t c = 0; c < body.children.size(); ++c) {
      batch::KernelSphere& parent = spheres[bodies[i].first_sphere + c];
      parent.first_child = static_cast<int>(children.size());
      parent.children = static_cast<int>(body.children[c].size());
      max_children = std::max(max_children, parent.children);
      for (std::uint32_t child : body.children[c]) children.push_back(first_fine + static_cast<int>(child));
    }
    bodies[i].first_inner = static_cast<int>(spheres.size());
    bodies[i].inners = static_cast<int>(body.inner.size());
    for (const PlacedSphere& sphere : body.inner) spheres.push_back(kernel_sphere(sphere, true));
  }
}

void BatchChecker::Impl::add_obstacles() {
  for (const BatchObstacle& o : world.obstacles) {
    batch::KernelObstacle kernel{};
    const Eigen::Isometry3d inverse = o.pose.inverse();
    copy_rotation(inverse.linear(), kernel.rotation);
    kernel.aligned = inverse.linear().isIdentity(0.0);
    kernel.exact = o.exact;
    kernel.size = below(diameter(o));
    for (int i = 0; i < 3; ++i) kernel.offset[i] = static_cast<float>(inverse.translation()[i]);
    double rounding = 0;
    switch (o.kind) {
      case BatchObstacle::Kind::sphere: rounding = o.size[0]; break;
      case BatchObstacle::Kind::box:
        for (int i = 0; i < 3; ++i) kernel.half[i] = static_cast<float>(o.size[i] / 2);
        break;
      case BatchObstacle::Kind::cylinder:
        kernel.cylinder = 1;
        kernel.half[0] = static_cast<float>(o.size[0]);
        kernel.half[2] = static_cast<float>(o.size[1] / 2);
        break;
      case BatchObstacle::Kind::capsule:
        kernel.half[2] = static_cast<float>(o.size[1] / 2);
        rounding = o.size[0];
        break;
      case BatchObstacle::Kind::field:
        kernel.field = kernel_field(*o.field);
        for (int i = 0; i < 3; ++i)
          kernel.offset[i] = static_cast<float>(inverse.translation()[i] + o.field_center[i] - o.field->corner()[i]);
        break;
    }
    // Local coordinates err by some units of everything that went into them, comparisons by some of the threshold.
    const double here = slack + 24 * kUnit * (arm_reach + o.pose.translation().norm() + extent(o) + o.padding + 1.0);
    kernel.radius = above(rounding + o.padding + here);
    kernel.inner_radius = below(rounding + o.padding - here);
    obstacles.push_back(kernel);
  }
}

bool BatchChecker::Impl::reachable(const BatchBody& body, const BatchObstacle& o) const {
  const double reach = node_reach[body.drive + 1] + body.bound.center.norm() + body.bound.radius + body.padding;
  const Eigen::Vector3d p = o.pose.inverse().translation();  // the base in the obstacle's frame
  double distance = p.norm() - extent(o);
  if (o.kind == BatchObstacle::Kind::box || o.kind == BatchObstacle::Kind::field)
    distance = (p.cwiseAbs() - o.size / 2).cwiseMax(0.0).norm();
  return distance - o.padding <= reach * 1.0001 + 1e-3;
}

void BatchChecker::Impl::add_pairs() {
  std::vector<std::array<int, 3>> pairs;  // body, obstacle, index
  for (const auto& [body, obstacle] : world.obstacle_pairs)
    pairs.push_back({body, obstacle, static_cast<int>(pairs.size())});
  std::sort(pairs.begin(), pairs.end());
  for (std::size_t i = 0, k = 0; i < bodies.size(); ++i) {
    bodies[i].first_pair = static_cast<int>(pair_obstacles.size());
    for (; k < pairs.size() && pairs[k][0] == static_cast<int>(i); ++k) {
      if (!reachable(world.bodies[i], world.obstacles[pairs[k][1]])) continue;
      pair_obstacles.push_back(pairs[k][1]);
      pair_ids.push_back(pairs[k][2]);
    }
    bodies[i].pairs = static_cast<int>(pair_obstacles.size()) - bodies[i].first_pair;
  }
}

void BatchChecker::Impl::add_self_pairs() {
  for (const BatchSelfPair& pair : world.self_pairs) {
    const auto chain = [&](int body) {
      std::vector<int> result;
      for (int n = bodies[body].node; n >= 0; n = nodes[n].parent) result.push_back(n);
      return result;
    };
    const std::vector<int> a = chain(pair.a), b = chain(pair.b);
    int up_a = 0, up_b = 0;  // steps to the last common node: only what is beyond moves one against the other
    while (a[up_a] != b[up_b]) ++(a[up_a] > b[up_b] ? up_a : up_b);
    const double here = 2 * slack + 24 * kUnit * (arm_reach + 1.0);
    self_pairs.push_back({pair.a, pair.b, pair.exact, bodies[pair.a].first_stage + up_a,
                          bodies[pair.b].first_stage + up_b, above(pair.padding), above(here)});
  }
}

BatchChecker::BatchChecker(const BatchWorld& world, SimdBackend backend) {
  auto impl = std::make_unique<Impl>();
  impl->world = world;
  impl->backend = backend;
  if (!cpu_has(backend)) throw InvalidArgument("batch checker: this CPU does not have " + to_string(backend));
  impl->kernel = kernel_of(backend);
  impl->require_valid();
  impl->add_nodes();
  impl->add_bodies();
  impl->add_obstacles();
  impl->add_pairs();
  impl->add_self_pairs();
  impl->drive_reach.assign(world.actuated_joints.size(), 0.0);
  for (const BatchBody& body : world.bodies) {
    double beyond = body.bound.center.norm() + body.bound.radius;
    for (int k = body.drive; k >= 0; k = world.actuated_joints[k].parent) {
      impl->drive_reach[k] = std::max(impl->drive_reach[k], world.actuated_joints[k].prismatic ? 1.0 : beyond);
      beyond += world.actuated_joints[k].frame.translation().norm() + world.actuated_joints[k].max_travel;
    }
  }
  impl_ = std::move(impl);
}

BatchChecker::~BatchChecker() = default;
BatchChecker::BatchChecker(BatchChecker&&) noexcept = default;
std::size_t BatchChecker::dof() const { return impl_->world.dof; }
SimdBackend BatchChecker::backend() const { return impl_->backend; }
double BatchChecker::slack() const { return impl_->slack; }

// --- Checks

class BatchChecker::Workspace {
 public:
  explicit Workspace(const Impl& impl)
      : values(aligned_floats(impl.world.actuated_joints.size() * kLanes + kLanes)),
        half_widths(aligned_floats(impl.world.actuated_joints.size() * kLanes + kLanes)),
        scratch(aligned_floats(static_cast<std::size_t>(batch::scratch_floats(impl.view())))),
        pair_lanes(impl.pair_obstacles.size() + impl.self_pairs.size(), 0),
        start(impl.world.actuated_joints.size()),
        delta(impl.world.actuated_joints.size()),
        view(impl.view()) {
    undecided.reserve(1024);
    open.reserve(4096);
    next.reserve(4096);
  }

  AlignedFloats values, half_widths, scratch;
  std::vector<batch::LaneMask> pair_lanes;
  std::vector<double> start, delta;  // of each drive: value at the start (turned near 0), change over the motion
  batch::KernelModel view;
  std::vector<UndecidedPair> undecided;
  std::vector<Interval> open, next;
  std::array<Interval, kLanes> lanes;
  BatchStatistics statistics;

  batch::KernelResult run(const Impl& impl, bool moving, unsigned proofs_only = 0) {
    ++statistics.blocks;
    batch::KernelResult result{0, 0, pair_lanes.data()};
    const batch::KernelRequest request{values.get(), moving ? half_widths.get() : nullptr, !moving,
                                       static_cast<batch::LaneMask>(proofs_only)};
    impl.kernel(view, request, scratch.get(), result);
    return result;
  }

  /// Moves the kernel's report into `undecided`, for the lanes wanted that do not collide; `at(lane)` is the interval
  /// of a lane.
  template <class At>
  void collect(const Impl& impl, const batch::KernelResult& result, unsigned wanted, At&& at) {
    if (!result.undecided) return;
    wanted &= ~static_cast<unsigned>(result.colliding);
    const int pairs = view.pair_count;
    for (int k = 0; k < static_cast<int>(pair_lanes.size()); ++k) {
      const unsigned lanes = std::exchange(pair_lanes[k], batch::LaneMask{0}) & wanted;
      if (lanes == 0) continue;
      const bool self = k >= pairs;
      const int pair = self ? k - pairs : impl.pair_ids[k];
      for (int lane = 0; lane < kLanes; ++lane)
        if (lanes >> lane & 1) undecided.push_back({at(lane).t, at(lane).half, self, pair});
    }
  }

  void forget() { std::fill(pair_lanes.begin(), pair_lanes.end(), batch::LaneMask{0}); }

  void set_motion(const Impl& impl, std::span<const double> a, std::span<const double> difference) {
    for (std::size_t k = 0; k < start.size(); ++k) {
      const BatchActuatedJoint& drive = impl.world.actuated_joints[k];
      start[k] = drive.ratio * a[drive.joint] + drive.offset;
      delta[k] = drive.ratio * difference[drive.joint];
      constexpr double turn = 2 * std::numbers::pi;
      if (!drive.prismatic) start[k] -= turn * std::nearbyint((start[k] + 0.5 * delta[k]) / turn);
    }
  }

  /// The first of `from`, up to a block full; the last fills what is left. How many there were.
  std::size_t set_lanes(std::span<const Interval> from) {
    const std::size_t count = std::min<std::size_t>(kLanes, from.size());
    for (std::size_t i = 0; i < kLanes; ++i) lanes[i] = from[std::min(i, count - 1)];
    for (std::size_t k = 0; k < start.size(); ++k)
      for (int i = 0; i < kLanes; ++i) {
        values[k * kLanes + i] = static_cast<float>(start[k] + lanes[i].t * delta[k]);
        // A little wider: for the float rounding of this number and of the bound made of it.
        half_widths[k * kLanes + i] = static_cast<float>(std::abs(delta[k]) * lanes[i].half * (1 + 1e-4) + 1e-12);
      }
    return count;
  }

  /// The four parts of those lanes that are undecided.
  void cut(unsigned undecided, std::vector<Interval>& parts) const {
    for (std::size_t i = 0; i < kLanes; ++i)
      if (undecided >> i & 1)
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

BatchChecker::Lanes BatchChecker::judge_block(std::span<const double> configurations, Workspace& w,
                                              bool proofs_only) const {
  const std::size_t n = dof(), count = n ? configurations.size() / n : 0;
  if (n == 0 || count * n != configurations.size() || count == 0 || count > block)
    throw InvalidArgument("batch checker: a block holds 1 to 16 configurations of " + std::to_string(n) + " entries");
  w.undecided.clear();
  for (std::size_t k = 0; k < impl_->world.actuated_joints.size(); ++k) {
    const BatchActuatedJoint& drive = impl_->world.actuated_joints[k];
    for (std::size_t i = 0; i < kLanes; ++i) {
      double value = drive.ratio * configurations[std::min(i, count - 1) * n + drive.joint] + drive.offset;
      constexpr double turn = 2 * std::numbers::pi;
      if (!drive.prismatic) value -= turn * std::nearbyint(value / turn);
      w.values[k * kLanes + i] = static_cast<float>(value);
    }
  }
  const unsigned wanted = (1u << count) - 1;
  const batch::KernelResult result = w.run(*impl_, false, proofs_only ? (1u << kLanes) - 1 : 0);
  w.collect(*impl_, result, wanted, [](int lane) { return Interval{static_cast<double>(lane), 0}; });
  std::sort(w.undecided.begin(), w.undecided.end(), by_time_and_pair);
  const unsigned colliding = result.colliding & wanted;
  return {static_cast<std::uint16_t>(colliding), static_cast<std::uint16_t>(result.undecided & wanted & ~colliding)};
}

CollisionStatus BatchChecker::motion_block(std::span<const double> a, std::span<const double> difference,
                                           Workspace& w) const {
  return motion(a, difference, w, {.step = std::numeric_limits<double>::infinity(), .refinements = 0, .max_blocks = 1});
}

/// The first intervals, all of one length.
void BatchChecker::begin_motion(std::span<const double> a, std::span<const double> difference, Workspace& w,
                                const MotionOptions& options) const {
  require_size(a.size(), dof(), "batch checker: start of the motion");
  require_size(difference.size(), dof(), "batch checker: difference of the motion");
  ++w.statistics.motions;
  w.undecided.clear();
  w.set_motion(*impl_, a, difference);
  double length = 0;
  for (std::size_t k = 0; k < w.delta.size(); ++k) length += std::abs(w.delta[k]) * impl_->drive_reach[k];
  const int cuts = static_cast<int>(std::clamp(std::ceil(length / (2 * options.step * kLanes)), 1.0, 64.0));
  w.open.clear();
  for (int j = 0; j < cuts; ++j)  // a block's lanes are spread over the motion: collisions show early
    for (int i = 0; i < kLanes; ++i)
      w.open.push_back({(static_cast<double>(i) * cuts + j + 0.5) / (cuts * kLanes), 0.5 / (cuts * kLanes)});
}

CollisionStatus BatchChecker::motion(std::span<const double> a, std::span<const double> difference, Workspace& w,
                                     const MotionOptions& options) const {
  begin_motion(a, difference, w, options);
  int blocks = 0;
  for (int level = 0; !w.open.empty(); ++level) {
    w.next.clear();
    const bool last = level >= options.refinements || blocks >= options.max_blocks;
    for (std::size_t first = 0; first < w.open.size(); first += kLanes) {
      const unsigned wanted = (1u << w.set_lanes(std::span(w.open).subspan(first))) - 1;
      ++blocks;
      const batch::KernelResult result = w.run(*impl_, true);
      if (result.colliding) {
        w.forget();
        w.undecided.clear();
        ++w.statistics.motions_colliding;
        return CollisionStatus::colliding;
      }
      if (last) {
        w.collect(*impl_, result, wanted, [&](int lane) { return w.lanes[lane]; });
        continue;
      }
      if (result.undecided == 0) continue;
      w.forget();
      w.cut(result.undecided & wanted, w.next);
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
  // What was cut last is looked at first, so that a part that cannot be proved shows early.
  std::reverse(w.open.begin(), w.open.end());
  const double first = w.open.front().half, least = 1.5 * first * std::pow(0.25, options.refinements);
  for (int blocks = 0; !w.open.empty(); ++blocks) {
    const bool late = blocks >= options.max_blocks;
    const std::size_t count = w.set_lanes(std::span(w.open).last(std::min<std::size_t>(kLanes, w.open.size())));
    w.open.resize(w.open.size() - count);
    unsigned whole = 0;  // lanes that are not cut any more
    for (std::size_t i = 0; i < kLanes; ++i)
      if (w.lanes[i].half < (late ? first : least)) whole |= 1u << i;
    const batch::KernelResult result = w.run(*impl_, true, whole);
    if (result.undecided) w.forget();
    if (result.colliding || (result.undecided & whole)) {
      ++w.statistics.motions_undecided;
      return false;
    }
    w.cut(result.undecided & ((1u << count) - 1), w.open);
  }
  ++w.statistics.motions_free;
  return true;
}

Eigen::Isometry3d BatchChecker::drive_pose(std::span<const double> q, std::size_t k, Workspace& w) const {
  require_size(q.size(), dof(), "batch checker: configuration");
  if (k >= impl_->world.actuated_joints.size())
    throw InvalidArgument("batch checker: drive " + std::to_string(k) + " was asked for; there are " +
                          std::to_string(impl_->world.actuated_joints.size()));
  judge_block(q, w);
  // The kernel leaves lane 0 of the last slice's frames at the front of its scratch memory; all lanes are equal here.
  const int width = impl_->backend == SimdBackend::avx512 ? 16 : impl_->backend == SimdBackend::avx2 ? 8 : 4;
  const float* frame = w.scratch.get() + static_cast<std::size_t>(12 * width) * (k + 1);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pose.linear()(r, c) = frame[(3 * r + c) * width];
    pose.translation()[r] = frame[(9 + r) * width];
  }
  return pose;
}

}  // namespace srmp
