#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>

namespace srmp {

/// New limits of a joint; what is missing stays.
struct JointLimitEdit {
  std::optional<double> lower, upper, velocity;  ///< [rad or m], [rad/s or m/s]
};

/// The URDF text with other limits, by joint. A continuous joint that is given lower and upper limits becomes a
/// revolute one. Joints that the URDF does not have are passed over. Throws FileError for text that is not a URDF.
std::string with_limits(const std::string& urdf_text, const std::map<std::string, JointLimitEdit>& limits);

/// The URDF text without these links and the joints above them, and without the collision geometry of others. Throws
/// FileError for text that is not a URDF.
std::string without_links(const std::string& urdf_text, const std::set<std::string>& links,
                          const std::set<std::string>& without_geometry);

}  // namespace srmp
