#include "srmp/collision/self_filter.hpp"

#include <coal/shape/geometric_shapes.h>

#include "srmp/collision/narrow_phase.hpp"
#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"

namespace srmp {

using namespace detail;

namespace {

/// Tests whether points are within a distance of one geometry: spheres around them against it.
class NearGeometry {
 public:
  NearGeometry(const coal::CollisionGeometry& geometry, const GeometryParts& parts, const Eigen::Isometry3d& pose,
               double distance)
      : geometry_(geometry),
        bvh_(parts.bvh.get()),
        bounds_(bounds_of(geometry)),
        pose_(pose),
        center_(pose * bounds_.center),
        sphere_(distance),
        sphere_bounds_{Eigen::Vector3d::Zero(), distance, Eigen::Vector3d::Zero(),
                       Eigen::Vector3d::Constant(distance)} {
    if (!bvh_) formula_ = table_.index(sphere_, geometry_);
    narrow_ = std::make_unique<NarrowPhase>(table_);
  }

  bool contains(const Eigen::Vector3d& point) {
    const Eigen::Vector3d local = pose_.linear().transpose() * (point - pose_.translation()) - bounds_.box_center;
    if ((local.cwiseAbs() - bounds_.box_half).cwiseMax(0.0).norm() > sphere_.radius) return false;
    Eigen::Isometry3d sphere_pose = Eigen::Isometry3d::Identity();
    sphere_pose.translation() = point;
    const Placed sphere{&sphere_, nullptr, sphere_bounds_, sphere_pose, point};
    const Placed body{&geometry_, bvh_, bounds_, pose_, center_};
    const double distance =
        bvh_ ? narrow_->primitives(sphere, body, {.enough = 1.0}) : narrow_->solids(formula_, sphere, body, 0.0);
    return distance <= NarrowPhase::contact_distance;
  }

 private:
  const coal::CollisionGeometry& geometry_;
  const PrimitiveBvh* bvh_;
  Bounds bounds_;
  Eigen::Isometry3d pose_;
  Eigen::Vector3d center_;
  coal::Sphere sphere_;
  Bounds sphere_bounds_;
  FormulaTable table_;
  int formula_{-1};
  std::unique_ptr<NarrowPhase> narrow_;
};

}  // namespace

std::vector<Eigen::Vector3d> points_clear_of_robots(const Scene& scene, const std::vector<Eigen::Vector3d>& points,
                                                    const Pose& pose, double distance) {
  require_positive(distance, "self_filter_distance");
  std::vector<Eigen::Vector3d> kept = points;
  const auto filter = [&](const coal::CollisionGeometry& geometry, const GeometryParts& parts,
                          const Eigen::Isometry3d& geometry_pose) {
    NearGeometry near(geometry, parts, geometry_pose, distance);
    std::erase_if(kept, [&](const Eigen::Vector3d& point) {
      interruption_point();
      return near.contains(pose * point);
    });
  };
  for (const auto& [name, robot] : scene.robots()) {
    const RobotDataPtr data = robot.model->make_data(robot.other_positions);
    robot.model->forward(*data, robot.q);
    for (std::size_t i = 0; i < robot.parts.size(); ++i)
      filter(*robot.model->geometries()[i].shape, robot.parts[i],
             robot.base.isometry() * robot.model->geometry_pose(*data, i));
  }
  for (const auto& [name, attachment] : scene.attachments()) {
    const Object& object = scene.object(name);
    filter(*object.geometry, object.parts, scene.object_pose(name).isometry());
  }
  return kept;
}

}  // namespace srmp
