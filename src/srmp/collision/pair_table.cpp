#include "srmp/collision/pair_table.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>

#include "srmp/collision/narrow_phase.hpp"
#include "srmp/collision/sweep.hpp"
#include "srmp/core/cache_file.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/core/low_discrepancy.hpp"
#include "srmp/cover/cover_file.hpp"

namespace srmp {

using namespace detail;

namespace {

constexpr std::string_view extension = ".pairs";
constexpr std::uint64_t table_version = 5;  // raise when the same pair gets another table, or the layout changes
constexpr int coarsest = 32;                // cells along an edge of the blocks that are tried first
constexpr double turn = 2 * std::numbers::pi;

int cell_of(double angle) { return static_cast<int>(std::floor(angle / turn * PairTable::cells)); }
int wrapped(int cell) { return cell & (PairTable::cells - 1); }

/// Joints that move one geometry relative to the other, where a table can be made for them.
struct Turning {
  std::array<int, 2> joints{-1, -1};
  std::vector<std::size_t> of_a, of_b;  // actuated joints, the deepest first
};

std::optional<Turning> turning_of(const RobotModel& model, std::size_t a, std::size_t b) {
  const std::uint64_t support_a = model.geometries()[a].support, support_b = model.geometries()[b].support;
  Turning turning;
  std::size_t count = 0;
  for (std::size_t k = model.actuated_joints().size(); k-- > 0;) {
    const bool moves_a = support_a >> k & 1, moves_b = support_b >> k & 1;
    if (moves_a == moves_b) continue;
    const ActuatedJoint& actuated = model.actuated_joints()[k];
    const int joint = static_cast<int>(actuated.joint);
    if (actuated.prismatic || std::abs(actuated.ratio) != 1.0 || count == 2 || joint == turning.joints[0])
      return std::nullopt;
    turning.joints[count++] = joint;
    (moves_a ? turning.of_a : turning.of_b).push_back(k);
  }
  if (count == 0) return std::nullopt;
  return turning;
}

/// Proves boxes of joint angles free.
class TableBuilder {
 public:
  TableBuilder(const RobotModel& model, const std::vector<GeometryParts>& parts, std::size_t a, std::size_t b,
               const Turning& turning)
      : model_(model),
        turning_(turning),
        a_(model.geometries()[a], parts[a], a),
        b_(model.geometries()[b], parts[b], b),
        data_(model.make_data()),
        q_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.dof()))) {
    if (a_.solid && b_.solid) formula_ = formulas_.index(*a_.solid, *b_.solid);
    narrow_.emplace(formulas_);
  }

  PairTable table() {
    PairTable table{a_.index, b_.index, turning_.joints, {}};
    rows_ = turning_.joints[1] < 0 ? 1 : PairTable::cells;
    table.free.assign(static_cast<std::size_t>(rows_ * PairTable::cells / 64), 0);
    const int edge = std::min(coarsest, rows_);
    for (int second = 0; second < rows_; second += edge)
      for (int first = 0; first < PairTable::cells; first += coarsest) prove(table, first, second, coarsest);
    return table;
  }

 private:
  struct Part {
    Part(const LinkGeometry& geometry, const GeometryParts& parts, std::size_t i)
        : index(i), shape(geometry.shape.get()), bvh(parts.bvh.get()), bounds(bounds_of(*geometry.shape)) {
      bounds.center = geometry.center;
      bounds.radius = geometry.radius;
      if (is_convex_solid(*parts.hull)) solid = parts.hull.get();
    }
    std::size_t index;
    const coal::CollisionGeometry *shape, *solid{};
    const PrimitiveBvh* bvh;
    Bounds bounds;
  };

  void prove(PairTable& table, int first, int second, int edge) {
    interruption_point();
    const int rows = std::min(edge, rows_);
    if (apart(first + 0.5 * edge, second + 0.5 * rows, 0.5 * edge)) {
      for (int y = second; y < second + rows; ++y)
        for (int x = first; x < first + edge; ++x) {
          const auto bit = static_cast<std::size_t>(y * PairTable::cells + x);
          table.free[bit / 64] |= std::uint64_t{1} << bit % 64;
        }
      return;
    }
    if (edge == 1) return;
    const int half = edge / 2;
    for (int y = second; y < second + rows; y += half)
      for (int x = first; x < first + edge; x += half) prove(table, x, y, half);
  }

  /// Are the two proved apart while each joint is within `half` cells of these? As the checker proves a part of a
  /// motion: in the middle they must be farther apart than both can move; within a cell, primitives that are nearer
  /// must be separated by planes farther apart than these move across them.
  bool apart(double first, double second, double half) {
    constexpr double cell = turn / PairTable::cells;
    q_[turning_.joints[0]] = first * cell;
    if (turning_.joints[1] >= 0) q_[turning_.joints[1]] = second * cell;
    model_.forward(*data_, q_);
    const Eigen::Isometry3d pose_a = model_.geometry_pose(*data_, a_.index),
                            pose_b = model_.geometry_pose(*data_, b_.index);
    const Eigen::Vector3d center_a = pose_a * a_.bounds.center, center_b = pose_b * b_.bounds.center;
    const double change = half * cell + 1e-9, reserve = NarrowPhase::tolerance + PairTable::reserve;
    const Sweep of_a = sweep(turning_.of_a, center_a, a_.bounds.radius, change),
                of_b = sweep(turning_.of_b, center_b, b_.bounds.radius, change);
    const double margin = of_a.moved + of_b.moved + reserve;
    if ((center_a - center_b).norm() - a_.bounds.radius - b_.bounds.radius > margin) return true;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (a_.solid && b_.solid &&
        narrow_->solids(formula_, {a_.solid, nullptr, a_.bounds, pose_a, center_a},
                        {b_.solid, nullptr, b_.bounds, pose_b, center_b}, margin) == infinity)
      return true;
    const auto stays_separated = [&](const SeparatedParts& parts) {
      return parts.gap > along(turning_.of_a, of_a, change, parts.direction, parts.a) +
                             along(turning_.of_b, of_b, change, parts.direction, parts.b) + reserve;
    };
    PrimitiveQuery query{.margin = margin, .enough = infinity};
    // Blocks of cells are too large for anything but the distance.
    if (half <= 0.5) query.stays_separated = std::cref(stays_separated);
    return narrow_->primitives({a_.shape, a_.bvh, a_.bounds, pose_a, center_a},
                               {b_.shape, b_.bvh, b_.bounds, pose_b, center_b}, query) == infinity;
  }

  Sweep sweep(const std::vector<std::size_t>& actuated_joints, const Eigen::Vector3d& center, double radius,
              double change) const {
    Sweep all;
    for (const std::size_t k : actuated_joints) {
      const auto [point, axis] = model_.actuated_joint_axis(*data_, k);
      all.add_turn(change, (center - point).cross(axis).norm() + radius);
    }
    return all;
  }

  /// How far it moves along a unit vector, of the hull of these points; none: of all of it.
  double along(const std::vector<std::size_t>& actuated_joints, const Sweep& all, double change,
               const Eigen::Vector3d& direction, std::span<const Eigen::Vector3d> part) const {
    if (part.empty()) return all.moved;
    double farthest = 0.0;
    for (const Eigen::Vector3d& corner : part) {
      double linear = 0.0;
      for (const std::size_t k : actuated_joints) {
        const auto [point, axis] = model_.actuated_joint_axis(*data_, k);
        linear += change * std::abs(axis.cross(corner - point).dot(direction));
      }
      farthest = std::max(farthest, linear);
    }
    return all.bound(farthest);
  }

  const RobotModel& model_;
  const Turning turning_;
  Part a_, b_;
  RobotDataPtr data_;
  Eigen::VectorXd q_;
  FormulaTable formulas_;
  int formula_{-1}, rows_{};
  std::optional<NarrowPhase> narrow_;
};

