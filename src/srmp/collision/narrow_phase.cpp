#include "srmp/collision/narrow_phase.hpp"

#include <coal/collision.h>
#include <coal/distance.h>
#include <coal/narrowphase/gjk.h>
#include <coal/narrowphase/minkowski_difference.h>
#include <coal/narrowphase/support_functions.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <optional>

#include "srmp/collision/oriented_box.hpp"

namespace srmp::detail {

namespace {

coal::Transform3s transform(const Eigen::Isometry3d& pose) { return {pose.linear(), pose.translation()}; }

constexpr double max_formula_margin = 1e4;  // [m]

/// Octrees and their boxes are stored in single precision: a relative error bound.
constexpr double single_precision = 1e-6;

/// When GJK runs out of iterations, its distance is too large by less than this [m].
constexpr double unconverged = 1e-3;

/// Iterations of GJK for a box around primitives. Where they do not prove that it is too far away, its contents are
/// visited.
constexpr std::size_t node_iterations = 4;

constexpr unsigned steps_per_poll = 64;  // distances of solids, or of bounding boxes

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

/// A direction for GJK.
Eigen::Vector3d nonzero(const Eigen::Vector3d& guess) {
  return guess.squaredNorm() > 1e-12 ? guess : Eigen::Vector3d(1, 0, 0);
}

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

Eigen::Vector3d middle_of(const PrimitiveBvh& tree, std::size_t primitive) {
  if (tree.of_cubes()) return tree.cubes()[primitive];
  const PrimitiveBvh::Triangle& t = tree.triangles()[primitive];
  return (t[0] + t[1] + t[2]) / 3;
}

/// The largest product of a point of the primitive with the direction.
double support_along(const Eigen::Vector3d& direction, const PrimitiveBvh& tree, std::size_t primitive) {
  if (tree.of_cubes()) return direction.dot(tree.cubes()[primitive]) + tree.edge() / 2 * direction.lpNorm<1>();
  const PrimitiveBvh::Triangle& t = tree.triangles()[primitive];
  return std::max({direction.dot(t[0]), direction.dot(t[1]), direction.dot(t[2])});
}

/// The axes that separated primitives in the last runs of GJK. Neighbours of these primitives are often separated by
/// one of them too, which two projections show.
class SeparatingAxes {
 public:
  struct Axis {
    Eigen::Vector3d in_a, in_b;  // the unit vector from b to a, in the frame of each
    double offset;               // the distance along the axis of what is projected, where both projections are 0
  };

  void clear() { count_ = 0; }
  /// In place of the oldest one.
  void add(const Axis& axis) { axes_[count_++ % axes_.size()] = axis; }
  /// Is the distance along one of them, by this function of an axis, more than `limit`?
  template <class Distance>
  bool separate(double limit, Distance&& distance_along) const {
    const auto end = axes_.begin() + static_cast<std::ptrdiff_t>(std::min(count_, axes_.size()));
    return std::any_of(axes_.begin(), end, [&](const Axis& axis) { return distance_along(axis) > limit; });
  }

 private:
  std::array<Axis, 3> axes_;
  std::size_t count_{};
};

/// The unit vector along which GJK separated two solids, in the frame of the first; none near contact.
std::optional<Eigen::Vector3d> separating_axis(const coal::details::GJK& gjk) {
  const double length = gjk.ray.norm();
  if (!(length > NarrowPhase::contact_distance)) return std::nullopt;
  return gjk.ray / length;
}

/// A primitive of a BVH as one of Coal's shapes.
class PrimitiveShape {
 public:
  explicit PrimitiveShape(const PrimitiveBvh& tree) : tree_(&tree), cube_(tree.edge(), tree.edge(), tree.edge()) {}
  const coal::ShapeBase* shape() const {
    if (tree_->of_cubes()) return &cube_;
    return &triangle_;
  }
  /// Changes shape() into the primitive; returns its frame's origin in the tree's frame.
  Eigen::Vector3d set(std::size_t primitive) {
    if (tree_->of_cubes()) return tree_->cubes()[primitive];
    const PrimitiveBvh::Triangle& t = tree_->triangles()[primitive];
    triangle_.a = t[0], triangle_.b = t[1], triangle_.c = t[2];
    return Eigen::Vector3d::Zero();
  }

