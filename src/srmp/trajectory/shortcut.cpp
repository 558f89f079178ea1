#include "srmp/trajectory/shortcut.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "srmp/core/error.hpp"
#include "srmp/trajectory/path.hpp"
#include "srmp/trajectory/skip_waypoints.hpp"

namespace srmp {

namespace {

using Point = Eigen::VectorXd;

struct Waypoint {
  Point q;
  bool proved{true};    ///< the segment that ends here is one of the input, or was called free
  bool fresh{true};     ///< it or a neighbour moved since it was last removed, slid or cut
  bool unpulled{true};  ///< the same for pulling
};
using Path = std::vector<Waypoint>;

class Shortcutter {
 public:
  Shortcutter(const MotionFree& is_free, const Deadline& deadline, const ShortcutOptions& options)
      : is_free_(is_free), deadline_(deadline), options_(options) {}

  void run(Path& path);
  std::size_t checks() const { return checks_; }
  bool stopped() const { return stopped_; }

 private:
  /// b - a; continuous joints go the short way.
  Point difference(const Point& a, const Point& b) const;
  double distance(const Point& a, const Point& b) const { return difference(a, b).norm(); }
  double length(const Path& path) const;
  bool visible(const Point& a, const Point& b);

  void skip(Path& path);
  void tighten_corners(Path& path);
  void pull_corners(Path& path);
  bool improve(Path& path, void (Shortcutter::*pass)(Path&));
  bool prove(Path& path);

  void remove_corner(Path& path, std::size_t i);
  void slide_corner(Path& path, std::size_t i);
  double slide(const Point& corner, const Point& towards, const Point& from, bool forward);
  void pull_corner(Path& path, std::size_t i);
  bool cut_corner(Path& path, std::size_t i);

