#include "srmp/collision/motion_proof.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/collision/checker_workspace.hpp"
#include "srmp/core/error.hpp"

namespace srmp {

using detail::NarrowPhase;
using detail::Pair;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rough_distance = 0.3;  // of an interval's motion: distances below are not refined, it is cut anyway
constexpr int max_levels = 3;           // cut at once
constexpr int max_looks = 200'000;      // at configurations: nobody waits for the proof of a million turns
constexpr double largest = 1e100;       // [rad or m] beyond it, squares overflow

/// Rows from, ..., to of a motion, or within one of its pieces the share from u to v.
struct Interval {
  Eigen::Index from{}, to{};
  double u{0.0}, v{1.0};
  bool one_piece() const { return to == from + 1; }
};

/// The pieces' Bernstein coefficients, between the smallest and largest of which a joint stays.
class Pieces {
 public:
  explicit Pieces(const CubicMotion& motion) : motion_(motion) {
    for (Eigen::Index first = motion.positions.rows() - 1; first > 0; first /= 2) ++levels_;
    build();
  }

  /// Configuration and time in the middle, and how far each joint gets from there.
  void range(const Interval& at, Eigen::VectorXd& middle, double& time, std::span<double> change) const {
    if (at.one_piece()) return range_of_piece(at, middle, time, change);
    const Eigen::Index mid = (at.from + at.to) / 2;
    middle = motion_.positions.row(mid).transpose();
    time = motion_.times[mid];
    std::fill(change.begin(), change.end(), 0.0);
    for_each_block(at.from, at.to, [&](const double* low, const double* high) {
      for (std::size_t j = 0; j < change.size(); ++j)
        change[j] = std::max(
            {change[j], high[j] - middle[static_cast<Eigen::Index>(j)], middle[static_cast<Eigen::Index>(j)] - low[j]});
    });
  }

  double time(const Interval& at, double share) const {
    return (1.0 - share) * motion_.times[at.from] + share * motion_.times[at.to];  // those of rows bit for bit
  }

 private:
  std::array<double, 4> coefficients(Eigen::Index piece, Eigen::Index joint) const {
    const double a = motion_.positions(piece, joint), b = motion_.positions(piece + 1, joint);
    if (motion_.velocities.rows() == 0) return {a, a + (b - a) / 3.0, b - (b - a) / 3.0, b};
    const double third = (motion_.times[piece + 1] - motion_.times[piece]) / 3.0;
    const double arrival =
        motion_.arrivals ? (*motion_.arrivals)(piece + 1, joint) : motion_.velocities(piece + 1, joint);
    return {a, a + third * motion_.velocities(piece, joint), b - third * arrival, b};
  }

  /// The polynomial's coefficient for the arguments r, s, t (its polar form).
  static double blossom(const std::array<double, 4>& c, double r, double s, double t) {
    const auto mix = [](double x, double y, double w) { return x + w * (y - x); };
    const double a = mix(c[0], c[1], r), b = mix(c[1], c[2], r), d = mix(c[2], c[3], r);
    return mix(mix(a, b, s), mix(b, d, s), t);
  }

  void range_of_piece(const Interval& at, Eigen::VectorXd& middle, double& time, std::span<double> change) const {
    const double m = (at.u + at.v) / 2.0;
    time = this->time(at, m);
    for (Eigen::Index j = 0; j < middle.size(); ++j) {
      const auto c = coefficients(at.from, j);
      middle[j] = blossom(c, m, m, m);
      double& most = change[static_cast<std::size_t>(j)] = 0.0;
      for (const double x : {blossom(c, at.u, at.u, at.u), blossom(c, at.u, at.u, at.v), blossom(c, at.u, at.v, at.v),
                             blossom(c, at.v, at.v, at.v)})
        most = std::max(most, std::abs(x - middle[j]));
    }
  }

