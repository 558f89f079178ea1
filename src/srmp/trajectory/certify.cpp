#include "srmp/trajectory/certify.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>

#include "srmp/collision/motion_proof.hpp"
#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/core/stopping.hpp"
#include "srmp/trajectory/cubic.hpp"
#include "srmp/trajectory/joint_torques.hpp"
#include "srmp/trajectory/limit_check.hpp"

namespace srmp {

namespace {

constexpr double largest = 1e100;              // beyond it, squares overflow
constexpr double rest_tolerance = 1e-6;        // [rad/s or m/s]
constexpr double negligible_deviation = 1e-9;  // [m] of a row: it is on its segment

/// Checks that this is a trajectory of the robot and that its polynomials are finite.
class FormatCheck {
 public:
  FormatCheck(const Trajectory& trajectory, const RobotModel& robot) : t_(trajectory), robot_(robot) {}

  std::optional<Fault> run() {
    if (names_agree() && shapes_agree() && numbers_are_finite() && times_increase() && polynomials_are_finite())
      return std::nullopt;
    return fault_;
  }

 private:
  bool fault(FaultKind kind, const std::string& text, double time = std::numeric_limits<double>::quiet_NaN()) {
    fault_ = {kind, text, time};
    return false;
  }

  bool names_agree() {
    const std::vector<std::string>& names = robot_.joint_names();
    if (t_.joint_names == names) return true;
    auto expected = names, given = t_.joint_names;
    std::sort(expected.begin(), expected.end());
    std::sort(given.begin(), given.end());
    const std::string order = expected == given ? "the joints are in another order: " : "the joints are ";
    return fault(FaultKind::joint_names, order + quoted_list(t_.joint_names) + ", but those of robot '" +
                                             robot_.name() + "' are " + quoted_list(names));
  }

  bool shapes_agree() {
    const auto dof = static_cast<Eigen::Index>(t_.dof()), n = t_.positions.rows();
    if (n == 0) return fault(FaultKind::shape, "the trajectory has no rows");
    if (t_.times.size() != n)
      return fault(FaultKind::shape, "there are " + std::to_string(n) + " rows of positions, but " +
                                         std::to_string(t_.times.size()) + " times");
    const auto fits = [&](const RowMatrix& rows, const char* what, bool required) {
      if (rows.rows() == 0 && !required) return true;
      if (rows.rows() == n && rows.cols() == dof) return true;
      return fault(FaultKind::shape, std::string(what) + " have the shape (" + std::to_string(rows.rows()) + ", " +
                                         std::to_string(rows.cols()) + "), not (" + std::to_string(n) + ", " +
                                         std::to_string(dof) + ")");
    };
    if (t_.waypoints.rows() > 0 && t_.waypoints.cols() != dof)
      return fault(FaultKind::shape,
                   "waypoints have " + std::to_string(t_.waypoints.cols()) + " columns, not " + std::to_string(dof));
    if (t_.accelerations.rows() > 0 && t_.velocities.rows() == 0)
      return fault(FaultKind::shape, "there are accelerations, but no velocities");
    return fits(t_.positions, "positions", true) && fits(t_.velocities, "velocities", false) &&
           fits(t_.accelerations, "accelerations", false);
  }

  bool numbers_are_finite() {
    for (Eigen::Index i = 0; i < t_.positions.rows(); ++i) {
      interruption_point();
      const auto finite = [&](const RowMatrix& rows) { return rows.rows() == 0 || rows.row(i).allFinite(); };
      if (!std::isfinite(t_.times[i]) || !finite(t_.positions) || !finite(t_.velocities) || !finite(t_.accelerations))
        return fault(FaultKind::not_finite, "row " + std::to_string(i) + " holds NaN or infinity");
    }
    for (Eigen::Index i = 0; i < t_.waypoints.rows(); ++i)
      if (!(t_.waypoints.row(i).array().abs() < largest).all())
        return fault(FaultKind::not_finite,
                     "waypoint " + std::to_string(i) + " holds NaN, infinity or a number that overflows");
    return true;
  }