 private:
  const PrimitiveBvh* tree_;
  coal::TriangleP triangle_;
  coal::Box cube_;
};

/// GJK is not needed for the distance of these.
bool is_cube_and_sphere(const PrimitiveBvh& tree, const Placed& solid) {
  return tree.of_cubes() && solid.geometry->getNodeType() == coal::GEOM_SPHERE;
}

/// A primitive of a BVH at a pose; null: all of a solid.
struct Part {
  const PrimitiveBvh* tree{};
  std::size_t primitive{};
  const Eigen::Isometry3d* pose{};
};

/// The corners of a primitive; none of a solid.
struct Corners {
  std::array<Eigen::Vector3d, 8> points;
  std::size_t count{};

  explicit Corners(const Part& part) {
    if (!part.tree) return;
    const PrimitiveBvh& tree = *part.tree;
    const Eigen::Isometry3d& pose = *part.pose;
    if (!tree.of_cubes()) {
      for (const Eigen::Vector3d& corner : tree.triangles()[part.primitive]) points[count++] = pose * corner;
      return;
    }
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5})
        for (const double z : {-0.5, 0.5})
          points[count++] = pose * (tree.cubes()[part.primitive] + tree.edge() * Eigen::Vector3d(x, y, z));
  }
  std::span<const Eigen::Vector3d> all() const { return {points.data(), count}; }
};

}  // namespace

struct NarrowPhase::Impl {
  std::vector<std::unique_ptr<Functor>> formulas;
  coal::details::GJK gjk{coal::GJK_DEFAULT_MAX_ITERATIONS, coal::GJK_DEFAULT_TOLERANCE};
  coal::details::GJK short_gjk{node_iterations, coal::GJK_DEFAULT_TOLERANCE};
  coal::details::MinkowskiDiff difference;
  coal::CollisionRequest request;
  coal::CollisionResult result;
  struct Open {
    float squared_distance_bound;
    std::uint32_t a, b;
  };
  /// What GJK found of a solid and a box around primitives, with which it begins at the next box.
  struct NearBox {
    explicit NearBox(const Eigen::Vector3d& guess) : ray(guess) {}
    Eigen::Vector3d ray;                                                      // in the solid's frame
    coal::support_func_guess_t vertices{coal::support_func_guess_t::Zero()};  // hints
    Eigen::Vector3d point;                                                    // of the solid, in the tree's frame
  };
  std::vector<Open> open;
  SeparatingAxes axes;              // in this query
  int separation_queries{};         // in this query
  std::optional<NearBox> last_box;  // in this query
  coal::Box box{1, 1, 1};
  std::function<void()> poll = [] {};
  unsigned steps{};

  void count_step() {
    if (++steps % steps_per_poll == 0) poll();
  }
  double run_gjk(const Eigen::Vector3d& guess, double margin,
                 const coal::support_func_guess_t& hint = coal::support_func_guess_t::Zero());
  double gap_across(const Eigen::Vector3d& direction) const;
  void add_axis_of_solid(const coal::details::GJK& separated, const Eigen::Isometry3d& to_tree);
  void add_axis(const Eigen::Isometry3d& to_a);
  double by_formula(int formula, const Placed& a, const Placed& b, double margin);
  double solid_to_primitive(const Placed& solid, const PrimitiveBvh& tree, std::size_t primitive,
                            const Eigen::Isometry3d& to_tree, PrimitiveShape& shape, double margin);
  bool is_beyond(const Placed& solid, const PrimitiveBvh::Node& node, const Eigen::Isometry3d& to_tree, double limit);
  bool is_kept_separated(const Eigen::Isometry3d& pose, const Part& a, const Part& b,
                         const StaysSeparated& stays_separated);
  double solid_to_primitives(const Placed& solid, const Placed& other, double margin, double enough,
                             const StaysSeparated& stays_separated);
  double primitives_to_primitives(const Placed& a, const Placed& b, double margin, double enough,
                                  const StaysSeparated& stays_separated);
  void push_nearer_last(const Open& one, const Open& other, double limit);
};

