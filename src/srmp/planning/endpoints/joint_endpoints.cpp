#include "srmp/planning/endpoints/joint_endpoints.hpp"

#include "srmp/core/error.hpp"
#include "srmp/planning/validity.hpp"

namespace srmp {

namespace {

/// The collision of two robots at two configurations, as a sentence; "" = there is none.
std::string contact(const GroupCheckers& checkers, std::size_t i, const Eigen::VectorXd& a, std::size_t j,
                    const Eigen::VectorXd& b) {
  const Checker* checker = checkers.pair(i, j);
  if (!checker) return "";
  Eigen::VectorXd both(a.size() + b.size());
  both << a, b;
  const std::string contact = contact_sentence(*checker, both, *checker->make_workspace());
  if (contact.empty()) return "";
  return "'" + checkers.names()[i] + "' and '" + checkers.names()[j] + "' are " +
         (checkers.clearance() > 0.0 ? "too close" : "in collision") + ": " + contact;
}

/// The collision at the first two targets; "" = some targets are free of collisions with each other, or there are none.
std::string goal_contact(const GroupCheckers& checkers, std::size_t i, const RobotEndpoints& a, std::size_t j,
                         const RobotEndpoints& b) {
  std::string first;
  for (const Eigen::VectorXd& of_a : a.targets)
    for (const Eigen::VectorXd& of_b : b.targets) {
      const std::string why = contact(checkers, i, of_a, j, of_b);
      if (why.empty()) return "";
      if (first.empty()) first = why;
    }
  return first;
}

}  // namespace

void require_joint_endpoints(const GroupCheckers& checkers, const std::vector<const RobotEndpoints*>& endpoints) {
  for (std::size_t i = 0; i < endpoints.size(); ++i)
    for (std::size_t j = i + 1; j < endpoints.size(); ++j)
      if (const std::string why = contact(checkers, i, endpoints[i]->start, j, endpoints[j]->start); !why.empty())
        throw PlanningError(Status::start_invalid, "the starts are invalid: " + why);
  for (std::size_t i = 0; i < endpoints.size(); ++i)
    for (std::size_t j = i + 1; j < endpoints.size(); ++j)
      if (const std::string why = goal_contact(checkers, i, *endpoints[i], j, *endpoints[j]); !why.empty())
        throw PlanningError(Status::goal_invalid, "the goals cannot be reached together: at them " + why);
}

}  // namespace srmp