  /// Ranges of 1, 2, 4, … pieces, so that any run of pieces is a few blocks.
  void build() {
    const Eigen::Index pieces = motion_.positions.rows() - 1, dof = motion_.positions.cols();
    low_.resize(static_cast<std::size_t>(levels_));
    high_ = low_;
    for (std::size_t level = 0; level < low_.size(); ++level) {
      const Eigen::Index count = pieces >> level;
      RowMatrix &low = low_[level], &high = high_[level];
      low.resize(count, dof);
      high.resize(count, dof);
      for (Eigen::Index i = 0; i < count; ++i)
        for (Eigen::Index j = 0; j < dof; ++j) {
          if (level == 0) {
            const auto c = coefficients(i, j);
            std::tie(low(i, j), high(i, j)) = std::minmax({c[0], c[1], c[2], c[3]});
          } else {
            low(i, j) = std::min(low_[level - 1](2 * i, j), low_[level - 1](2 * i + 1, j));
            high(i, j) = std::max(high_[level - 1](2 * i, j), high_[level - 1](2 * i + 1, j));
          }
        }
    }
  }

  template <class Visit>
  void for_each_block(Eigen::Index from, Eigen::Index to, Visit&& visit) const {
    while (from < to) {
      std::size_t level = 0;
      while (level + 1 < low_.size() && from % (Eigen::Index{2} << level) == 0 &&
             from + (Eigen::Index{2} << level) <= to)
        ++level;
      visit(low_[level].row(from >> level).data(), high_[level].row(from >> level).data());
      from += Eigen::Index{1} << level;
    }
  }

  const CubicMotion& motion_;
  int levels_{};
  std::vector<RowMatrix> low_, high_;  // [level](block, joint)
};

class Prover {
 public:
  Prover(const Checker::Impl& impl, const CubicMotion& motion, Checker::Workspace& workspace,
         const ProofOptions& options)
      : impl_(impl),
        motion_(motion),
        pieces_(motion),
        workspace_(workspace),
        gap_tolerance_(options.gap_tolerance),
        deadline_(options.deadline) {
    const auto dof = motion.positions.cols();
    middle_.resize(dof);
    change_.resize(static_cast<std::size_t>(dof));
    body_motion_.resize(impl.bodies.moving.size());
    open_.reserve(4 * impl.bodies.pairs.size());
  }

  MotionProof run();

 private:
  struct Open {
    std::uint32_t pair;
    int levels;  // to go down before it is worth another look
  };
  enum class CollisionStatus { apart, contact, open };

  void look_at(Eigen::Index row);
  bool prove(const Interval& interval, std::size_t first, std::size_t count);
  CollisionStatus judge(Open& open, bool& finest);
  double approach(const Pair& pair);
  double goal() const {
    return gap_tolerance_ > 0.0 ? gap_tolerance_ * least_ : 0.0;
  }  // that is to be proved of every pair
  CollisionStatus meet(const Pair& pair, double distance);
  void leave(const Interval& interval, std::uint32_t pair);
  double span(const Interval& at, bool end) const {
    if (!at.one_piece()) return motion_.times[end ? at.to : at.from];
    return pieces_.time(at, end ? at.v : at.u);
  }

