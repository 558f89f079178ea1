#pragma once

#include <Eigen/Core>
#include <vector>

#include "srmp/cover/solid_geometry.hpp"

namespace srmp {

/// A sphere inside of a solid: centre and radius [m].
struct InscribedSphere {
  Eigen::Vector3d center;
  double depth;  ///< SolidGeometry::depth of the centre; may be negative for centres near the surface
};

/// Spheres on the solid's medial axis, found from the centres of the surface's triangles by the shrinking-ball
/// transform (Ma, Bae, Choi 2012), and spheres at those centres; of those whose centres fall into one cell of a grid
/// with edge `grid` [m], the deepest. `triangles` is the surface of the solid in small parts.
std::vector<InscribedSphere> find_inscribed_spheres(const SolidGeometry& solid, const std::vector<Triangle>& triangles,
                                                    double grid);

}  // namespace srmp