/// Relative poses of geometries for two positions of the joints that are not planned: do these joints move them?
class OtherJoints {
 public:
  explicit OtherJoints(const RobotModel& model) : model_(model), here_(model.make_data()), there_(model.make_data()) {
    const Eigen::VectorXd moved =
        model.default_other_positions() +
        0.3 * low_discrepancy_point(1, static_cast<Eigen::Index>(model.other_joints().size()));
    model.set_other_positions(*there_, moved);
    for (RobotData* data : {here_.get(), there_.get()})
      model.forward(*data, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(model.dof())));
  }

  bool move(std::size_t a, std::size_t b) const {
    const auto between = [&](const RobotData& data) {
      return model_.geometry_pose(data, a).inverse() * model_.geometry_pose(data, b);
    };
    return !between(*here_).isApprox(between(*there_), 1e-12);
  }

 private:
  const RobotModel& model_;
  RobotDataPtr here_, there_;
};

PairTables build(const RobotModel& model, const std::vector<GeometryParts>& parts, std::size_t threads,
                 const StepProgress& progress) {
  struct Job {
    std::size_t a, b;
    Turning turning;
  };
  std::vector<Job> jobs;
  const OtherJoints others(model);
  for (const auto& [a, b] : model.self_pairs())
    if ((parts[a].bvh || parts[b].bvh) && !others.move(a, b))
      if (auto turning = turning_of(model, a, b)) jobs.push_back({a, b, std::move(*turning)});
  PairTables tables(jobs.size());
  Steps steps(std::min(jobs.size(), threads), jobs.size(), progress);
  steps.run(jobs.size(), [&](std::size_t i) {
    tables[i] = TableBuilder(model, parts, jobs[i].a, jobs[i].b, jobs[i].turning).table();
  });
  return tables;
}

