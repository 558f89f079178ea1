#pragma once

#include <optional>
#include <string>
#include <vector>

#include "srmp/collision/checker.hpp"
#include "srmp/collision/cubic_motion.hpp"

// The independent proof that a motion is free. It is a twin of the checker's own motion check (SceneWorkspace) on
// purpose: the certificate of a motion must not rest on the code that planned it. The two share Coal's distances, the
// kinematic tree with its bounds on how far a motion moves each body, the scene's geometry and the list of pairs whose
// contact counts; they do not share spheres, tables of pairs, batches, or any code that decides which parts of a motion
// are checked, subdivided and called free.

namespace srmp {

struct MotionProof {
  bool free{};                 ///< no contact was found
  double clearance{};          ///< [m] smallest distance found, less padding; infinity: no pair needed a distance
  double time{};               ///< [s] when that is, or the contact
  std::string body_a, body_b;  ///< the pair there, named as in Contact
  double proved{};             ///< [m] no pair comes nearer than this anywhere, except in `unproved`; >= 0
  /// A part of the motion over which a pair could not be proved apart, though no contact was found.
  struct Part {
    double from{}, to{};  ///< [s]
    std::string body_a, body_b;
  };
  std::vector<Part> unproved;
};

struct ProofOptions {
  /// Relative gap tolerance of the clearance, in (0, 1]. It says how well the clearance is to be known, and nothing
  /// about what is proved free: `proved` is raised until (clearance - proved) / clearance is no more than this, or the
  /// two are within 25 µm, or, while the motion is proved free and again once it is, 256 more checks were made for it.
  /// 1: not at all; `clearance` and `proved` are then true, but may be far apart.
  double gap_tolerance{0.5};
  const Deadline* deadline{};  ///< once it passes, all that is open goes to `unproved`; null: none
};

/// Proves that a motion is free, between rows too, and finds how near the bodies come to each other.
///
/// Branch and bound over time, each pair of bodies or group of pairs by itself: a distance of Coal's at a
/// configuration, less what the two can approach each other anywhere in an interval around it (from the range of the
/// polynomials' Bernstein coefficients and the kinematic tree), bounds their distance all through it. Where bounding
/// volumes suffice, only the motion across planes between them counts, and bodies that the same joints move are checked
/// together, by a sphere around them. Intervals where the bound is not above 0 are halved (conservative advancement:
/// Schwarzer, Saha, Latombe, "Exact collision checking of robot paths", 2004). Intervals of less than a quarter of
/// Checker::motion_floor of motion are not (a checker may decide between two floors, where this proof has to follow):
/// they go to `unproved`, and so does all that is open when time is up, or after 200 000 configurations. Where nothing
/// is left open, bounds that are still too low are raised, the least first (best-first branch and bound), as far as
/// ProofOptions::gap_tolerance asks.
///
/// With a checker of CheckMode::coal, no pair was left out because of a table either. The result depends on the
/// arguments alone. Stops at the first contact. Throws InvalidArgument for no rows, sizes that do not match
/// Checker::dof, NaN, positions beyond 1e100, times that do not increase, and a checker that is not the library's own
/// (make_checker).
MotionProof prove_motion(const Checker& checker, const CubicMotion& motion, Checker::Workspace& workspace,
                         const ProofOptions& options = {});

}  // namespace srmp
