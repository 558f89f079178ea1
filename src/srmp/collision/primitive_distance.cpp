#include "srmp/collision/primitive_distance.hpp"

#include <coal/narrowphase/support_functions.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <array>
#include <functional>

namespace srmp::detail {

namespace {

/// Iterations of GJK for a box around primitives. Where they do not prove that it is too far away, its contents are
/// visited.
constexpr std::size_t node_iterations = 4;

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

/// The unit vector along which GJK separated two solids, in the frame of the first; none near contact.
std::optional<Eigen::Vector3d> separating_axis(const coal::details::GJK& gjk) {
  const double length = gjk.ray.norm();
  if (!(length > contact_distance)) return std::nullopt;
  return gjk.ray / length;
}

/// GJK is not needed for the distance of these.
bool is_cube_and_sphere(const PrimitiveBvh& tree, const Placed& solid) {
  return tree.of_cubes() && solid.geometry->getNodeType() == coal::GEOM_SPHERE;
}

/// The corners of a primitive; none of a solid.
struct Corners {
  std::array<Eigen::Vector3d, 8> points;
  std::size_t count{};

  explicit Corners(const PlacedPrimitive& part) {
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

/// A primitive of a BVH as one of Coal's shapes.
class PrimitiveDistance::Shape {
 public:
  explicit Shape(const PrimitiveBvh& tree) : tree_(&tree), cube_(tree.edge(), tree.edge(), tree.edge()) {}
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

/// What a query has found.
class PrimitiveDistance::Found {
 public:
  explicit Found(const PrimitiveQuery& query)
      : query_(query), collects_(query.candidates != nullptr), limit_(query.margin + distance_tolerance) {
    if (collects_) query_.candidates->clear();
  }

  double distance() const { return distance_; }
  /// Primitives that are proved to be farther apart need no distance.
  double limit() const { return limit_; }
  /// Primitives farther apart need no exact distance.
  double margin() const { return collects_ ? query_.margin : std::min(query_.margin, distance_); }
  bool needs(double distance) const { return collects_ ? distance < infinity : distance < distance_; }

  void count_box() {
    if (collects_ && ++boxes_ > PrimitiveQuery::max_boxes) give_up_candidates();
  }
  /// Adds a distance that is needed; true: it is enough.
  bool add(double distance, std::size_t a, std::size_t b) {
    distance_ = std::min(distance_, distance);
    if (collects_ && query_.candidates->size() == PrimitiveQuery::max_candidates) give_up_candidates();
    if (collects_) {
      query_.candidates->push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)});
      return false;
    }
    lower_limit();
    return distance_ <= query_.enough;
  }

 private:
  void give_up_candidates() {
    collects_ = false;
    query_.candidates->clear();
    lower_limit();
  }
  void lower_limit() { limit_ = std::min(limit_, distance_ + distance_tolerance); }

