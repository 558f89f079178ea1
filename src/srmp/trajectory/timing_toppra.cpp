#include <algorithm>
#include <cmath>
#include <limits>
#include <toppra/algorithm/toppra.hpp>
#include <toppra/constraint.hpp>
#include <toppra/geometric_path.hpp>
#include <toppra/solver/seidel.hpp>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/trajectory/timing.hpp"

namespace srmp::detail {

namespace {

constexpr double spacing = 0.03;  // [s at full speed] between grid points of straight segments
constexpr double min_straight = 8.0, max_straight = 60.0, per_corner = 4.0;  // grid intervals of a segment
/// Segments are not divided into shorter intervals than this, or than a part of a short path: in tiny ones, rounding
/// becomes acceleration.
constexpr double min_interval = 5e-4;  // [s at full speed]
constexpr int parts_of_short_path = 16;
constexpr double soon_reached = 0.9;  // of the first interval: a point nearer to its end gains nothing
constexpr double min_step = 1e-9;     // of the path: over shorter ones, rounding becomes acceleration

constexpr double within = 1.0 - 1e-6;  // of the speed that a curve allows: at the limit itself rounding decides

/// TOPP-RA's solver has absolute tolerances, so it is given a problem of size 1: the path's parameter runs from 0 to 1,
/// a unit of time is about what the motion takes, and each joint is measured by what its acceleration limit gives in
/// that time.
struct Scales {
  double length;          // of s
  double time;            // [s]
  Eigen::VectorXd joint;  // [rad or m]

  Scales(const SmoothPath& path, const MotionLimits& limits) : length(0.0), time(0.0) {
    for (const PathSegment& segment : path) length += segment.length;
    for (const PathSegment& segment : path)
      time = std::max(time, (segment.direction.array().abs() / limits.acceleration.array()).maxCoeff());
    time = std::max(length, std::sqrt(time * length));
    joint = limits.acceleration * time * time;
  }
};

class ScaledPath : public toppra::GeometricPath {
 public:
  ScaledPath(const SmoothPath& path, const Scales& scales)
      : GeometricPath(static_cast<int>(scales.joint.size())), path_(path), scales_(scales) {
    double begin = 0.0;
    for (const PathSegment& segment : path) {
      begins_.push_back(begin);
      begin += segment.length / scales.length;
    }
  }

  toppra::Vector eval_single(toppra::value_type at, int order) const override {
    const auto [segment, s] = find(at);
    const double unit = std::pow(scales_.length, order);
    const Eigen::VectorXd value = order == 0   ? segment->position(s)
                                  : order == 1 ? segment->tangent(s)
                                               : segment->curvature;
    return unit * value.cwiseQuotient(scales_.joint);
  }

  toppra::Bound pathInterval() const override { return {0.0, 1.0}; }

  /// The segment that begins at or before `at` (not at the very end), and s in it.
  std::pair<const PathSegment*, double> find(double at) const {
    const auto after = std::upper_bound(begins_.begin() + 1, begins_.end(), at);
    const auto i = static_cast<std::size_t>(after - begins_.begin()) - 1;
    return {&path_[i], (at - begins_[i]) * scales_.length};
  }

  /// The speed at which a link reaches its limit.
  double fastest_of_links(double at, LinkSpeeds& speeds) const {
    const auto [segment, s] = find(at);
    const double use = speeds.use(segment->position(s), segment->tangent(s));
    return scales_.time / scales_.length / std::max(use, 1e-9);
  }

  /// Grid points: evenly on every segment, its ends included, and where a straight one is at full speed after a stop at
  /// its beginning, or brakes for one at its end, if that is within the first or last interval: the path's acceleration
  /// is constant between grid points. With a speed at an end, these would leave no margin for rounding.
  Eigen::VectorXd grid(const MotionLimits& limits, bool at_rest) const {
    const double shortest = std::min(min_interval, scales_.length / parts_of_short_path);
    std::vector<double> points{0.0};
    for (std::size_t i = 0; i < path_.size(); ++i) {
      const double end = i + 1 < path_.size() ? begins_[i + 1] : 1.0;
      const double straight = std::clamp(path_[i].length / spacing, min_straight, max_straight);
      const double most = std::max(min_intervals(i), path_[i].length / shortest);
      const int count = static_cast<int>(std::min(path_[i].rounded ? per_corner : straight, most));
      const double part = std::max(shortest, length_to_full_speed(path_[i], limits)) / path_[i].length;
      const double step = (end - begins_[i]) * part;
      const bool soon = at_rest && !path_[i].rounded && step > min_step && part < soon_reached / std::max(count, 2);
      if (soon) points.push_back(begins_[i] + step);
      for (int k = 1; k < count; ++k) points.push_back(begins_[i] + (end - begins_[i]) * k / count);
      if (soon) points.push_back(end - step);
      points.push_back(end);
    }
    return Eigen::Map<const Eigen::VectorXd>(points.data(), static_cast<Eigen::Index>(points.size()));
  }

