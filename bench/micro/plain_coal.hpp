#pragma once

#include <coal/broadphase/broadphase_callbacks.h>
#include <coal/broadphase/broadphase_dynamic_AABB_tree.h>
#include <coal/collision.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <stdexcept>

#include "srmp/scene/scene.hpp"

// What one writes with Pinocchio and Coal and nothing of srmp's collision checking: the measure of its speed.
namespace bench {

using srmp::ConstVector;

/// Samples a motion so that no point of the robot moves more than `step` between two of them, and stops at the first
/// contact of the first sample that has one. Kinematics by Pinocchio, contacts by Coal, as fast as its options allow:
/// one functor a pair, no contact points, GJK stops once it has proved the pair apart. The start is known to be free,
/// the end is the first sample, the others follow in van der Corput's order.
class PlainCoal {
 public:
  enum class BroadPhase {
    boxes,  ///< the boxes of a pair are compared before Coal checks it
    tree,   ///< obstacles in Coal's DynamicAABBTreeCollisionManager; boxes between links
  };

  PlainCoal(const srmp::Scene& scene, const std::string& robot, BroadPhase broad_phase)
      : model_(*scene.robot(robot).model), data_(model_.make_data()) {
    if (!scene.attachments().empty() || scene.robots().size() != 1)
      throw std::invalid_argument("PlainCoal: one robot that holds nothing only");
    model_.set_other_positions(*data_, scene.robot(robot).other_positions);
    request_.num_max_contacts = 1;
    request_.enable_contact = false;
    request_.distance_upper_bound = 0.0;
    add_links(scene.robot(robot));
    add_obstacles(scene, robot);
    use_tree_ = broad_phase == BroadPhase::tree;
    tree_.setup();
  }

  /// At most this many samples see no point move more than `step` between two: from the middle no point gets farther
  /// than d, so none travels more than 2 d in all.
  int samples(ConstVector a, ConstVector difference, double step) {
    place(a + 0.5 * difference);
    double farthest = 0.0;
    for (std::size_t i = 0; i < model_.geometries().size(); ++i)
      farthest = std::max(farthest, displacement(i, 0.5 * difference));
    return std::max(1, static_cast<int>(std::ceil(2 * farthest / step)));
  }

  bool is_motion_free(ConstVector a, ConstVector difference, double step) {
    const unsigned n = static_cast<unsigned>(samples(a, difference, step)), all = std::bit_ceil(n);
    for (unsigned i = 0; i < all; ++i) {
      const unsigned k = reverse(i, all);
      if (k < n && !is_free(a + difference * (static_cast<double>(n - k) / n))) return false;
    }
    return true;
  }

  bool is_free(const Eigen::VectorXd& q) {
    place(q);
    for (std::size_t i : moving_) {
      objects_[i].setTransform(transform(model_.geometry_pose(*data_, i)));
      objects_[i].computeAABB();
    }
    return (use_tree_ ? free_in_tree() : free_of(obstacle_pairs_)) && free_of(self_pairs_);
  }

 private:
  struct Pair {
    const coal::CollisionObject *a, *b;
    coal::ComputeCollision collide;
  };

  static coal::Transform3s transform(const Eigen::Isometry3d& pose) { return {pose.linear(), pose.translation()}; }
  static coal::CollisionObject object(const std::shared_ptr<const coal::CollisionGeometry>& geometry,
                                      const Eigen::Isometry3d& pose) {
    // Coal wants to write the geometry's bounding box, which is known already.
    return {std::const_pointer_cast<coal::CollisionGeometry>(geometry), transform(pose), false};
  }

  static unsigned reverse(unsigned i, unsigned all) {
    unsigned reversed = 0;
    for (; all > 1; all /= 2, i /= 2) reversed = 2 * reversed + i % 2;
    return reversed;
  }

  void place(const Eigen::VectorXd& q) { model_.forward(*data_, q); }

