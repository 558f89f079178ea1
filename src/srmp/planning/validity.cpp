#include "srmp/planning/validity.hpp"

#include "srmp/core/error.hpp"

namespace srmp {

std::string contact_sentence(const Checker& checker, const Eigen::VectorXd& q, Checker::Workspace& workspace) {
  if (checker.is_free(q, workspace)) return "";
  const std::vector<Contact> contacts = checker.contacts(q, workspace);
  return contacts.empty() ? "it is in collision" : contact_sentence(checker, contacts.front());
}

std::string contact_sentence(const Checker& checker, Contact contact) {
  contact.distance += checker.clearance_kept();  // which its padding holds
  contact.padding -= checker.clearance_kept();
  return contact.describe() +
         (contact.distance > 0.0 ? ", less than the clearance of " + to_text(checker.clearance_kept()) + " m" : "");
}

std::string invalidity(const Checker& checker, const Eigen::VectorXd& q, Checker::Workspace& workspace) {
  const auto violation = checker.robot().limit_violation(q);
  return violation ? *violation : contact_sentence(checker, q, workspace);
}

}  // namespace srmp
