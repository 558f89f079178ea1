#pragma once

#include <optional>
#include <string>
#include <vector>

#include "srmp/collision/checker.hpp"

namespace srmp {

/// A motion of all joints of a checker: between two rows every joint follows the cubic polynomial with their positions
/// and velocities, a straight line if there are no velocities. References outlive the call.
struct CubicMotion {
  const Eigen::VectorXd& times;  ///< n [s], strictly increasing
  ConstRows positions;           ///< n x dof [rad or m]
  ConstRows velocities;          ///< n x dof, or no rows
  /// Where velocities jump at rows: those with which each row is reached, n x dof; `velocities` are those with which it
  /// is left. Null: they are the same.
  const RowMatrix* arrivals{};
};

struct MotionProof {
  bool free{};                 ///< no contact was found
  double clearance{};          ///< [m] smallest distance found, less padding; infinity: nothing is near enough to look
  double time{};               ///< [s] where that is, or the contact
  std::string body_a, body_b;  ///< the pair there, named as in Contact
  double proved{};             ///< [m] no pair comes nearer than this anywhere, but in `unproved`; >= 0
  /// A part of the motion over which a pair could not be proved apart, though no contact was found.
  struct Part {
    double from{}, to{};  ///< [s]
    std::string body_a, body_b;
  };
  std::vector<Part> unproved;
};

struct ProofOptions {
  /// The proof goes on until `proved` is at least this share of `clearance`, or within 25 µm of it, in [0, 1). 0: until
  /// the motion is proved free; nothing is then said of the clearance.
  double gap_tolerance{0.5};
  const Deadline* deadline{};  ///< once it passes, all that is open goes to `unproved`; null: none
};

/// Proves that a motion is free, between rows too, and finds how near the bodies come to each other.
///
/// Branch and bound over time, each pair of bodies by itself: a distance of Coal's at a configuration, less what the
/// two can approach each other anywhere in an interval around it (from the range of the polynomials' Bernstein
/// coefficients and the kinematic tree), bounds their distance all through it; intervals where that is not enough are
/// halved (conservative advancement: Schwarzer, Saha, Latombe, "Exact collision checking of robot paths", 2004).
/// Intervals of less than Checker::motion_floor of motion are not: they go to `unproved`, and so does all that is open
/// when time is up, or after 200 000 configurations.
///
/// No spheres, no tables and no code of Checker::is_motion_free have a say; with a checker of CheckMode::coal no pair
/// was left out by them either. The answer depends on the arguments alone. Stops at the first contact. Throws
/// InvalidArgument for no rows, sizes that do not match Checker::dof, NaN, positions beyond 1e100, and times that do
/// not increase.
MotionProof prove_motion(const Checker& checker, const CubicMotion& motion, Checker::Workspace& workspace,
                         const ProofOptions& options = {});

}  // namespace srmp
