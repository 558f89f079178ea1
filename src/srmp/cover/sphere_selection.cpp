#include "srmp/cover/sphere_selection.hpp"

#include <algorithm>
#include <queue>
#include <utility>

#include "srmp/core/interruption.hpp"

namespace srmp {

SphereSelection::SphereSelection(const std::vector<InscribedSphere>& candidates, double growth)
    : candidates_(candidates), growth_(growth) {
  system_.sets.resize(candidates.size());
  new_from_.resize(candidates.size());
}

PlacedSphere SphereSelection::sphere(int candidate) const {
  return {candidates_[candidate].center, std::max(0.0, candidates_[candidate].depth + growth_)};
}

void SphereSelection::improve(std::size_t work) { selected_ = smaller_cover(system_, selected_, work); }

std::vector<ConvexPart> SphereSelection::extend(const std::vector<ConvexPart>& parts) {
  const std::size_t first = system_.elements;
  add_elements(parts);
  std::vector<char> open(parts.size(), 1);
  const auto close = [&](int i) {
    for (std::size_t k = new_from_[i]; k < set(i).size(); ++k) open[set(i)[k] - first] = 0;
  };
  const auto gain_of = [&](int i) {
    interruption_point();
    int gain = 0;
    for (std::size_t k = new_from_[i]; k < set(i).size(); ++k) gain += open[set(i)[k] - first];
    return gain;
  };
  for (const int i : selected_) close(i);
  std::priority_queue<std::pair<int, int>> queue;  // (gain, -candidate)
  for (std::size_t i = 0; i < candidates_.size(); ++i) queue.push({gain_of(static_cast<int>(i)), -static_cast<int>(i)});
  while (!queue.empty()) {
    const auto [upper_bound, minus_i] = queue.top();
    queue.pop();
    const int gain = gain_of(-minus_i);
    if (gain == 0) continue;
    if (gain < upper_bound) {
      queue.push({gain, minus_i});
      continue;
    }
    selected_.push_back(-minus_i);
    close(-minus_i);
  }
  std::vector<ConvexPart> uncovered;
  for (std::size_t k = 0; k < parts.size(); ++k)
    if (open[k]) uncovered.push_back(parts[k]);
  drop_redundant();
  return uncovered;
}

void SphereSelection::add_elements(const std::vector<ConvexPart>& parts) {
  const PartBlocks blocks(parts);
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    interruption_point();
    new_from_[i] = system_.sets[i].size();
    blocks.for_each_contained(sphere(static_cast<int>(i)), [&](std::size_t k) {
      system_.sets[i].push_back(static_cast<std::uint32_t>(system_.elements + k));
    });
  }
  system_.elements += parts.size();
}

/// Spheres selected later often make earlier ones redundant.
void SphereSelection::drop_redundant() {
  std::vector<int> times(system_.elements, 0);
  for (const int i : selected_)
    for (const std::uint32_t k : set(i)) ++times[k];
  std::erase_if(selected_, [&](int i) {
    if (std::any_of(set(i).begin(), set(i).end(), [&](std::uint32_t k) { return times[k] == 1; })) return false;
    for (const std::uint32_t k : set(i)) --times[k];
    return true;
  });
}

}  // namespace srmp
