#include <coal/collision.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "srmp/core/interruption.hpp"
#include "srmp/core/low_discrepancy.hpp"
#include "srmp/robot/robot_impl.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp {

namespace {

using Impl = RobotModelBuilder::Impl;

constexpr std::size_t kSamples = 2000;
constexpr std::size_t kMaxFreeSamples = kSamples / 20;  // "always" means in at least 95 % of the samples

/// Are the links joined by one moving joint, with only fixed joints and links without geometry in between?
bool adjacent(const Impl& m, std::size_t a, std::size_t b) {
  const auto up = [&](std::size_t link, std::size_t other) -> bool {  // from `link` towards the root, to `other`
    for (int moving = 0; m.urdf.links[link].parent_joint;) {
      const UrdfJoint& joint = m.urdf.joints[*m.urdf.links[link].parent_joint];
      moving += joint.scalar();
      link = joint.parent;
      if (moving > 1) return false;
      if (link == other) return true;
      if (!m.urdf.links[link].collisions.empty()) return false;
    }
    return false;
  };
  return up(a, b) || up(b, a);
}

/// Visits the ancestors of a link as long as they have no geometry and no more than one moving joint leads to them:
/// visit(ancestor, moving joints) returns whether to go on.
template <class Visit>
void climb(const Impl& m, std::size_t link, Visit&& visit) {
  for (int moving = 0; m.urdf.links[link].parent_joint;) {
    const UrdfJoint& joint = m.urdf.joints[*m.urdf.links[link].parent_joint];
    moving += joint.scalar();
    link = joint.parent;
    if (moving > 1 || !m.urdf.links[link].collisions.empty() || !visit(link, moving)) return;
  }
}

/// Allows collisions of links in two branches below a link without geometry, with at most one moving joint between
/// them.
void allow_through_common_parents(Impl& m) {
  constexpr int none = 2;
  const std::size_t n = m.link_names.size();
  std::vector<int> moving_to(n, none);  // from `a` to each of its ancestors
  for (std::size_t a = 0; a < n; ++a) {
    rare_interruption_point();
    climb(m, a, [&](std::size_t ancestor, int moving) {
      moving_to[ancestor] = moving;
      return true;
    });
    for (std::size_t b = a + 1; b < n; ++b)
      climb(m, b, [&](std::size_t ancestor, int moving) {
        if (moving_to[ancestor] == none) return true;
        if (moving_to[ancestor] + moving <= 1) m.set_allowed(a, b, true);
        return false;
      });
    climb(m, a, [&](std::size_t ancestor, int) {
      moving_to[ancestor] = none;
      return true;
    });
  }
}

/// A pair of links that may always collide.
struct Candidate {
  std::size_t link_a, link_b;
  std::vector<std::pair<std::size_t, std::size_t>> geometries;
  std::size_t free_samples{0};
};

bool collide(const RobotModel& model, const RobotData& data, std::size_t a, std::size_t b) {
  rare_interruption_point();
  const LinkGeometry &ga = model.geometries()[a], &gb = model.geometries()[b];
  const Eigen::Isometry3d pa = model.geometry_pose(data, a), pb = model.geometry_pose(data, b);
  const double reach = ga.radius + gb.radius;
  if ((pa * ga.center - pb * gb.center).squaredNorm() > reach * reach) return false;
  const coal::Transform3s ta(pa.linear(), pa.translation()), tb(pb.linear(), pb.translation());
  const coal::CollisionRequest request(coal::NO_REQUEST, 1);
  coal::CollisionResult result;
  return coal::collide(ga.shape.get(), ta, gb.shape.get(), tb, request, result) > 0;
}

bool collide(const RobotModel& model, const RobotData& data, const Candidate& candidate) {
  return std::any_of(candidate.geometries.begin(), candidate.geometries.end(),
                     [&](const auto& pair) { return collide(model, data, pair.first, pair.second); });
}

std::vector<Candidate> candidates_of(const RobotModel& model) {
  std::vector<Candidate> candidates;
  for (const auto& pair : model.self_pairs()) {
    const std::size_t a = model.geometries()[pair.first].link_index, b = model.geometries()[pair.second].link_index;
    auto it = std::find_if(candidates.begin(), candidates.end(),
                           [&](const Candidate& c) { return c.link_a == a && c.link_b == b; });
    if (it == candidates.end()) it = candidates.insert(it, {a, b, {}, 0});
    it->geometries.push_back(pair);
  }
  return candidates;
}

double sample_in(const Joint& joint, double unit) {
  if (joint.kind == JointKind::continuous) return (2 * unit - 1) * std::numbers::pi;
  return joint.lower + unit * (joint.upper - joint.lower);
}

}  // namespace

