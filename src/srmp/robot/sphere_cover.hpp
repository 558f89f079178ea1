#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

namespace srmp {

/// A ball: centre [m] in the frame of the geometry it belongs to, radius [m].
struct Ball {
  Eigen::Vector3d center{Eigen::Vector3d::Zero()};
  double radius{};
};

/// A solid that balls can cover, in its own frame; curved solids lie along z, centred, as in scene/shape.hpp.
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
  /// that and from the cavities that a ball of radius `closing` [m] cannot enter; a cover need not hold those. A mesh
  /// that is convex but for rounding is treated as its hull.
  static CoverSolid mesh(const Vertices& vertices, const Triangles& triangles, double closing = 0);

  bool is_convex() const;
  bool is_closed() const;  ///< convex, or a mesh whose every edge has an even number of triangles
  /// Smallest ball found (not minimal) that holds the solid.
  Ball bounding_ball() const;
  /// Depth of a point [m]: > 0 inside (a ball of that radius is inside the solid), < 0 outside. Exact for convex solids
  /// inside, a lower bound elsewhere.
  double depth(const Eigen::Vector3d& point) const;

  struct Impl;
  const Impl& impl() const { return *impl_; }

 private:
  explicit CoverSolid(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

struct CoverOptions {
  double max_inflation{0.004};  ///< [m], > 0: no ball sticks out of the solid farther than this
  std::size_t max_balls{0};     ///< 0: as many as it takes; else max_inflation grows until so many are enough
};

/// Balls that together contain a solid.
struct SphereCover {
  std::vector<Ball> balls;
  double max_inflation{};   ///< [m] how far the worst ball sticks out
  double mean_inflation{};  ///< [m] mean over balls
};

/// Covers the solid, deterministically. Every ball is an inscribed ball of the solid, grown by at most max_inflation;
/// they are chosen among balls on the medial axis (shrinking-ball transform: Ma, Bae, Choi 2012), greedily and then by
/// local search (smaller_cover). Containment
/// is proved, not sampled: a ball is convex, so a triangle (a cell) is in it when its corners are, else it is split;
/// what stays uncovered is given to the greedy choice again. Proved is: for convex solids the whole interior; for
/// meshes every triangle and every enclosed cell that the surface does not cut.
/// Throws InvalidArgument for options out of range.
SphereCover cover_solid(const CoverSolid& solid, const CoverOptions& options = {});

/// The proof alone: do the balls contain the solid? `resolution` [m] is the size of the smallest cell looked at; gaps
/// (and overlaps of neighbouring balls) thinner than that count as not covered.
bool contains_solid(const std::vector<Ball>& balls, const CoverSolid& solid, double resolution = 1e-5);

/// At most `count` balls inside the solid, none smaller than `min_radius` [m]; together they fill much of it. Empty
/// for surfaces that enclose nothing.
std::vector<Ball> pack_solid(const CoverSolid& solid, std::size_t count, double min_radius = 0.002);

/// For two covers of one solid: children[i] are the fine balls to look at when coarse ball i is hit. Every point of
/// the solid is in a coarse ball i such that one of children[i] holds it as well, so when every coarse ball is either
/// clear or has clear children, the solid is clear.
std::vector<std::vector<std::uint32_t>> cover_children(const CoverSolid& solid, const std::vector<Ball>& coarse,
                                                       const std::vector<Ball>& fine);

}  // namespace srmp