  bool times_increase() {
    for (Eigen::Index i = 1; i < t_.times.size(); ++i)
      if (!(t_.times[i] > t_.times[i - 1]))
        return fault(FaultKind::times,
                     std::string("time ") + (t_.times[i] == t_.times[i - 1] ? "stands still" : "runs back") +
                         " from row " + std::to_string(i - 1) + " (" + to_text(t_.times[i - 1]) + " s) to row " +
                         std::to_string(i) + " (" + to_text(t_.times[i]) + " s)",
                     t_.times[i - 1]);
    return true;
  }

  /// Where rows are too near in time, or too fast, the polynomials overflow and nothing can be verified.
  bool polynomials_are_finite() {
    if (are_moderate()) return true;
    for (Eigen::Index row = 0; row + 1 < t_.positions.rows(); ++row) {
      interruption_point();
      for (Eigen::Index j = 0; j < t_.positions.cols(); ++j) {
        const detail::Cubic p = detail::segment_of(t_, row, j);
        const auto small = [](double x) { return std::abs(x) < largest; };
        if (!std::all_of(p.c.begin(), p.c.end(), small) || !small(p.h * p.c[1]) || !small(p.h * p.velocity(p.h)) ||
            !small(p.position(p.h)))
          return fault(FaultKind::not_finite,
                       "the polynomial of " + t_.joint_names[static_cast<std::size_t>(j)] + " overflows between rows " +
                           std::to_string(row) + " and " + std::to_string(row + 1),
                       t_.times[row]);
      }
    }
    return true;
  }

  /// Numbers of such sizes overflow nowhere.
  bool are_moderate() const {
    const auto small = [](const RowMatrix& rows) { return rows.size() == 0 || rows.cwiseAbs().maxCoeff() < 1e9; };
    for (Eigen::Index i = 1; i < t_.times.size(); ++i)
      if (const double h = t_.times[i] - t_.times[i - 1]; !(h > 1e-9 && h < 1e9)) return false;
    return small(t_.positions) && small(t_.velocities);
  }

  const Trajectory& t_;
  const RobotModel& robot_;
  Fault fault_;
};

class Certifier {
 public:
  Certifier(const Trajectory& trajectory, const Checker& checker, const MotionLimits& limits,
            const CertifyOptions& options)
      : t_(trajectory), checker_(checker), robot_(checker.robot()), limits_(limits), options_(options) {}

  Certificate run() {
    result_.limits = limits_;
    if (!check_rows()) return std::move(result_);
    if (options_.collisions) check_collisions();
    return std::move(result_);
  }

 private:
  void fault(FaultKind kind, const std::string& text, double time = std::numeric_limits<double>::quiet_NaN()) {
    result_.faults.push_back({kind, text, time});
  }

  /// False: the trajectory cannot be read.
  bool check_rows() {
    std::optional<InterruptionScope> scope;  // a few rows are checked at once, also after the limit
    if (t_.positions.rows() > 1000)
      scope.emplace([this] {
        if (options_.deadline)
          stop_if_late(*options_.deadline,
                       "the " + std::to_string(t_.positions.rows()) + " rows of the trajectory were verified");
      });
    if (const auto why = unreadable(t_, robot_)) {
      result_.faults.push_back(*why);
      return false;
    }
    check_limits(t_, limits_,
                 {.joints = &robot_.joints(),
                  .limits = options_.limits,
                  .jerk = options_.jerk,
                  .at_rest = options_.at_rest,
                  .start_acceleration = &options_.start_acceleration},
                 result_);
    check_bounds_of_robot();
    check_start_velocity();
    check_ends_at_rest();
    check_deviation();
    return true;
  }

  void check_bounds_of_robot() {
    if (!need_robot(limits_)) return;
    RobotBounds bounds;
    bounds.add(robot_, checker_.base(), checker_.other_positions(), limits_);
    bounds.certify(result_, t_, options_.limits);
  }

  void check_start_velocity() {
    if (options_.start_velocity.size() == 0) return;
    const Eigen::VectorXd first = t_.velocities.rows() > 0 ? Eigen::VectorXd(t_.velocities.row(0).transpose())
                                                           : Eigen::VectorXd::Zero(t_.positions.cols());
    Eigen::Index j{};
    if ((first - options_.start_velocity).cwiseAbs().maxCoeff(&j) > rest_tolerance)
      fault(FaultKind::start,
            t_.joint_names[static_cast<std::size_t>(j)] + ": the velocity is " + to_text(first[j]) +
                " at the start; it should be " + to_text(options_.start_velocity[j]),
            t_.times[0]);
  }

