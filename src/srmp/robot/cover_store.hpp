#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "srmp/robot/geometry_cover.hpp"

namespace srmp {

/// Sphere covers made so far, one for each geometry. Threads share it.
class CoverStore {
 public:
  /// The cover of a geometry (`hull` as in cover_geometry); made at the first call. The reference lives as long as the
  /// store.
  const GeometryCover& cover(const coal::CollisionGeometry& shape, const coal::CollisionGeometry* hull);

 private:
  std::mutex mutex_;
  std::map<const coal::CollisionGeometry*, std::unique_ptr<const GeometryCover>> covers_;
};

}  // namespace srmp
