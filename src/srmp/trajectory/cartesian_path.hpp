#pragma once

#include <vector>

#include "srmp/core/pose.hpp"
#include "srmp/trajectory/certificate.hpp"

namespace srmp {

inline CartesianTolerance fraction_of(double fraction, const CartesianTolerance& tolerance) {
  return {fraction * tolerance.position, fraction * tolerance.rotation};
}
inline bool is_within(double position, double rotation, const CartesianTolerance& tolerance) {
  return position <= tolerance.position && rotation <= tolerance.rotation;
}

/// Poses that a link is to pass in order: from each to the next its origin moves straight and its rotation along the
/// shortest arc (slerp: Shoemake 1985), both in proportion.
class CartesianPath {
 public:
  /// At least two poses, in one frame.
  explicit CartesianPath(std::vector<Pose> poses);

  std::size_t segments() const { return poses_.size() - 1; }
  double length(std::size_t segment) const { return lengths_[segment]; }  ///< [m]
  double angle(std::size_t segment) const { return angles_[segment]; }    ///< [rad]
  double length() const;                                                  ///< of all segments [m]
  const Pose& end() const { return poses_.back(); }
  /// `fraction` in [0, 1]
  Pose pose(std::size_t segment, double fraction) const;
  /// The same path in the frame whose pose in this frame is `frame`.
  CartesianPath seen_from(const Pose& frame) const;

  /// The same path without poses to which it is shorter than this from the last one that is kept. The ends stay.
  CartesianPath thinned(const CartesianTolerance& closer) const;

  /// How far a pose is from the path: from the place on a segment that is nearest to it by both tolerances.
  struct Miss {
    std::size_t segment{};
    double position{};  ///< [m]
    double rotation{};  ///< [rad]
  };
  /// From this segment.
  Miss miss(const Pose& pose, std::size_t segment, const CartesianTolerance& tolerance) const;
  /// From the segment of least miss among `first` and those that begin no farther than `ahead` tolerances behind it.
  Miss miss(const Pose& pose, std::size_t first, double ahead, const CartesianTolerance& tolerance) const;

 private:
  std::vector<Pose> poses_;
  std::vector<double> lengths_, angles_;
};

}  // namespace srmp
