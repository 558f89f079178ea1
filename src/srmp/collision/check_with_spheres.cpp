// What a SceneWorkspace leaves to the batch: checks by spheres, and by tables of pairs of links.

#include <algorithm>
#include <ranges>
#include <span>

#include "srmp/collision/scene_workspace.hpp"

namespace srmp::detail {

namespace {

/// A motion that a table does not prove as a whole is looked up in so many parts, which touch fewer cells.
constexpr int table_parts = 8;

std::span<const double> as_span(const Eigen::VectorXd& v) { return {v.data(), static_cast<std::size_t>(v.size())}; }

}  // namespace

// --- straight motions

/// Checks the motion with the spheres, of deferred pairs with their tables first; the pairs that are left undecided go
/// to open_.
CollisionStatus SceneWorkspace::check_with_spheres() {
  const BatchChecker& batch = *model_.batch;
  const std::uint64_t blocks = batch.statistics(*batch_).blocks;
  open_.clear();
  CollisionStatus status = batch.motion(as_span(start_), as_span(delta_), *batch_, model_.batch_options);
  if (status == CollisionStatus::undecided) open_undecided();
  if (status != CollisionStatus::colliding) find_open_deferred();
  if (status != CollisionStatus::colliding && !open_deferred_.empty()) {
    const CollisionStatus of_deferred =
        batch.motion_of_pairs(as_span(start_), as_span(delta_), *batch_, model_.batch_options, open_deferred_);
    if (of_deferred == CollisionStatus::undecided) open_undecided();
    if (of_deferred != CollisionStatus::free) status = of_deferred;
  }
  statistics.blocks += batch.statistics(*batch_).blocks - blocks;
  if (status != CollisionStatus::undecided) return status;
  return open_.empty() ? CollisionStatus::free : status;
}

/// Puts the deferred pairs that their tables do not prove free on the whole motion into open_deferred_.
void SceneWorkspace::find_open_deferred() {
  open_deferred_.clear();
  const auto is_free = [&](std::uint32_t pair) {
    const auto proves = [&](int part, int parts) {
      return bodies_.pairs[pair].is_free_by_table(start_, delta_, static_cast<double>(part) / parts,
                                                  static_cast<double>(part + 1) / parts);
    };
    const auto parts = std::views::iota(0, table_parts);
    const bool proved = proves(0, 1) || std::ranges::all_of(parts, [&](int part) { return proves(part, table_parts); });
    statistics.by_tables += proved;
    return proved;
  };
  for (const int pair : model_.batch_scene.pairs.deferred)
    if (!std::ranges::all_of(model_.pairs_of({.self = true, .pair = pair}), is_free)) open_deferred_.push_back(pair);
}

/// The pairs that the spheres left undecided go to open_, one interval each, from the first to the last that is open:
/// Coal proves a long one as readily as a short one.
void SceneWorkspace::open_undecided() {
  const BatchChecker& batch = *model_.batch;
  const std::size_t first = open_.size();
  for (const UndecidedPair& u : batch.undecided(*batch_))
    for (std::uint32_t pair : model_.pairs_of(u)) {
      if (table_proves(bodies_.pairs[pair], u.t - u.half, u.t + u.half)) continue;
      auto& [low, high] = span_of_[pair];
      if (high < low) {
        open_.push_back({0.0, 0.0, pair});
        low = u.t - u.half;
      }
      high = u.t + u.half;
    }
  for (Interval& interval : std::span(open_).subspan(first)) {
    auto& [low, high] = span_of_[interval.pair];
    interval.t = (low + high) / 2;
    interval.half_width = (high - low) / 2;
    low = 1.0;
    high = 0.0;
  }
  statistics.undecided += batch.undecided(*batch_).size();
}

/// Do the spheres alone prove the motion free?
bool SceneWorkspace::prove_with_spheres() {
  const std::uint64_t blocks = model_.batch->statistics(*batch_).blocks;
  const bool proved = model_.batch->proves_free(as_span(start_), as_span(delta_), *batch_, model_.batch_options);
  statistics.blocks += model_.batch->statistics(*batch_).blocks - blocks;
  return proved;
}

// --- blocks of configurations

/// Are all of the pairs that the spheres left undecided apart at q?
bool SceneWorkspace::resolve_lane(ConstVector q, std::span<const UndecidedPair> open) {
  place(q);
  for (const UndecidedPair& u : open)
    for (std::uint32_t pair : model_.pairs_of(u))
      if (in_contact(bodies_.pairs[pair])) return false;
  return true;
}

void SceneWorkspace::find_colliding(ConstRows q, std::span<bool> colliding) {
  const std::uint64_t blocks = model_.batch->statistics(*batch_).blocks;
  const unsigned hits = model_.batch->find_likely_hits({q.data(), static_cast<std::size_t>(q.size())}, *batch_);
  statistics.blocks += model_.batch->statistics(*batch_).blocks - blocks;
  for (std::size_t lane = 0; lane < colliding.size(); ++lane)
    colliding[lane] = (hits >> lane & 1) && model_.spheres_reach(q.row(static_cast<Eigen::Index>(lane)).transpose());
}

void SceneWorkspace::check_block(ConstRows q, std::span<bool> free, const StateQuery& query) {
  const BatchChecker& batch = *model_.batch;
  const auto lanes =
      batch.check_block({q.data(), static_cast<std::size_t>(q.size())}, *batch_, {.proofs_only = query.spheres_only});
  ++statistics.blocks;
  std::span<const UndecidedPair> open = batch.undecided(*batch_);
  if (!query.spheres_only) statistics.undecided += open.size();
  for (std::size_t lane = 0; lane < free.size(); ++lane) {
    std::size_t count = 0;  // open pairs of this lane; they come in order of lanes
    while (count < open.size() && open[count].t == static_cast<double>(lane)) ++count;
    const bool undecided = lanes.undecided >> lane & 1;
    free[lane] = !undecided && !(lanes.colliding >> lane & 1);
    if (undecided && !query.spheres_only)
      free[lane] = resolve_lane(q.row(static_cast<Eigen::Index>(lane)).transpose(), open.first(count));
    else
      ++statistics.states_by_spheres;
    open = open.subspan(count);
  }
}

}  // namespace srmp::detail