/// A hash of all that the tables depend on: shapes, and where they are at some configurations.
Sha256::Digest key_of(const RobotModel& model) {
  Sha256 hash = cover_key("pairs");
  hash.add(table_version);
  for (const LinkGeometry& geometry : model.geometries()) add_content(hash, *geometry.shape);
  for (const auto& [a, b] : model.self_pairs()) hash.add(static_cast<std::uint64_t>(a * model.geometries().size() + b));
  for (const ActuatedJoint& actuated : model.actuated_joints()) {
    hash.add(static_cast<std::uint64_t>(actuated.joint));
    hash.add(actuated.ratio);
  }
  const RobotDataPtr data = model.make_data();
  for (std::size_t sample = 1; sample <= 4; ++sample) {
    model.forward(*data, 6.0 * low_discrepancy_point(sample, static_cast<Eigen::Index>(model.dof())));
    for (std::size_t i = 0; i < model.geometries().size(); ++i) {
      const Eigen::Matrix4d pose = model.geometry_pose(*data, i).matrix();
      for (const double x : pose.reshaped()) hash.add(x);
    }
  }
  return hash.digest();
}

std::string to_bytes(const PairTables& tables) {
  std::string text;
  const auto put = [&](const auto& value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (const PairTable& table : tables) {
    put(static_cast<std::uint64_t>(table.geometry_a));
    put(static_cast<std::uint64_t>(table.geometry_b));
    for (const int joint : table.joints) put(static_cast<std::int32_t>(joint));
    for (const std::uint64_t word : table.free) put(word);
  }
  return text;
}

std::optional<PairTables> from_bytes(std::string_view text, const RobotModel& model) {
  PairTables tables;
  const auto get = [&](auto& value) {
    if (text.size() < sizeof value) return false;
    std::memcpy(&value, text.data(), sizeof value);
    text.remove_prefix(sizeof value);
    return true;
  };
  const auto known = [&](int joint) { return joint >= -1 && joint < static_cast<int>(model.dof()); };
  while (!text.empty()) {
    std::uint64_t a = 0, b = 0;
    std::array<std::int32_t, 2> joints{};
    if (!get(a) || !get(b) || !get(joints[0]) || !get(joints[1])) return std::nullopt;
    const std::size_t count = model.geometries().size();
    if (a >= count || b >= count || joints[0] < 0 || !known(joints[0]) || !known(joints[1])) return std::nullopt;
    PairTable& table = tables.emplace_back(PairTable{a, b, {joints[0], joints[1]}, {}});
    table.free.resize((joints[1] < 0 ? 1u : unsigned{PairTable::cells}) * PairTable::cells / 64);
    for (std::uint64_t& word : table.free)
      if (!get(word)) return std::nullopt;
  }
  return tables;
}

}  // namespace

