#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "srmp/core/placed_sphere.hpp"
#include "srmp/cover/cover_solid.hpp"

namespace srmp {

/// What is required of a cover.
struct CoverOptions {
  double max_inflation{0.004};  ///< [m], > 0: no sphere extends beyond the solid by more than this
  std::size_t max_spheres{0};   ///< 0: no limit; otherwise max_inflation grows until this many spheres suffice
};

/// Spheres that together contain a solid.
struct SphereCover {
  std::vector<PlacedSphere> spheres;
  double max_inflation{};   ///< [m] largest inflation of a sphere
  double mean_inflation{};  ///< [m] mean inflation of the spheres
};

/// Covers the solid, deterministically. Every sphere is an inscribed sphere of the solid, grown by at most
/// max_inflation; they are chosen among spheres on the medial axis (shrinking-ball transform: Ma, Bae, Choi 2012),
/// greedily and then by local search (smaller_cover). Containment is proved, not sampled: a sphere is convex, so a
/// triangle (or a cell) is inside when its corners are, and is subdivided otherwise; what stays uncovered is returned
/// to the greedy selection. The proof covers the whole interior of convex solids, and every triangle and every enclosed
/// cell that the surface does not cut of meshes. Throws InvalidArgument for options out of range.
SphereCover cover_solid(const CoverSolid& solid, const CoverOptions& options = {});

/// The proof alone: do the spheres contain the solid? `resolution` [m] > 0 is the size of the smallest cell; a part of
/// the solid that only cells smaller than this could prove covered counts as uncovered. Throws InvalidArgument for
/// another resolution.
bool contains_solid(const std::vector<PlacedSphere>& spheres, const CoverSolid& solid, double resolution = 1e-5);

/// At most `count` spheres inside the solid, none smaller than `min_radius` [m] > 0; together they fill much of it.
/// Empty for surfaces that enclose nothing. Throws InvalidArgument for a radius out of range.
std::vector<PlacedSphere> pack_solid(const CoverSolid& solid, std::size_t count, double min_radius = 0.002);

/// For two covers of one solid: children[i] are the fine spheres to check when coarse sphere i collides. Every point of
/// the solid is in a coarse sphere i such that one of children[i] contains it as well; when every coarse sphere is
/// collision-free or has collision-free children, so is the solid. Throws InvalidArgument when the fine spheres do not
/// contain the solid.
std::vector<std::vector<std::uint32_t>> cover_children(const CoverSolid& solid, const std::vector<PlacedSphere>& coarse,
                                                       const std::vector<PlacedSphere>& fine);

}  // namespace srmp
