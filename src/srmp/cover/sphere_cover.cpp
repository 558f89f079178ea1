#include "srmp/cover/sphere_cover.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <queue>
#include <tuple>

#include "srmp/core/error.hpp"
#include "srmp/cover/cover_solid.hpp"
#include "srmp/cover/set_cover.hpp"

namespace srmp {

namespace {

using Eigen::Vector3d;
using Indices = std::vector<int>;

constexpr std::size_t kMaxPieces = 12000;  // surface pieces that the greedy choice starts from
constexpr std::size_t kMaxCandidates = 6000;
constexpr std::size_t kWorkPerSphere = 2'000'000, kMaxWork = 100'000'000;  // of the local search
constexpr double kRounding = 1e-9;  // [m] added to every proved radius; dwarfs the proof's own rounding

// --- The proof

/// A piece of the solid: the convex hull of a few points.
using Piece = std::vector<Vector3d>;

bool holds(const PlacedSphere& sphere, const Piece& piece) {
  for (const Vector3d& p : piece)
    if ((p - sphere.center).squaredNorm() > sphere.radius * sphere.radius) return false;
  return true;
}

/// The smallest sphere around a piece's centre.
PlacedSphere sphere_around(const Piece& piece) {
  PlacedSphere sphere;
  for (const Vector3d& p : piece) sphere.center += p / static_cast<double>(piece.size());
  for (const Vector3d& p : piece) sphere.radius = std::max(sphere.radius, (p - sphere.center).norm());
  sphere.radius *= 1 + 1e-9;
  return sphere;
}

/// Walks over the solid by ever smaller pieces until each is inside one sphere or smaller than `resolution`.
class Proof {
 public:
  Proof(const CoverSolid::Impl& solid, const std::vector<PlacedSphere>& spheres, double resolution)
      : solid_(solid), spheres_(spheres), resolution_(resolution) {}

  std::function<bool(const Piece&)> on_gap;  ///< not covered; return false to stop
  std::function<void(const Piece&, int sphere)> on_covered;

