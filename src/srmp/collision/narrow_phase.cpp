#include "srmp/collision/narrow_phase.hpp"

#include <coal/collision.h>
#include <coal/distance.h>
#include <coal/narrowphase/support_functions.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>

#include "srmp/collision/gjk.hpp"
#include "srmp/collision/oriented_box.hpp"
#include "srmp/collision/primitive_distance.hpp"

namespace srmp::detail {

namespace {

constexpr double max_formula_margin = 1e4;  // [m]

/// Octrees and their boxes are stored in single precision: a relative error bound.
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

/// Coal's support functions of boxes keep a factor for the whole process, which is 1 + 1e-10 if a coordinate of the
/// first direction that they are ever asked for is 0, else 1. It is 1 when they are first asked here, as the library is
/// loaded; otherwise distances would depend, in their last digits, on what the process did before.
template <int swept_sphere>
Eigen::Vector3d ask_for_first_support() {
  const coal::Box box(1.0, 1.0, 1.0);
  int hint = 0;
  return coal::details::getSupport<swept_sphere>(&box, Eigen::Vector3d::Ones(), hint);
}
[[maybe_unused]] const std::array first_supports{
    ask_for_first_support<coal::details::SupportOptions::NoSweptSphere>(),
    ask_for_first_support<coal::details::SupportOptions::WithSweptSphere>()};

/// The first direction for GJK, in the frame of a.
Eigen::Vector3d first_guess(const Placed& a, const Placed& b) {
  return nonzero(a.pose.linear().transpose() * (a.center - b.center));
}

/// Coal also keeps the last support vertex inside the functor; only "cached guess" resets that at every query, and a
/// query must not depend on the one before.
void set_guess(coal::QueryRequest& request, const Placed& a, const Placed& b) {
  request.gjk_initial_guess = coal::GJKInitialGuess::CachedGuess;
  request.cached_gjk_guess = first_guess(a, b);
  request.cached_support_func_guess.setZero();
}

/// Does Coal have a formula for the distance of these two, so that it does not use GJK?
bool has_formula(coal::NODE_TYPE a, coal::NODE_TYPE b) {
  const auto beside_sphere = [](coal::NODE_TYPE type) {
    return type == coal::GEOM_SPHERE || type == coal::GEOM_BOX || type == coal::GEOM_CAPSULE ||
           type == coal::GEOM_CYLINDER;
  };
  if (a == coal::GEOM_SPHERE) return beside_sphere(b);
  if (b == coal::GEOM_SPHERE) return beside_sphere(a);
  return a == coal::GEOM_CAPSULE && b == coal::GEOM_CAPSULE;
}

}  // namespace

Bounds bounds_of(const coal::CollisionGeometry& geometry) {
  const coal::AABB& box = geometry.aabb_local;
  Bounds bounds{geometry.aabb_center, geometry.aabb_radius, box.center(), (box.max_ - box.min_) / 2};
  if (geometry.getNodeType() == coal::GEOM_SPHERE) bounds.radius = static_cast<const coal::Sphere&>(geometry).radius;
  if (geometry.getObjectType() == coal::OT_OCTREE) {
    const double error = single_precision * (box.min_.cwiseAbs().maxCoeff() + box.max_.cwiseAbs().maxCoeff());
    bounds.radius += 2 * error;
    bounds.box_half.array() += error;
  }
  return bounds;
}

Core core_of(const coal::CollisionGeometry& geometry, const Bounds& bounds) {
  const coal::NODE_TYPE type = bounds.center.isZero(0.0) ? geometry.getNodeType() : coal::BV_UNKNOWN;
  if (type == coal::GEOM_SPHERE) return {Eigen::Vector3d::Zero(), 0.0};
  if (type == coal::GEOM_CAPSULE) return {{0.0, 0.0, static_cast<const coal::Capsule&>(geometry).halfLength}, 0.0};
  return {Eigen::Vector3d::Zero(), bounds.radius};
}

bool is_convex_solid(const coal::CollisionGeometry& geometry) { return geometry.getObjectType() == coal::OT_GEOM; }

FormulaTable::FormulaTable() : known_(std::size_t{coal::NODE_COUNT} * coal::NODE_COUNT, not_known) {}

int FormulaTable::index(const coal::CollisionGeometry& a, const coal::CollisionGeometry& b) {
  const coal::NODE_TYPE type_a = a.getNodeType(), type_b = b.getNodeType();
  int& known = known_[static_cast<std::size_t>(type_a) * coal::NODE_COUNT + static_cast<std::size_t>(type_b)];
  if (known == not_known) {
    known = -1;
    if (has_formula(type_a, type_b)) {
      known = static_cast<int>(examples_.size());
      examples_.emplace_back(&a, &b);
    }
  }
  return known;
}

namespace {

OrientedBox box_around(const Placed& body) {
  return {body.pose.linear(), body.pose * body.bounds.box_center, body.bounds.box_half};
}

}  // namespace

struct NarrowPhase::Impl {
  std::vector<std::unique_ptr<Functor>> formulas;
  Gjk gjk;
  PrimitiveDistance primitives{gjk};
  coal::CollisionRequest request;
  coal::CollisionResult result;

