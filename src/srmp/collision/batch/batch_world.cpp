#include "srmp/collision/batch/batch_world.hpp"

#include <coal/shape/geometric_shapes.h>

#include <map>
#include <numeric>
#include <string_view>
#include <utility>

#include "srmp/collision/bodies.hpp"
#include "srmp/cover/quick_cover.hpp"

namespace srmp::detail {

namespace {

Eigen::Isometry3d frame_on_axis(const std::pair<Eigen::Vector3d, Eigen::Vector3d>& axis) {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  const Eigen::Vector3d z = axis.second.normalized(), x = z.unitOrthogonal();
  frame.linear() << x, z.cross(x), z;
  frame.translation() = axis.first;
  return frame;
}

/// A small sphere around spheres (Badoiu and Clarkson 2003).
PlacedSphere around(const std::vector<PlacedSphere>& spheres) {
  if (spheres.size() == 1) return spheres.front();
  PlacedSphere result{spheres.front().center, 0};
  const auto farthest = [&] {
    const PlacedSphere* far = &spheres.front();
    for (const PlacedSphere& b : spheres)
      if ((b.center - result.center).norm() + b.radius > (far->center - result.center).norm() + far->radius) far = &b;
    return *far;
  };
  for (int i = 1; i <= 30; ++i) {
    const PlacedSphere far = farthest();
    const Eigen::Vector3d offset = far.center - result.center;
    const double distance = offset.norm();
    if (distance > 0) result.center += offset * ((distance + far.radius) / distance / (i + 1));
  }
  const PlacedSphere far = farthest();
  result.radius = ((far.center - result.center).norm() + far.radius) * (1 + 1e-12);
  return result;
}

/// The cover of an attached object must be quick to make: unless that is a primitive, its bounding box is covered.
GeometryCover cover_of_attached(const Body& body) {
  const coal::NODE_TYPE type = body.geometry->getNodeType();
  if (type == coal::GEOM_SPHERE || type == coal::GEOM_BOX || type == coal::GEOM_CYLINDER ||
      type == coal::GEOM_CAPSULE || type == coal::GEOM_CONE)
    return quick_cover(*body.geometry);
  GeometryCover cover = box_cover(body.bounds.box_center, body.bounds.box_half);
  cover.bound = {body.bounds.center, body.bounds.radius};
  return cover;
}

/// A geometry of a batch body.
struct Piece {
  std::size_t body{};  // of the batch
  const Body* of{};
  const MovingBody* moving{};                  // null: it is fixed
  Eigen::Isometry3d pose;                      // of one that is fixed, or where a link holds an object
  std::shared_ptr<const GeometryCover> cover;  // of a link
};

/// Makes the robot of a batch from its pieces.
class RobotBuilder {
 public:
  RobotBuilder(const RobotGroup& group, const std::vector<Piece>& pieces)
      : group_(group), pieces_(pieces), data_(group.make_data()) {
    group.forward(data_, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(group.joints().size())));
  }

  BatchRobot build() {
    robot_.dof = group_.joints().size();
    add_actuated_joints();
    for (const Piece& piece : pieces_) add(piece);
    for (std::size_t i = 0; i < robot_.bodies.size(); ++i) {
      robot_.bodies[i].bound = around(bounds_[i]);
      if (robot_.bodies[i].exact) robot_.bodies[i].inner.clear();
    }
    return std::move(robot_);
  }

 private:
  void add_actuated_joints() {
    for (std::size_t k = 0; k < group_.actuated_joints().size(); ++k) {
      const ActuatedJoint& from = group_.actuated_joints()[k];
      frames_.push_back(frame_on_axis(group_.actuated_joint_axis(data_, k)));
      BatchActuatedJoint actuated;
      actuated.parent = group_.parent(k);
      actuated.frame =
          actuated.parent < 0 ? frames_[k] : frames_[static_cast<std::size_t>(actuated.parent)].inverse() * frames_[k];
      actuated.prismatic = from.prismatic;
      actuated.joint = static_cast<int>(from.joint);
      actuated.ratio = from.ratio;
      if (from.prismatic) {
        const Joint& joint = group_.joints()[from.joint];
        actuated.max_travel = std::abs(from.ratio) * (std::max(std::abs(joint.lower), std::abs(joint.upper)) + 1.0);
      }
      robot_.actuated_joints.push_back(actuated);
    }
  }