void RobotModelBuilder::allow_by_rules(Impl& m, const Srdf* srdf) {
  const std::size_t n = m.link_names.size();
  m.allowed.assign(n * n, 0);
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b)
      if (adjacent(m, a, b)) m.set_allowed(a, b, true);
  allow_through_common_parents(m);
  if (srdf) {
    for (const std::string& link : srdf->disabled_by_default)
      for (std::size_t b = 0; b < n; ++b) m.set_allowed(*m.urdf.find_link(link), b, true);
    for (const auto& [a, b] : srdf->disabled) m.set_allowed(*m.urdf.find_link(a), *m.urdf.find_link(b), true);
    for (const auto& [a, b] : srdf->enabled) m.set_allowed(*m.urdf.find_link(a), *m.urdf.find_link(b), false);
  }
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a; b < n; ++b)  // one rigid body cannot collide with itself
      if (m.tree->fixed_placement(a).joint == m.tree->fixed_placement(b).joint) m.set_allowed(a, b, true);
}

void RobotModelBuilder::list_self_pairs(Impl& m) {
  m.self_pairs.clear();
  for (std::size_t a = 0; a < m.geometries.size(); ++a)
    for (std::size_t b = a + 1; b < m.geometries.size(); ++b)
      if (!m.is_allowed(m.geometries[a].link_index, m.geometries[b].link_index)) m.self_pairs.emplace_back(a, b);
}

void RobotModelBuilder::allow_always_colliding(RobotModel& model) {
  std::vector<Candidate> candidates = candidates_of(model);
  const auto dof = static_cast<Eigen::Index>(model.dof());
  const auto others = static_cast<Eigen::Index>(model.other_joints().size());
  const RobotDataPtr data = model.make_data();
  Eigen::VectorXd q(dof), other = model.default_other_positions();
  for (Eigen::Index i = 0; i < dof; ++i)
    q[i] = std::clamp(0.0, model.joints()[static_cast<std::size_t>(i)].lower,
                      model.joints()[static_cast<std::size_t>(i)].upper);
  model.forward(*data, q);
  std::erase_if(candidates, [&](const Candidate& c) { return !collide(model, *data, c); });

  for (std::size_t sample = 0; sample < kSamples && !candidates.empty(); ++sample) {
    const Eigen::VectorXd unit = low_discrepancy_point(sample, dof + others);
    for (Eigen::Index i = 0; i < dof; ++i) q[i] = sample_in(model.joints()[static_cast<std::size_t>(i)], unit[i]);
    for (Eigen::Index i = 0; i < others; ++i)
      other[i] = sample_in(model.other_joints()[static_cast<std::size_t>(i)], unit[dof + i]);
    model.set_other_positions(*data, other);
    model.forward(*data, q);
    std::erase_if(candidates,
                  [&](Candidate& c) { return !collide(model, *data, c) && ++c.free_samples > kMaxFreeSamples; });
  }
  Impl& m = impl(model);
  for (const Candidate& c : candidates) {
    m.set_allowed(c.link_a, c.link_b, true);
    m.always_colliding.emplace_back(m.link_names[c.link_a], m.link_names[c.link_b]);
  }
  list_self_pairs(m);
}

}  // namespace srmp
