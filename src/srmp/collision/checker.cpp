#include "srmp/collision/checker.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "srmp/collision/checker_workspace.hpp"
#include "srmp/collision/motion_proof.hpp"
#include "srmp/core/error.hpp"
#include "srmp/robot/robot_cover.hpp"

namespace srmp {

using detail::Bodies;
using detail::NarrowPhase;
using detail::Pair;
using detail::Proximity;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Where spheres are the bodies, they may as well look closely; elsewhere they stop early, because Coal settles what
/// they leave open, pair by pair, in less time than more blocks would take.
BatchChecker::MotionOptions batch_options(const BatchWorld& world) {
  const bool exact = std::all_of(world.bodies.begin(), world.bodies.end(), [](const auto& body) { return body.exact; });
  return {.step = 0.05, .refinements = exact ? 4 : 1, .max_blocks = 64};
}

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g mm", 1e3 * metres);
  return text;
}

const char* kind_text(BodyKind kind) {
  switch (kind) {
    case BodyKind::link: return "link '";
    case BodyKind::object: return "object '";
    case BodyKind::attached_object: return "attached object '";
  }
  return "'";
}

std::vector<std::string> with_other_robots(const std::string& robot, std::vector<std::string> names) {
  names.insert(names.begin(), robot);
  return names;
}

using Tables = std::vector<std::shared_ptr<const PairTables>>;
Tables tables_of(const detail::RobotGroup& group, const CheckerOptions& options) {
  Tables tables(group.size());
  if (options.mode != CheckMode::coal && options.pair_tables && !options.other_robots_only)
    for (std::size_t i = 0; i < group.size(); ++i) {
      const RobotInstance& robot = group.instance(i);
      tables[i] = options.pair_tables->tables(robot.model, robot.parts);
    }
  return tables;
}
std::vector<const PairTables*> addresses(const Tables& tables) {
  std::vector<const PairTables*> result;
  for (const auto& table : tables) result.push_back(table.get());
  return result;
}

}  // namespace

std::string Contact::describe() const {
  const std::string pair = kind_text(kind_a) + body_a + "' and " + kind_text(kind_b) + body_b + "'";
  const double gap = distance + padding;
  if (gap <= 0.0) return pair + " overlap by " + millimetres(-gap);
  if (distance <= 0.0)
    return pair + " are " + millimetres(gap) + " apart, less than their padding of " + millimetres(padding);
  return pair + " are " + millimetres(gap) + " apart";
}

Checker::Impl::Impl(const Scene& scene, const std::string& robot, const CheckerOptions& options)
    : group(scene, with_other_robots(robot, options.other_robots)),
      tables(tables_of(group, options)),
      bodies(scene, group, options, addresses(tables)),
      mode(options.mode) {
  for (const Joint& joint : group.joints()) continuous.push_back(joint.kind == JointKind::continuous);
  if (mode == CheckMode::coal) return;
  const auto covers = options.covers ? options.covers : std::make_shared<CoverStore>();
  for (const auto& [name, other] : scene.robots())
    if (group.contains(name) || !bodies.leaves_out(name)) ensure_covered(*other.model, *covers);
  const detail::CoverOf cover_of = [&](const auto& shape) -> const GeometryCover& { return covers->cover(shape); };
  batch_scene = detail::make_batch_scene(bodies, group, cover_of);
  batch.emplace(batch_scene.world);
  batch_options = srmp::batch_options(batch_scene.world);
}

// --- the public face

Checker::Checker(const Scene& scene, const std::string& robot, const CheckerOptions& options)
    : impl_(std::make_unique<const Impl>(scene, robot, options)) {}
Checker::~Checker() = default;

const RobotModel& Checker::robot() const { return impl_->group.model(0); }
std::size_t Checker::dof() const { return impl_->group.joints().size(); }
const Pose& Checker::base() const { return impl_->group.instance(0).base; }
const Eigen::VectorXd& Checker::other_positions() const { return impl_->group.instance(0).other_positions; }
CheckMode Checker::mode() const { return impl_->mode; }

/// How far a prismatic drive gets from where it is at 0.
double Checker::Impl::travel(const ActuatedJoint& drive) const {
  const Joint& joint = group.joints()[drive.joint];
  return drive.prismatic ? std::abs(drive.ratio) * std::max(std::abs(joint.lower), std::abs(joint.upper)) : 0.0;
}

