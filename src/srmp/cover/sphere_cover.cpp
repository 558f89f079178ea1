#include "srmp/cover/sphere_cover.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/cover/containment_proof.hpp"
#include "srmp/cover/inscribed_spheres.hpp"
#include "srmp/cover/solid_geometry.hpp"
#include "srmp/cover/sphere_selection.hpp"

namespace srmp {

namespace {

using Eigen::Vector3d;

constexpr std::size_t kMaxParts = 12000;  // of the surface that the greedy selection starts from
constexpr std::size_t kWorkPerSphere = 2'000'000, kMaxWork = 100'000'000;  // of the local search
constexpr double kRounding = 1e-9;  // [m] added to every proved radius; larger than the proof's own rounding errors

/// Spheres along a capsule's axis. The spacing follows from the geometry of a sphere and a cylinder; it is a little
/// smaller than necessary, so that a proof by cells terminates.
std::vector<PlacedSphere> cover_capsule(double radius, double length, double inflation) {
  const double grown = radius + inflation, half = length / 2, shift = 0.9 * inflation;
  if (half <= shift) return {{Vector3d::Zero(), radius + half / 0.9}};
  const double between = length - 2 * shift, reach = 1.9 * std::sqrt(grown * grown - radius * radius);
  const int steps = static_cast<int>(std::ceil(between / reach));
  std::vector<PlacedSphere> spheres;
  for (int i = 0; i <= steps; ++i) spheres.push_back({{0, 0, -half + shift + between * i / steps}, grown});
  return spheres;
}

/// The surface in triangles of about the size of the inflation, and not many more than kMaxParts.
std::vector<Triangle> split_surface(const SolidGeometry& solid, double inflation) {
  double area = 0;
  for (const Triangle& t : solid.triangles) area += 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
  const double edge = std::max(0.5 * inflation, std::sqrt(8 * area / kMaxParts));
  std::vector<Triangle> parts;
  for (const Triangle& t : solid.triangles) split_triangle(t, edge, [&](const Triangle& p) { parts.push_back(p); });
  return parts;
}

/// Adds points of the interior, which spheres that contain the surface may leave uncovered.
void add_interior(const SolidGeometry& solid, double step, std::vector<ConvexPart>& parts) {
  const Vector3d low = solid.box.min(), size = solid.box.sizes();
  const Eigen::Array3i count = (size.array() / step).ceil().cast<int>();
  for (int x = 0; x < count[0]; ++x)
    for (int y = 0; y < count[1]; ++y)
      for (int z = 0; z < count[2]; ++z) {
        interruption_point();
        const Vector3d p = low + step * Vector3d(x + 0.5, y + 0.5, z + 0.5);
        if (solid.convex ? solid.depth(p) > 0 : solid.enclosed.encloses(p)) parts.push_back({p});
      }
}

/// Every n-th triangle, so that at most `count` are left. The triangles are small; the proof finds those that the cover
/// misses.
std::vector<Triangle> thinned(const std::vector<Triangle>& triangles, std::size_t count) {
  const std::size_t stride = (triangles.size() + count - 1) / count;
  std::vector<Triangle> result;
  for (std::size_t i = 0; i < triangles.size(); i += stride) result.push_back(triangles[i]);
  return result;
}

/// The surface in parts. Adds candidates, so that each part is inside of at least one of them grown by `growth` or is
/// smaller than a quarter of the inflation; parts for which there is none are split.
std::vector<ConvexPart> find_parts(const SolidGeometry& solid, double inflation, double growth,
                                   std::vector<InscribedSphere>& candidates) {
  std::vector<ConvexPart> result;
  std::vector<Triangle> open = thinned(split_surface(solid, inflation), kMaxParts);
  while (!open.empty()) {
    const std::vector<InscribedSphere> more = find_inscribed_spheres(solid, open, 0.2 * inflation);
    candidates.insert(candidates.end(), more.begin(), more.end());
    std::vector<ConvexPart> parts;
    for (const Triangle& t : open) parts.emplace_back(t.begin(), t.end());
    std::vector<char> contained(parts.size(), 0);
    const PartBlocks blocks(parts);
    for (const InscribedSphere& c : candidates) {
      interruption_point();
      blocks.for_each_contained({c.center, std::max(0.0, c.depth + growth)}, [&](std::size_t k) { contained[k] = 1; });
    }
    std::vector<Triangle> next;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const double radius = sphere_around(parts[k]).radius;
      if (contained[k] || radius < 0.25 * inflation)
        result.push_back(parts[k]);
      else
        split_triangle(open[k], std::max(radius, 0.25 * inflation), [&](const Triangle& t) { next.push_back(t); });
    }
    open = std::move(next);
  }
  return result;
}

/// What the spheres do not contain, in parts of about `resolution`; at most `count`, evenly chosen among those found.
std::vector<ConvexPart> find_uncovered(const SolidGeometry& solid, const std::vector<PlacedSphere>& spheres,
                                       double resolution, std::size_t count) {
  std::vector<ConvexPart> found;
  ContainmentProof proof(solid, spheres, resolution);
  proof.on_uncovered = [&](const ConvexPart& part) {
    found.push_back(part);
    return found.size() < 20'000;
  };
  proof.run();
  if (found.size() <= count) return found;
  std::vector<ConvexPart> uncovered;
  for (std::size_t i = 0; i < count; ++i) uncovered.push_back(found[i * found.size() / count]);
  return uncovered;
}

/// Replaces cells by their centres and drops centres outside of the solid, because large cells extend beyond the solid.
void keep_centers(const SolidGeometry& solid, std::vector<ConvexPart>& parts) {
  for (ConvexPart& part : parts)
    if (part.size() == 8) part = {0.5 * (part.front() + part.back())};
  std::erase_if(parts, [&](const ConvexPart& p) { return p.size() == 1 && solid.depth(p[0]) < 0; });
}

/// Adds spheres for parts that no candidate contains.
void add_extra_spheres(const SolidGeometry& solid, const std::vector<ConvexPart>& parts, double inflation,
                       std::vector<PlacedSphere>& spheres) {
  std::vector<ConvexPart> small;
  for (const ConvexPart& part : parts) {
    if (part.size() != 3 || sphere_around(part).radius <= 0.5 * inflation)
      small.push_back(part);
    else
      split_triangle({part[0], part[1], part[2]}, 0.5 * inflation,
                     [&](const Triangle& t) { small.emplace_back(t.begin(), t.end()); });
  }
  const auto before = static_cast<std::ptrdiff_t>(spheres.size());
  for (const ConvexPart& part : small) {
    if (std::any_of(spheres.begin() + before, spheres.end(), [&](const PlacedSphere& b) { return contains(b, part); }))
      continue;
    PlacedSphere sphere = sphere_around(part);
    sphere.radius = std::max(sphere.radius, solid.depth(sphere.center) + inflation);
    spheres.push_back(sphere);
  }
}

std::vector<PlacedSphere> cover_with(const SolidGeometry& solid, double inflation) {
  if (solid.kind == SolidGeometry::Kind::sphere) return {{Vector3d::Zero(), solid.radius}};
  if (solid.kind == SolidGeometry::Kind::capsule) return cover_capsule(solid.radius, solid.length, inflation);
  const double margin = 0.02 * inflation;  // a proof can end at cells of this size
  std::vector<InscribedSphere> candidates;
  std::vector<ConvexPart> parts = find_parts(solid, inflation, inflation - margin, candidates);
  add_interior(solid, std::max(2 * inflation, solid.box.sizes().maxCoeff() / 24), parts);
  SphereSelection selection(candidates, inflation - margin);
  selection.extend(parts);  // parts that no candidate contains are too large; the proof finds smaller ones
  const std::size_t work = std::min(kMaxWork, kWorkPerSphere * selection.selected().size());
  selection.improve(work);
  std::vector<PlacedSphere> extra;
  const double finest = 0.5 * margin;
  for (double resolution = inflation / 8;;) {
    std::vector<PlacedSphere> spheres = extra;
    for (const int i : selection.selected()) {
      spheres.push_back(selection.sphere(i));
      spheres.back().radius += margin;
    }
    std::vector<ConvexPart> uncovered = find_uncovered(solid, spheres, resolution, 4000);
    if (uncovered.empty() && resolution == finest) return spheres;
    if (resolution > finest) keep_centers(solid, uncovered);
    const std::size_t before = selection.selected().size();
    const std::vector<ConvexPart> remaining = selection.extend(uncovered);
    if (selection.selected().size() > before) {
      selection.improve(work / 10);
    } else if (resolution > finest) {
      resolution = std::max(finest, resolution / 4);
    } else {
      add_extra_spheres(solid, remaining, inflation, extra);
    }
  }
}

double inflation_of(const SolidGeometry& solid, const PlacedSphere& sphere) {
  return std::max(0.0, sphere.radius - solid.depth(sphere.center));
}

}  // namespace