bool PairTable::is_free(const std::array<double, 2>& low, const std::array<double, 2>& high) const {
  const int rows = joints[1] < 0 ? 1 : cells;
  const auto span = [&](std::size_t i, int& first) {
    first = cell_of(low[i]);
    return std::min(cell_of(high[i]) - first + 1, cells);
  };
  int x = 0, y = 0;
  const int width = span(0, x), height = rows == 1 ? 1 : span(1, y);
  constexpr std::size_t words = cells / 64;  // of a row
  std::array<std::uint64_t, words> touched{};
  for (int i = 0; i < width; ++i) {
    const auto bit = static_cast<std::size_t>(wrapped(x + i));
    touched[bit / 64] |= std::uint64_t{1} << bit % 64;
  }
  for (int j = 0; j < height; ++j) {
    const std::uint64_t* row = free.data() + words * static_cast<std::size_t>(rows == 1 ? 0 : wrapped(y + j));
    for (std::size_t k = 0; k < words; ++k)
      if (touched[k] & ~row[k]) return false;
  }
  return true;
}

bool PairTable::never_collide() const {
  return std::all_of(free.begin(), free.end(), [](std::uint64_t word) { return word == ~std::uint64_t{0}; });
}

PairTableStore::Known* PairTableStore::known(const std::shared_ptr<const RobotModel>& model) {
  std::erase_if(known_, [](const Known& known) { return known.model.expired(); });
  const auto found = std::find_if(known_.begin(), known_.end(), [&](const Known& known) {
    return !known.model.owner_before(model) && !model.owner_before(known.model);
  });
  return found == known_.end() ? nullptr : &*found;
}

void PairTableStore::keep(const std::shared_ptr<const RobotModel>& model, std::shared_ptr<const PairTables> tables) {
  const std::lock_guard lock(mutex_);
  Known* entry = known(model);
  if (!entry) entry = &known_.emplace_back(Known{model, nullptr});
  if (!entry->tables) entry->tables = std::move(tables);
}

std::shared_ptr<const PairTables> PairTableStore::find(const std::shared_ptr<const RobotModel>& model) {
  {
    const std::lock_guard lock(mutex_);
    if (const Known* entry = known(model)) return entry->tables;
  }
  std::shared_ptr<const PairTables> tables;
  if (const auto bytes = read_cached(directory_, extension, key_of(*model)))
    if (auto read = from_bytes(*bytes, *model)) tables = std::make_shared<const PairTables>(std::move(*read));
  keep(model, tables);
  return tables;
}

std::shared_ptr<const PairTables> PairTableStore::tables(const std::shared_ptr<const RobotModel>& model,
                                                         const std::vector<GeometryParts>& parts, std::size_t threads,
                                                         const StepProgress& progress) {
  if (auto tables = find(model)) return tables;
  auto tables = std::make_shared<const PairTables>(build(*model, parts, threads, progress));
  write_cached(directory_, extension, key_of(*model), to_bytes(*tables));
  keep(model, tables);
  return tables;
}

}  // namespace srmp
