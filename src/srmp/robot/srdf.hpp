#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "srmp/robot/robot_description.hpp"
#include "srmp/robot/urdf.hpp"

namespace srmp {

// The parts of an SRDF that this library uses, checked against the URDF: every name exists.

/// A planning group.
struct SrdfGroup {
  std::string name;
  std::vector<std::pair<std::string, std::string>> chains;  ///< base link, last link
  std::vector<std::string> joints, links, subgroups;        ///< names
};

/// A named state of a group.
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

  /// Throws FileError "<label>:<line>: …" for mistakes. A <disable_collisions> between links that do not exist is one,
  /// unless the file names three or more such links: it then describes a variant of the robot with more links (as for
  /// MotionBenchMaker's Fetch), and those rules are ignored with a warning.
  static Srdf parse(const std::string& text, const Urdf& urdf, const std::string& label = "SRDF text");

  /// The group of this name, or nullptr.
  const SrdfGroup* find_group(const std::string& group) const;
  std::vector<std::string> group_names() const;
  /// The joints of a group with one degree of freedom that are not mimic joints, as indices into urdf.joints, parents
  /// first.
  std::vector<std::size_t> joints_of(const SrdfGroup& group, const Urdf& urdf) const;
};

}  // namespace srmp