  void add(const Piece& piece) {
    if (piece.body == robot_.bodies.size()) {
      robot_.bodies.emplace_back();
      bounds_.emplace_back();
      if (piece.moving) {
        robot_.bodies.back().actuated_joint = deepest_actuated_joint(piece.of->support);
        robot_.bodies.back().padding = piece.of->padding;
      }
    }
    Eigen::Isometry3d pose = piece.pose;
    if (piece.moving)
      pose = frames_[static_cast<std::size_t>(deepest_actuated_joint(piece.of->support))].inverse() *
             pose_of(*piece.moving, group_, data_);
    add_spheres(piece.body, piece.cover ? *piece.cover : cover_of_attached(*piece.of), pose);
  }

  /// Adds a geometry's spheres to a body. Those of a cover grow a little, so that what they prove free is farther from
  /// contact than SceneWorkspace's reserve; then no result depends on which cover of the geometry this is.
  void add_spheres(std::size_t number, const GeometryCover& cover, const Eigen::Isometry3d& pose) {
    BatchBody& body = robot_.bodies[number];
    const auto first_fine = static_cast<std::uint32_t>(body.fine.size());
    const double reserve = cover.exact ? 0.0 : PairTable::reserve;
    const auto add = [&](std::vector<PlacedSphere>& to, const std::vector<PlacedSphere>& spheres, double growth) {
      for (const PlacedSphere& sphere : spheres) to.push_back({pose * sphere.center, sphere.radius + growth});
    };
    const bool had_children = !body.children.empty(), first = body.coarse.empty();
    body.exact = cover.exact && (first || body.exact);
    body.hollow = body.hollow || cover.hollow;
    if (!cover.children.empty() && !had_children) body.children.resize(body.coarse.size());
    add(body.coarse, cover.coarse, reserve);
    add(body.fine, cover.fine, reserve);
    add(body.inner, cover.exact ? cover.coarse : cover.inner, 0.0);
    for (const auto& list : cover.children) {
      body.children.push_back(list);
      for (std::uint32_t& child : body.children.back()) child += first_fine;
    }
    if (!body.children.empty()) body.children.resize(body.coarse.size());
    bounds_[number].push_back({pose * cover.bound.center, cover.bound.radius + reserve});
  }

  const RobotGroup& group_;
  const std::vector<Piece>& pieces_;
  RobotGroup::Data data_;
  BatchRobot robot_;
  std::vector<Eigen::Isometry3d> frames_;          // of actuated joints, at q = 0
  std::vector<std::vector<PlacedSphere>> bounds_;  // of each body's geometries
};

class Builder {
 public:
  Builder(const Bodies& bodies, const RobotGroup& group, const CoverOf& cover_of)
      : bodies_(bodies), group_(group), cover_of_(cover_of) {}

  BatchScene build(BatchRobotStore& known) {
    for (const MovingBody& body : bodies_.moving) scene_.body_of_moving.push_back(add_moving(body));
    moving_ = scene_.geometry_counts.size();
    scene_.part_of_fixed.reserve(bodies_.fixed.size());
    scene_.pairs.obstacles.reserve(bodies_.fixed.size());
    for (std::size_t i = 0; i < bodies_.fixed.size(); ++i) add_fixed(i);
    scene_.robot = known.get(key(), [&] { return RobotBuilder(group_, pieces_).build(); });
    scene_.make_pairs(bodies_);
    return std::move(scene_);
  }

 private:
  void add_piece(Piece piece) {
    if (piece.of->kind == BodyKind::link) piece.cover = cover_of_(*piece.of->geometry);
    if (piece.body == scene_.geometry_counts.size()) scene_.geometry_counts.push_back(0);
    ++scene_.geometry_counts[piece.body];
    pieces_.push_back(std::move(piece));
  }

  int add_moving(const MovingBody& body) {
    const auto [place, added] = links_.try_emplace(std::pair(std::string_view(body.scene_name), body.attached()),
                                                   static_cast<int>(scene_.geometry_counts.size()));
    const auto number = static_cast<std::size_t>(place->second);
    add_piece({number, &body, &body, body.attached() ? body.in_link : Eigen::Isometry3d::Identity(), nullptr});
    return place->second;
  }

