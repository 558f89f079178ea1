#include "srmp/planning/user_heuristic.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/core/error.hpp"
#include "srmp/planning/options.hpp"

namespace srmp {

void require_new_heuristic(const std::string& name, const UserHeuristic& heuristic, const UserHeuristics& known) {
  if (name.empty() || name.find_first_of(" ,()") != std::string::npos)
    throw InvalidArgument("heuristic '" + name + "': a name must not be empty or have spaces, commas or brackets");
  const std::vector<std::string>& built_in = built_in_heuristics();
  if (std::find(built_in.begin(), built_in.end(), name) != built_in.end() || known.contains(name))
    throw InvalidArgument("there is a heuristic '" + name + "' already; give another name or remove that one");
  if (!heuristic.function) throw InvalidArgument("heuristic '" + name + "' has an empty function");
}

Eigen::VectorXd evaluate(const std::string& name, const UserHeuristic& heuristic, ConstRows configurations,
                         ConstRows goals) {
  Eigen::VectorXd values = heuristic.function(configurations, goals);
  if (values.size() != configurations.rows())
    throw InvalidArgument("heuristic '" + name + "' returned " + std::to_string(values.size()) + " values for " +
                          std::to_string(configurations.rows()) + " configurations; it must be one each");
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (std::isfinite(values[i]) && values[i] >= 0.0) continue;
    std::string q;
    for (const double x : configurations.row(i)) q += (q.empty() ? "" : ", ") + to_text(x);
    throw InvalidArgument("heuristic '" + name + "' is " + to_text(values[i]) + " at [" + q +
                          "]; it must be finite and at least 0");
  }
  return values;
}

}  // namespace srmp