/// The axes keep their distances as the joints turn, so a body is no farther from an axis than along the chain of axes
/// to it, as it is at any one configuration, and what prismatic joints on the way add. Calls at_axis(body, drive, way)
/// for every moving body and every drive that moves it, the body's own first: no point of the body is ever farther
/// than `way` from the point of the axis where the drive is.
template <class AtAxis>
void Checker::Impl::for_each_axis(AtAxis&& at_axis) const {
  const std::vector<ActuatedJoint>& actuated_joints = group.actuated_joints();
  detail::RobotGroup::Data data = group.make_data();
  group.forward(data, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(group.joints().size())));
  for (const detail::MovingBody& body : bodies.moving) {
    Eigen::Vector3d from = detail::pose_of(body, group, data) * body.bounds.center;
    double way = body.bounds.radius;
    for (int k = detail::deepest_drive(body.support); k >= 0; k = group.parent(static_cast<std::size_t>(k))) {
      const auto drive = static_cast<std::size_t>(k);
      const Eigen::Vector3d axis = group.actuated_joint_axis(data, drive).first;
      way += (from - axis).norm();
      at_axis(body, drive, way, axis);
      way += travel(actuated_joints[drive]);
      from = axis;
    }
  }
}

Eigen::VectorXd Checker::reach() const {
  const std::vector<ActuatedJoint>& actuated_joints = impl_->group.actuated_joints();
  std::vector<double> farthest(actuated_joints.size(), 0.0);  // from the drive's axis
  impl_->for_each_axis([&](const detail::MovingBody&, std::size_t drive, double way, const Eigen::Vector3d&) {
    farthest[drive] = std::max(farthest[drive], way);
  });
  Eigen::VectorXd reach = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(dof()));
  for (std::size_t k = 0; k < actuated_joints.size(); ++k)
    reach[static_cast<Eigen::Index>(actuated_joints[k].joint)] +=
        std::abs(actuated_joints[k].ratio) * (actuated_joints[k].prismatic ? 1.0 : farthest[k]);
  return reach;
}

/// Around the first axis that stays where it is.
PlacedSphere Checker::range() const {
  const detail::RobotGroup& group = impl_->group;
  PlacedSphere sphere;
  bool centered = false;
  const auto hold = [&](const Eigen::Vector3d& point, double radius) {
    if (!std::exchange(centered, true)) sphere.center = point;
    sphere.radius = std::max(sphere.radius, (point - sphere.center).norm() + radius);
  };
  impl_->for_each_axis([&](const detail::MovingBody& body, std::size_t drive, double way, const Eigen::Vector3d& axis) {
    if (body.member == 0 && group.parent(drive) < 0)
      hold(axis, way + impl_->travel(group.actuated_joints()[drive]) + body.padding);
  });
  for (const detail::FixedBody& body : impl_->bodies.fixed)
    if (body.member == 0) hold(body.center, body.bounds.radius + body.padding);
  sphere.center = base() * sphere.center;
  return sphere;
}

void Checker::WorkspaceDeleter::operator()(Workspace* workspace) const { delete workspace; }

Checker::WorkspacePtr Checker::make_workspace() const { return WorkspacePtr(new Workspace(*impl_)); }

const CheckStatistics& Checker::statistics(const Workspace& workspace) const { return workspace.statistics; }

bool Checker::is_free(ConstVector q, Workspace& workspace) const {
  impl_->group.require_configuration(q, "configuration");
  ++workspace.statistics.states;
  if (!impl_->bodies.overlaps.empty()) return false;
  workspace.place(q);
  return workspace.is_free_here();
}

bool Checker::is_motion_free(ConstVector a, ConstVector b, Workspace& workspace, const MotionQuery& query) const {
  impl_->group.require_configuration(a, "start of the motion");
  impl_->group.require_configuration(b, "end of the motion");
  ++workspace.statistics.motions;
  if (!impl_->bodies.overlaps.empty()) return false;
  workspace.start_motion(a, b);
  return workspace.is_motion_free(query.start_is_free, query.spheres_only || impl_->mode == CheckMode::conservative);
}

void Checker::stop_at(const Deadline& deadline, Workspace& workspace) const { workspace.deadline = &deadline; }

void Checker::are_free(ConstRows q, std::span<bool> free, Workspace& workspace, const StateQuery& query) const {
  if (free.size() != static_cast<std::size_t>(q.rows()))
    throw InvalidArgument("are_free: there are " + std::to_string(q.rows()) + " configurations, but room for " +
                          std::to_string(free.size()) + " answers");
  for (Eigen::Index i = 0; i < q.rows(); ++i)
    if (q.cols() != static_cast<Eigen::Index>(dof()) || !q.row(i).allFinite())
      impl_->group.require_configuration(q.row(i).transpose(), "configuration " + std::to_string(i));
  workspace.statistics.states += free.size();
  if (!impl_->bodies.overlaps.empty()) {
    std::fill(free.begin(), free.end(), false);
    return;
  }
  bool has_spheres = impl_->batch.has_value();
  for (Eigen::Index i = 0; i < q.rows() && has_spheres; ++i) has_spheres = impl_->spheres_reach(q.row(i).transpose());
  if (!has_spheres) {
    for (std::size_t i = 0; i < free.size(); ++i) {
      workspace.place(q.row(static_cast<Eigen::Index>(i)).transpose());
      free[i] = workspace.is_free_here();
    }
    return;
  }
  for (std::size_t first = 0; first < free.size(); first += BatchChecker::block) {
    const std::size_t count = std::min<std::size_t>(BatchChecker::block, free.size() - first);
    workspace.judge_block(q.middleRows(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count)),
                          free.subspan(first, count), query.spheres_only || impl_->mode == CheckMode::conservative);
  }
}

