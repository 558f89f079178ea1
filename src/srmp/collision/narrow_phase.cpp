#include "srmp/collision/narrow_phase.hpp"

#include <coal/collision.h>
#include <coal/distance.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <limits>

namespace srmp::detail {

namespace {

coal::Transform3s transform(const Eigen::Isometry3d& pose) { return {pose.linear(), pose.translation()}; }

/// Octrees are stored in single precision; their boxes are too, by this share.
constexpr double single_precision = 1e-6;

/// A functor that can be pointed at another pair of geometries of the same types. One functor a type pair instead of
/// one a pair keeps the workspace small and warm.
struct Functor : coal::ComputeCollision {
  using coal::ComputeCollision::ComputeCollision;
  void point_at(const coal::CollisionGeometry* a, const coal::CollisionGeometry* b) const {
    o1 = a;
    o2 = b;
  }
};

/// The first direction for GJK. Coal also keeps the last support vertex inside the functor; only "cached guess" resets
/// that at every query, and a query must not depend on the one before.
void set_guess(coal::QueryRequest& request, const Placed& a, const Placed& b) {
  request.gjk_initial_guess = coal::GJKInitialGuess::CachedGuess;
  const Eigen::Vector3d guess = a.pose.linear().transpose() * (a.center - b.center);
  request.cached_gjk_guess = guess.squaredNorm() > 1e-12 ? guess : Eigen::Vector3d(1, 0, 0);
  request.cached_support_func_guess.setZero();
}

}  // namespace

Bounds bounds_of(const coal::CollisionGeometry& geometry) {
  const coal::AABB& box = geometry.aabb_local;
  Bounds bounds{geometry.aabb_center, geometry.aabb_radius, box.center(), (box.max_ - box.min_) / 2};
  if (geometry.getNodeType() == coal::GEOM_SPHERE) bounds.radius = static_cast<const coal::Sphere&>(geometry).radius;
  if (geometry.getObjectType() == coal::OT_OCTREE) {
    const double slack = single_precision * (box.min_.cwiseAbs().maxCoeff() + box.max_.cwiseAbs().maxCoeff());
    bounds.radius += 2 * slack;
    bounds.box_half.array() += slack;
  }
  return bounds;
}

bool is_convex_solid(const coal::CollisionGeometry& geometry) { return geometry.getObjectType() == coal::OT_GEOM; }

std::uint8_t FunctorTable::index(const coal::CollisionGeometry& a, const coal::CollisionGeometry& b) {
  const auto [it, added] = known_.emplace(std::pair<int, int>(a.getNodeType(), b.getNodeType()),
                                          static_cast<std::uint8_t>(examples_.size()));
  if (added) examples_.emplace_back(&a, &b);
  return it->second;
}

struct NarrowPhase::Impl {
  std::vector<std::unique_ptr<Functor>> functors;
  coal::CollisionRequest request;
  coal::CollisionResult result;
};

NarrowPhase::NarrowPhase(const FunctorTable& table) : impl_(std::make_unique<Impl>()) {
  for (const auto& [a, b] : table.examples()) impl_->functors.push_back(std::make_unique<Functor>(a, b));
  coal::CollisionRequest& request = impl_->request;
  request.enable_contact = false;
  request.num_max_contacts = 1;
  request.break_distance = 0.0;        // do not refine bounding volumes beyond the margin
  request.distance_upper_bound = 0.0;  // GJK stops once it has proved more than the margin
}

NarrowPhase::~NarrowPhase() = default;

bool NarrowPhase::within(std::uint8_t functor, const Placed& a, const Placed& b, double margin, double& distance) {
  Functor& coal_functor = *impl_->functors[functor];
  coal_functor.point_at(a.geometry, b.geometry);
  set_guess(impl_->request, a, b);
  impl_->request.security_margin = margin;
  impl_->result.clear();
  const bool near = coal_functor(transform(a.pose), transform(b.pose), impl_->request, impl_->result) > 0;
  distance = std::max(0.0, impl_->result.distance_lower_bound + margin);
  return near;
}

Proximity NarrowPhase::deepest(const Placed& a, const Placed& b, double margin) {
  coal::CollisionRequest request(coal::CONTACT, std::numeric_limits<std::size_t>::max());
  request.security_margin = margin;
  request.break_distance = 0.0;
  set_guess(request, a, b);
  coal::CollisionResult result;
  coal::collide(a.geometry, transform(a.pose), b.geometry, transform(b.pose), request, result);
  Proximity best{margin, a.center, b.center};
  bool found = false;
  for (const coal::Contact& contact : result.getContacts()) {
    // Without a normal (a degenerate polytope) Coal's depth means nothing.
    if (!contact.nearest_points[0].allFinite() || !contact.nearest_points[1].allFinite()) continue;
    if (found && contact.penetration_depth >= best.distance) continue;
    best = {contact.penetration_depth, contact.nearest_points[0], contact.nearest_points[1]};
    found = true;
  }
  return best;
}

Proximity NarrowPhase::distance(const Placed& a, const Placed& b) {
  coal::DistanceRequest request;
  request.enable_nearest_points = true;
  request.enable_signed_distance = true;
  set_guess(request, a, b);
  coal::DistanceResult result;
  coal::distance(a.geometry, transform(a.pose), b.geometry, transform(b.pose), request, result);
  if (result.min_distance <= 0.0) return deepest(a, b, 0.0);  // of a mesh, Coal stops at the first piece in contact
  return {result.min_distance, result.nearest_points[0], result.nearest_points[1]};
}

}  // namespace srmp::detail