NarrowPhase::NarrowPhase(const FormulaTable& table) : impl_(std::make_unique<Impl>()) {
  for (const auto& [a, b] : table.examples()) impl_->formulas.push_back(std::make_unique<Functor>(a, b));
  impl_->open.reserve(256);
  impl_->gjk.gjk_variant = coal::GJKVariant::DefaultGJK;
  impl_->gjk.convergence_criterion = coal::GJKConvergenceCriterion::Default;
  impl_->gjk.convergence_criterion_type = coal::GJKConvergenceCriterionType::Relative;
  coal::CollisionRequest& request = impl_->request;
  request.enable_contact = false;
  request.num_max_contacts = 1;
  request.break_distance = 2 * contact_distance;  // do not refine bounding volumes beyond the margin
  request.collision_distance_threshold = contact_distance;
}

NarrowPhase::~NarrowPhase() = default;

void NarrowPhase::poll_with(std::function<void()> poll) { impl_->poll = std::move(poll); }

/// Runs GJK on `difference` as Coal's functors do, without their allocations. evaluate() starts afresh every time.
double NarrowPhase::Impl::run_gjk(const Eigen::Vector3d& guess, double margin, const coal::support_func_guess_t& hint) {
  count_step();
  gjk.setDistanceEarlyBreak(margin + contact_distance);  // it stops once more than this is proved
  gjk.evaluate(difference, guess, hint);
  double distance = std::max(0.0, gjk.distance);
  switch (gjk.status) {
    case coal::details::GJK::Collision:
    case coal::details::GJK::CollisionWithPenetrationInformation: break;
    case coal::details::GJK::NoCollisionEarlyStopped: return infinity;
    case coal::details::GJK::NoCollision: break;
    default: distance = std::max(0.0, distance - unconverged);
  }
  return distance <= margin + contact_distance ? distance : infinity;
}

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
  impl.difference.set(static_cast<const coal::ShapeBase*>(a.geometry), static_cast<const coal::ShapeBase*>(b.geometry),
                      transform(a.pose), transform(b.pose));
  if (!separation) return impl.run_gjk(first_guess(a, b), margin);
  coal::support_func_guess_t vertices(separation->vertices[0], separation->vertices[1]);
  const bool known = !separation->direction.isZero(0.0);
  const double found = impl.run_gjk(known ? separation->direction : first_guess(a, b), margin, vertices);
  separation->direction = impl.gjk.ray;
  separation->vertices = {impl.gjk.support_hint[0], impl.gjk.support_hint[1]};
  separation->gap = found < infinity ? impl.gap_across(impl.gjk.ray) : 0.0;
  return found;
}

/// The distance of two planes across the direction that separate the solids of `difference`.
double NarrowPhase::Impl::gap_across(const Eigen::Vector3d& direction) const {
  const double length = direction.norm();
  if (!(length > contact_distance)) return 0.0;
  coal::support_func_guess_t vertices = gjk.support_hint;
  Eigen::Vector3d a, b;
  difference.support(-direction, a, b, vertices);
  return std::max(0.0, direction.dot(a - b) / length - difference.swept_sphere_radius.sum());
}

/// Keeps the axis that separates the primitives of a and b that GJK ran for last. `to_a`: from the frame of b.
void NarrowPhase::Impl::add_axis(const Eigen::Isometry3d& to_a) {
  if (const auto axis = separating_axis(gjk))
    axes.add({*axis, to_a.linear().transpose() * *axis, -axis->dot(to_a.translation())});
}

