#pragma once

#include <Eigen/Geometry>
#include <functional>

#include "srmp/cover/cover_store.hpp"
#include "srmp/robot/robot_model.hpp"

namespace srmp {

struct RobotCoverOptions {
  CoverLevels levels;
  /// Coarse spheres of the whole robot. Where levels.coarse needs more, the coarse spheres of the geometries with the
  /// most of them grow until so many are enough. 0: no limit.
  std::size_t max_coarse{160};
  std::size_t threads{0};  ///< that build; 0: as many as there are cores. The cover is the same
};

/// All collision geometries of a robot under spheres.
struct RobotCover {
  struct Part {
    std::string link;
    std::string name;                                          ///< LinkGeometry::name
    Eigen::Isometry3d in_link{Eigen::Isometry3d::Identity()};  ///< pose of the geometry's frame
    std::shared_ptr<const GeometryCover> cover;                ///< equal geometries share one
  };
  std::vector<Part> parts;  ///< by RobotModel::geometries()
  CoverStore::Origin origin{};
  double seconds{};  ///< it took to build or load

  std::size_t coarse_spheres() const;
  std::size_t fine_spheres() const;  ///< exact covers count with their coarse sphere
  double coarse_inflation() const;   ///< [m] largest
  double fine_inflation() const;     ///< [m] largest
};

/// Told before each step what is done, of how much; what it throws ends the work.
using CoverProgress = std::function<void(std::size_t done, std::size_t total)>;

/// Covers every link with the same bits on every run, by the store or anew. From then on the store's cover() answers
/// with these covers for the model's geometries. Throws InvalidArgument for options out of range.
RobotCover cover_robot(const RobotModel& model, CoverStore& store, const RobotCoverOptions& options = {},
                       const CoverProgress& progress = {});

/// cover_robot, unless the store answers for the model's geometries already.
void ensure_covered(const RobotModel& model, CoverStore& store);

/// cover_robot for a URDF file of which nothing is planned. Throws FileError as RobotModel::load does.
RobotCover cover_urdf(const std::string& urdf_path, const std::vector<std::string>& package_dirs, CoverStore& store,
                      const RobotCoverOptions& options = {}, const CoverProgress& progress = {});

}  // namespace srmp
