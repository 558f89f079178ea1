#include "srmp/trajectory/rounded_path.hpp"

#include <algorithm>
#include <cmath>

namespace srmp::detail {

namespace {

constexpr int chords = 8;          // of a parabola, that are asked for collisions
constexpr int halvings = 6;        // a corner that is not free then is a stop
constexpr double min_part = 1e-6;  // of the shorter segment: below this a rounded corner is a stop

/// A segment between two waypoints; s runs from 0 to length.
struct Segment {
  Eigen::VectorXd from, way;
  double length{};
};

std::vector<Segment> make_segments(const RowMatrix& waypoints, const MotionLimits& limits) {
  std::vector<Segment> segments;
  for (Eigen::Index i = 1; i < waypoints.rows(); ++i) {
    const Eigen::VectorXd step = (waypoints.row(i) - waypoints.row(i - 1)).transpose();
    const double length = (step.array().abs() / limits.velocity.array()).maxCoeff();
    segments.push_back({waypoints.row(i - 1).transpose(), step / length, length});
  }
  return segments;
}

/// The parabola that leaves the first segment `cut` before its end and meets the second `cut` after its start.
PathPiece parabola(const Segment& in, const Segment& out, double cut) {
  return {2.0 * cut, out.from - cut * in.way, in.way, (out.way - in.way) / (2.0 * cut), true};
}

bool is_free(const PathPiece& corner, const TimingOptions& options) {
  if (!options.is_free) return true;
  Eigen::VectorXd from = corner.start;
  for (int k = 1; k <= chords; ++k) {
    const Eigen::VectorXd to = corner.position(corner.length * k / chords);
    if (!options.is_free(from, to)) return false;
    from = to;
  }
  return true;
}

/// How much of both segments the rounded corner takes; 0: a stop.
double cut_of(const Segment& in, const Segment& out, const TimingOptions& options) {
  if (options.blend_deviation == 0.0) return 0.0;
  const Eigen::VectorXd turn = (out.way - in.way).cwiseAbs();
  const double off = options.reach.size() ? turn.dot(options.reach) : turn.sum();
  const double most = 0.5 * std::min(in.length, out.length);
  double cut = off > 0.0 ? std::min(most, 4.0 * options.blend_deviation / off) : most;
  for (int i = 0; i < halvings && cut > min_part * most; ++i, cut *= 0.5)
    if (is_free(parabola(in, out, cut), options)) return cut;
  return 0.0;
}

}  // namespace

std::vector<SmoothPath> round_corners(const RowMatrix& waypoints, const MotionLimits& limits,
                                      const TimingOptions& options) {
  const std::vector<Segment> segments = make_segments(waypoints, limits);
  std::vector<SmoothPath> paths;
  double before = 0.0;  // taken from the segment by the corner at its start
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& segment = segments[i];
    const double after = i + 1 < segments.size() ? cut_of(segment, segments[i + 1], options) : 0.0;
    if (before == 0.0) paths.emplace_back();
    if (const double left = segment.length - before - after; left > min_part * segment.length)
      paths.back().push_back(
          {left, segment.from + before * segment.way, segment.way, Eigen::VectorXd::Zero(segment.way.size()), false});
    if (after > 0.0) paths.back().push_back(parabola(segment, segments[i + 1], after));
    before = after;
  }
  return paths;
}

}  // namespace srmp::detail
