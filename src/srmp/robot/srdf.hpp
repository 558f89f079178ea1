#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "srmp/robot/robot_description.hpp"
#include "srmp/robot/urdf.hpp"

namespace srmp {

// The parts of an SRDF that this library uses, checked against the URDF: every name exists, but in groups with a fault.

/// A planning group.
struct SrdfGroup {
  std::string name;
  std::vector<std::pair<std::string, std::string>> chains;  ///< base link, last link: the joints between them
  std::vector<std::string> joints, links, subgroups;        ///< names
  std::string fault{};  ///< why the group cannot be used, as a sentence; "" = it can
};

/// A named state of a group; `group` may be empty.
struct SrdfState {
  std::string name, group;
  std::map<std::string, double> positions;  ///< by joint name [rad or m]
};

/// An end effector; parent_group may be empty.
struct SrdfEndEffector {
  std::string name, parent_link, group, parent_group;
};

/// An SRDF.
struct Srdf {
  std::string label;  ///< file path, for messages
  std::vector<SrdfGroup> groups;
  std::vector<SrdfState> states;
  std::vector<SrdfEndEffector> end_effectors;
  std::optional<VirtualJoint> virtual_joint;                           ///< of the root link
  std::vector<std::pair<std::string, std::string>> disabled, enabled;  ///< pairs of links
  std::vector<std::string> disabled_by_default;                        ///< links
  std::vector<std::string> warnings;                                   ///< what was ignored and why, as sentences

  /// Throws FileError "<label>:<line>: …" for mistakes. Those that leave the meaning of the rest as it is are warnings,
  /// and what they are in is left out: names that the URDF does not have in a group, which then has a fault, in a
  /// state, in an end effector, and in rules that disable collisions (the file may describe a variant of the robot with
  /// more links, as that of MotionBenchMaker's Fetch does); and states without a group. When `strict`, only rules that
  /// name three or more such links are.
  static Srdf parse(const std::string& text, const Urdf& urdf, const std::string& label = "SRDF text",
                    bool strict = false);

  /// The group of this name, or nullptr.
  const SrdfGroup* find_group(const std::string& group) const;
  std::vector<std::string> group_names() const;
  /// The joints of a group with one degree of freedom that are not mimic joints, as indices into urdf.joints, parents
  /// first.
  std::vector<std::size_t> joints_of(const SrdfGroup& group, const Urdf& urdf) const;
};

}  // namespace srmp
