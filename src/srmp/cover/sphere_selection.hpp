#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "srmp/core/placed_sphere.hpp"
#include "srmp/cover/convex_part.hpp"
#include "srmp/cover/inscribed_spheres.hpp"
#include "srmp/cover/set_cover.hpp"

namespace srmp {

/// Selects few of many candidate spheres, each grown by `growth` [m], so that every part that some candidate contains
/// is contained in a selected one. Deterministic.
class SphereSelection {
 public:
  /// The candidates must outlive this.
  SphereSelection(const std::vector<InscribedSphere>& candidates, double growth);

  /// Adds parts and, greedily, spheres for them; returns the parts that no candidate contains.
  std::vector<ConvexPart> extend(const std::vector<ConvexPart>& parts);
  /// Replaces the selection by a smaller one where local search finds it; `work` as in smaller_cover.
  void improve(std::size_t work);

  const std::vector<int>& selected() const { return selected_; }  ///< indices of candidates, the most useful first
  PlacedSphere sphere(int candidate) const;                       ///< grown

 private:
  const std::vector<std::uint32_t>& set(int i) const { return system_.sets[i]; }
  void add_elements(const std::vector<ConvexPart>& parts);
  void drop_redundant();

  const std::vector<InscribedSphere>& candidates_;
  const double growth_;
  SetSystem system_;                   // by candidate
  std::vector<std::size_t> new_from_;  // in each set, the first element of the last extend
  std::vector<int> selected_;
};

}  // namespace srmp
