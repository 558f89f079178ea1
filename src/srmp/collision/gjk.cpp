#include "srmp/collision/gjk.hpp"

#include <algorithm>

#include "srmp/collision/distance_query.hpp"

namespace srmp::detail {

namespace {

/// When GJK runs out of iterations, its distance is too large by less than this [m].
constexpr double unconverged = 1e-3;

}  // namespace

Gjk::Gjk() {
  search.gjk_variant = coal::GJKVariant::DefaultGJK;
  search.convergence_criterion = coal::GJKConvergenceCriterion::Default;
  search.convergence_criterion_type = coal::GJKConvergenceCriterionType::Relative;
}

/// evaluate() starts afresh every time.
double Gjk::run(const Eigen::Vector3d& guess, double margin, const coal::support_func_guess_t& hint) {
  count_step();
  search.setDistanceEarlyBreak(margin + contact_distance);  // it stops once more than this is proved
  search.evaluate(difference, guess, hint);
  double distance = std::max(0.0, search.distance);
  switch (search.status) {
    case coal::details::GJK::Collision:
    case coal::details::GJK::CollisionWithPenetrationInformation: break;
    case coal::details::GJK::NoCollisionEarlyStopped: return infinity;
    case coal::details::GJK::NoCollision: break;
    default: distance = std::max(0.0, distance - unconverged);
  }
  return distance <= margin + contact_distance ? distance : infinity;
}

double Gjk::gap_across(const Eigen::Vector3d& direction) const {
  const double length = direction.norm();
  if (!(length > contact_distance)) return 0.0;
  coal::support_func_guess_t vertices = search.support_hint;
  Eigen::Vector3d a, b;
  difference.support(-direction, a, b, vertices);
  return std::max(0.0, direction.dot(a - b) / length - difference.swept_sphere_radius.sum());
}

/// The radii that solids are swept by move, but do not turn.
double Gjk::gap_along(const Eigen::Vector3d& of_a, const Eigen::Vector3d& of_b) const {
  coal::support_func_guess_t vertices = search.support_hint;
  Eigen::Vector3d a, b, other;
  difference.support(-of_a, a, other, vertices);
  difference.support(-of_b, other, b, vertices);
  return of_a.dot(a) - of_b.dot(b) - difference.swept_sphere_radius.sum();
}

}  // namespace srmp::detail
