#include "srmp/collision/bodies.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>

#include "srmp/collision/contact_rules.hpp"
#include "srmp/core/error.hpp"
#include "srmp/core/low_discrepancy.hpp"

namespace srmp::detail {

namespace {

std::string full_name(const std::string& robot, const std::string& link) { return robot + "/" + link; }

const coal::CollisionGeometry* solid_of(const GeometryParts& parts) {
  return is_convex_solid(*parts.hull) ? parts.hull.get() : nullptr;
}

Body link_body(const RobotInstance& instance, std::size_t index) {
  const LinkGeometry& geometry = instance.model->geometries()[index];
  Bounds bounds = bounds_of(*geometry.shape);
  bounds.center = geometry.center;
  bounds.radius = geometry.radius;
  const std::string scene_name = full_name(instance.model->name(), geometry.link);
  return {scene_name,
          BodyKind::link,
          geometry.shape,
          instance.parts[index],
          instance.fields[index],
          bounds,
          core_of(*geometry.shape, bounds),
          instance.padding,
          -1,
          0,
          scene_name,
          index,
          solid_of(instance.parts[index])};
}

Body object_body(const Object& object, BodyKind kind) {
  const Bounds bounds = bounds_of(*object.geometry);
  return {object.name,
          kind,
          object.geometry,
          object.parts,
          object.field,
          bounds,
          core_of(*object.geometry, bounds),
          object.padding,
          -1,
          0,
          object.name,
          0,
          solid_of(object.parts)};
}

FixedBody placed(Body body, const Eigen::Isometry3d& pose) {
  const Eigen::Vector3d center = pose * body.bounds.center;
  return {std::move(body), pose, center};
}

}  // namespace

Bodies::Bodies(const Scene& scene, const RobotGroup& group, const CheckerOptions& options,
               std::vector<const PairTables*> tables)
    : group_(group), options_(options), tables_(std::move(tables)), data_(group.make_data()) {
  for (const std::string& name : options.excluded_robots) {
    scene.robot(name);  // throws with the nearest name
    if (group.contains(name)) throw InvalidArgument("robot '" + name + "' is planned and cannot be excluded");
  }
  group.forward(data_, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(group.joints().size())));
  fixed.reserve(scene.objects().size() + 8);  // moving them costs more than making room
  for (std::size_t i = 0; i < group.size(); ++i) add_links(static_cast<int>(i));
  add_objects(scene);
  add_other_robots(scene);

  build_tree();
  add_envelopes();
  add_pairs(scene);
  if (clearance() > 0.0) exempt_close_links();
}

void Bodies::build_tree() {
  std::vector<Eigen::AlignedBox3d> boxes;
  boxes.reserve(fixed.size());
  max_fixed_padding = 0.0;
  for (const FixedBody& body : fixed) {
    max_fixed_padding = std::max(max_fixed_padding, body.padding + clearance());
    const Bounds& b = body.bounds;
    const Eigen::Vector3d half = body.pose.linear().cwiseAbs() * b.box_half, center = body.pose * b.box_center;
    boxes.emplace_back(center - half, center + half);
  }
  tree.build(boxes);
}

bool Bodies::leaves_out(const std::string& robot) const {
  const auto& excluded_robots = options_.excluded_robots;
  return options_.other_robots_only ||
         std::find(excluded_robots.begin(), excluded_robots.end(), robot) != excluded_robots.end();
}

Eigen::Isometry3d Bodies::in_base(const Pose& pose) const {
  return (group_.instance(0).base.inverse() * pose).isometry();
}

void Bodies::add_fixed(Body body, const Eigen::Isometry3d& pose) { fixed.push_back(placed(std::move(body), pose)); }

FixedBody Bodies::free_object(const Object& object) const {
  return placed(object_body(object, BodyKind::object), in_base(object.pose));
}

void Bodies::add_links(int robot) {
  const auto index = static_cast<std::size_t>(robot);
  const RobotInstance& instance = group_.instance(index);
  for (std::size_t i = 0; i < instance.model->geometries().size(); ++i) {
    Body body = link_body(instance, i);
    const LinkGeometry& geometry = instance.model->geometries()[i];
    body.robot = robot;
    body.support = group_.support(index, geometry.support);
    if (robot == 0) body.name = geometry.link;
    if (body.support == 0)
      add_fixed(std::move(body), group_.geometry_pose(data_, index, i));
    else
      moving.push_back({std::move(body), Eigen::Isometry3d::Identity()});
  }
}