  double by_formula(int formula, const Placed& a, const Placed& b, double margin);
};

NarrowPhase::NarrowPhase(const FormulaTable& table) : impl_(std::make_unique<Impl>()) {
  for (const auto& [a, b] : table.examples()) impl_->formulas.push_back(std::make_unique<Functor>(a, b));
  coal::CollisionRequest& request = impl_->request;
  request.enable_contact = false;
  request.num_max_contacts = 1;
  request.break_distance = 2 * contact_distance;  // do not refine bounding volumes beyond the margin
  request.collision_distance_threshold = contact_distance;
}

NarrowPhase::~NarrowPhase() = default;

void NarrowPhase::poll_with(std::function<void()> poll) { impl_->gjk.poll = std::move(poll); }

double NarrowPhase::solids(int formula, const Placed& a, const Placed& b, double margin, Separation* separation) {
  Impl& impl = *impl_;
  if (formula >= 0) {
    // Formulas give the distance less the margin, which a very large one would swallow.
    const double found = impl.by_formula(formula, a, b, std::min(margin, max_formula_margin));
    if (found < infinity || margin <= max_formula_margin) return found;
  }
  // Boxes around the two that are too far apart are cheaper than GJK.
  const double limit = margin + tolerance;
  if (squared_distance_bound(box_around(a), box_around(b)) > limit * limit) return infinity;
  Gjk& gjk = impl.gjk;
  gjk.difference.set(static_cast<const coal::ShapeBase*>(a.geometry), static_cast<const coal::ShapeBase*>(b.geometry),
                     coal_transform(a.pose), coal_transform(b.pose));
  if (!separation) return gjk.run(first_guess(a, b), margin);
  coal::support_func_guess_t vertices(separation->vertices[0], separation->vertices[1]);
  const bool known = !separation->direction.isZero(0.0);
  const double found = gjk.run(known ? separation->direction : first_guess(a, b), margin, vertices);
  separation->direction = gjk.search.ray;
  separation->vertices = {gjk.search.support_hint[0], gjk.search.support_hint[1]};
  separation->gap = found < infinity ? gjk.gap_across(gjk.search.ray) : 0.0;
  return found;
}

/// What planes lose is concave in s, so the ends of its range bound it.
double NarrowPhase::gap_in_motion(const Placed& a, const Placed& b, const Eigen::Vector3d& direction,
                                  const DirectedMotion& of_a, const DirectedMotion& of_b) {
  Gjk& gjk = impl_->gjk;
  gjk.difference.set(static_cast<const coal::ShapeBase*>(a.geometry), static_cast<const coal::ShapeBase*>(b.geometry),
                     coal_transform(a.pose), coal_transform(b.pose));
  const Eigen::Matrix3d to_a = a.pose.linear().transpose();
  const Eigen::Vector3d across = to_a * direction, slope_a = to_a * of_a.slope, slope_b = to_a * of_b.slope;
  const double shift =
      of_a.shift - of_b.shift + (of_a.slope - of_b.slope).dot(a.pose.translation());  // of the origin of a's frame
  double gap = infinity;
  for (const double s : {-1.0, 1.0})
    gap = std::min(gap, gjk.gap_along(across + s * slope_a, across + s * slope_b) + s * shift);
  return gap - of_a.rest - of_b.rest;
}

double NarrowPhase::Impl::by_formula(int formula, const Placed& a, const Placed& b, double margin) {
  gjk.count_step();
  const Functor& functor = *formulas[static_cast<std::size_t>(formula)];
  functor.point_at(a.geometry, b.geometry);
  set_guess(request, a, b);
  request.security_margin = margin;
  request.distance_upper_bound = margin + contact_distance;
  result.clear();
  if (functor(coal_transform(a.pose), coal_transform(b.pose), request, result) == 0) return infinity;
  return std::max(0.0, result.distance_lower_bound + margin);
}

double NarrowPhase::primitives(const Placed& a, const Placed& b, const PrimitiveQuery& query) {
  return impl_->primitives.find(a, b, query);
}

Proximity NarrowPhase::deepest(const Placed& a, const Placed& b, double margin) {
  coal::CollisionRequest request(coal::CONTACT, std::numeric_limits<std::size_t>::max());
  request.security_margin = margin;
  request.break_distance = 0.0;
  set_guess(request, a, b);
  coal::CollisionResult result;
  coal::collide(a.geometry, coal_transform(a.pose), b.geometry, coal_transform(b.pose), request, result);
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
  coal::distance(a.geometry, coal_transform(a.pose), b.geometry, coal_transform(b.pose), request, result);
  if (result.min_distance <= 0.0)
    return deepest(a, b, 0.0);  // for a mesh, Coal stops at the first primitive in contact
  return {result.min_distance, result.nearest_points[0], result.nearest_points[1]};
}

}  // namespace srmp::detail