 private:
  /// Of s, after a stop.
  static double length_to_full_speed(const PathSegment& segment, const MotionLimits& limits) {
    return 0.5 * (segment.direction.array().abs() / limits.acceleration.array()).maxCoeff();
  }

  /// Motions speed up and brake on straight segments, but for those that are shorter than the corners beside them.
  double min_intervals(std::size_t i) const {
    const double before = i > 0 ? path_[i - 1].length : 0.0, after = i + 1 < path_.size() ? path_[i + 1].length : 0.0;
    return path_[i].rounded || path_[i].length < std::max(before, after) ? 1.0 : 4.0;
  }

  const SmoothPath& path_;
  const Scales& scales_;
  std::vector<double> begins_;  // in 0 … 1
};

/// Velocity and acceleration limits. Segments are straight or parabolas and the path's acceleration is constant between
/// grid points, so a joint's acceleration is linear there: it keeps its limit if it does so at both ends, each with the
/// curvature of the segment between them.
class Limits : public toppra::LinearConstraint {
 public:
  /// The motion begins and ends with these squared speeds.
  Limits(const ScaledPath& path, const Eigen::VectorXd& speed, const LinkSpeedBounds& links, double start, double end)
      : LinearConstraint(4 * speed.size(), 2 * speed.size(), true, false, true),
        path_(path),
        speed_(speed),
        links_(links),
        start_(start),
        end_(end) {
    discretizationType(toppra::Collocation);
  }

 private:
  void computeParams_impl(const toppra::GeometricPath&, const toppra::Vector& grid, toppra::Vectors& a,
                          toppra::Vectors& b, toppra::Vectors& c, toppra::Matrices& F, toppra::Vectors& g,
                          toppra::Bounds&, toppra::Bounds& xbound) override {
    const Eigen::Index last = grid.size() - 1, dof = speed_.size();
    F[0].setZero();
    F[0].topRows(2 * dof).setIdentity();
    F[0].bottomRows(2 * dof).diagonal().setConstant(-1.0);
    g[0].setOnes();
    std::vector<double> fastest(a.size());  // squared, by grid point
    for (std::size_t i = 0; i < a.size(); ++i) {
      interruption_point();
      fastest[i] = speed_.cwiseQuotient(path_.eval_single(grid[static_cast<Eigen::Index>(i)], 1).cwiseAbs())
                       .array()
                       .square()
                       .minCoeff();
    }
    const std::vector<double> of_links = fastest_of_links(grid);
    for (std::size_t i = 0; i < a.size(); ++i) {
      interruption_point();
      const auto row = static_cast<Eigen::Index>(i);
      const std::size_t before = i - (i > 0), after = std::min(i + 1, a.size() - 1);
      xbound[i] << 0.0, std::min({fastest[before], fastest[i], fastest[after], of_links[i]});
      const double from = grid[std::min(row, last - 1)], to = grid[std::min(row, last - 1) + 1];
      const Eigen::VectorXd curvature = path_.eval_single(from, 2), tangent = path_.eval_single(from, 1);
      const double largest = curvature.cwiseAbs().maxCoeff();
      if (largest > 0.0)
        for (const std::size_t end : {i, after}) xbound[end][1] = std::min(xbound[end][1], within / largest);
      c[i].setZero();
      if (row == last) {
        a[i].setZero();
        b[i].setZero();
        continue;
      }
      a[i] << tangent, tangent + (to - from) * curvature + 2.0 * (to - from) * curvature;
      b[i] << curvature, curvature;
    }
  }