  const Checker::Impl& impl_;
  const CubicMotion& motion_;
  Pieces pieces_;
  Checker::Workspace& workspace_;
  double gap_tolerance_;
  const Deadline* deadline_;
  double least_{infinity};  // distance found, less padding
  const Pair* nearest_{};
  double nearest_time_{};
  Eigen::VectorXd nearest_place_;
  double proved_{infinity};
  int looks_{};
  Eigen::VectorXd middle_;
  std::vector<double> change_;
  std::vector<double> body_motion_;  // by moving body, in the interval at hand; -1: not known yet
  double time_{};
  std::vector<Open> open_;  // a stack: those of the interval at hand on top
  std::vector<std::pair<std::uint32_t, std::pair<double, double>>> left_;
  std::vector<std::pair<double, std::uint32_t>> order_;
};

/// Notes a distance found at the configuration at hand.
Prover::CollisionStatus Prover::meet(const Pair& pair, double distance) {
  const double clearance = distance - pair.padding;
  if (clearance < least_) {
    least_ = clearance;
    nearest_ = &pair;
    nearest_time_ = time_;
    nearest_place_ = middle_;
  }
  return clearance <= NarrowPhase::contact_distance ? CollisionStatus::contact : CollisionStatus::open;
}

/// The nearest pair at a row, so that what follows need not look at those farther away.
void Prover::look_at(Eigen::Index row) {
  time_ = motion_.times[row];
  middle_ = motion_.positions.row(row).transpose();
  workspace_.place(middle_);
  order_.clear();
  for (std::uint32_t i = 0; i < impl_.bodies.pairs.size(); ++i) {
    const Pair& pair = impl_.bodies.pairs[i];
    const double bound = workspace_.gap(pair) - pair.padding;
    if (bound < least_) order_.emplace_back(bound, i);
  }
  std::sort(order_.begin(), order_.end());
  for (const auto& [bound, i] : order_) {
    if (bound >= least_) return;
    const Pair& pair = impl_.bodies.pairs[i];
    const double margin = least_ + pair.padding;
    if (!pair.solid && margin < infinity && workspace_.hull_distance(pair, margin, infinity) == infinity) continue;
    const double found = workspace_.distance(pair, margin, 0.0);
    if (found < infinity) meet(pair, found);
  }
}

/// How far the pair can get towards each other; the same for all that a body meets at rest.
double Prover::approach(const Pair& pair) {
  if (!pair.b_fixed) return workspace_.approach(pair);
  double& known = body_motion_[pair.a];
  if (known < 0.0) known = workspace_.approach(pair);
  return known;
}

/// Judges a pair over the interval around the configuration at hand.
Prover::CollisionStatus Prover::judge(Open& open, bool& finest) {
  const Pair& pair = impl_.bodies.pairs[open.pair];
  const double motion = approach(pair), goal = this->goal();
  const double margin = pair.padding + motion + goal + NarrowPhase::tolerance, apart = workspace_.gap(pair);
  const auto prove = [&](double at_least) {
    proved_ = std::min(proved_, std::max(0.0, at_least));
    return CollisionStatus::apart;
  };
  // An interval of the motion m shall be cut until m + goal is no more than the distance.
  const auto cut_for = [&](double distance) {
    if (finest) return CollisionStatus::open;
    const double room = std::max(distance - pair.padding - this->goal(), 0.1 * motion);
    open.levels = std::clamp(static_cast<int>(std::log2(motion / room)), 0, max_levels);
    return CollisionStatus::open;
  };
  finest = motion < Checker::motion_floor;
  if (apart > margin) return prove(apart - pair.padding - motion - NarrowPhase::tolerance);
  if (!finest && motion + goal > workspace_.farthest(pair, apart)) {  // no need to ask what cannot be proved
    if (apart > pair.padding || !workspace_.in_contact(pair, false)) return cut_for(apart + motion / 2.0);
    return meet(pair, pair.padding);
  }
  if (!pair.solid) {
    const double hulls = workspace_.hull_distance(pair, margin, margin - 0.9 * motion);
    if (hulls == infinity) return prove(goal);
    // Hulls a tenth of the motion apart prove it once it is cut: cheaper than asking the meshes.
    if (!finest && hulls > margin - 0.9 * motion) return cut_for(hulls);
  }
  const double touching = pair.padding + NarrowPhase::contact_distance;
  double found = workspace_.distance(pair, margin, pair.padding + rough_distance * motion);
  if (found == infinity) return prove(goal);
  if (finest && found > touching && !pair.solid) found = workspace_.distance(pair, margin, touching);
  if (meet(pair, found) == CollisionStatus::contact) return CollisionStatus::contact;
  // What is left of it is the pair's distance then: one that is only of two of its points is less than the motion.
  const double left = found - pair.padding - motion - NarrowPhase::tolerance;
  if (left > (finest ? 0.0 : this->goal())) return prove(left);
  return cut_for(found);
}

void Prover::leave(const Interval& interval, std::uint32_t pair) {
  const std::pair<double, double> part{span(interval, false), span(interval, true)};
  proved_ = 0.0;
  for (auto& [known, known_part] : left_)
    if (known == pair && known_part.second >= part.first) {
      known_part.second = part.second;
      return;
    }
  left_.emplace_back(pair, part);
}

/// Proves the pairs open_[first, first + count) over the interval; false at a contact.
bool Prover::prove(const Interval& interval, std::size_t first, std::size_t count) {
  if (looks_ >= max_looks || (deadline_ && deadline_->stop_requested())) {
    for (std::size_t i = first; i < first + count; ++i) leave(interval, open_[i].pair);
    return true;
  }
  const auto due = [](const Open& open) { return open.levels == 0; };
  const auto begin = open_.begin() + static_cast<std::ptrdiff_t>(first);
  const bool look = std::any_of(begin, begin + static_cast<std::ptrdiff_t>(count), due);
  if (look) {
    ++looks_;
    pieces_.range(interval, middle_, time_, change_);
    workspace_.place_in_range(middle_, change_);
    std::fill(body_motion_.begin(), body_motion_.end(), -1.0);
  }
  const std::size_t kept = open_.size();
  for (std::size_t i = first; i < first + count; ++i) {
    Open open = open_[i];
    if (open.levels > 0) {
      open_.push_back({open.pair, open.levels - 1});
      continue;
    }
    bool finest = false;
    const CollisionStatus verdict = judge(open, finest);
    if (verdict == CollisionStatus::contact) return false;
    if (verdict == CollisionStatus::open && finest)
      leave(interval, open.pair);
    else if (verdict == CollisionStatus::open)
      open_.push_back(open);
  }
  const std::size_t still = open_.size() - kept;
  if (still > 0) {
    Interval left = interval, right = interval;
    if (interval.one_piece())
      left.v = right.u = (interval.u + interval.v) / 2.0;
    else
      left.to = right.from = (interval.from + interval.to) / 2;
    if (!prove(left, kept, still) || !prove(right, kept, still)) return false;
  }
  open_.resize(kept);
  return true;
}

MotionProof Prover::run() {
  const std::vector<Pair>& pairs = impl_.bodies.pairs;
  const Eigen::Index last = motion_.positions.rows() - 1;
  std::uint64_t active = 0;
  for (std::size_t k = 0; k < impl_.group.actuated_joints().size(); ++k) active |= std::uint64_t{1} << k;
  workspace_.start_any_motion(active);
  bool free = true;
  if (gap_tolerance_ > 0.0 || last == 0)
    for (const Eigen::Index row : {last / 2, Eigen::Index{0}, last}) look_at(row);
  free = least_ > NarrowPhase::contact_distance;
  if (free && last > 0) {
    open_.clear();
    for (std::uint32_t i = 0; i < pairs.size(); ++i) open_.push_back({i, 0});
    free = prove({0, last}, 0, pairs.size());
  }
  if (free && nearest_ && !nearest_->solid) {  // it may have been that of any two near points
    workspace_.place(nearest_place_);
    const double found = workspace_.distance(*nearest_, least_ + nearest_->padding, 0.0) - nearest_->padding;
    least_ = std::min(least_, found);
    free = least_ > NarrowPhase::contact_distance;
  }
  const double most = std::max(least_ - NarrowPhase::tolerance, 0.0);  // one row is proved by what it was found to have
  MotionProof proof{free, least_, nearest_time_, "", "", free ? std::min(proved_, most) : 0.0, {}};
  if (nearest_) {
    proof.body_a = workspace_.body_a(*nearest_).name;
    proof.body_b = workspace_.body_b(*nearest_).name;
  }
  for (const auto& [pair, part] : left_)
    proof.unproved.push_back(
        {part.first, part.second, workspace_.body_a(pairs[pair]).name, workspace_.body_b(pairs[pair]).name});
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
  if (!(options.gap_tolerance >= 0.0 && options.gap_tolerance < 1.0))
    throw InvalidArgument("motion proof: gap_tolerance is " + to_text(options.gap_tolerance) +
                          "; it must be in [0, 1)");
  const Checker::Impl& impl = workspace.impl;
  if (!impl.bodies.overlaps.empty()) {
    const Contact rigid = checker.contacts(motion.positions.row(0).transpose(), workspace).front();
    return {false, rigid.distance, motion.times[0], rigid.body_a, rigid.body_b, 0.0, {}};
  }
  return Prover(impl, motion, workspace, options).run();
}

}  // namespace srmp
