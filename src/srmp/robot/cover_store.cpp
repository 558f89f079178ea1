#include "srmp/robot/cover_store.hpp"

namespace srmp {

const GeometryCover& CoverStore::cover(const coal::CollisionGeometry& shape, const coal::CollisionGeometry* hull) {
  const std::lock_guard lock(mutex_);
  auto& slot = covers_[&shape];
  if (!slot) slot = std::make_unique<const GeometryCover>(cover_geometry(shape, hull));
  return *slot;
}

}  // namespace srmp