MotionCertificate Checker::certify_motion(ConstVector a, ConstVector b, Workspace& workspace) const {
  impl_->group.require_configuration(a, "start of the motion");
  impl_->group.require_configuration(b, "end of the motion");
  ++workspace.statistics.motions;
  if (!impl_->bodies.overlaps.empty()) {
    const std::vector<Contact> rigid = contacts(a, workspace);
    return {false, 0.0, 1.0, rigid.front().body_a, rigid.front().body_b};
  }
  RowMatrix ends(2, a.size());
  ends << a.transpose(), b.transpose();
  for (std::size_t i = 0; i < impl_->continuous.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    if (impl_->continuous[i]) ends(1, j) = a[j] + std::remainder(b[j] - a[j], 2.0 * std::numbers::pi);
  }
  const Eigen::VectorXd times = Eigen::Vector2d(0.0, 1.0);
  const MotionProof proof =
      prove_motion(*this, {times, ends, RowMatrix(0, a.size())}, workspace, {.gap_tolerance = 0.0});
  if (!proof.free) return {false, proof.time, proof.time, proof.body_a, proof.body_b};
  if (proof.unproved.empty()) return {true, 0.0, 0.0, "", ""};
  const MotionProof::Part& part = proof.unproved.front();
  return {false, part.from, part.to, part.body_a, part.body_b};
}

Contact Checker::Workspace::contact(const detail::Body& a, const detail::Body& b, const Proximity& found,
                                    double padding) const {
  const Pose& base = impl.group.instance(0).base;
  return {a.name, b.name, found.distance - padding, base * found.point_a, base * found.point_b, padding,
          a.kind, b.kind};
}

namespace {

const detail::Body& body_of(const Bodies& bodies, bool fixed, std::size_t index) {
  if (fixed) return bodies.fixed[index];
  return bodies.moving[index];
}

/// One entry a pair of bodies, the deepest; deepest first, then by name.
void tidy(std::vector<Contact>& contacts) {
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

std::vector<Contact> Checker::contacts(ConstVector q, Workspace& workspace) const {
  impl_->group.require_configuration(q, "configuration");
  const Bodies& bodies = impl_->bodies;
  workspace.place(q);
  std::vector<Contact> contacts;
  const auto add = [&](bool a_fixed, std::size_t a, bool b_fixed, std::size_t b, double padding) {
    const Proximity found = NarrowPhase::deepest(workspace.placed(a_fixed, a), workspace.placed(b_fixed, b), padding);
    contacts.push_back(workspace.contact(body_of(bodies, a_fixed, a), body_of(bodies, b_fixed, b), found, padding));
  };
  for (const detail::RigidOverlap& overlap : bodies.overlaps)
    add(overlap.a_fixed, overlap.a, overlap.b_fixed, overlap.b, 0.0);
  for (const Pair& pair : bodies.pairs)
    if (workspace.in_contact(pair)) add(false, pair.a, pair.b_fixed, pair.b, pair.padding);
  tidy(contacts);
  return contacts;
}

std::optional<Contact> Checker::nearest(ConstVector q, Workspace& workspace) const {
  std::vector<Contact> in_contact = contacts(q, workspace);
  if (!in_contact.empty()) return in_contact.front();
  const Bodies& bodies = impl_->bodies;
  std::vector<std::pair<double, std::size_t>> order;  // by the lower bound, so that most are never asked
  for (std::size_t i = 0; i < bodies.pairs.size(); ++i)
    order.emplace_back(workspace.gap(bodies.pairs[i]) - bodies.pairs[i].padding, i);
  std::sort(order.begin(), order.end());
  double least = infinity;
  const Pair* pair = nullptr;
  for (const auto& [bound, i] : order) {
    if (bound > least) break;
    const Pair& next = bodies.pairs[i];
    const double apart = workspace.distance(next, least + next.padding, 0.0) - next.padding;
    if (apart >= least) continue;
    least = apart;
    pair = &next;
  }
  if (!pair) return std::nullopt;
  const Proximity found =
      NarrowPhase::distance(workspace.placed(false, pair->a), workspace.placed(pair->b_fixed, pair->b));
  return workspace.contact(bodies.moving[pair->a], body_of(bodies, pair->b_fixed, pair->b), found, pair->padding);
}

std::unique_ptr<const Checker> make_checker(const Scene& scene, const std::string& robot,
                                            const CheckerOptions& options) {
  return std::make_unique<const Checker>(scene, robot, options);
}

}  // namespace srmp
