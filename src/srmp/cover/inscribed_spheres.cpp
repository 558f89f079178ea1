#include "srmp/cover/inscribed_spheres.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>

#include "srmp/core/interruption.hpp"

namespace srmp {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kMaxTouchPoints = 6000;  // on the surface

/// The centre of the largest sphere that touches the surface at `x` from the side that `inward` points to.
std::optional<Vector3d> shrink_sphere(const SolidGeometry& solid, const Vector3d& x, const Vector3d& inward) {
  const double size = solid.box.diagonal().norm();
  double r = 0.5 * size;
  if (solid.convex) {  // the first plane that the growing sphere touches
    for (Eigen::Index j = 0; j < solid.normals.rows(); ++j) {
      const double rate = 1 + solid.normals.row(j).dot(inward);
      const double distance = std::max(0.0, solid.offsets[j] - solid.normals.row(j).dot(x));
      if (rate > 1e-6) r = std::min(r, distance / rate);
    }
    return x + inward * r;
  }
  for (int i = 0; i < 30; ++i) {
    interruption_point();
    const Vector3d c = x + inward * r;
    const auto nearest = solid.outer.nearest(c, r * (1 - 1e-6));
    if (nearest.distance >= r * (1 - 1e-6)) return c;
    const Vector3d d = nearest.point - x;
    const double along = 2 * d.dot(inward);
    if (along <= 0) return std::nullopt;
    r = std::min(d.squaredNorm() / along, 0.999 * r);
    if (r < 1e-5) return std::nullopt;
  }
  return x + inward * r;
}

}  // namespace

std::vector<InscribedSphere> find_inscribed_spheres(const SolidGeometry& solid, const std::vector<Triangle>& triangles,
                                                    double grid) {
  std::map<std::array<long, 3>, InscribedSphere> best;  // the deepest of each grid cell
  const auto offer = [&](const Vector3d& c) {
    const InscribedSphere candidate{c, solid.depth(c)};
    const std::array<long, 3> key{std::lround(c.x() / grid), std::lround(c.y() / grid), std::lround(c.z() / grid)};
    const auto [place, added] = best.try_emplace(key, candidate);
    if (!added && candidate.depth > place->second.depth) place->second = candidate;
  };
  const std::size_t stride = (triangles.size() + kMaxTouchPoints - 1) / kMaxTouchPoints;
  for (std::size_t i = 0; i < triangles.size(); i += stride) {
    interruption_point();
    const Triangle& t = triangles[i];
    const Vector3d x = (t[0] + t[1] + t[2]) / 3, cross = (t[1] - t[0]).cross(t[2] - t[0]);
    if (cross.norm() < 1e-16) continue;
    Vector3d inward = -cross.normalized();
    offer(x);
    if (solid.convex) {
      if (inward.dot(solid.box.center() - x) < 0) inward = -inward;
      offer(*shrink_sphere(solid, x, inward));
      continue;
    }
    for (const Vector3d& direction : {inward, Vector3d(-inward)})
      if (const auto c = shrink_sphere(solid, x, direction); c && solid.depth(*c) > 0) offer(*c);
  }
  std::vector<InscribedSphere> result;
  for (const auto& entry : best) result.push_back(entry.second);
  return result;
}

}  // namespace srmp