  void run() {
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

 private:
  void gap(const Piece& piece) {
    if (running_ && on_gap) running_ = on_gap(piece);
  }

  void triangle(const Triangle& t, const Indices& near) {
    const Vector3d center = (t[0] + t[1] + t[2]) / 3;
    const double radius = std::sqrt(
        std::max({(t[0] - center).squaredNorm(), (t[1] - center).squaredNorm(), (t[2] - center).squaredNorm()}));
    const Piece piece(t.begin(), t.end());
    Indices meeting;
    for (int i : near) {
      const double distance = (spheres_[i].center - center).norm();
      if (distance > spheres_[i].radius + radius) continue;
      if (holds(spheres_[i], piece)) return covered(piece, i);
      meeting.push_back(i);
    }
    if (radius < resolution_ || meeting.empty()) return gap(piece);
    int k = 0;  // split the longest edge
    for (int e = 1; e < 3; ++e)
      if ((t[(e + 1) % 3] - t[e]).squaredNorm() > (t[(k + 1) % 3] - t[k]).squaredNorm()) k = e;
    const Vector3d middle = 0.5 * (t[k] + t[(k + 1) % 3]);
    if (running_) triangle({t[k], middle, t[(k + 2) % 3]}, meeting);
    if (running_) triangle({middle, t[(k + 1) % 3], t[(k + 2) % 3]}, meeting);
  }

  void cell(const Vector3d& c, double half, const Indices& near, const Indices& planes) {
    Indices cutting, meeting;
    if (!meets_solid(c, half, planes, cutting)) return;
    for (int i : near) {
      const Eigen::Array3d offset = (c - spheres_[i].center).array().abs();
      const double r2 = spheres_[i].radius * spheres_[i].radius;
      if ((offset + half).square().sum() <= r2) return covered(corners(c, half), i);
      if ((offset - half).max(0.0).square().sum() <= r2) meeting.push_back(i);
    }
    if (half < resolution_) {
      // The triangles are proved one by one, so cells that they cut need not be.
      if (solid_.convex || solid_.all.nearest(c, 2 * half).distance > 1.75 * half) gap(corners(c, half));
      return;
    }
    for (int k = 0; k < 8 && running_; ++k) {
      const Vector3d way(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
      cell(c + 0.5 * half * way, 0.5 * half, meeting, cutting);
    }
  }

  /// Can the cell hold a point of the solid? `cutting` gets the planes that can tell for its parts.
  bool meets_solid(const Vector3d& c, double half, const Indices& planes, Indices& cutting) const {
    if (!solid_.convex) {
      const double reach = half * std::sqrt(3.0);
      return solid_.enclosed.encloses(c) || solid_.all.nearest(c, 1.01 * reach).distance <= reach;
    }
    if (solid_.kind == CoverSolid::Impl::Kind::sphere || solid_.kind == CoverSolid::Impl::Kind::capsule)
      return solid_.curved_depth(c) > -half * std::sqrt(3.0);
    for (int i : planes) {
      const auto n = solid_.normals.row(i);
      const double above = n.dot(c) - solid_.offsets[i], spread = half * n.lpNorm<1>();
      if (above > spread) return false;
      if (above > -spread) cutting.push_back(i);
    }
    return true;
  }

  static Piece corners(const Vector3d& c, double half) {
    Piece piece;
    for (int k = 0; k < 8; ++k) piece.push_back(c + half * Vector3d(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1));
    return piece;
  }

  void covered(const Piece& piece, int sphere) {
    if (on_covered) on_covered(piece, sphere);
  }

  const CoverSolid::Impl& solid_;
  const std::vector<PlacedSphere>& spheres_;
  const double resolution_;
  bool running_{true};
};

// --- Candidates: inscribed spheres on the medial axis

struct Candidate {
  Vector3d center;
  double depth;  ///< radius of the inscribed sphere
};

/// The largest sphere that touches the surface at `x` from the side that `inward` points to.
std::optional<Vector3d> shrink_sphere(const CoverSolid::Impl& solid, const Vector3d& x, const Vector3d& inward) {
  const double size = solid.box.diagonal().norm();
  double r = 0.5 * size;
  if (solid.convex) {  // the first plane that the growing sphere meets
    for (Eigen::Index j = 0; j < solid.normals.rows(); ++j) {
      const double rate = 1 + solid.normals.row(j).dot(inward);
      const double gap = std::max(0.0, solid.offsets[j] - solid.normals.row(j).dot(x));
      if (rate > 1e-6) r = std::min(r, gap / rate);
    }
    return x + inward * r;
  }
  for (int i = 0; i < 30; ++i) {
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

std::vector<Candidate> find_candidates(const CoverSolid::Impl& solid, const std::vector<Triangle>& pieces,
                                       double grid) {
  std::map<std::array<long, 3>, Candidate> best;  // the deepest of each grid cell
  const auto offer = [&](const Vector3d& c) {
    const Candidate candidate{c, solid.depth(c)};
    const std::array<long, 3> key{std::lround(c.x() / grid), std::lround(c.y() / grid), std::lround(c.z() / grid)};
    const auto [place, added] = best.try_emplace(key, candidate);
    if (!added && candidate.depth > place->second.depth) place->second = candidate;
  };
  const std::size_t stride = (pieces.size() + kMaxCandidates - 1) / kMaxCandidates;
  for (std::size_t i = 0; i < pieces.size(); i += stride) {
    const Triangle& t = pieces[i];
    const Vector3d x = (t[0] + t[1] + t[2]) / 3, cross = (t[1] - t[0]).cross(t[2] - t[0]);
    if (cross.norm() < 1e-16) continue;
    Vector3d inward = -cross.normalized();
    offer(x);
    if (solid.convex) {
      if (inward.dot(solid.box.center() - x) < 0) inward = -inward;
      offer(*shrink_sphere(solid, x, inward));
      continue;
    }
    for (const Vector3d& way : {inward, Vector3d(-inward)})
      if (const auto c = shrink_sphere(solid, x, way); c && solid.depth(*c) > 0) offer(*c);
  }
  std::vector<Candidate> result;
  for (const auto& entry : best) result.push_back(entry.second);
  return result;
}

// --- The choice among candidates

/// Pieces in blocks of neighbours, so that most are held, or out of reach, with their block.
class PieceBlocks {
 public:
  explicit PieceBlocks(const std::vector<Piece>& pieces) : pieces_(pieces) {
    for (const Piece& piece : pieces) around_.push_back(sphere_around(piece));
    std::vector<std::size_t> order(pieces.size());
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
    if (!order.empty()) split(order.data(), order.data() + order.size());
  }

  template <class Visit>
  void for_each_held(const PlacedSphere& sphere, Visit&& visit) const {
    for (const Block& block : blocks_) {
      const double distance = (block.around.center - sphere.center).norm();
      if (distance > sphere.radius + block.around.radius) continue;
      const bool all = distance + block.around.radius < sphere.radius * (1 - 1e-12);
      for (const std::size_t k : block.pieces)
        if (all || holds(sphere, pieces_[k])) visit(k);
    }
  }

 private:
  struct Block {
    PlacedSphere around;
    std::vector<std::size_t> pieces;
  };

  void split(std::size_t* begin, std::size_t* end) {
    Eigen::AlignedBox3d box;
    for (const std::size_t* k = begin; k != end; ++k) box.extend(around_[*k].center);
    if (end - begin <= 24) {
      Block block{{box.center(), 0}, {begin, end}};
      for (const std::size_t k : block.pieces)
        block.around.radius =
            std::max(block.around.radius, (around_[k].center - block.around.center).norm() + around_[k].radius);
      blocks_.push_back(std::move(block));
      return;
    }
    int axis;
    box.sizes().maxCoeff(&axis);
    std::size_t* middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, [&](std::size_t a, std::size_t b) {
      return std::pair(around_[a].center[axis], a) < std::pair(around_[b].center[axis], b);
    });
    split(begin, middle);
    split(middle, end);
  }

  const std::vector<Piece>& pieces_;
  std::vector<PlacedSphere> around_;
  std::vector<Block> blocks_;
};

/// Which of many pieces each candidate sphere holds; picks spheres until every piece that some candidate holds is held.
class Choice {
 public:
  Choice(const std::vector<Candidate>& candidates, double growth) : candidates_(candidates), growth_(growth) {
    system_.sets.resize(candidates.size());
    new_from_.resize(candidates.size());
  }

  /// Adds pieces and, greedily, spheres for them; returns the pieces that no candidate holds.
  std::vector<Piece> extend(const std::vector<Piece>& pieces) {
    const std::size_t first = system_.elements;
    add_elements(pieces);
    std::vector<char> open(pieces.size(), 1);
    const auto close = [&](int i) {
      for (std::size_t k = new_from_[i]; k < set(i).size(); ++k) open[set(i)[k] - first] = 0;
    };
    const auto gain_of = [&](int i) {
      int gain = 0;
      for (std::size_t k = new_from_[i]; k < set(i).size(); ++k) gain += open[set(i)[k] - first];
      return gain;
    };
    for (const int i : chosen_) close(i);
    std::priority_queue<std::pair<int, int>> queue;  // (gain, -candidate)
    for (std::size_t i = 0; i < candidates_.size(); ++i)
      queue.push({gain_of(static_cast<int>(i)), -static_cast<int>(i)});
    while (!queue.empty()) {
      const auto [promised, minus_i] = queue.top();
      queue.pop();
      const int gain = gain_of(-minus_i);
      if (gain == 0) continue;
      if (gain < promised) {
        queue.push({gain, minus_i});
        continue;
      }
      chosen_.push_back(-minus_i);
      close(-minus_i);
    }
    std::vector<Piece> left;
    for (std::size_t k = 0; k < pieces.size(); ++k)
      if (open[k]) left.push_back(pieces[k]);
    drop_needless();
    return left;
  }

  void polish(std::size_t work) { chosen_ = smaller_cover(system_, chosen_, work); }

  const Indices& chosen() const { return chosen_; }
  PlacedSphere sphere(int i) const { return {candidates_[i].center, std::max(0.0, candidates_[i].depth + growth_)}; }

 private:
  const std::vector<std::uint32_t>& set(int i) const { return system_.sets[i]; }

  void add_elements(const std::vector<Piece>& pieces) {
    const PieceBlocks blocks(pieces);
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      new_from_[i] = system_.sets[i].size();
      blocks.for_each_held(sphere(static_cast<int>(i)), [&](std::size_t k) {
        system_.sets[i].push_back(static_cast<std::uint32_t>(system_.elements + k));
      });
    }
    system_.elements += pieces.size();
  }

  /// Later choices often make earlier ones needless.
  void drop_needless() {
    std::vector<int> times(system_.elements, 0);
    for (const int i : chosen_)
      for (const std::uint32_t k : set(i)) ++times[k];
    std::erase_if(chosen_, [&](int i) {
      if (std::any_of(set(i).begin(), set(i).end(), [&](std::uint32_t k) { return times[k] == 1; })) return false;
      for (const std::uint32_t k : set(i)) --times[k];
      return true;
    });
  }

  const std::vector<Candidate>& candidates_;
  const double growth_;
  SetSystem system_;                   // by candidate
  std::vector<std::size_t> new_from_;  // in each set, the first element of the last extend
  Indices chosen_;
};

// --- Whole covers

/// Spheres along a capsule's axis; by the geometry of a sphere and a cylinder, a little closer than need be, so that a
/// proof by cells ends.
std::vector<PlacedSphere> cover_capsule(double radius, double length, double inflation) {
  const double grown = radius + inflation, half = length / 2, shift = 0.9 * inflation;
  if (half <= shift) return {{Vector3d::Zero(), radius + half / 0.9}};
  const double between = length - 2 * shift, reach = 1.9 * std::sqrt(grown * grown - radius * radius);
  const int steps = static_cast<int>(std::ceil(between / reach));
  std::vector<PlacedSphere> spheres;
  for (int i = 0; i <= steps; ++i) spheres.push_back({{0, 0, -half + shift + between * i / steps}, grown});
  return spheres;
}

std::vector<Triangle> split_surface(const CoverSolid::Impl& solid, double inflation) {
  double area = 0;
  for (const Triangle& t : solid.triangles) area += 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
  const double edge = std::max(0.5 * inflation, std::sqrt(8 * area / kMaxPieces));
  std::vector<Triangle> pieces;
  for (const Triangle& t : solid.triangles) split_triangle(t, edge, [&](const Triangle& p) { pieces.push_back(p); });
  return pieces;
}

/// Points deep inside, which the surface's pieces do not speak for.
void add_interior(const CoverSolid::Impl& solid, double step, std::vector<Piece>& pieces) {
  const Vector3d low = solid.box.min(), size = solid.box.sizes();
  const Eigen::Array3i count = (size.array() / step).ceil().cast<int>();
  for (int x = 0; x < count[0]; ++x)
    for (int y = 0; y < count[1]; ++y)
      for (int z = 0; z < count[2]; ++z) {
        const Vector3d p = low + step * Vector3d(x + 0.5, y + 0.5, z + 0.5);
        if (solid.convex ? solid.depth(p) > 0 : solid.enclosed.encloses(p)) pieces.push_back({p});
      }
}

/// Every n-th, so that at most `count` are left: of small pieces, the proof finds those that are missed.
std::vector<Triangle> thinned(const std::vector<Triangle>& triangles, std::size_t count) {
  const std::size_t stride = (triangles.size() + count - 1) / count;
  std::vector<Triangle> result;
  for (std::size_t i = 0; i < triangles.size(); i += stride) result.push_back(triangles[i]);
  return result;
}

/// The surface in pieces, and candidates of which one at least, grown by `growth`, holds each piece: where none does,
/// the piece is split.
std::vector<Piece> find_pieces(const CoverSolid::Impl& solid, double inflation, double growth,
                               std::vector<Candidate>& candidates) {
  std::vector<Piece> result;
  std::vector<Triangle> open = thinned(split_surface(solid, inflation), kMaxPieces);
  while (!open.empty()) {
    const std::vector<Candidate> more = find_candidates(solid, open, 0.2 * inflation);
    candidates.insert(candidates.end(), more.begin(), more.end());
    std::vector<Piece> pieces;
    for (const Triangle& t : open) pieces.emplace_back(t.begin(), t.end());
    std::vector<char> held(pieces.size(), 0);
    const PieceBlocks blocks(pieces);
    for (const Candidate& c : candidates)
      blocks.for_each_held({c.center, std::max(0.0, c.depth + growth)}, [&](std::size_t k) { held[k] = 1; });
    std::vector<Triangle> next;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      const double radius = sphere_around(pieces[k]).radius;
      if (held[k] || radius < 0.25 * inflation)
        result.push_back(pieces[k]);
      else
        split_triangle(open[k], std::max(radius, 0.25 * inflation), [&](const Triangle& t) { next.push_back(t); });
    }
    open = std::move(next);
  }
  return result;
}

/// What the spheres do not hold, in pieces of about `resolution`; at most `count`, spread over what was found.
std::vector<Piece> find_gaps(const CoverSolid::Impl& solid, const std::vector<PlacedSphere>& spheres, double resolution,
                             std::size_t count) {
  std::vector<Piece> found;
  Proof proof(solid, spheres, resolution);
  proof.on_gap = [&](const Piece& piece) {
    found.push_back(piece);
    return found.size() < 20'000;
  };
  proof.run();
  if (found.size() <= count) return found;
  std::vector<Piece> gaps;
  for (std::size_t i = 0; i < count; ++i) gaps.push_back(found[i * found.size() / count]);
  return gaps;
}

/// Large cells reach out of the solid: only their centres, where those are inside, speak for it.
void keep_centers(const CoverSolid::Impl& solid, std::vector<Piece>& pieces) {
  for (Piece& piece : pieces)
    if (piece.size() == 8) piece = {0.5 * (piece.front() + piece.back())};
  std::erase_if(pieces, [&](const Piece& p) { return p.size() == 1 && solid.depth(p[0]) < 0; });
}

/// Spheres for pieces that no candidate reaches.
void add_own_spheres(const CoverSolid::Impl& solid, const std::vector<Piece>& pieces, double inflation,
                     std::vector<PlacedSphere>& spheres) {
  std::vector<Piece> small;
  for (const Piece& piece : pieces) {
    if (piece.size() != 3 || sphere_around(piece).radius <= 0.5 * inflation)
      small.push_back(piece);
    else
      split_triangle({piece[0], piece[1], piece[2]}, 0.5 * inflation,
                     [&](const Triangle& t) { small.emplace_back(t.begin(), t.end()); });
  }
  const auto before = static_cast<std::ptrdiff_t>(spheres.size());
  for (const Piece& piece : small) {
    if (std::any_of(spheres.begin() + before, spheres.end(), [&](const PlacedSphere& b) { return holds(b, piece); }))
      continue;
    PlacedSphere sphere = sphere_around(piece);
    sphere.radius = std::max(sphere.radius, solid.depth(sphere.center) + inflation);
    spheres.push_back(sphere);
  }
}

std::vector<PlacedSphere> cover_with(const CoverSolid::Impl& solid, double inflation) {
  if (solid.kind == CoverSolid::Impl::Kind::sphere) return {{Vector3d::Zero(), solid.radius}};
  if (solid.kind == CoverSolid::Impl::Kind::capsule) return cover_capsule(solid.radius, solid.length, inflation);
  const double slack = 0.02 * inflation;  // lets the proof end at cells of this order
  std::vector<Candidate> candidates;
  std::vector<Piece> pieces = find_pieces(solid, inflation, inflation - slack, candidates);
  add_interior(solid, std::max(2 * inflation, solid.box.sizes().maxCoeff() / 24), pieces);
  Choice choice(candidates, inflation - slack);
  choice.extend(pieces);  // what no candidate holds is in pieces too large; the proof finds smaller ones
  const std::size_t work = std::min(kMaxWork, kWorkPerSphere * choice.chosen().size());
  choice.polish(work);
  std::vector<PlacedSphere> extra;
  const double finest = 0.5 * slack;
  for (double resolution = inflation / 8;;) {
    std::vector<PlacedSphere> spheres = extra;
    for (const int i : choice.chosen()) {
      spheres.push_back(choice.sphere(i));
      spheres.back().radius += slack;
    }
    std::vector<Piece> gaps = find_gaps(solid, spheres, resolution, 4000);
    if (gaps.empty() && resolution == finest) return spheres;
    if (resolution > finest) keep_centers(solid, gaps);
    const std::size_t before = choice.chosen().size();
    const std::vector<Piece> left = choice.extend(gaps);
    if (choice.chosen().size() > before) {
      choice.polish(work / 10);
    } else if (resolution > finest) {
      resolution = std::max(finest, resolution / 4);
    } else {
      add_own_spheres(solid, left, inflation, extra);
    }
  }
}

double inflation_of(const CoverSolid::Impl& solid, const PlacedSphere& sphere) {
  return std::max(0.0, sphere.radius - solid.depth(sphere.center));
}

}  // namespace

SphereCover cover_solid(const CoverSolid& solid, const CoverOptions& options) {
  require_positive(options.max_inflation, "cover: max_inflation");
  SphereCover cover;
  double inflation = options.max_inflation;
  for (;; inflation *= 1.2) {
    cover.spheres = cover_with(solid.impl(), inflation);
    if (options.max_spheres == 0 || cover.spheres.size() <= options.max_spheres) break;
    if (const PlacedSphere one = solid.bounding_sphere(); inflation > one.radius) {
      cover.spheres = {one};
      break;
    }
  }
  for (PlacedSphere& sphere : cover.spheres) {
    const double inflated = inflation_of(solid.impl(), sphere);
    cover.max_inflation = std::max(cover.max_inflation, inflated);
    cover.mean_inflation += inflated / static_cast<double>(cover.spheres.size());
    sphere.radius += kRounding;
  }
  return cover;
}

bool contains_solid(const std::vector<PlacedSphere>& spheres, const CoverSolid& solid, double resolution) {
  require_positive(resolution, "cover proof: resolution");
  bool contained = true;
  Proof proof(solid.impl(), spheres, resolution);
  proof.on_gap = [&](const Piece&) { return contained = false; };
  proof.run();
  return contained;
}

std::vector<PlacedSphere> pack_solid(const CoverSolid& solid, std::size_t count, double min_radius) {
  require_positive(min_radius, "sphere packing: min_radius");
  const CoverSolid::Impl& impl = solid.impl();
  if (count == 0) return {};
  if (impl.kind == CoverSolid::Impl::Kind::sphere) return {{Vector3d::Zero(), impl.radius}};
  std::vector<Candidate> candidates;
  if (impl.kind == CoverSolid::Impl::Kind::capsule) {
    for (int i = 0; i <= 32; ++i) candidates.push_back({{0, 0, impl.length * (i / 32.0 - 0.5)}, impl.radius});
  } else {
    const double size = impl.box.sizes().maxCoeff();
    candidates = find_candidates(impl, split_surface(impl, std::max(min_radius, size / 40)), size / 80);
    for (Candidate& c : candidates) c.depth = impl.inner_depth(c.center) - kRounding;
  }
  std::erase_if(candidates, [&](const Candidate& c) { return !(c.depth >= min_radius); });
  std::vector<Piece> samples;
  add_interior(impl, impl.box.sizes().maxCoeff() / 32, samples);
  Choice choice(candidates, 0.0);
  choice.extend(samples);
  const Indices& chosen = choice.chosen();
  std::vector<PlacedSphere> spheres;
  for (std::size_t i = 0; i < std::min(count, chosen.size()); ++i)
    spheres.push_back({candidates[chosen[i]].center, candidates[chosen[i]].depth});
  return spheres;
}

std::vector<std::vector<std::uint32_t>> cover_children(const CoverSolid& solid, const std::vector<PlacedSphere>& coarse,
                                                       const std::vector<PlacedSphere>& fine) {
  std::vector<std::vector<char>> linked(coarse.size(), std::vector<char>(fine.size(), 0));
  const auto link = [&](const Piece& piece, int f) {
    std::size_t best = coarse.size();
    for (std::size_t c = 0; c < coarse.size(); ++c) {
      if (!holds(coarse[c], piece)) continue;
      if (linked[c][f]) return;
      if (best == coarse.size()) best = c;
    }
    if (best < coarse.size()) {
      linked[best][f] = 1;
      return;
    }
    const PlacedSphere around = sphere_around(piece);  // in no single coarse sphere: all that it meets
    for (std::size_t c = 0; c < coarse.size(); ++c)
      if ((coarse[c].center - around.center).norm() <= coarse[c].radius + around.radius) linked[c][f] = 1;
  };
  bool contained = true;
  Proof proof(solid.impl(), fine, 1e-5);
  proof.on_covered = link;
  proof.on_gap = [&](const Piece&) { return contained = false; };
  proof.run();
  if (!contained) throw InvalidArgument("cover hierarchy: the fine spheres do not contain the solid");
  std::vector<std::vector<std::uint32_t>> children(coarse.size());
  for (std::size_t c = 0; c < coarse.size(); ++c)
    for (std::size_t f = 0; f < fine.size(); ++f)
      if (linked[c][f]) children[c].push_back(static_cast<std::uint32_t>(f));
  return children;
}

}  // namespace srmp
