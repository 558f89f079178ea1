#include "srmp/planning/endpoints/close_motions.hpp"

#include "srmp/planning/endpoints/start_recovery.hpp"
#include "srmp/planning/validity.hpp"

namespace srmp {

CloseMotions::CloseMotions(const ProblemCheckers& checkers, const Deadline& deadline)
    : clearance_(checkers.planning.alone(0)),
      contacts_(checkers.verification().alone(0)),
      with_clearance_(clearance_.make_workspace()),
      of_contacts_(contacts_.make_workspace()) {
  clearance_.stop_at(deadline, *with_clearance_);
  contacts_.stop_at(deadline, *of_contacts_);
}

bool CloseMotions::withdraws(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const Eigen::VectorXd end = a + clearance_.robot().difference(a, b);
  return !contact_rule_violation(clearance_, {a, end}, *with_clearance_) &&
         contacts_.is_motion_free(a, end, *of_contacts_);
}

std::string CloseMotions::approach(const std::vector<Eigen::VectorXd>& path) {
  const auto worse = contact_rule_violation(clearance_, path, *with_clearance_);
  return worse ? contact_sentence(clearance_, *worse) : "";
}

std::string CloseMotions::closeness(const Eigen::VectorXd& q) {
  return contact_sentence(clearance_, q, *with_clearance_);
}

}  // namespace srmp
