#pragma once

#include <cstddef>

#include "srmp/core/simd_backend.hpp"

namespace srmp {

/// A joint of the chain that moves a link. Its axis is the z axis of its frame.
struct ChainJoint {
  double rotation[9];     ///< of its frame, by rows, in that of the joint before, with all joints at 0
  double translation[3];  ///< [m]
  double ratio;           ///< its position is that of `planned`, times this
  std::size_t planned;    ///< number of the planned joint that moves it
  bool prismatic;
};

/// A link that is to be brought to a target by damped least squares on its Jacobian (Sugihara 2011,
/// "Solvability-unconcerned inverse kinematics by the Levenberg-Marquardt method").
struct DampedLeastSquares {
  static constexpr std::size_t max_joints = 64;

  const ChainJoint* joints;  ///< from the base to the link; the first in the frame of the target
  std::size_t joint_count;   ///< at most max_joints
  double end_rotation[9];    ///< of the link in the frame of the last joint, or of the target
  double end_translation[3];
  const double *lower, *upper;  ///< limits of the planned joints [rad or m]
  std::size_t planned_count;    ///< at most max_joints
  /// Along the target's axes [m], and about them: four times the tangent of a quarter of the angle, which needs no arc
  /// functions, is the angle where it is small, and 4 at half a turn. Infinity: free.
  double tolerance[6];
  int max_iterations;
};

/// Goes from each of `count` seeds, configurations of planned joints one after the other, towards the target. Where the
/// tolerances were reached, the best configuration takes the place of the seed. A seed is abandoned after a few steps
/// without progress. Each seed's result is the same whatever the others.
using DampedLeastSquaresFunction = void (*)(const DampedLeastSquares& problem, std::size_t count,
                                            double* configurations, bool* reached);

void damped_least_squares_portable(const DampedLeastSquares& problem, std::size_t count, double* configurations,
                                   bool* reached);
#if defined(__x86_64__) && !defined(SRMP_PORTABLE_ONLY)
void damped_least_squares_avx2(const DampedLeastSquares& problem, std::size_t count, double* configurations,
                               bool* reached);
void damped_least_squares_avx512(const DampedLeastSquares& problem, std::size_t count, double* configurations,
                                 bool* reached);
#endif

/// Of an instruction set that the CPU has; all give the same bits.
DampedLeastSquaresFunction damped_least_squares(SimdBackend backend);

}  // namespace srmp
