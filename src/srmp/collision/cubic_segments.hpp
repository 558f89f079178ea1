#pragma once

#include <array>
#include <utility>
#include <vector>

#include "srmp/collision/cubic_motion.hpp"

namespace srmp::detail {

/// The segments' Bernstein coefficients: each joint stays between the smallest and the largest of them.
class CubicSegments {
 public:
  /// Rows from, ..., to of a motion; or, of the segment between two rows, the part from u to v of [0, 1].
  struct Interval {
    Eigen::Index from{}, to{};
    double u{0.0}, v{1.0};
    bool in_one_segment() const { return to == from + 1; }
    /// About as short as doubles resolve. Only of segments that move bodies by more than 10^10 m are parts so short
    /// halved any further.
    bool is_indivisible() const {
      const double middle = (u + v) / 2.0;
      return in_one_segment() && (v - u < 0x1p-60 || middle <= u || middle >= v);
    }
    std::pair<Interval, Interval> halves() const;
  };

  /// Where the joints get in an interval.
  struct Range {
    explicit Range(Eigen::Index dof)
        : middle(dof), change(static_cast<std::size_t>(dof)), linear(change.size()), rest(change.size()) {}

    Eigen::VectorXd middle;      // the configuration in the middle
    double time{};               // of it
    std::vector<double> change;  // of each joint from there, at most
    /// From the middle each joint moves by s * linear, where s in [-1, 1] is the same for all, and by `rest` at most
    /// besides.
    std::vector<double> linear, rest;
  };

  /// The motion outlives this.
  explicit CubicSegments(const CubicMotion& motion) : motion_(motion) { build(); }

  void range(const Interval& at, Range& range) const;
  /// When the interval begins or ends: at rows, their times bit for bit.
  double time_of(const Interval& at, bool end) const;

 private:
  using Coefficients = std::array<double, 4>;

  Coefficients coefficients(Eigen::Index segment, Eigen::Index joint) const;
  const Coefficients& of(Eigen::Index segment, Eigen::Index joint) const {
    return coefficients_[static_cast<std::size_t>(segment * motion_.positions.cols() + joint)];
  }
  double time(const Interval& at, double fraction) const;
  void range_of_segment(const Interval& at, Range& range) const;
  void fit_line(const Interval& at, Range& range) const;
  void build();
  template <class Visit>
  void for_each_block(Eigen::Index from, Eigen::Index to, Visit&& visit) const;

  const CubicMotion& motion_;
  std::vector<Coefficients> coefficients_;  // [segment * joints + joint]
  std::vector<RowMatrix> low_, high_;       // [level](block, joint)
};

}  // namespace srmp::detail