  /// Squared, by grid point: also what links allow at both points beside it, but not near an end with a given speed.
  std::vector<double> fastest_of_links(const toppra::Vector& grid) const {
    const auto points = static_cast<std::size_t>(grid.size());
    std::vector<double> own(points, std::numeric_limits<double>::infinity());
    if (!links_.speeds) return own;
    for (std::size_t i = 0; i < points; ++i) {
      const double allowed = path_.fastest_of_links(grid[static_cast<Eigen::Index>(i)], *links_.speeds);
      const double given = i == 0 ? start_ : i + 1 == points ? end_ : 0.0;
      own[i] = std::pow(links_.fraction * allowed, 2);
      if (given <= allowed * allowed) own[i] = std::max(own[i], given);  // whatever the fraction
    }
    std::vector<double> fastest = own;
    for (std::size_t i = 1; i + 1 < points; ++i) {
      const bool near_given = (i == 1 && start_ > 0.0) || (i + 2 == points && end_ > 0.0);
      if (!near_given) fastest[i] = std::min({own[i - 1], own[i], own[i + 1]});
    }
    return fastest;
  }

  const ScaledPath& path_;
  const Eigen::VectorXd speed_;
  const LinkSpeedBounds links_;
  const double start_, end_;
};

/// The problems of the grid points, one after the other.
class InterruptibleSeidel : public toppra::solver::Seidel {
 public:
  bool solveStagewiseOptim(std::size_t i, const toppra::Matrix& H, const toppra::Vector& g, const toppra::Bound& x,
                           const toppra::Bound& next, toppra::Vector& solution) override {
    interruption_point();
    return Seidel::solveStagewiseOptim(i, H, g, x, next, solution);
  }
};

class Solver : public toppra::algorithm::TOPPRA {
 public:
  using TOPPRA::TOPPRA;

  bool can_start_with(double squared_speed, double end_speed) {
    initialize();
    if (computeControllableSets(toppra::Bound::Constant(end_speed * end_speed)) != toppra::ReturnCode::OK) return false;
    const auto set = m_data.controllable_sets.row(0);
    return squared_speed >= set[0] && squared_speed <= set[1];
  }
};

}  // namespace

Knots time_with_toppra(const SmoothPath& path, const MotionLimits& limits, double start_speed, double end_speed,
                       const LinkSpeedBounds& links) {
  const Scales scales(path, limits);
  const auto scaled = std::make_shared<ScaledPath>(path, scales);
  const Eigen::VectorXd speed = (limits.velocity * scales.time).cwiseQuotient(scales.joint);

  const double unit = scales.time / scales.length;
  // The library takes the square of the speed at the start, and the speed at the end.
  const double start = std::pow(start_speed * unit, 2), end = end_speed * unit;
  Solver solver({std::make_shared<Limits>(*scaled, speed, links, start, end * end)}, scaled);
  solver.setGridpoints(scaled->grid(limits, start == 0.0 && end == 0.0));
  solver.solver(std::make_shared<InterruptibleSeidel>());
  if ((start > 0.0 || end > 0.0) && !solver.can_start_with(start, end))
    throw Error("too fast for the length of the path");  // checked here: the library would complain on stderr
  const auto code = solver.computePathParametrization(start, end);
  if (code != toppra::ReturnCode::OK)
    throw Error("TOPP-RA found no timing (error " + std::to_string(static_cast<int>(code)) + ")");

  const toppra::ParametrizationData& found = solver.getParameterizationData();
  Knots knots;
  double time = 0.0, speed_before = 0.0;
  for (Eigen::Index i = 0; i < found.gridpoints.size(); ++i) {
    const double rate = std::sqrt(std::max(0.0, found.parametrization[i]));
    if (i > 0) {
      time += 2.0 * (found.gridpoints[i] - found.gridpoints[i - 1]) / (rate + speed_before) * scales.time;
      if (!std::isfinite(time)) throw Error("TOPP-RA stopped within the path");
    }
    const auto [segment, s] = scaled->find(found.gridpoints[i]);
    knots.add(time, segment->position(s), segment->tangent(s) * (rate / unit));
    speed_before = rate;
  }
  return knots;
}

}  // namespace srmp::detail
