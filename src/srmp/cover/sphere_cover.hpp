#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "srmp/core/placed_sphere.hpp"

namespace srmp {

/// A solid that spheres can cover, in its own frame; curved solids lie along z, centred, as in scene/shape.hpp.
/// Immutable and cheap to copy.
class CoverSolid {
 public:
  using Vertices = std::vector<Eigen::Vector3d>;
  using Triangles = std::vector<std::array<int, 3>>;

  static CoverSolid sphere(double radius);
  static CoverSolid box(const Eigen::Vector3d& size);
  static CoverSolid cylinder(double radius, double length);
  static CoverSolid capsule(double radius, double length);
  static CoverSolid cone(double radius, double length);
  /// The convex hull of the vertices; the triangles are its faces, or nearly so (only the quality depends on them).
  static CoverSolid convex(const Vertices& vertices, const Triangles& triangles);
  /// A triangle surface with everything that it encloses. Holes, doubled faces and wrong orientations are fine:
  /// enclosed is what cannot be reached from outside on a voxel grid (1/128 of the size). Inflation is measured from
  /// that and from the cavities that a sphere of radius `closing` [m] cannot enter; a cover need not hold those. A mesh
  /// that is convex but for rounding is treated as its hull.
  static CoverSolid mesh(const Vertices& vertices, const Triangles& triangles, double closing = 0);

  bool is_convex() const;
  bool is_closed() const;  ///< convex, or a mesh whose every edge has an even number of triangles
  /// Smallest sphere found (not minimal) that holds the solid.
  PlacedSphere bounding_sphere() const;
  /// Depth of a point [m]: > 0 inside (a sphere of that radius is inside the solid), < 0 outside. Exact for convex
  /// solids inside, a lower bound elsewhere.
  double depth(const Eigen::Vector3d& point) const;

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  explicit CoverSolid(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

struct CoverOptions {
  double max_inflation{0.004};  ///< [m], > 0: no sphere sticks out of the solid farther than this
  std::size_t max_spheres{0};   ///< 0: as many as it takes; else max_inflation grows until so many are enough
};

/// Spheres that together contain a solid.
struct SphereCover {
  std::vector<PlacedSphere> spheres;
  double max_inflation{};   ///< [m] how far the worst sphere sticks out
  double mean_inflation{};  ///< [m] mean over spheres
};

/// Covers the solid, deterministically. Every sphere is an inscribed sphere of the solid, grown by at most
/// max_inflation; they are chosen among spheres on the medial axis (shrinking-sphere transform: Ma, Bae, Choi 2012),
/// greedily and then by local search (smaller_cover). Containment is proved, not sampled: a sphere is convex, so a
/// triangle (a cell) is in it when its corners are, else it is split; what stays uncovered is given to the greedy
/// choice again. Proved is: for convex solids the whole interior; for meshes every triangle and every enclosed cell
/// that the surface does not cut. Throws InvalidArgument for options out of range.
SphereCover cover_solid(const CoverSolid& solid, const CoverOptions& options = {});

/// The proof alone: do the spheres contain the solid? `resolution` [m] is the size of the smallest cell looked at; gaps
/// (and overlaps of neighbouring spheres) thinner than that count as not covered.
bool contains_solid(const std::vector<PlacedSphere>& spheres, const CoverSolid& solid, double resolution = 1e-5);

/// At most `count` spheres inside the solid, none smaller than `min_radius` [m]; together they fill much of it. Empty
/// for surfaces that enclose nothing.
std::vector<PlacedSphere> pack_solid(const CoverSolid& solid, std::size_t count, double min_radius = 0.002);

/// For two covers of one solid: children[i] are the fine spheres to look at when coarse sphere i is hit. Every point of
/// the solid is in a coarse sphere i such that one of children[i] holds it as well, so when every coarse sphere is
/// either clear or has clear children, the solid is clear.
std::vector<std::vector<std::uint32_t>> cover_children(const CoverSolid& solid, const std::vector<PlacedSphere>& coarse,
                                                       const std::vector<PlacedSphere>& fine);

}  // namespace srmp