  /// Models, where they stand and where joints stand that are not planned; then the pieces.
  BatchRobotStore::Key key() const {
    BatchRobotStore::Key key;
    const auto add = [&](const auto& matrix) {
      key.numbers.insert(key.numbers.end(), matrix.data(), matrix.data() + matrix.size());
    };
    key.numbers.push_back(static_cast<double>(group_.size()));
    const Pose to_base = group_.instance(0).base.inverse();
    for (std::size_t i = 0; i < group_.size(); ++i) {
      const RobotInstance& instance = group_.instance(i);
      key.parts.push_back(instance.model);
      if (i > 0) add((to_base * instance.base).isometry().matrix());
      add(instance.other_positions);
    }
    for (const Piece& piece : pieces_) {
      key.parts.push_back(piece.of->geometry);
      key.parts.push_back(piece.cover);
      for (const double number : {static_cast<double>(piece.body), static_cast<double>(piece.of->source),
                                  static_cast<double>(piece.of->robot), piece.moving ? piece.of->padding : -1.0})
        key.numbers.push_back(number);
      add(piece.pose.matrix());
    }
    return key;
  }

  /// A distance field takes longer to check than a sphere: it pays only for links that need as many spheres.
  static constexpr std::size_t many_spheres = 512;

  /// Is a fixed body an obstacle? A link with a distance field may be; but obstacles keep their padding from all that
  /// moves, and a hit of any geometry of a link counts.
  bool is_obstacle(std::size_t fixed) const {
    const FixedBody& body = bodies_.fixed[fixed];
    if (body.kind != BodyKind::link) return true;
    if (body.robot >= 0 && (body.padding != 0.0 || bodies_.clearance() != 0.0)) return false;
    if (!body.field || cover_of_(*body.geometry)->fine.size() < many_spheres) return false;
    std::vector<int> pairs(moving_);
    for (std::size_t i = 0; i < bodies_.moving.size(); ++i)
      if (bodies_.fixed_pair[i * bodies_.fixed.size() + fixed] >= 0)
        ++pairs[static_cast<std::size_t>(scene_.body_of_moving[i])];
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (pairs[i] != 0 && pairs[i] != scene_.geometry_counts[i]) return false;
    return true;
  }

  void add_fixed(std::size_t fixed) {
    const FixedBody& from = bodies_.fixed[fixed];
    if (is_obstacle(fixed)) {
      scene_.part_of_fixed.push_back({true, static_cast<int>(scene_.pairs.obstacles.size())});
      scene_.pairs.obstacles.push_back(as_obstacle(from, bodies_.clearance()));
      return;
    }
    scene_.part_of_fixed.push_back({false, static_cast<int>(scene_.geometry_counts.size())});
    add_piece({scene_.geometry_counts.size(), &from, nullptr, from.pose, nullptr});
  }

  const Bodies& bodies_;
  const RobotGroup& group_;
  const CoverOf& cover_of_;
  BatchScene scene_;
  std::vector<Piece> pieces_;
  std::size_t moving_{};                                    // so many bodies of the robot move, the first ones
  std::map<std::pair<std::string_view, bool>, int> links_;  // by scene name, and whether it is an object
};

}  // namespace

std::vector<int> BatchScene::follow(const Bodies& bodies, const FixedChanges& changes) {
  const auto is_changed = [&](std::size_t i) { return changes.before[i] == FixedChanges::changed; };
  std::vector<Part> parts;
  std::vector<int> before;
  parts.reserve(bodies.fixed.size());
  before.reserve(bodies.fixed.size());
  for (std::size_t i = 0; i < bodies.fixed.size(); ++i) {
    parts.push_back(is_changed(i) ? Part{true, FixedChanges::changed}  // an object, which is an obstacle
                                  : part_of_fixed[static_cast<std::size_t>(changes.before[i])]);
    if (!parts.back().is_obstacle) continue;
    before.push_back(parts.back().number);
    parts.back().number = static_cast<int>(before.size()) - 1;
  }
  part_of_fixed = std::move(parts);
  if (!changes.same_pairs) {
    std::vector<BatchObstacle> obstacles(before.size());
    for (std::size_t i = 0; i < before.size(); ++i)
      if (before[i] != FixedChanges::changed)
        obstacles[i] = std::move(pairs.obstacles[static_cast<std::size_t>(before[i])]);
    pairs.obstacles = std::move(obstacles);
  }
  for (std::size_t i = 0; i < bodies.fixed.size(); ++i)
    if (is_changed(i))
      pairs.obstacles[static_cast<std::size_t>(part_of_fixed[i].number)] =
          as_obstacle(bodies.fixed[i], bodies.clearance());
  if (!changes.same_pairs) make_pairs(bodies);
  return before;
}

