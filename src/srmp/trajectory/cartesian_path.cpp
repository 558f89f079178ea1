#include "srmp/trajectory/cartesian_path.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace srmp {

namespace {

/// The rotation from a to b as a vector along its axis, in a's frame [rad].
Eigen::Vector3d turn_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  Eigen::Quaterniond turn = a.conjugate() * b;
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  return sine < 1e-12 ? Eigen::Vector3d(2.0 * turn.vec())
                      : Eigen::Vector3d(turn.vec() * (2.0 * std::atan2(sine, turn.w()) / sine));
}

double largest_part(double position, double rotation, const CartesianTolerance& tolerance) {
  return std::max(position / tolerance.position, rotation / tolerance.rotation);
}

}  // namespace

CartesianPath::CartesianPath(std::vector<Pose> poses) : poses_(std::move(poses)) {
  for (std::size_t i = 0; i < segments(); ++i) {
    lengths_.push_back((poses_[i + 1].p - poses_[i].p).norm());
    angles_.push_back(turn_between(poses_[i].q, poses_[i + 1].q).norm());
  }
}

double CartesianPath::length() const { return std::accumulate(lengths_.begin(), lengths_.end(), 0.0); }

Pose CartesianPath::pose(std::size_t segment, double fraction) const {
  const Pose &a = poses_[segment], &b = poses_[segment + 1];
  return {a.p + fraction * (b.p - a.p), a.q.slerp(fraction, b.q)};
}

CartesianPath CartesianPath::seen_from(const Pose& frame) const {
  const Pose inverse = frame.inverse();
  std::vector<Pose> poses;
  for (const Pose& pose : poses_) poses.push_back(inverse * pose);
  return CartesianPath(std::move(poses));
}

CartesianPath CartesianPath::thinned(const CartesianTolerance& closer) const {
  std::vector<Pose> kept{poses_.front()};
  double length = 0.0, angle = 0.0;  // since the last kept one
  for (std::size_t i = 1; i + 1 < poses_.size(); ++i) {
    length += lengths_[i - 1];
    angle += angles_[i - 1];
    if (length < closer.position && angle < closer.rotation) continue;
    kept.push_back(poses_[i]);
    length = angle = 0.0;
  }
  kept.push_back(poses_.back());
  return CartesianPath(std::move(kept));
}

CartesianPath::Miss CartesianPath::miss(const Pose& at, std::size_t segment,
                                        const CartesianTolerance& tolerance) const {
  const Pose &a = poses_[segment], &b = poses_[segment + 1];
  // The fractions that fit the position and the rotation best, in proportion to what they count.
  const Eigen::Vector3d along = b.p - a.p, turn = turn_between(a.q, b.q);
  const double straight = along.squaredNorm() / (tolerance.position * tolerance.position);
  const double round = turn.squaredNorm() / (tolerance.rotation * tolerance.rotation);
  const double passed = along.dot(at.p - a.p) / (tolerance.position * tolerance.position);
  const double turned = turn.dot(turn_between(a.q, at.q)) / (tolerance.rotation * tolerance.rotation);
  const double fraction = straight + round > 0.0 ? std::clamp((passed + turned) / (straight + round), 0.0, 1.0) : 0.0;
  const Pose nearest = pose(segment, fraction);
  return {segment, (at.p - nearest.p).norm(), turn_between(nearest.q, at.q).norm()};
}

CartesianPath::Miss CartesianPath::miss(const Pose& at, std::size_t first, double ahead,
                                        const CartesianTolerance& tolerance) const {
  Miss best = miss(at, first, tolerance);
  for (std::size_t i = first; i + 1 < segments() && ahead >= 0.0; ++i) {
    if (i > first) ahead -= largest_part(lengths_[i], angles_[i], tolerance);
    const Miss next = miss(at, i + 1, tolerance);
    if (largest_part(next.position, next.rotation, tolerance) < largest_part(best.position, best.rotation, tolerance))
      best = next;
  }
  return best;
}

}  // namespace srmp
