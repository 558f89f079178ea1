#include "srmp/planning/endpoints/joint_endpoints.hpp"

#include <algorithm>

#include "srmp/core/error.hpp"
#include "srmp/planning/validity.hpp"

namespace srmp {

namespace {

/// Two robots that may collide.
class PairAtEnds {
 public:
  PairAtEnds(const GroupCheckers& checkers, std::size_t i, std::size_t j)
      : checkers_(checkers), i_(i), j_(j), checker_(*checkers.pair(i, j)), workspace_(checker_.make_workspace()) {}

  bool is_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return checker_.is_free(both(a, b), *workspace_); }

  /// Their collision at two configurations, as a sentence; points of contact take longer to find than all else here.
  std::string contact(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return "'" + checkers_.names()[i_] + "' and '" + checkers_.names()[j_] + "' are " +
           (checkers_.clearance() > 0.0 ? "too close" : "in collision") + ": " +
           contact_sentence(checker_, both(a, b), *workspace_);
  }

  /// Are there no two targets that are free of each other?
  bool collide_at_all(const std::vector<Eigen::VectorXd>& targets_a, const std::vector<Eigen::VectorXd>& targets_b) {
    return std::ranges::none_of(targets_a, [&](const Eigen::VectorXd& a) {
      return std::ranges::any_of(targets_b, [&](const Eigen::VectorXd& b) { return is_free(a, b); });
    });
  }

 private:
  static Eigen::VectorXd both(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    Eigen::VectorXd q(a.size() + b.size());
    q << a, b;
    return q;
  }

  const GroupCheckers& checkers_;
  const std::size_t i_, j_;
  const Checker& checker_;
  const Checker::WorkspacePtr workspace_;
};

/// Calls `check` for each pair of robots that may collide.
template <class Check>
void for_each_pair(const GroupCheckers& checkers, const std::vector<const RobotEndpoints*>& endpoints, Check&& check) {
  for (std::size_t i = 0; i < endpoints.size(); ++i)
    for (std::size_t j = i + 1; j < endpoints.size(); ++j)
      if (checkers.pair(i, j)) check(PairAtEnds(checkers, i, j), *endpoints[i], *endpoints[j]);
}

}  // namespace

void require_joint_endpoints(const GroupCheckers& checkers, const std::vector<const RobotEndpoints*>& endpoints) {
  for_each_pair(checkers, endpoints, [](PairAtEnds pair, const RobotEndpoints& a, const RobotEndpoints& b) {
    if (!pair.is_free(a.start, b.start))
      throw PlanningError(Status::start_invalid, "the starts are invalid: " + pair.contact(a.start, b.start));
  });
  for_each_pair(checkers, endpoints, [](PairAtEnds pair, const RobotEndpoints& a, const RobotEndpoints& b) {
    if (!a.targets.empty() && !b.targets.empty() && pair.collide_at_all(a.targets, b.targets))
      throw PlanningError(Status::goal_invalid, "the goals cannot be reached together: at them " +
                                                    pair.contact(a.targets.front(), b.targets.front()));
  });
}

}  // namespace srmp