void Bodies::add_objects(const Scene& scene) {
  for (const auto& [name, object] : scene.objects()) {
    const auto it = scene.attachments().find(name);
    if (it == scene.attachments().end() && options_.other_robots_only) continue;
    if (it != scene.attachments().end() && !group_.contains(it->second.robot) && leaves_out(it->second.robot)) continue;
    if (it == scene.attachments().end()) {
      fixed.push_back(free_object(object));
      continue;
    }
    Body body = object_body(object, BodyKind::attached_object);
    for (std::size_t i = 0; i < group_.size(); ++i)
      if (group_.model(i).name() == it->second.robot) body.robot = static_cast<int>(i);
    if (body.robot < 0) {
      add_fixed(std::move(body), in_base(scene.object_pose(name)));
      continue;
    }
    const auto robot = static_cast<std::size_t>(body.robot);
    const std::size_t link = group_.model(robot).link_index(it->second.link);
    body.support = group_.support(robot, group_.model(robot).link_support(link));
    body.source = link;
    const Eigen::Isometry3d in_link = object.pose.isometry();
    if (body.support == 0)
      add_fixed(std::move(body), group_.link_pose(data_, robot, link) * in_link);
    else
      moving.push_back({std::move(body), in_link});
  }
}

void Bodies::add_other_robots(const Scene& scene) {
  const Eigen::Isometry3d to_base = group_.instance(0).base.inverse().isometry();
  for (const auto& [name, instance] : scene.robots()) {
    if (group_.contains(name) || leaves_out(name)) continue;
    const RobotDataPtr data = instance.model->make_data(instance.other_positions);
    instance.model->forward(*data, instance.q);
    for (std::size_t i = 0; i < instance.model->geometries().size(); ++i)
      add_fixed(link_body(instance, i), to_base * instance.base.isometry() * instance.model->geometry_pose(*data, i));
  }
}

void Bodies::add_envelopes() {
  std::map<std::uint64_t, std::vector<std::uint32_t>> by_support;  // each is of one robot
  for (std::uint32_t i = 0; i < moving.size(); ++i) by_support[moving[i].support].push_back(i);
  envelope_of.resize(moving.size());
  in_envelope.assign(moving.size(), Eigen::Vector3d::Zero());
  for (const auto& [support, bodies] : by_support) {
    const auto number = static_cast<std::uint32_t>(moving.size() + envelopes.size());
    for (const std::uint32_t i : bodies) envelope_of[i] = bodies.size() > 1 ? number : i;
    if (bodies.size() > 1) envelopes.push_back(envelope_around(bodies));
  }
}

MovingBody Bodies::envelope_around(std::span<const std::uint32_t> bodies) {
  const MovingBody& first = moving[bodies.front()];
  const Eigen::Isometry3d to_first = pose_of(first, group_, data_).inverse();
  std::vector<Eigen::Vector3d> centers;
  Eigen::AlignedBox3d box;
  for (const std::uint32_t i : bodies) {
    const Bounds& bounds = moving[i].bounds;
    centers.push_back(to_first * (pose_of(moving[i], group_, data_) * bounds.center));
    box.extend(Eigen::AlignedBox3d(centers.back().array() - bounds.radius, centers.back().array() + bounds.radius));
  }
  MovingBody envelope{};
  envelope.robot = first.robot;
  envelope.support = first.support;
  envelope.kind = first.kind;
  envelope.source = first.source;
  envelope.in_link = first.in_link;
  envelope.bounds.center = box.center();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Eigen::Vector3d from_center = centers[i] - envelope.bounds.center;
    in_envelope[bodies[i]] = from_center;
    const double reach = from_center.norm() + moving[bodies[i]].bounds.radius;
    envelope.bounds.radius = std::max(envelope.bounds.radius, reach);
  }
  envelope.core = {Eigen::Vector3d::Zero(), envelope.bounds.radius};
  return envelope;
}

