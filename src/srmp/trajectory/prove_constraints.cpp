#include "srmp/trajectory/prove_constraints.hpp"

#include <algorithm>

#include "srmp/core/error.hpp"
#include "srmp/core/stopping.hpp"

namespace srmp {

namespace {

constexpr double rounding = 1e-6;  // of the tolerance

}  // namespace

void add_constraints(Certificate& certificate, const Trajectory& trajectory, const PlacedConstraints& constraints,
                     const Deadline& deadline) {
  ConstraintChecker checker(constraints);
  std::vector<ConstraintDeviation>& worst = certificate.constraints;
  worst = checker.none();
  std::vector<detail::Cubic> cubics(trajectory.dof());
  const auto set_segment = [&](Eigen::Index row) {
    for (std::size_t j = 0; j < cubics.size(); ++j)
      cubics[j] = row + 1 < trajectory.positions.rows()
                      ? detail::segment_of(trajectory, row, static_cast<Eigen::Index>(j))
                      : detail::line(trajectory.positions(row, static_cast<Eigen::Index>(j)),
                                     trajectory.positions(row, static_cast<Eigen::Index>(j)), 1.0);
  };
  const Eigen::Index segments = std::max<Eigen::Index>(1, trajectory.positions.rows() - 1);
  for (Eigen::Index row = 0; row < segments; ++row) {
    stop_if_late(deadline, "the path constraints were proved");
    set_segment(row);
    checker.add(cubics, trajectory.times[row], worst);
  }
  for (const ConstraintDeviation& kept : worst)
    if (kept.deviation > (1.0 + rounding) * kept.tolerance)
      certificate.faults.push_back({FaultKind::constraint,
                                    "the constraint '" + kept.constraint + "' is broken by up to " +
                                        to_text(kept.deviation) + ", " + to_text(kept.tolerance) +
                                        " are allowed (rad or m)",
                                    kept.time});
}

bool keeps_constraints(const Certificate& certificate) {
  return std::none_of(certificate.faults.begin(), certificate.faults.end(),
                      [](const Fault& fault) { return fault.kind == FaultKind::constraint; });
}

}  // namespace srmp