/// The same of the solid and a primitive. The solid's projection is part of the offset.
void NarrowPhase::Impl::add_axis_of_solid(const coal::details::GJK& separated, const Eigen::Isometry3d& to_tree) {
  const auto axis = separating_axis(separated);
  if (!axis) return;
  const Eigen::Vector3d in_tree = to_tree.linear() * *axis;
  coal::support_func_guess_t vertices = separated.support_hint;
  Eigen::Vector3d nearest, of_primitive;
  difference.support(-*axis, nearest, of_primitive, vertices);
  axes.add(
      {*axis, in_tree, axis->dot(nearest) - difference.swept_sphere_radius[0] + in_tree.dot(to_tree.translation())});
}

double NarrowPhase::Impl::by_formula(int formula, const Placed& a, const Placed& b, double margin) {
  count_step();
  const Functor& functor = *formulas[static_cast<std::size_t>(formula)];
  functor.point_at(a.geometry, b.geometry);
  set_guess(request, a, b);
  request.security_margin = margin;
  request.distance_upper_bound = margin + contact_distance;
  result.clear();
  if (functor(transform(a.pose), transform(b.pose), request, result) == 0) return infinity;
  return std::max(0.0, result.distance_lower_bound + margin);
}

double NarrowPhase::primitives(const Placed& a, const Placed& b, double margin, double enough,
                               const StaysSeparated& stays_separated) {
  if (!a.bvh) return impl_->solid_to_primitives(a, b, margin, enough, stays_separated);
  if (b.bvh) return impl_->primitives_to_primitives(a, b, margin, enough, stays_separated);
  if (!stays_separated) return impl_->solid_to_primitives(b, a, margin, enough, stays_separated);
  const auto swapped = [&](const SeparatedParts& parts) {
    return stays_separated({parts.direction, parts.gap, parts.b, parts.a});
  };
  return impl_->solid_to_primitives(b, a, margin, enough, std::cref(swapped));
}

/// Are the two of `difference`, which GJK found apart last, known to stay so? `pose`: of the first one's frame.
bool NarrowPhase::Impl::is_kept_separated(const Eigen::Isometry3d& pose, const Part& a, const Part& b,
                                          const StaysSeparated& stays_separated) {
  if (!stays_separated || ++separation_queries > max_separation_queries) return false;
  const double gap = gap_across(gjk.ray);
  if (!(gap > 0.0)) return false;
  const Corners of_a(a), of_b(b);
  return stays_separated({pose.linear() * gjk.ray.normalized(), gap, of_a.all(), of_b.all()});
}

/// `to_tree`: from the solid's frame.
double NarrowPhase::Impl::solid_to_primitive(const Placed& solid, const PrimitiveBvh& tree, std::size_t primitive,
                                             const Eigen::Isometry3d& to_tree, PrimitiveShape& shape, double margin) {
  const Eigen::Vector3d origin = shape.set(primitive);
  if (is_cube_and_sphere(tree, solid)) {
    const Eigen::Vector3d off = (to_tree.translation() - origin).cwiseAbs();
    const double distance = (off.array() - tree.edge() / 2).cwiseMax(0.0).matrix().norm() - solid.bounds.radius;
    return distance <= margin + contact_distance ? std::max(0.0, distance) : infinity;
  }
  difference.set(static_cast<const coal::ShapeBase*>(solid.geometry), shape.shape(), transform(to_tree),
                 coal::Transform3s(Eigen::Matrix3d::Identity(), origin));
  const Eigen::Vector3d guess =
      to_tree.linear().transpose() * (to_tree * solid.bounds.center - middle_of(tree, primitive));
  return run_gjk(nonzero(guess), margin);
}