  void check_ends_at_rest() {
    if (!options_.at_rest || t_.velocities.rows() == 0) return;
    for (const Eigen::Index row : {Eigen::Index{0}, t_.velocities.rows() - 1}) {
      if (row == 0 && options_.start_velocity.size() > 0) continue;
      Eigen::Index j{};
      const double fastest = t_.velocities.row(row).cwiseAbs().maxCoeff(&j);
      if (fastest > rest_tolerance)
        fault(FaultKind::not_at_rest,
              t_.joint_names[static_cast<std::size_t>(j)] + ": the velocity is " + to_text(t_.velocities(row, j)) +
                  (row == 0 ? " at the start" : " at the end") + "; it should be 0",
              t_.times[row]);
    }
  }

  // --- deviation from the waypoints

  using BernsteinPoints = std::array<Eigen::RowVectorXd, 4>;

  /// A bound on how far any point of the robot gets from the straight segment: the largest distance of the polynomial's
  /// Bernstein coefficients, which enclose the curve; or one of these that is at least `enough`.
  double off_segment(const BernsteinPoints& points, Eigen::Index segment, double enough) {
    from_ = t_.waypoints.row(segment);
    step_ = t_.waypoints.row(segment + 1) - from_;
    step_.cwiseAbs().cwiseProduct(reach_).maxCoeff(&heaviest_);
    double largest_off = 0.0;
    for (const Eigen::RowVectorXd& point : points) {
      largest_off = std::max(largest_off, off_segment(point));
      if (largest_off >= enough) break;
    }
    return largest_off;
  }

  /// The smallest sum of reach * |difference of a joint| to a point between from_ and to_: at a weighted median.
  double off_segment(const Eigen::RowVectorXd& point) {
    // Most points are on the segment: where the joint that moves most is.
    const double at_heaviest = off_point(point, place_on_segment(point, heaviest_));
    if (at_heaviest <= negligible_deviation) return at_heaviest;
    breaks_.clear();
    double total = 0.0;
    for (Eigen::Index j = 0; j < point.size(); ++j) {
      const double weight = reach_[j] * std::abs(step_[j]);
      if (!(weight > 0.0)) continue;
      breaks_.emplace_back(place_on_segment(point, j), weight);
      total += weight;
    }
    std::sort(breaks_.begin(), breaks_.end());
    double along = 0.0, passed = 0.0;
    for (const auto& [at, weight] : breaks_) {
      along = at;
      if ((passed += weight) >= 0.5 * total) break;
    }
    return off_point(point, along);
  }

  /// The fraction of the segment at which a joint is as it is in the point; 0 for a joint that stays.
  double place_on_segment(const Eigen::RowVectorXd& point, Eigen::Index joint) const {
    return step_[joint] == 0.0 ? 0.0 : (point[joint] - from_[joint]) / step_[joint];
  }

  /// The sum of reach * |difference of a joint| to the point at a fraction of the segment.
  double off_point(const Eigen::RowVectorXd& point, double along) const {
    return (point - from_ - std::clamp(along, 0.0, 1.0) * step_).cwiseAbs().dot(reach_);
  }

  void check_deviation() {
    if (t_.waypoints.rows() == 0 || t_.waypoints.cols() != t_.positions.cols()) return;
    reach_ = checker_.reach().transpose();
    result_.deviation_time = t_.times[0];
    if (t_.waypoints.rows() == 1) {
      for (Eigen::Index row = 0; row < t_.positions.rows(); ++row)
        note_deviation((t_.positions.row(row) - t_.waypoints.row(0)).cwiseAbs().dot(reach_), row);
      return;
    }
    const Eigen::Index segments = t_.waypoints.rows() - 1;
    Eigen::Index at = 0;  // the motion follows the segments in their order
    BernsteinPoints points;
    for (Eigen::Index row = 0; row + 1 < std::max<Eigen::Index>(t_.positions.rows(), 2); ++row) {
      interruption_point();
      bernstein(row, points);
      double smallest = off_segment(points, at, std::numeric_limits<double>::infinity());
      for (Eigen::Index next = at + 1; next < segments && smallest > negligible_deviation; ++next) {
        const double off = off_segment(points, next, smallest);
        if (off < smallest) {
          smallest = off;
          at = next;
        } else if (next > at + 4) {
          break;
        }
      }
      note_deviation(smallest, row);
    }
  }

