#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "srmp/robot/urdf.hpp"

namespace srmp {

// What this library uses of an SRDF, checked against the URDF: every name it holds exists.

struct SrdfGroup {
  std::string name;
  std::vector<std::pair<std::string, std::string>> chains;  ///< base link, tip link
  std::vector<std::string> joints, links, subgroups;
};

struct SrdfState {
  std::string name, group;
  std::map<std::string, double> positions;  ///< by joint
};

struct SrdfEndEffector {
  std::string name, parent_link, group, parent_group;
};

struct Srdf {
  std::string label;
  std::vector<SrdfGroup> groups;
  std::vector<SrdfState> states;
  std::vector<SrdfEndEffector> end_effectors;
  std::vector<std::pair<std::string, std::string>> disabled, enabled;  ///< pairs of links
  std::vector<std::string> disabled_by_default;                        ///< links
  std::vector<std::string> warnings;                                   ///< what was ignored, and why

  /// Throws FileError "<label>:<line>: …". A <disable_collisions> between links that do not exist is an error too,
  /// unless the file names three or more different such links: then it was written for a fuller variant of the robot
  /// (as MotionBenchMaker's Fetch), those rules are ignored and a warning says so.
  static Srdf parse(const std::string& text, const Urdf& urdf, const std::string& label = "SRDF text");

  const SrdfGroup* find_group(const std::string& group) const;
  std::vector<std::string> group_names() const;
  /// Movable joints of a group as indices into urdf.joints, parents first. Mimic joints are left out.
  std::vector<std::size_t> joints_of(const SrdfGroup& group, const Urdf& urdf) const;
};

}  // namespace srmp