/// Is the box around primitives farther from the solid than `limit`? A solid may be far from its own bounding box. True
/// is proved; false may also be said of a box that is farther.
bool NarrowPhase::Impl::is_beyond(const Placed& solid, const PrimitiveBvh::Node& node, const Eigen::Isometry3d& to_tree,
                                  double limit) {
  const auto distance_along = [&](const SeparatingAxes::Axis& axis) {
    return axis.offset - support_along(axis.in_b, node.box);
  };
  if (axes.separate(limit, distance_along)) return true;
  if (last_box && squared_distance(last_box->point, node.box) <= limit * limit) return false;
  if (!last_box) {
    const Eigen::Vector3d guess = to_tree.linear().transpose() * (to_tree * solid.bounds.center - node.box.center3d());
    last_box.emplace(nonzero(guess).normalized());
  }
  count_step();
  box.halfSide = node.box.half_extents3d();
  difference.set(static_cast<const coal::ShapeBase*>(solid.geometry), &box, transform(to_tree),
                 coal::Transform3s(node.box.axes(), node.box.center3d()));
  short_gjk.setDistanceEarlyBreak(limit + tolerance);
  short_gjk.evaluate(difference, last_box->ray, last_box->vertices);
  const coal::details::GJK::Simplex& simplex = *short_gjk.getSimplex();
  last_box->point = to_tree * simplex.vertex[simplex.rank - 1]->w0;
  last_box->vertices = short_gjk.support_hint;
  last_box->ray = nonzero(short_gjk.ray).normalized();
  if (short_gjk.status != coal::details::GJK::NoCollisionEarlyStopped) return false;
  add_axis_of_solid(short_gjk, to_tree);
  return true;
}

/// The nearer of the two is visited first; what is too far is not visited.
void NarrowPhase::Impl::push_nearer_last(const Open& one, const Open& other, double limit) {
  const Open &far = one.squared_distance_bound > other.squared_distance_bound ? one : other,
             &near = &far == &one ? other : one;
  if (!(far.squared_distance_bound > limit * limit)) open.push_back(far);
  if (!(near.squared_distance_bound > limit * limit)) open.push_back(near);
}

double NarrowPhase::Impl::solid_to_primitives(const Placed& solid, const Placed& other, double margin, double enough,
                                              const StaysSeparated& stays_separated) {
  const PrimitiveBvh& tree = *other.bvh;
  const Eigen::Isometry3d to_tree = other.pose.inverse(Eigen::Isometry) * solid.pose;
  const RoundedBox box(to_tree.linear(), to_tree * solid.bounds.box_center, solid.bounds.box_half);
  const BoxDistanceBounds distances(Eigen::Isometry3d::Identity(), tree.reach(), box.reach());
  PrimitiveShape shape(tree);
  const bool by_gjk = !is_cube_and_sphere(tree, solid);
  const bool fills_its_box_badly = dynamic_cast<const coal::ConvexBase*>(solid.geometry) != nullptr;
  const float size = box.half_extents.squaredNorm();  // hardly any larger box is beside the solid, not its box
  double best = infinity, limit = margin + tolerance;
  axes.clear();
  separation_queries = 0;
  last_box.reset();
  const auto bound_to = [&](std::uint32_t node) {
    return distances.squared_bound(tree.nodes()[node].box, box, static_cast<float>(limit * limit));
  };
  open.assign(1, {bound_to(0), 0, 0});
  while (!open.empty()) {
    count_step();
    const Open next = open.back();
    open.pop_back();
    if (next.squared_distance_bound > limit * limit) continue;
    const PrimitiveBvh::Node& node = tree.nodes()[next.a];
    if (node.size == 0) {
      if (fills_its_box_badly && node.box.half_extents.squaredNorm() < size && is_beyond(solid, node, to_tree, limit))
        continue;
      push_nearer_last({bound_to(next.a + 1), next.a + 1, 0}, {bound_to(node.right), node.right, 0}, limit);
      continue;
    }
    for (std::size_t i = node.first; i < node.first + node.size; ++i) {
      const auto distance_along = [&](const SeparatingAxes::Axis& axis) {
        return axis.offset - support_along(axis.in_b, tree, i);
      };
      if (axes.separate(limit, distance_along)) continue;
      const double found = solid_to_primitive(solid, tree, i, to_tree, shape, std::min(margin, best));
      if (by_gjk) add_axis_of_solid(gjk, to_tree);
      if (found >= best) continue;
      if (by_gjk && found > contact_distance &&
          is_kept_separated(solid.pose, {}, {&tree, i, &other.pose}, stays_separated))
        continue;
      best = found;
      if (best <= enough) return best;
      limit = std::min(limit, best + tolerance);
    }
  }
  return best;
}