  /// How far the joints, from the end effector to the base, can move any point of the geometry.
  double displacement(std::size_t geometry, ConstVector change) {
    const srmp::LinkGeometry& g = model_.geometries()[geometry];
    const Eigen::Vector3d center = model_.geometry_pose(*data_, geometry) * g.center;
    double moved = 0.0;
    for (std::size_t k = model_.actuated_joints().size(); k-- > 0;) {
      if (!(g.support >> k & 1)) continue;
      const srmp::ActuatedJoint& actuated = model_.actuated_joints()[k];
      const double step = std::abs(actuated.ratio * change[static_cast<Eigen::Index>(actuated.joint)]);
      const auto [point, axis] = model_.actuated_joint_axis(*data_, k);
      moved += actuated.prismatic ? step : step * ((center - point).cross(axis).norm() + g.radius + moved);
    }
    return moved;
  }

  void add_links(const srmp::RobotInstance& instance) {
    const auto& geometries = model_.geometries();
    place(instance.q);
    for (std::size_t i = 0; i < geometries.size(); ++i) {
      objects_.push_back(object(geometries[i].shape, model_.geometry_pose(*data_, i)));
      objects_[i].computeAABB();
      if (geometries[i].support != 0) moving_.push_back(i);
    }
    for (const auto& [a, b] : model_.self_pairs())
      if (geometries[a].support != geometries[b].support) self_pairs_.push_back(pair(objects_[a], objects_[b]));
  }

  void add_obstacles(const srmp::Scene& scene, const std::string& robot) {
    const srmp::Pose to_base = scene.robot(robot).base.inverse();
    obstacles_.reserve(scene.objects().size());
    for (const auto& [name, item] : scene.objects()) {
      obstacles_.push_back(object(item.geometry, (to_base * item.pose).isometry()));
      obstacles_.back().computeAABB();
      tree_.registerObject(&obstacles_.back());
      for (std::size_t i : moving_) {
        if (scene.allowed_collision(name, robot + "/" + model_.geometries()[i].link)) continue;
        obstacle_pairs_.push_back(pair(objects_[i], obstacles_.back()));
      }
    }
    for (const Pair& p : obstacle_pairs_) by_objects_.emplace(std::pair(p.a, p.b), &p);
  }

  static Pair pair(const coal::CollisionObject& a, const coal::CollisionObject& b) {
    return {&a, &b, coal::ComputeCollision(a.collisionGeometryPtr(), b.collisionGeometryPtr())};
  }

  bool hit(const Pair& p) {
    result_.clear();
    return p.collide(p.a->getTransform(), p.b->getTransform(), request_, result_) > 0;
  }

  bool free_of(const std::vector<Pair>& pairs) {
    return std::none_of(pairs.begin(), pairs.end(),
                        [&](const Pair& p) { return p.a->getAABB().overlap(p.b->getAABB()) && hit(p); });
  }

  bool free_in_tree() {
    struct Callback : coal::CollisionCallBackBase {
      explicit Callback(PlainCoal& owner) : self(owner) {}
      bool collide(coal::CollisionObject* a, coal::CollisionObject* b) override {
        auto it = self.by_objects_.find({a, b});
        if (it == self.by_objects_.end()) it = self.by_objects_.find({b, a});
        return it != self.by_objects_.end() && (found = self.hit(*it->second));
      }
      PlainCoal& self;
      bool found{};
    } callback(*this);
    for (std::size_t i : moving_) {
      tree_.collide(&objects_[i], &callback);
      if (callback.found) return false;
    }
    return true;
  }

  const srmp::RobotModel& model_;
  srmp::RobotDataPtr data_;
  std::vector<coal::CollisionObject> objects_;  // by geometry of the robot
  std::vector<std::size_t> moving_;
  std::vector<coal::CollisionObject> obstacles_;
  std::vector<Pair> obstacle_pairs_, self_pairs_;
  std::map<std::pair<const coal::CollisionObject*, const coal::CollisionObject*>, const Pair*> by_objects_;
  coal::DynamicAABBTreeCollisionManager tree_;
  bool use_tree_{};
  coal::CollisionRequest request_;
  coal::CollisionResult result_;
};

}  // namespace bench