void BatchScene::make_pairs(const Bodies& bodies) {
  // The places of pairs: of a body and an obstacle, then of two bodies, the one with the lower number first.
  const std::size_t count = geometry_counts.size(), obstacles = pairs.obstacles.size(), first_self = count * obstacles;
  const auto place_of = [=, moving = std::span(body_of_moving), fixed = std::span(part_of_fixed)](const Pair& pair) {
    const auto a = static_cast<std::size_t>(moving[pair.a]);
    const Part other = pair.b_fixed ? fixed[pair.b] : Part{false, moving[pair.b]};
    const auto b = static_cast<std::size_t>(other.number);
    return other.is_obstacle ? a * obstacles + b : first_self + std::min(a, b) * count + std::max(a, b);
  };
  std::vector<std::uint32_t> next(first_self + count * count + 1), places(bodies.pairs.size()), ids(places.size());
  for (std::size_t id = 0; id < places.size(); ++id) {
    places[id] = static_cast<std::uint32_t>(place_of(bodies.pairs[id]));
    ++next[places[id] + 1];
  }
  std::partial_sum(next.begin(), next.end(), next.begin());
  for (std::size_t id = 0; id < places.size(); ++id) ids[next[places[id]]++] = static_cast<std::uint32_t>(id);

  // `next` is where each place ends.
  const std::uint32_t* end = next.data();
  const auto make_lists = [&](NumberLists& lists, std::size_t columns, auto&& add) {
    const std::uint32_t begin = end == next.data() ? 0 : end[-1];
    std::uint32_t last = begin;
    lists.ends.clear();
    lists.ends.reserve(count * columns);
    for (std::size_t a = 0; a < count; ++a)
      for (std::size_t b = 0; b < columns; ++b, last = *end++)
        if (*end != last) {
          lists.ends.push_back(*end - begin);
          add(static_cast<int>(a), static_cast<int>(b), std::span(ids).subspan(last, *end - last));
        }
    lists.numbers.assign(ids.begin() + begin, ids.begin() + last);
  };
  pairs.obstacle_pairs.clear();
  pairs.obstacle_pairs.reserve(first_self);
  make_lists(obstacle_pairs, obstacles,
             [&](int a, int b, std::span<const std::uint32_t>) { pairs.obstacle_pairs.emplace_back(a, b); });
  pairs.self_pairs.clear();
  pairs.deferred.clear();
  make_lists(self_pairs, count, [&](int a, int b, std::span<const std::uint32_t> of_both) {
    // Where some geometries of the two may touch, a hit proves nothing.
    const bool all = of_both.size() == static_cast<std::size_t>(geometry_counts[static_cast<std::size_t>(a)]) *
                                           static_cast<std::size_t>(geometry_counts[static_cast<std::size_t>(b)]);
    const bool by_tables = !robot->exact && std::ranges::all_of(of_both, [&](std::uint32_t id) {
      return bodies.pairs[id].table != nullptr;
    });
    if (by_tables) pairs.deferred.push_back(static_cast<int>(pairs.self_pairs.size()));
    pairs.self_pairs.push_back({a, b, bodies.pairs[of_both.front()].padding + NarrowPhase::contact_distance, all});
  });
}

BatchScene make_batch_scene(const Bodies& bodies, const RobotGroup& group, const CoverOf& cover_of,
                            BatchRobotStore& known) {
  return Builder(bodies, group, cover_of).build(known);
}

BatchObstacle as_obstacle(const FixedBody& body, double clearance) {
  const coal::CollisionGeometry* shape = body.geometry.get();
  BatchObstacle o{.pose = body.pose, .padding = body.padding + clearance + NarrowPhase::contact_distance};
  if (const auto* s = dynamic_cast<const coal::Sphere*>(shape)) {
    o.kind = BatchObstacle::Kind::sphere;
    o.size = {s->radius, 0, 0};
  } else if (const auto* s = dynamic_cast<const coal::Box*>(shape)) {
    o.kind = BatchObstacle::Kind::box;
    o.size = 2 * s->halfSide;
  } else if (const auto* s = dynamic_cast<const coal::Cylinder*>(shape)) {
    o.kind = BatchObstacle::Kind::cylinder;
    o.size = {s->radius, 2 * s->halfLength, 0};
  } else if (const auto* s = dynamic_cast<const coal::Capsule*>(shape)) {
    o.kind = BatchObstacle::Kind::capsule;
    o.size = {s->radius, 2 * s->halfLength, 0};
  } else {
    o.kind = body.field ? BatchObstacle::Kind::field : BatchObstacle::Kind::box;
    o.size = 2 * body.bounds.box_half;
    o.pose.translate(body.bounds.box_center);
    o.field = body.field;
    o.field_center = body.bounds.box_center;
    o.exact = body.field != nullptr;
    o.connected = !body.parts.bvh;
  }
  return o;
}

}  // namespace srmp::detail
