#include "srmp/cover/solid_geometry.hpp"

#include <cmath>
#include <limits>

namespace srmp {

using Eigen::Vector3d;

bool SolidGeometry::is_odd(const Vector3d& p) const {
  const Vector3d direction(0.4371, 0.7213, 0.5373);  // an arbitrary direction, with which no mesh is aligned
  return closed && all.crossings(p, direction) % 2 == 1 && all.crossings(p, -direction) % 2 == 1;
}

double SolidGeometry::depth(const Vector3d& p) const {
  if (curved_depth) return curved_depth(p);
  if (convex) return (offsets - normals * p).minCoeff();
  const double distance = outer.nearest(p).distance;
  // In a voxel that triangles cut, the point is inside when the outer surface is far, since the triangles are then
  // those of an inner wall; otherwise the parity of a closed mesh decides.
  const bool inside = filled.encloses(p) || (filled.cut(p) && distance > 3 * filled.voxel()) || is_odd(p);
  return inside ? distance : -distance;
}

double SolidGeometry::inner_depth(const Vector3d& p) const {
  if (curved_depth) return curved_depth(p);
  if (convex) return (inner_offsets - normals * p).minCoeff();
  if (!is_odd(p)) return -std::numeric_limits<double>::infinity();
  return all.nearest(p).distance;
}

}  // namespace srmp