  const MotionFree& is_free_;
  const Deadline& deadline_;
  const ShortcutOptions& options_;
  std::size_t checks_{0};
  bool stopped_{false};
  double total_{0.0};  ///< length at the start of the round: what gains are measured against
};

Point Shortcutter::difference(const Point& a, const Point& b) const {
  Point d = b - a;
  for (std::size_t j = 0; j < options_.continuous.size(); ++j)
    if (options_.continuous[j])
      d[static_cast<Eigen::Index>(j)] = std::remainder(d[static_cast<Eigen::Index>(j)], 2 * std::numbers::pi);
  return d;
}

double Shortcutter::length(const Path& path) const {
  double sum = 0.0;
  for (std::size_t i = 1; i < path.size(); ++i) sum += distance(path[i - 1].q, path[i].q);
  return sum;
}

bool Shortcutter::visible(const Point& a, const Point& b) {
  stopped_ = stopped_ || deadline_.stop_requested();
  if (stopped_) return false;
  ++checks_;
  return is_free_(a, b);
}

/// A waypoint that bisection misses is found when corners are removed.
void Shortcutter::skip(Path& path) {
  const auto is_free = [&](std::size_t from, std::size_t to) { return visible(path[from].q, path[to].q); };
  Path kept;
  for (const std::size_t i : skip_waypoints(path.size() - 1, is_free)) kept.push_back(path[i]);
  path = std::move(kept);
}

void touch(Waypoint& waypoint) { waypoint.fresh = waypoint.unpulled = true; }

void Shortcutter::remove_corner(Path& path, std::size_t i) {
  touch(path[i - 1]);
  touch(path[i + 1]);
  path[i + 1].proved = true;
  path.erase(path.begin() + static_cast<std::ptrdiff_t>(i));
}

/// The largest fraction (of those tried) of the segment from `corner` to `towards` whose point is visible from `from`.
double Shortcutter::slide(const Point& corner, const Point& towards, const Point& from, bool forward) {
  const Point along = difference(corner, towards);
  const double before = distance(from, corner);
  double reached = 0.0, blocked = 1.0;
  for (int k = 0; k < options_.halvings; ++k) {
    // An upper bound of what could be saved beyond `reached`: too little is not worth a check.
    const double saved_at_most = distance(from, corner + reached * along) + (blocked - reached) * along.norm() -
                                 distance(from, corner + blocked * along);
    if (saved_at_most < options_.min_gain * total_) break;
    const double middle = 0.5 * (reached + blocked);
    const Point there = corner + middle * along;
    const bool seen = forward ? visible(from, there) : visible(there, from);
    (seen ? reached : blocked) = middle;
  }
  const double saved = before + reached * along.norm() - distance(from, corner + reached * along);
  return saved > 0.0 ? reached : 0.0;
}

void Shortcutter::slide_corner(Path& path, std::size_t i) {
  Waypoint &before = path[i - 1], &corner = path[i], &after = path[i + 1];
  if (const double fraction = slide(corner.q, after.q, before.q, true); fraction > 0.0) {
    corner.q += fraction * difference(corner.q, after.q);
    corner.proved = true;
    after.proved = false;  // part of a free segment, but not checked itself
    for (Waypoint* moved : {&before, &corner, &after}) touch(*moved);
  }
  if (const double fraction = slide(corner.q, before.q, after.q, false); fraction > 0.0) {
    corner.q += fraction * difference(corner.q, before.q);
    corner.proved = false;
    after.proved = true;
    for (Waypoint* moved : {&before, &corner, &after}) touch(*moved);
  }
}

/// Moves single joints of a corner, then all, towards the chord between its neighbours (one joint at a time: Geraerts
/// and Overmars, "Creating High-quality Paths for Motion Planning", IJRR 2007).
void Shortcutter::pull_corner(Path& path, std::size_t i) {
  Waypoint &before = path[i - 1], &corner = path[i], &after = path[i + 1];
  const Eigen::Index dof = corner.q.size();
  for (Eigen::Index j = 0; j <= dof; ++j) {
    const Point chord = difference(before.q, after.q), offset = difference(before.q, corner.q);
    const double squared = chord.squaredNorm();
    const double fraction = squared > 0.0 ? std::clamp(offset.dot(chord) / squared, 0.0, 1.0) : 0.0;
    Point pull = fraction * chord - offset;
    if (j < dof) {
      const double only = pull[j];
      pull.setZero();
      pull[j] = only;
    }
    const double now = distance(before.q, corner.q) + distance(corner.q, after.q);
    for (double t = 1.0; t > 0.2; t *= 0.5) {
      const Point there = corner.q + t * pull;
      if (now - distance(before.q, there) - distance(there, after.q) < options_.pull_gain * total_) break;
      if (!visible(before.q, there) || !visible(there, after.q)) continue;
      corner.q = there;
      corner.proved = after.proved = true;
      for (Waypoint* moved : {&before, &corner, &after}) touch(*moved);
      break;
    }
  }
}

bool Shortcutter::cut_corner(Path& path, std::size_t i) {
  const Point corner = path[i].q, back = difference(corner, path[i - 1].q), ahead = difference(corner, path[i + 1].q);
  const double reach = std::min(back.norm(), ahead.norm());
  if (!(reach > 0.0)) return false;
  for (double fraction = 0.5; fraction > 0.1; fraction *= 0.5) {
    const Point in = corner + fraction * reach / back.norm() * back,
                out = corner + fraction * reach / ahead.norm() * ahead;
    if (2 * fraction * reach - distance(in, out) < options_.cut_gain * total_) return false;
    if (!visible(in, out)) continue;
    path[i].q = in;
    path[i].proved = false;
    path[i + 1].proved = false;
    path.insert(path.begin() + static_cast<std::ptrdiff_t>(i) + 1, Waypoint{out});
    for (std::size_t k = i - 1; k <= i + 2; ++k) touch(path[k]);
    return true;
  }
  return false;
}

void Shortcutter::tighten_corners(Path& path) {
  for (std::size_t i = 1; i + 1 < path.size() && !stopped_;) {
    if (!path[i].fresh) {
      ++i;
      continue;
    }
    path[i].fresh = false;
    if (visible(path[i - 1].q, path[i + 1].q)) {
      remove_corner(path, i);
      continue;
    }
    slide_corner(path, i);
    if (cut_corner(path, i)) ++i;
    ++i;
  }
}

void Shortcutter::pull_corners(Path& path) {
  for (std::size_t i = 1; i + 1 < path.size() && !stopped_; ++i)
    if (std::exchange(path[i].unpulled, false)) pull_corner(path, i);
}

/// Checks every segment that is only part of a free one. False when one is not free, or when time is up.
bool Shortcutter::prove(Path& path) {
  for (std::size_t i = 1; i < path.size(); ++i)
    if (!path[i].proved && !(path[i].proved = visible(path[i - 1].q, path[i].q))) return false;
  return true;
}

/// One pass over the corners; true when it was worth another.
bool Shortcutter::improve(Path& path, void (Shortcutter::*pass)(Path&)) {
  const double before = length(path);
  total_ = before;
  Path better = path;
  (this->*pass)(better);
  if (!prove(better)) return false;
  const double after = length(better);
  if (after < before || (after <= before && better.size() < path.size())) path = std::move(better);
  return before - after >= options_.min_gain * before;
}

void Shortcutter::run(Path& path) {
  if (path.size() < 3) return;
  skip(path);
  if (path.size() < 3) return;
  // Pulling costs the most checks, so it waits until the cheap moves are used up.
  for (int round = 0; round < options_.max_rounds && !stopped_; ++round)
    if (!improve(path, &Shortcutter::tighten_corners) && !improve(path, &Shortcutter::pull_corners)) return;
}

Path make_path(ConstRows waypoints) {
  Path path;
  for (Eigen::Index i = 0; i < waypoints.rows(); ++i)
    if (path.empty() || waypoints.row(i).transpose() != path.back().q)
      path.push_back(Waypoint{waypoints.row(i).transpose()});
  return path;
}

void require_options(const ShortcutOptions& options) {
  require_positive(options.min_gain, "shortcut: min_gain");
  require_positive(options.pull_gain, "shortcut: pull_gain");
  require_positive(options.cut_gain, "shortcut: cut_gain");
  if (options.max_rounds < 0)
    throw InvalidArgument("shortcut: max_rounds is " + std::to_string(options.max_rounds) + "; it must be 0 or more");
  if (options.halvings < 1)
    throw InvalidArgument("shortcut: halvings is " + std::to_string(options.halvings) + "; it must be 1 or more");
}

}  // namespace

ShortcutResult shortcut(ConstRows waypoints, const MotionFree& is_free, const Deadline& deadline,
                        const ShortcutOptions& options) {
  std::vector<std::string> columns;
  for (Eigen::Index j = 0; j < waypoints.cols(); ++j) columns.push_back("joint " + std::to_string(j));
  require_waypoints(waypoints, columns);
  require_short_way(waypoints, options.continuous, columns);
  require_options(options);
  if (!is_free) throw InvalidArgument("shortcut: the function that says whether a motion is free is empty");

  Path path = make_path(waypoints);
  Shortcutter shortcutter(is_free, deadline, options);
  shortcutter.run(path);

  std::vector<Point> points;
  for (const Waypoint& waypoint : path) points.push_back(waypoint.q);
  ShortcutResult result;
  result.waypoints = unwrap_waypoints(stack_waypoints(points), options.continuous);
  result.length_before = path_length(waypoints);
  result.length_after = path_length(result.waypoints);
  result.checks = shortcutter.checks();
  result.finished = !shortcutter.stopped();
  return result;
}

}  // namespace srmp
