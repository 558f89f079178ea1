#include "srmp/collision/scene_checker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "srmp/collision/motion_proof.hpp"
#include "srmp/collision/scene_workspace.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/robot/robot_cover.hpp"

namespace srmp {

using detail::Bodies;
using detail::NarrowPhase;
using detail::Pair;
using detail::Proximity;
using detail::RobotGroup;
using detail::SceneWorkspace;

namespace {

/// Keeps one entry for each pair of bodies, the deepest; sorts them by depth, then by name.
void keep_deepest(std::vector<Contact>& contacts) {
  const auto names = [](const Contact& c) { return std::tie(c.body_a, c.body_b); };
  std::stable_sort(contacts.begin(), contacts.end(), [&](const Contact& a, const Contact& b) {
    return names(a) != names(b) ? names(a) < names(b) : a.distance < b.distance;
  });
  const auto same = [&](const Contact& a, const Contact& b) { return names(a) == names(b); };
  contacts.erase(std::unique(contacts.begin(), contacts.end(), same), contacts.end());
  std::stable_sort(contacts.begin(), contacts.end(),
                   [](const Contact& a, const Contact& b) { return a.distance < b.distance; });
}

}  // namespace

SceneChecker::SceneChecker(const Scene& scene, const std::string& robot, const CheckerOptions& options)
    : Checker(scene, robot, options), model_(scene, group(), options) {}

Checker::WorkspacePtr SceneChecker::do_make_workspace() const { return std::make_unique<SceneWorkspace>(model_); }

bool SceneChecker::do_is_free(ConstVector q, Workspace& workspace) const {
  if (!model_.bodies.overlaps.empty()) return false;
  auto& scene = static_cast<SceneWorkspace&>(workspace);
  // Where spheres are the bodies, a block of them decides earlier than pairs, one by one.
  if (model_.batch && model_.batch_scene.robot->exact && model_.spheres_reach(q)) {
    bool free = false;
    scene.check_block(q.transpose(), {&free, 1}, {});
    return free;
  }
  scene.place(q);
  return scene.is_free_here();
}

bool SceneChecker::do_is_motion_free(ConstVector a, ConstVector b, Workspace& workspace,
                                     const MotionQuery& query) const {
  if (!model_.bodies.overlaps.empty()) return false;
  auto& scene = static_cast<SceneWorkspace&>(workspace);
  scene.start_motion(a, b);
  return scene.is_motion_free({.start_is_free = query.start_is_free,
                               .spheres_only = query.spheres_only || model_.mode == CheckMode::conservative});
}

void SceneChecker::do_are_free(ConstRows q, std::span<bool> free, Workspace& workspace, const StateQuery& query) const {
  if (!model_.bodies.overlaps.empty()) {
    std::fill(free.begin(), free.end(), false);
    return;
  }
  auto& scene = static_cast<SceneWorkspace&>(workspace);
  bool has_spheres = model_.batch.has_value();
  for (Eigen::Index i = 0; i < q.rows() && has_spheres; ++i) has_spheres = model_.spheres_reach(q.row(i).transpose());
  if (!has_spheres) {
    for (std::size_t i = 0; i < free.size(); ++i) {
      rare_interruption_point();
      scene.place(q.row(static_cast<Eigen::Index>(i)).transpose());
      free[i] = scene.is_free_here();
    }
    return;
  }
  const StateQuery block_query{.spheres_only = query.spheres_only || model_.mode == CheckMode::conservative};
  for (std::size_t first = 0; first < free.size(); first += BatchChecker::block) {
    rare_interruption_point();
    const std::size_t count = std::min<std::size_t>(BatchChecker::block, free.size() - first);
    scene.check_block(q.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count)),
                      free.subspan(first, count), block_query);
  }
}

void SceneChecker::do_find_colliding(ConstRows q, std::span<bool> colliding, Workspace& workspace) const {
  if (!model_.bodies.overlaps.empty()) {
    std::ranges::fill(colliding, true);
    return;
  }
  if (!model_.batch) return;
  auto& scene = static_cast<SceneWorkspace&>(workspace);
  for (std::size_t first = 0; first < colliding.size(); first += BatchChecker::block) {
    rare_interruption_point();
    const std::size_t count = std::min<std::size_t>(BatchChecker::block, colliding.size() - first);
    scene.find_colliding(q.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count)),
                         colliding.subspan(first, count));
  }
}

MotionCertificate SceneChecker::do_certify_motion(ConstVector a, ConstVector b, Workspace& workspace) const {
  if (!model_.bodies.overlaps.empty()) {
    const std::vector<Contact> rigid = do_contacts(a, workspace);
    return {false, 0.0, 1.0, rigid.front().body_a, rigid.front().body_b};
  }
  RowMatrix ends(2, a.size());
  ends << a.transpose(), b.transpose();
  for (std::size_t i = 0; i < group().continuous().size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    if (group().continuous()[i]) ends(1, j) = a[j] + std::remainder(b[j] - a[j], 2.0 * std::numbers::pi);
  }
  const Eigen::VectorXd times = Eigen::Vector2d(0.0, 1.0);
  const MotionProof proof =
      prove_motion(*this, {times, ends, RowMatrix(0, a.size())}, workspace, {.gap_tolerance = 1.0});
  if (!proof.free) return {false, proof.time, proof.time, proof.body_a, proof.body_b};
  if (proof.unproved.empty()) return {true, 0.0, 0.0, "", ""};
  const MotionProof::Part& part = proof.unproved.front();
  return {false, part.from, part.to, part.body_a, part.body_b};
}