SphereCover cover_solid(const CoverSolid& solid, const CoverOptions& options) {
  require_positive(options.max_inflation, "cover: max_inflation");
  SphereCover cover;
  double inflation = options.max_inflation;
  for (;; inflation *= 1.2) {
    cover.spheres = cover_with(solid.geometry(), inflation);
    if (options.max_spheres == 0 || cover.spheres.size() <= options.max_spheres) break;
    if (const PlacedSphere one = solid.bounding_sphere(); inflation > one.radius) {
      cover.spheres = {one};
      break;
    }
  }
  for (PlacedSphere& sphere : cover.spheres) {
    const double inflated = inflation_of(solid.geometry(), sphere);
    cover.max_inflation = std::max(cover.max_inflation, inflated);
    cover.mean_inflation += inflated / static_cast<double>(cover.spheres.size());
    sphere.radius += kRounding;
  }
  return cover;
}

bool contains_solid(const std::vector<PlacedSphere>& spheres, const CoverSolid& solid, double resolution) {
  require_positive(resolution, "cover proof: resolution");
  bool contained = true;
  ContainmentProof proof(solid.geometry(), spheres, resolution);
  proof.on_uncovered = [&](const ConvexPart&) { return contained = false; };
  proof.run();
  return contained;
}

std::vector<PlacedSphere> pack_solid(const CoverSolid& solid, std::size_t count, double min_radius) {
  require_positive(min_radius, "sphere packing: min_radius");
  const SolidGeometry& geometry = solid.geometry();
  if (count == 0) return {};
  if (geometry.kind == SolidGeometry::Kind::sphere) return {{Vector3d::Zero(), geometry.radius}};
  std::vector<InscribedSphere> candidates;
  if (geometry.kind == SolidGeometry::Kind::capsule) {
    for (int i = 0; i <= 32; ++i) candidates.push_back({{0, 0, geometry.length * (i / 32.0 - 0.5)}, geometry.radius});
  } else {
    const double size = geometry.box.sizes().maxCoeff();
    candidates = find_inscribed_spheres(geometry, split_surface(geometry, std::max(min_radius, size / 40)), size / 80);
    for (InscribedSphere& c : candidates) {
      interruption_point();
      c.depth = geometry.inner_depth(c.center) - kRounding;
    }
  }
  std::erase_if(candidates, [&](const InscribedSphere& c) { return !(c.depth >= min_radius); });
  std::vector<ConvexPart> samples;
  add_interior(geometry, geometry.box.sizes().maxCoeff() / 32, samples);
  SphereSelection selection(candidates, 0.0);
  selection.extend(samples);
  const std::vector<int>& selected = selection.selected();
  std::vector<PlacedSphere> spheres;
  for (std::size_t i = 0; i < std::min(count, selected.size()); ++i)
    spheres.push_back({candidates[selected[i]].center, candidates[selected[i]].depth});
  return spheres;
}

