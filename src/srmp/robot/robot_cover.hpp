#pragma once

#include <Eigen/Geometry>

#include "srmp/core/steps.hpp"
#include "srmp/cover/cover_store.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp {

/// Options of cover_robot and cover_urdf.
struct RobotCoverOptions {
  CoverLevels levels{};  ///< of every geometry
  /// Largest number of coarse spheres of the whole robot, 0: no limit. Where levels.coarse needs more, coarse spheres
  /// grow beyond it until this many suffice, in each step those of the geometry with the most spheres per inflation.
  std::size_t max_coarse{160};
  std::size_t threads{0};  ///< 0: as many as there are cores. The cover does not depend on it
};

/// The sphere covers of all collision geometries of a robot.
struct RobotCover {
  /// The cover of one geometry.
  struct Part {
    std::string link;                                          ///< link name
    std::string name;                                          ///< LinkGeometry::name
    Eigen::Isometry3d in_link{Eigen::Isometry3d::Identity()};  ///< pose of the geometry's frame in the link's
    std::shared_ptr<const GeometryCover> cover;                ///< equal geometries share one
  };
  std::vector<Part> parts;  ///< in the order of RobotModel::geometries()
  CoverStore::Origin origin{};
  double seconds{};  ///< [s] time to compute or load the covers

  std::size_t coarse_spheres() const;  ///< number of coarse spheres
  std::size_t fine_spheres() const;    ///< number of fine spheres; exact covers count with their coarse sphere
  double coarse_inflation() const;     ///< [m] largest
  double fine_inflation() const;       ///< [m] largest
};

/// Covers every geometry of the robot, or takes the covers from the store; they are the same bit for bit. The store
/// adopts them, so that its cover() returns them for the model's geometries. Throws InvalidArgument for options out of
/// range.
RobotCover cover_robot(const RobotModel& model, CoverStore& store, const RobotCoverOptions& options = {},
                       const StepProgress& progress = {});

/// Has the store adopt covers for all geometries of the model: those of cover_robot (with default options) where they
/// are known, else quick covers. Takes milliseconds. Returns whether none of them is quick.
bool ensure_covered(const RobotModel& model, CoverStore& store);
/// Has the store adopt quick covers for all geometries of the model, which CoverStore::adopted_quick returns. Takes
/// milliseconds.
void ensure_quickly_covered(const RobotModel& model, CoverStore& store);

/// cover_robot for a URDF file without a RobotModel; no cover is adopted. Throws FileError as RobotModel::load does,
/// and InvalidArgument for options out of range.
RobotCover cover_urdf(const std::string& urdf_path, const std::vector<std::string>& package_dirs, CoverStore& store,
                      const RobotCoverOptions& options = {}, const StepProgress& progress = {});

}  // namespace srmp