std::vector<Contact> SceneChecker::do_contacts(ConstVector q, Workspace& workspace) const {
  auto& scene = static_cast<SceneWorkspace&>(workspace);
  const Bodies& bodies = model_.bodies;
  scene.place(q);
  std::vector<Contact> contacts;
  const auto add = [&](bool a_fixed, std::size_t a, bool b_fixed, std::size_t b, double padding) {
    const Proximity found = NarrowPhase::deepest(scene.placed(a_fixed, a), scene.placed(b_fixed, b), padding);
    contacts.push_back(scene.contact(bodies.body(a_fixed, a), bodies.body(b_fixed, b), found, padding));
  };
  for (const detail::RigidOverlap& overlap : bodies.overlaps)
    add(overlap.a_fixed, overlap.a, overlap.b_fixed, overlap.b, 0.0);
  for (const Pair& pair : bodies.pairs)
    if (scene.in_contact(pair)) add(false, pair.a, pair.b_fixed, pair.b, pair.padding);
  keep_deepest(contacts);
  return contacts;
}

struct SceneChecker::NearestPair {
  const Pair* pair{};  // null: there is none
  double distance{std::numeric_limits<double>::infinity()};
};

SceneChecker::NearestPair SceneChecker::nearest_pair(SceneWorkspace& scene) const {
  std::vector<std::pair<double, const Pair*>> order;  // by the lower bound, so that most pairs need no distance
  for (const std::vector<Pair>* pairs : {&model_.bodies.pairs, &model_.bodies.apart})
    for (const Pair& pair : *pairs) order.emplace_back(scene.distance_bound(pair) - pair.padding, &pair);
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    const auto key = [](const auto& entry) {
      return std::tuple(entry.first, entry.second->b_fixed, entry.second->a, entry.second->b);
    };
    return key(a) < key(b);
  });
  NearestPair nearest;
  for (const auto& [bound, pair] : order) {
    if (bound > nearest.distance) break;
    const double distance = scene.distance(*pair, nearest.distance + pair->padding, 0.0) - pair->padding;
    if (distance < nearest.distance) nearest = {pair, distance};
  }
  return nearest;
}

std::optional<Contact> SceneChecker::do_nearest(ConstVector q, Workspace& workspace) const {
  std::vector<Contact> in_contact = do_contacts(q, workspace);
  if (!in_contact.empty()) return in_contact.front();
  auto& scene = static_cast<SceneWorkspace&>(workspace);
  const Bodies& bodies = model_.bodies;
  const Pair* pair = nearest_pair(scene).pair;
  if (!pair) return std::nullopt;
  const Proximity found = NarrowPhase::distance(scene.placed(false, pair->a), scene.placed(pair->b_fixed, pair->b));
  return scene.contact(bodies.moving[pair->a], bodies.body(pair->b_fixed, pair->b), found, pair->padding);
}

double SceneChecker::do_clearance(ConstVector q, Workspace& workspace) const {
  const std::vector<Contact> in_contact = do_contacts(q, workspace);
  if (!in_contact.empty()) return in_contact.front().distance;
  return nearest_pair(static_cast<SceneWorkspace&>(workspace)).distance;
}

std::optional<Contact> SceneChecker::do_nearest_fixed() const {
  const Bodies& bodies = model_.bodies;
  const auto workspace = std::make_unique<SceneWorkspace>(model_);
  const auto bound = [&](const auto& pair) {  // from bounding spheres, so that most pairs need no distance
    const detail::FixedBody &a = bodies.fixed[pair.first], &b = bodies.fixed[pair.second];
    return (a.center - b.center).norm() - a.bounds.radius - b.bounds.radius;
  };
  std::optional<Contact> nearest;
  for (const auto& pair : bodies.fixed_pairs) {
    if (nearest && bound(pair) >= nearest->distance) continue;
    const Proximity found =
        NarrowPhase::distance(workspace->placed(true, pair.first), workspace->placed(true, pair.second));
    if (found.distance > touching_tolerance && (!nearest || found.distance < nearest->distance))
      nearest = workspace->contact(bodies.fixed[pair.first], bodies.fixed[pair.second], found, 0.0);
  }
  return nearest;
}

std::unique_ptr<const Checker> make_checker(const Scene& scene, const std::string& robot,
                                            const CheckerOptions& options) {
  return std::make_unique<const SceneChecker>(scene, robot, options);
}

}  // namespace srmp
