#include "srmp/planning/validity.hpp"

namespace srmp {

std::string invalidity(const Checker& checker, const Eigen::VectorXd& q, Checker::Workspace& workspace) {
  if (const auto violation = checker.robot().limit_violation(q)) return *violation;
  if (checker.is_free(q, workspace)) return "";
  const std::vector<Contact> contacts = checker.contacts(q, workspace);
  return contacts.empty() ? "it is in collision" : contacts.front().describe();
}

}  // namespace srmp