void Bodies::add_pairs(const Scene& scene) {
  ContactRules rules(scene, group_, options_.other_robots_only);
  const std::vector<PairSide> of_moving = rules.sides(moving), of_fixed = rules.sides(fixed);
  pairs.reserve(moving.size() * fixed.size() + moving.size() * moving.size() / 2);
  for (std::size_t i = 0; i < moving.size(); ++i) {
    for (std::size_t j = 0; j < fixed.size(); ++j)
      if (rules.count(of_moving[i], of_fixed[j])) add(pair_of(of_moving[i], i, of_fixed[j], true, j));
    for (std::size_t j = i + 1; j < moving.size(); ++j) {
      if (!rules.count(of_moving[i], of_moving[j])) continue;
      const bool swap = of_moving[i].robot != 0;  // the planned robot's body comes first
      const std::size_t a = swap ? j : i, b = swap ? i : j;
      if (of_moving[a].support == of_moving[b].support)
        add_rigid_pair(false, a, false, b);
      else
        add(pair_of(of_moving[a], a, of_moving[b], false, b));
    }
  }
  number_pairs();
  for (std::size_t i = 0; i < fixed.size(); ++i) {
    if (fixed[i].robot != 0) continue;
    for (std::size_t j = 0; j < fixed.size(); ++j) {
      const bool once = fixed[j].robot != 0 || i < j;
      if (once && rules.count(of_fixed[i], of_fixed[j])) add_rigid_pair(true, i, true, j);
    }
  }
}

bool Bodies::are_closer(const Pair& pair, const RobotGroup::Data& data, double distance, NarrowPhase& narrow) const {
  const MovingBody& a = moving[pair.a];
  const Body& b = body(pair.b_fixed, pair.b);
  const Eigen::Isometry3d pose_a = pose_of(a, group_, data);
  const Eigen::Isometry3d pose_b = pair.b_fixed ? fixed[pair.b].pose : pose_of(moving[pair.b], group_, data);
  const Eigen::Vector3d center_a = pose_a * a.bounds.center, center_b = pose_b * b.bounds.center;
  if ((center_a - center_b).norm() - a.bounds.radius - b.bounds.radius > distance) return false;
  if (a.solid && b.solid)
    return narrow.solids(pair.formula, {a.solid, nullptr, a.bounds, pose_a, center_a},
                         {b.solid, nullptr, b.bounds, pose_b, center_b}, distance) < infinity;
  return narrow.primitives({a.geometry.get(), a.parts.bvh.get(), a.bounds, pose_a, center_a},
                           {b.geometry.get(), b.parts.bvh.get(), b.bounds, pose_b, center_b},
                           {.margin = distance, .enough = distance}) < infinity;
}

void Bodies::exempt_close_links() {
  constexpr std::size_t samples = 32;
  struct Links {
    std::vector<Pair*> pairs;
    std::size_t closer{};  // samples where they are
  };
  std::map<std::pair<std::string, std::string>, Links> links;
  for (Pair& pair : pairs) {
    const Body &a = moving[pair.a], &b = body(pair.b_fixed, pair.b);
    if (a.robot == b.robot && a.kind == BodyKind::link && b.kind == BodyKind::link)
      links[std::minmax(a.name, b.name)].pairs.push_back(&pair);
  }
  NarrowPhase narrow(formulas);
  RobotGroup::Data data = group_.make_data();
  const auto dof = static_cast<Eigen::Index>(group_.joints().size());
  for (std::size_t k = 0; k < samples; ++k) {
    Eigen::VectorXd q = low_discrepancy_point(k, dof);
    for (Eigen::Index j = 0; j < dof; ++j) {
      const Joint& joint = group_.joints()[static_cast<std::size_t>(j)];
      const double low = std::max(joint.lower, -std::numbers::pi), high = std::min(joint.upper, std::numbers::pi);
      q[j] = low + q[j] * (high - low);
    }
    group_.forward(data, q);
    for (auto& [names, entry] : links)
      entry.closer += std::any_of(entry.pairs.begin(), entry.pairs.end(),
                                  [&](const Pair* pair) { return are_closer(*pair, data, clearance(), narrow); });
  }
  for (auto& [names, entry] : links) {
    if (2 * entry.closer < samples) continue;
    close_links.push_back(names.first + " and " + names.second);
    for (Pair* pair : entry.pairs) pair->padding = 0.0;
  }
}