  const PrimitiveQuery& query_;
  bool collects_;
  int boxes_{};
  double distance_{infinity}, limit_;
};

PrimitiveDistance::PrimitiveDistance(Gjk& gjk) : gjk_(gjk), short_gjk_(node_iterations, coal::GJK_DEFAULT_TOLERANCE) {
  open_.reserve(256);
}

double PrimitiveDistance::find(const Placed& a, const Placed& b, const PrimitiveQuery& query) {
  axes_.clear();
  separation_queries_ = 0;
  if (a.bvh && b.bvh) return primitives_to_primitives(a, b, query);
  if (!a.bvh) return solid_to_primitives(a, b, query);
  if (!query.stays_separated) return solid_to_primitives(b, a, query);
  const auto swapped = [&](const SeparatedParts& parts) {
    return query.stays_separated({parts.direction, parts.gap, parts.b, parts.a});
  };
  PrimitiveQuery other = query;
  other.stays_separated = std::cref(swapped);
  return solid_to_primitives(b, a, other);
}

/// Keeps the axis that separates the primitives of a and b that GJK ran for last. `to_a`: from the frame of b.
void PrimitiveDistance::add_axis(const Eigen::Isometry3d& to_a) {
  if (const auto axis = separating_axis(gjk_.search))
    axes_.add({*axis, to_a.linear().transpose() * *axis, -axis->dot(to_a.translation())});
}

/// The same of the solid and a primitive. The solid's projection is part of the offset.
void PrimitiveDistance::add_axis_of_solid(const coal::details::GJK& separated, const Eigen::Isometry3d& to_tree) {
  const auto axis = separating_axis(separated);
  if (!axis) return;
  const Eigen::Vector3d in_tree = to_tree.linear() * *axis;
  coal::support_func_guess_t vertices = separated.support_hint;
  Eigen::Vector3d nearest, of_primitive;
  gjk_.difference.support(-*axis, nearest, of_primitive, vertices);
  axes_.add({*axis, in_tree,
             axis->dot(nearest) - gjk_.difference.swept_sphere_radius[0] + in_tree.dot(to_tree.translation())});
}

/// Are the two of `difference`, which GJK found apart last, known to stay so? `pose`: of the first one's frame.
bool PrimitiveDistance::is_kept_separated(const Eigen::Isometry3d& pose, const PlacedPrimitive& a,
                                          const PlacedPrimitive& b, const StaysSeparated& stays_separated) {
  if (!stays_separated || ++separation_queries_ > PrimitiveQuery::max_separations) return false;
  const double gap = gjk_.gap_across(gjk_.search.ray);
  if (!(gap > 0.0)) return false;
  const Corners of_a(a), of_b(b);
  return stays_separated({pose.linear() * gjk_.search.ray.normalized(), gap, of_a.all(), of_b.all()});
}

/// `to_tree`: from the solid's frame.
double PrimitiveDistance::solid_to_primitive(const Placed& solid, const PrimitiveBvh& tree, std::size_t primitive,
                                             const Eigen::Isometry3d& to_tree, Shape& shape, double margin) {
  const Eigen::Vector3d origin = shape.set(primitive);
  if (is_cube_and_sphere(tree, solid)) {
    const Eigen::Vector3d off = (to_tree.translation() - origin).cwiseAbs();
    const double distance = (off.array() - tree.edge() / 2).cwiseMax(0.0).matrix().norm() - solid.bounds.radius;
    return distance <= margin + contact_distance ? std::max(0.0, distance) : infinity;
  }
  gjk_.difference.set(static_cast<const coal::ShapeBase*>(solid.geometry), shape.shape(), coal_transform(to_tree),
                      coal::Transform3s(Eigen::Matrix3d::Identity(), origin));
  const Eigen::Vector3d guess =
      to_tree.linear().transpose() * (to_tree * solid.bounds.center - middle_of(tree, primitive));
  return gjk_.run(nonzero(guess), margin);
}

/// Is the box around primitives farther from the solid than `limit`? A solid may be far from its own bounding box. True
/// is proved; false may also be said of a box that is farther.
bool PrimitiveDistance::is_beyond(const Placed& solid, const RoundedBox& box, const Eigen::Isometry3d& to_tree,
                                  double limit) {
  const auto distance_along = [&](const SeparatingAxes::Axis& axis) {
    return axis.offset - support_along(axis.in_b, box);
  };
  if (axes_.separate(limit, distance_along)) return true;
  if (last_box_ && squared_distance(last_box_->point, box) <= limit * limit) return false;
  if (!last_box_) {
    const Eigen::Vector3d guess = to_tree.linear().transpose() * (to_tree * solid.bounds.center - box.center3d());
    last_box_.emplace(nonzero(guess).normalized());
  }
  gjk_.count_step();
  box_.halfSide = box.half_extents3d();
  gjk_.difference.set(static_cast<const coal::ShapeBase*>(solid.geometry), &box_, coal_transform(to_tree),
                      coal::Transform3s(box.axes3d(), box.center3d()));
  short_gjk_.setDistanceEarlyBreak(limit + distance_tolerance);
  short_gjk_.evaluate(gjk_.difference, last_box_->ray, last_box_->vertices);
  const coal::details::GJK::Simplex& simplex = *short_gjk_.getSimplex();
  last_box_->point = to_tree * simplex.vertex[simplex.rank - 1]->w0;
  last_box_->vertices = short_gjk_.support_hint;
  last_box_->ray = nonzero(short_gjk_.ray).normalized();
  if (short_gjk_.status != coal::details::GJK::NoCollisionEarlyStopped) return false;
  add_axis_of_solid(short_gjk_, to_tree);
  return true;
}

/// Leaves those of the node's boxes that are not too far for later, the nearest, or deepest, last. entry(box, bound) is
/// the Open one.
template <class Entry>
void PrimitiveDistance::open_near(const PrimitiveBvh& tree, std::uint32_t node, const Eigen::Array4f& squared_bounds,
                                  double limit, Entry&& entry) {
  const std::size_t first = open_.size();
  open_.resize(first + RoundedBoxes::count);
  const double squared_limit = limit * limit;
  const int size = tree.nodes()[node].size;
  std::size_t end = first;
  for (int i = 0; i < size; ++i) {  // without a jump that depends on the bound
    const float bound = squared_bounds[i];
    open_[end] = entry(RoundedBoxes::count * node + static_cast<std::uint32_t>(i), bound);
    end += static_cast<std::size_t>(!(bound > squared_limit));
  }
  for (std::size_t i = first + 1; i < end; ++i)
    for (std::size_t k = i; k > first && open_[k - 1].squared_distance_bound < open_[k].squared_distance_bound; --k)
      std::swap(open_[k - 1], open_[k]);
  open_.resize(end);
}

/// One more box or pair of boxes.
void PrimitiveDistance::count_visit(Found& found) {
  gjk_.count_step();
  found.count_box();
}

/// Is one left that may be within the limit? It is the last one then.
bool PrimitiveDistance::is_near_left(const Found& found) {
  const double squared_limit = found.limit() * found.limit();
  while (!open_.empty() && open_.back().squared_distance_bound > squared_limit) open_.pop_back();
  return !open_.empty();
}

double PrimitiveDistance::solid_to_primitives(const Placed& solid, const Placed& other, const PrimitiveQuery& query) {
  const PrimitiveBvh& tree = *other.bvh;
  const Eigen::Isometry3d to_tree = other.pose.inverse(Eigen::Isometry) * solid.pose;
  const RoundedBox box(to_tree.linear(), to_tree * solid.bounds.box_center, solid.bounds.box_half);
  const RoundedBoxes boxes(box);
  const BoxDistanceBounds distances(Eigen::Isometry3d::Identity(), tree.reach(), box.reach());
  Shape shape(tree);
  const bool by_gjk = !is_cube_and_sphere(tree, solid);
  const bool fills_its_box_badly = dynamic_cast<const coal::ConvexBase*>(solid.geometry) != nullptr;
  const float size = box.squared_size();  // hardly any larger box is beside the solid, not its box
  Found found(query);
  last_box_.reset();
  /// True: the query ends.
  const auto add = [&](std::size_t i) {
    const auto distance_along = [&](const SeparatingAxes::Axis& axis) {
      return axis.offset - support_along(axis.in_b, tree, i);
    };
    if (axes_.separate(found.limit(), distance_along)) return false;
    const double distance = solid_to_primitive(solid, tree, i, to_tree, shape, found.margin());
    if (by_gjk) add_axis_of_solid(gjk_.search, to_tree);
    if (!found.needs(distance)) return false;
    if (by_gjk && distance > contact_distance &&
        is_kept_separated(solid.pose, {}, {&tree, i, &other.pose}, query.stays_separated))
      return false;
    return found.add(distance, i, 0);
  };
  const auto open_in = [&](std::uint32_t node) {
    open_near(tree, node, distances.squared_bounds(tree.nodes()[node].boxes, boxes), found.limit(),
              [](PrimitiveBvh::BoxNumber number, float bound) { return Open{bound, number, 0}; });
  };
  for (const PrimitivePair& pair : query.among)
    if (add(pair.a)) break;
  open_.clear();
  if (query.among.empty()) open_in(0);
  while (is_near_left(found)) {
    count_visit(found);
    const PrimitiveBvh::BoxNumber number = open_.back().a;
    open_.pop_back();
    const PrimitiveBvh::Part& part = tree.part(number);
    for (std::size_t i = part.first; i < part.first + part.size; ++i)
      if (add(i)) return found.distance();
    if (!part.has_primitives() && !(fills_its_box_badly && tree.squared_size(number) < size &&
                                    is_beyond(solid, tree.box(number), to_tree, found.limit())))
      open_in(part.first);
  }
  return found.distance();
}

double PrimitiveDistance::primitives_to_primitives(const Placed& a, const Placed& b, const PrimitiveQuery& query) {
  const PrimitiveBvh &tree_a = *a.bvh, &tree_b = *b.bvh;
  const Eigen::Isometry3d to_a = a.pose.inverse(Eigen::Isometry) * b.pose;
  Shape shape_a(tree_a), shape_b(tree_b);
  Found found(query);
  /// True: the query ends.
  const auto add = [&](std::size_t i, std::size_t j) {
    const auto distance_along = [&](const SeparatingAxes::Axis& axis) {
      return axis.offset - support_along(-axis.in_a, tree_a, i) - support_along(axis.in_b, tree_b, j);
    };
    if (axes_.separate(found.limit(), distance_along)) return false;
    const Eigen::Vector3d origin_a = shape_a.set(i), origin_b = shape_b.set(j);
    gjk_.difference.set(shape_a.shape(), shape_b.shape(), coal::Transform3s(Eigen::Matrix3d::Identity(), origin_a),
                        coal::Transform3s(to_a.linear(), to_a * origin_b));
    const Eigen::Vector3d guess = middle_of(tree_a, i) - to_a * middle_of(tree_b, j);
    const double distance = gjk_.run(nonzero(guess), found.margin());
    add_axis(to_a);
    if (!found.needs(distance)) return false;
    if (distance > contact_distance &&
        is_kept_separated(a.pose, {&tree_a, i, &a.pose}, {&tree_b, j, &b.pose}, query.stays_separated))
      return false;
    return found.add(distance, i, j);
  };
  const BoxDistanceBounds distances(to_a, tree_a.reach(), tree_b.reach());
  // Boxes of one tree beside a box of the other.
  const auto open_in_a = [&](std::uint32_t node, PrimitiveBvh::BoxNumber b_box) {
    const RoundedBoxes beside = distances.in_a(tree_b.repeated_box(b_box));
    open_near(tree_a, node, distances.squared_bounds(tree_a.nodes()[node].boxes, beside), found.limit(),
              [&](PrimitiveBvh::BoxNumber number, float bound) { return Open{bound, number, b_box}; });
  };
  const auto open_in_b = [&](std::uint32_t node, PrimitiveBvh::BoxNumber a_box) {
    const RoundedBoxes beside = distances.in_b(tree_a.repeated_box(a_box));
    open_near(tree_b, node, distances.squared_bounds(beside, tree_b.nodes()[node].boxes), found.limit(),
              [&](PrimitiveBvh::BoxNumber number, float bound) { return Open{bound, a_box, number}; });
  };
  for (const PrimitivePair& pair : query.among)
    if (add(pair.a, pair.b)) break;
  open_.clear();
  if (query.among.empty()) open_in_a(0, 0);
  while (is_near_left(found)) {
    count_visit(found);
    const PrimitiveBvh::BoxNumber box_a = open_.back().a, box_b = open_.back().b;
    open_.pop_back();
    const PrimitiveBvh::Part &part_a = tree_a.part(box_a), &part_b = tree_b.part(box_b);
    const bool ends_a = part_a.has_primitives(), ends_b = part_b.has_primitives();
    if (!ends_a && (ends_b || tree_a.squared_size(box_a) >= tree_b.squared_size(box_b))) {
      open_in_a(part_a.first, box_b);
    } else if (!ends_b) {
      open_in_b(part_b.first, box_a);
    } else {
      for (std::size_t i = part_a.first; i < part_a.first + part_a.size; ++i)
        for (std::size_t j = part_b.first; j < part_b.first + part_b.size; ++j)
          if (add(i, j)) return found.distance();
    }
  }
  return found.distance();
}

}  // namespace srmp::detail