double NarrowPhase::Impl::primitives_to_primitives(const Placed& a, const Placed& b, double margin, double enough,
                                                   const StaysSeparated& stays_separated) {
  const PrimitiveBvh &tree_a = *a.bvh, &tree_b = *b.bvh;
  const Eigen::Isometry3d to_a = a.pose.inverse(Eigen::Isometry) * b.pose;
  PrimitiveShape shape_a(tree_a), shape_b(tree_b);
  double best = infinity, limit = margin + tolerance;
  axes.clear();
  separation_queries = 0;
  const BoxDistanceBounds distances(to_a, tree_a.reach(), tree_b.reach());
  const auto box_of_b = [&](std::uint32_t j) { return distances.in_a(tree_b.nodes()[j].box); };
  const auto entry = [&](std::uint32_t i, std::uint32_t j, const RoundedBox& b_box) {
    return Open{distances.squared_bound(tree_a.nodes()[i].box, b_box, static_cast<float>(limit * limit)), i, j};
  };
  open.assign(1, entry(0, 0, box_of_b(0)));
  while (!open.empty()) {
    count_step();
    const Open next = open.back();
    open.pop_back();
    if (next.squared_distance_bound > limit * limit) continue;
    const PrimitiveBvh::Node &node_a = tree_a.nodes()[next.a], &node_b = tree_b.nodes()[next.b];
    const bool leaf_a = node_a.size > 0, leaf_b = node_b.size > 0;
    if (!leaf_a && (leaf_b || node_a.box.half_extents.squaredNorm() >= node_b.box.half_extents.squaredNorm())) {
      const RoundedBox b_box = box_of_b(next.b);
      push_nearer_last(entry(next.a + 1, next.b, b_box), entry(node_a.right, next.b, b_box), limit);
      continue;
    }
    if (!leaf_b) {
      push_nearer_last(entry(next.a, next.b + 1, box_of_b(next.b + 1)),
                       entry(next.a, node_b.right, box_of_b(node_b.right)), limit);
      continue;
    }
    for (std::size_t i = node_a.first; i < node_a.first + node_a.size; ++i)
      for (std::size_t j = node_b.first; j < node_b.first + node_b.size; ++j) {
        const auto distance_along = [&](const SeparatingAxes::Axis& axis) {
          return axis.offset - support_along(-axis.in_a, tree_a, i) - support_along(axis.in_b, tree_b, j);
        };
        if (axes.separate(limit, distance_along)) continue;
        const Eigen::Vector3d origin_a = shape_a.set(i), origin_b = shape_b.set(j);
        difference.set(shape_a.shape(), shape_b.shape(), coal::Transform3s(Eigen::Matrix3d::Identity(), origin_a),
                       coal::Transform3s(to_a.linear(), to_a * origin_b));
        const Eigen::Vector3d guess = node_a.box.center3d() - to_a * node_b.box.center3d();
        const double found = run_gjk(nonzero(guess), std::min(margin, best));
        add_axis(to_a);
        if (found >= best) continue;
        if (found > contact_distance &&
            is_kept_separated(a.pose, {&tree_a, i, &a.pose}, {&tree_b, j, &b.pose}, stays_separated))
          continue;
        best = found;
        if (best <= enough) return best;
        limit = std::min(limit, best + tolerance);
      }
  }
  return best;
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
  if (result.min_distance <= 0.0)
    return deepest(a, b, 0.0);  // for a mesh, Coal stops at the first primitive in contact
  return {result.min_distance, result.nearest_points[0], result.nearest_points[1]};
}

}  // namespace srmp::detail