const PairTable* Bodies::table_of(std::size_t robot, std::size_t geometry_a, std::size_t geometry_b) const {
  const PairTables* tables = tables_[robot];
  if (!tables) return nullptr;
  const auto found = std::find_if(tables->begin(), tables->end(), [&](const PairTable& table) {
    return std::minmax(geometry_a, geometry_b) == std::minmax(table.geometry_a, table.geometry_b);
  });
  return found == tables->end() ? nullptr : &*found;
}

void Bodies::add_rigid_pair(bool a_fixed, std::size_t ia, bool b_fixed, std::size_t ib) {
  const RigidOverlap pair{a_fixed, b_fixed, static_cast<std::uint32_t>(ia), static_cast<std::uint32_t>(ib)};
  if (a_fixed && b_fixed && fixed[ia].robot != fixed[ib].robot) fixed_pairs.emplace_back(pair.a, pair.b);
  if (overlap(pair)) overlaps.push_back(pair);
}

/// Of two bodies that never move relative to each other.
bool Bodies::overlap(const RigidOverlap& pair) const {
  const auto pose = [&](bool is_fixed, std::size_t i) {
    return is_fixed ? fixed[i].pose : pose_of(moving[i], group_, data_);
  };
  const Body &a = body(pair.a_fixed, pair.a), &b = body(pair.b_fixed, pair.b);
  const Eigen::Isometry3d pose_a = pose(pair.a_fixed, pair.a), pose_b = pose(pair.b_fixed, pair.b);
  const Eigen::Vector3d center_a = pose_a * a.bounds.center, center_b = pose_b * b.bounds.center;
  if ((center_a - center_b).norm() > a.bounds.radius + b.bounds.radius) return false;
  const Placed placed_a{a.geometry.get(), a.parts.bvh.get(), a.bounds, pose_a, center_a},
      placed_b{b.geometry.get(), b.parts.bvh.get(), b.bounds, pose_b, center_b};
  return NarrowPhase::deepest(placed_a, placed_b, 0.0).distance < -Checker::touching_tolerance;
}

Pair Bodies::pair_of(const PairSide& a, std::size_t ia, const PairSide& b, bool b_fixed, std::size_t ib) {
  Pair pair;
  pair.a = static_cast<std::uint32_t>(ia);
  pair.b = static_cast<std::uint32_t>(ib);
  pair.b_fixed = b_fixed;
  pair.solid = a.is_solid && b.is_solid;
  pair.both_meshes = !a.is_solid && !b.is_solid;
  if (a.solid && b.solid) pair.formula = formulas.index(*a.solid, *b.solid);
  pair.padding = (a.robot == b.robot ? 0.0 : a.padding + b.padding) + options_.clearance;
  pair.support_a = a.support & ~b.support;
  pair.support_b = b.support & ~a.support;
  if (!(a.robot == b.robot && a.link && b.link)) return pair;
  const auto robot = static_cast<std::size_t>(a.robot);
  pair.table = table_of(robot, a.source, b.source);
  if (pair.table) pair.first_joint = group_.first_joint(robot);
  return pair;
}

bool Pair::is_free_by_table(const Eigen::VectorXd& start, const Eigen::VectorXd& delta, double from, double to) const {
  std::array<double, 2> low{}, high{};
  for (std::size_t i = 0; i < 2; ++i) {
    if (table->joints[i] < 0) continue;
    const auto joint = static_cast<Eigen::Index>(first_joint) + table->joints[i];
    const double a = start[joint] + from * delta[joint], b = start[joint] + to * delta[joint];
    low[i] = std::min(a, b) - 1e-9;
    high[i] = std::max(a, b) + 1e-9;
    if (!(std::abs(low[i]) < 1e3 && std::abs(high[i]) < 1e3)) return false;
  }
  return table->is_free(low, high);
}

void Bodies::add(const Pair& pair) { (pair.table && pair.table->never_collide() ? apart : pairs).push_back(pair); }

void Bodies::number_pairs() {
  fixed_pair.assign(moving.size() * fixed.size(), -1);
  moving_pairs.clear();
  for (std::uint32_t id = 0; id < pairs.size(); ++id) {
    if (pairs[id].b_fixed)
      fixed_pair[pairs[id].a * fixed.size() + pairs[id].b] = static_cast<std::int32_t>(id);
    else
      moving_pairs.push_back(id);
  }
}

}  // namespace srmp::detail