  void bernstein(Eigen::Index row, BernsteinPoints& points) const {
    const Eigen::Index next = std::min(row + 1, t_.positions.rows() - 1);
    points[0] = t_.positions.row(row);
    points[3] = t_.positions.row(next);
    const double third = (t_.times[next] - t_.times[row]) / 3.0;
    points[1] = points[0];
    points[2] = points[3];
    if (t_.velocities.rows() == 0) return;
    points[1] += third * t_.velocities.row(row);
    points[2] -= third * t_.velocities.row(next);
  }

  void note_deviation(double off, Eigen::Index row) {
    if (off <= result_.deviation) return;
    result_.deviation = off;
    result_.deviation_time = t_.times[row];
  }

  // --- collisions

  void check_collisions() {
    result_.collisions_checked = true;
    Eigen::Index first = 0;
    while (first + 1 < t_.times.size() && t_.times[first] < options_.free_from) ++first;
    result_.checked_from = t_.times[first];
    const Eigen::Index rows = t_.times.size() - first;
    const Eigen::VectorXd times = t_.times.tail(rows);
    const auto workspace = checker_.make_workspace();
    const CubicMotion motion{times, t_.positions.bottomRows(rows),
                             t_.velocities.bottomRows(t_.velocities.rows() > 0 ? rows : 0)};
    const MotionProof proof = prove_motion(checker_, motion, *workspace, {options_.gap_tolerance, options_.deadline});
    result_.clearance = result_.clearance_proved = std::numeric_limits<double>::infinity();
    add_proof(result_, proof);
    if (proof.free) return;
    const auto contacts = checker_.contacts(t_.state(proof.time).position, *workspace);
    if (!contacts.empty())
      result_.faults.back().text = contacts.front().describe() + " at " + to_text(proof.time) + " s";
  }

  const Trajectory& t_;
  const Checker& checker_;
  const RobotModel& robot_;
  const MotionLimits& limits_;
  const CertifyOptions& options_;
  Eigen::RowVectorXd reach_;
  Eigen::RowVectorXd from_, step_;                 // a segment of the waypoints
  Eigen::Index heaviest_{};                        // the joint that moves points the farthest on it
  std::vector<std::pair<double, double>> breaks_;  // scratch of off_segment
  Certificate result_;
};

}  // namespace

std::optional<Fault> unreadable(const Trajectory& trajectory, const RobotModel& robot) {
  return FormatCheck(trajectory, robot).run();
}

void add_proof(Certificate& certificate, const MotionProof& proof) {
  if (proof.clearance < certificate.clearance || certificate.body_a.empty()) {
    certificate.clearance = proof.clearance;
    certificate.clearance_time = proof.time;
    certificate.body_a = proof.body_a;
    certificate.body_b = proof.body_b;
  }
  certificate.clearance_proved = std::min(certificate.clearance_proved, proof.proved);
  for (const MotionProof::Part& part : proof.unproved)
    certificate.sampled.push_back({part.from, part.to, part.body_a, part.body_b});
  if (!proof.free)
    certificate.faults.push_back(
        {FaultKind::collision,
         "'" + proof.body_a + "' and '" + proof.body_b + "' touch at " + to_text(proof.time) + " s", proof.time});
}

Certificate certify(const Trajectory& trajectory, const Checker& checker, const MotionLimits& limits,
                    const CertifyOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  require_limits(limits, checker.robot().joint_names());
  if (!(options.gap_tolerance > 0.0 && options.gap_tolerance < 1.0))
    throw InvalidArgument("certify: gap_tolerance is " + to_text(options.gap_tolerance) +
                          "; it must be above 0 and below 1");
  Certificate certificate = Certifier(trajectory, checker, limits, options).run();
  certificate.time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return certificate;
}

}  // namespace srmp
