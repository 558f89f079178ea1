#include "srmp/cover/containment_proof.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/interruption.hpp"

namespace srmp {

using Eigen::Vector3d;

namespace {

/// The cell with this centre and half edge length.
ConvexPart corners(const Vector3d& c, double half) {
  ConvexPart part;
  for (int k = 0; k < 8; ++k) part.push_back(c + half * Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
  return part;
}

}  // namespace

void ContainmentProof::run() {
  Indices all(spheres_.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
  if (!solid_.convex)
    for (const Triangle& t : solid_.triangles)
      if (running_) triangle(t, all);
  Indices planes(static_cast<std::size_t>(solid_.normals.rows()));
  for (std::size_t i = 0; i < planes.size(); ++i) planes[i] = static_cast<int>(i);
  const double half = 0.5 * solid_.box.sizes().maxCoeff() * (1 + 1e-9);
  if (running_) cell(solid_.box.center(), half, all, planes);
}

void ContainmentProof::covered(const ConvexPart& part, int sphere) {
  if (on_covered) on_covered(part, sphere);
}

void ContainmentProof::uncovered(const ConvexPart& part) {
  if (running_ && on_uncovered) running_ = on_uncovered(part);
}

void ContainmentProof::triangle(const Triangle& t, const Indices& near) {
  interruption_point();
  const Vector3d center = (t[0] + t[1] + t[2]) / 3;
  const double radius = std::sqrt(
      std::max({(t[0] - center).squaredNorm(), (t[1] - center).squaredNorm(), (t[2] - center).squaredNorm()}));
  const ConvexPart part(t.begin(), t.end());
  Indices overlapping;
  for (int i : near) {
    const double distance = (spheres_[i].center - center).norm();
    if (distance > spheres_[i].radius + radius) continue;
    if (contains(spheres_[i], part)) return covered(part, i);
    overlapping.push_back(i);
  }
  if (radius < resolution_ || overlapping.empty()) return uncovered(part);
  int k = 0;  // the longest edge is bisected
  for (int e = 1; e < 3; ++e)
    if ((t[(e + 1) % 3] - t[e]).squaredNorm() > (t[(k + 1) % 3] - t[k]).squaredNorm()) k = e;
  const Vector3d middle = 0.5 * (t[k] + t[(k + 1) % 3]);
  if (running_) triangle({t[k], middle, t[(k + 2) % 3]}, overlapping);
  if (running_) triangle({middle, t[(k + 1) % 3], t[(k + 2) % 3]}, overlapping);
}

void ContainmentProof::cell(const Vector3d& c, double half, const Indices& near, const Indices& planes) {
  interruption_point();
  Indices cutting, overlapping;
  if (!may_overlap_solid(c, half, planes, cutting)) return;
  for (int i : near) {
    const Eigen::Array3d offset = (c - spheres_[i].center).array().abs();
    const double r2 = spheres_[i].radius * spheres_[i].radius;
    if ((offset + half).square().sum() <= r2) return covered(corners(c, half), i);
    if ((offset - half).max(0.0).square().sum() <= r2) overlapping.push_back(i);
  }
  if (half < resolution_) {
    // Each triangle is proved by itself, so cells that a triangle cuts need no proof.
    if (solid_.convex || solid_.all.nearest(c, 2 * half).distance > 1.75 * half) uncovered(corners(c, half));
    return;
  }
  for (int k = 0; k < 8 && running_; ++k) {
    const Vector3d direction(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    cell(c + 0.5 * half * direction, 0.5 * half, overlapping, cutting);
  }
}

/// Can the cell contain a point of the solid? Adds to `cutting` the planes that cut the cell: the others decide nothing
/// for its parts.
bool ContainmentProof::may_overlap_solid(const Vector3d& c, double half, const Indices& planes,
                                         Indices& cutting) const {
  if (!solid_.convex) {
    const double reach = half * std::sqrt(3.0);
    return solid_.enclosed.encloses(c) || solid_.all.nearest(c, 1.01 * reach).distance <= reach;
  }
  if (solid_.kind == SolidGeometry::Kind::sphere || solid_.kind == SolidGeometry::Kind::capsule)
    return solid_.curved_depth(c) > -half * std::sqrt(3.0);
  for (int i : planes) {
    const auto n = solid_.normals.row(i);
    const double above = n.dot(c) - solid_.offsets[i], spread = half * n.lpNorm<1>();
    if (above > spread) return false;
    if (above > -spread) cutting.push_back(i);
  }
  return true;
}

}  // namespace srmp
