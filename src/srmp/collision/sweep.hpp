#pragma once

#include <algorithm>

namespace srmp::detail {

/// How far joints move the points of a body, at most, one after the other from the deepest: what the deeper ones have
/// moved already is farther from the axis.
struct Sweep {
  double moved{};  // by no more than this [m]
  double bent{};   // twice what paths deviate from straight lines by [m]

  /// A joint that turns by `change` [rad] at most, with no point farther from its axis than `reach`.
  void add_turn(double change, double reach) {
    const double swept = change * (reach + moved);
    bent += change * (swept + 2.0 * moved);
    moved += swept;
  }
  /// Of points whose straight lines are no longer than `linear`.
  double bound(double linear) const { return std::min(linear + bent / 2.0, moved); }
};

}  // namespace srmp::detail