std::vector<std::vector<std::uint32_t>> cover_children(const CoverSolid& solid, const std::vector<PlacedSphere>& coarse,
                                                       const std::vector<PlacedSphere>& fine) {
  std::vector<std::vector<char>> linked(coarse.size(), std::vector<char>(fine.size(), 0));
  const auto link = [&](const ConvexPart& part, int f) {
    std::size_t best = coarse.size();
    for (std::size_t c = 0; c < coarse.size(); ++c) {
      if (!contains(coarse[c], part)) continue;
      if (linked[c][f]) return;
      if (best == coarse.size()) best = c;
    }
    if (best < coarse.size()) {
      linked[best][f] = 1;
      return;
    }
    const PlacedSphere around = sphere_around(part);  // in no single coarse sphere: linked to all that it intersects
    for (std::size_t c = 0; c < coarse.size(); ++c)
      if ((coarse[c].center - around.center).norm() <= coarse[c].radius + around.radius) linked[c][f] = 1;
  };
  bool contained = true;
  ContainmentProof proof(solid.geometry(), fine, 1e-5);
  proof.on_covered = link;
  proof.on_uncovered = [&](const ConvexPart&) { return contained = false; };
  proof.run();
  if (!contained) throw InvalidArgument("cover hierarchy: the fine spheres do not contain the solid");
  std::vector<std::vector<std::uint32_t>> children(coarse.size());
  for (std::size_t c = 0; c < coarse.size(); ++c)
    for (std::size_t f = 0; f < fine.size(); ++f)
      if (linked[c][f]) children[c].push_back(static_cast<std::uint32_t>(f));
  return children;
}

}  // namespace srmp
