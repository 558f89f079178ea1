#include "srmp/trajectory/rounded_path.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/interruption.hpp"

namespace srmp::detail {

namespace {

constexpr int chords = 8;          // of a parabola, that are checked for collisions
constexpr int halvings = 6;        // a corner that is not free then is a stop
constexpr double min_part = 1e-6;  // of the shorter edge: below this a rounded corner is a stop
constexpr double max_part = 0.48;  // of the shorter edge: what is left of it is not too short to be timed

/// An edge between two waypoints; s runs from 0 to length.
struct Edge {
  Eigen::VectorXd from, direction;
  double length{};
};

std::vector<Edge> make_edges(const RowMatrix& waypoints, const MotionLimits& limits) {
  std::vector<Edge> edges;
  for (Eigen::Index i = 1; i < waypoints.rows(); ++i) {
    const Eigen::VectorXd step = (waypoints.row(i) - waypoints.row(i - 1)).transpose();
    const double length = (step.array().abs() / limits.velocity.array()).maxCoeff();
    edges.push_back({waypoints.row(i - 1).transpose(), step / length, length});
  }
  return edges;
}

/// The parabola that leaves the first edge `cut` before its end and joins the second `cut` after its start.
PathSegment parabola(const Edge& in, const Edge& out, double cut) {
  return {2.0 * cut, out.from - cut * in.direction, in.direction, (out.direction - in.direction) / (2.0 * cut), true};
}

bool is_free(const PathSegment& corner, const TimingOptions& options) {
  if (!options.is_free) return true;
  Eigen::VectorXd from = corner.start;
  for (int k = 1; k <= chords; ++k) {
    const Eigen::VectorXd to = corner.position(corner.length * k / chords);
    if (!options.is_free(from, to)) return false;
    from = to;
  }
  return true;
}

/// How much of both edges the rounded corner replaces; 0: a stop.
double cut_of(const Edge& in, const Edge& out, const TimingOptions& options) {
  if (options.blend_deviation == 0.0) return 0.0;
  const Eigen::VectorXd change = (out.direction - in.direction).cwiseAbs();
  const double off = options.reach.size() ? change.dot(options.reach) : change.sum();
  const double longest = max_part * std::min(in.length, out.length);
  double cut = off > 0.0 ? std::min(longest, 4.0 * options.blend_deviation / off) : longest;
  for (int i = 0; i < halvings && cut > min_part * longest; ++i, cut *= 0.5)
    if (is_free(parabola(in, out, cut), options)) return cut;
  return 0.0;
}

}  // namespace

std::vector<SmoothPath> round_corners(const RowMatrix& waypoints, const MotionLimits& limits,
                                      const TimingOptions& options) {
  const std::vector<Edge> edges = make_edges(waypoints, limits);
  std::vector<SmoothPath> paths;
  double before = 0.0;  // of the edge, replaced by the corner at its start
  for (std::size_t i = 0; i < edges.size(); ++i) {
    interruption_point();
    const Edge& edge = edges[i];
    const double after = i + 1 < edges.size() ? cut_of(edge, edges[i + 1], options) : 0.0;
    if (before == 0.0) paths.emplace_back();
    if (const double left = edge.length - before - after; left > min_part * edge.length)
      paths.back().push_back({left, edge.from + before * edge.direction, edge.direction,
                              Eigen::VectorXd::Zero(edge.direction.size()), false});
    if (after > 0.0) paths.back().push_back(parabola(edge, edges[i + 1], after));
    before = after;
  }
  return paths;
}

}  // namespace srmp::detail
