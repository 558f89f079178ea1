#include "srmp/robot/srdf.hpp"

#include <algorithm>
#include <set>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

using JointSet = std::set<std::size_t>;

/// Adds the joints of a group and its subgroups.
void collect(const Srdf& srdf, const SrdfGroup& group, const Urdf& urdf, JointSet& joints) {
  for (const auto& [base, last] : group.chains) {
    const auto up = urdf.chain_to(*urdf.find_link(base)), down = urdf.chain_to(*urdf.find_link(last));
    const auto [branch, other] = std::mismatch(up.begin(), up.end(), down.begin(), down.end());
    joints.insert(branch, up.end());
    joints.insert(other, down.end());
  }
  for (const std::string& joint : group.joints)
    if (const auto index = urdf.find_joint(joint)) joints.insert(*index);  // virtual joints are not in the URDF
  for (const std::string& link : group.links)
    if (const auto joint = urdf.links[*urdf.find_link(link)].parent_joint) joints.insert(*joint);
  for (const std::string& name : group.subgroups) collect(srdf, *srdf.find_group(name), urdf, joints);
}

}  // namespace

const SrdfGroup* Srdf::find_group(const std::string& group) const {
  const auto it = std::find_if(groups.begin(), groups.end(), [&](const SrdfGroup& g) { return g.name == group; });
  return it == groups.end() ? nullptr : &*it;
}

std::vector<std::string> Srdf::group_names() const {
  std::vector<std::string> names;
  for (const SrdfGroup& group : groups) names.push_back(group.name);
  return names;
}

std::vector<std::size_t> Srdf::joints_of(const SrdfGroup& group, const Urdf& urdf) const {
  JointSet members;
  collect(*this, group, urdf, members);
  std::vector<std::size_t> joints;
  for (const std::size_t joint : urdf.joint_order)
    if (members.contains(joint) && urdf.joints[joint].scalar() && !urdf.joints[joint].mimic) joints.push_back(joint);
  return joints;
}

}  // namespace srmp
