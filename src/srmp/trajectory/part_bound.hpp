#pragma once

#include <algorithm>
#include <cmath>

namespace srmp {

/// What is known of a quantity over a part of a motion: it is no larger than at the ends of the part, `at_ends`, and
/// what it can leave the chord between them by, `between`. Parts are halved until that is known well.
struct PartBound {
  /// A proved value is larger than the true one by this fraction of it at most, or of a tenth of the limit.
  static constexpr double fineness = 5e-4;
  static constexpr double slow = 0.1;            // of a limit: below, what is proved may be larger by more of it
  static constexpr double decision = 5e-7;       // of a limit: the same where it decides whether the limit is kept
  static constexpr double smallest_part = 1e-7;  // [s]

  double at_ends, between, limit;

  double bound() const { return at_ends + between; }
  /// Well enough, where `worst` is already proved of another part.
  bool is_known_well(double worst) const {
    if (std::isinf(limit) || bound() <= worst || !std::isfinite(between)) return true;
    if (at_ends <= limit && bound() > limit) return between <= decision * limit;
    return between <= fineness * std::max({worst, at_ends, slow * limit});
  }
  void raise(double& worst, double& time, double at) const {
    if (std::isinf(limit) || bound() <= worst) return;
    worst = bound();
    time = at;
  }
};

}  // namespace srmp
