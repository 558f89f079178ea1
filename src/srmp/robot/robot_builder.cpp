#include <algorithm>
#include <cmath>
#include <filesystem>

#include "srmp/core/error.hpp"
#include "srmp/robot/joint_names.hpp"
#include "srmp/robot/multi_dof_joint.hpp"
#include "srmp/robot/robot_impl.hpp"
#include "srmp/robot/robot_model.hpp"
#include "srmp/robot/xml.hpp"

namespace srmp {

namespace {

using Impl = RobotModelBuilder::Impl;
using Names = std::vector<std::string>;

constexpr std::size_t kMaxActuatedJoints = 64;  // bits of a joint support
constexpr double kDefaultVelocity = 1.0;        // [rad/s or m/s], of planned joints without a limit

/// The joints and the end effector that a description selects.
struct Selection {
  std::vector<std::size_t> joints;     // of the URDF
  std::vector<std::size_t> end_links;  // RobotModel::end_links
};

std::string leaf_names(const Impl& impl) {
  Names names;
  for (const std::size_t leaf : impl.urdf.leaves()) names.push_back(impl.link_names[leaf]);
  return quoted_list(names);
}

/// What a name that is no link is, and the link that may be meant; "" = unknown.
std::string meant_link(const Impl& impl, const std::string& name, const Srdf* srdf) {
  if (const auto joint = impl.urdf.find_joint(name))
    return "; it is a joint, which moves the link '" + impl.link_names[impl.urdf.joints[*joint].child] + "'";
  if (!srdf) return {};
  for (const SrdfEndEffector& effector : srdf->end_effectors)
    if (effector.name == name || effector.group == name)
      return "; the SRDF's end effector '" + effector.name + "' is at the link '" + effector.parent_link + "'";
  if (srdf->find_group(name)) return "; it is a group of the SRDF: give it as group, or the last link of its chain";
  return {};
}

std::size_t require_end_effector(const Impl& impl, const Srdf* srdf) {
  const std::string& link = impl.description.end_effector;
  if (const auto index = impl.urdf.find_link(link)) return *index;
  std::string hint = meant_link(impl, link, srdf);
  if (hint.empty()) hint = did_you_mean(link, impl.link_names);
  if (hint.empty()) hint = "; links at the ends of its chains are " + leaf_names(impl);
  throw InvalidArgument("end effector '" + link + "' is not a link of robot '" + impl.name + "'" + hint);
}

bool can_be_planned(const UrdfJoint& joint) { return joint.scalar() && !joint.mimic; }

std::vector<std::size_t> movable_chain(const Urdf& urdf, std::size_t link) {
  std::vector<std::size_t> joints;
  for (const std::size_t joint : urdf.chain_to(link))
    if (can_be_planned(urdf.joints[joint])) joints.push_back(joint);
  return joints;
}

std::vector<std::size_t> named_joints(const Impl& impl) {
  std::vector<std::size_t> joints;
  for (const std::string& name : impl.description.joint_names) {
    const auto index = impl.urdf.find_joint(name);
    if (!index)
      throw InvalidArgument("joint_names: robot '" + impl.name + "' has no joint '" + name + "'" +
                            did_you_mean(name, impl.urdf.joint_names()));
    const UrdfJoint& joint = impl.urdf.joints[*index];
    if (joint.mimic)
      throw InvalidArgument("joint_names: joint '" + name + "' mimics joint '" +
                            impl.urdf.joints[joint.mimic->source].name + "' and cannot be planned; name that one");
    if (!joint.scalar())
      throw InvalidArgument("joint_names: joint '" + name + "' cannot be planned; only revolute, continuous and " +
                            "prismatic joints can");
    if (std::find(joints.begin(), joints.end(), *index) != joints.end())
      throw InvalidArgument("joint_names: joint '" + name + "' is named twice");
    joints.push_back(*index);
  }
  return joints;
}

/// The links at the ends of the joints' chains: no other of the joints comes after them.
std::vector<std::size_t> ends_of(const Impl& impl, const std::vector<std::size_t>& joints) {
  std::vector<std::size_t> ends;
  for (const std::size_t candidate : joints) {
    const bool is_last = std::none_of(joints.begin(), joints.end(), [&](std::size_t other) {
      const auto chain = impl.urdf.chain_to(impl.urdf.joints[other].parent);
      return std::find(chain.begin(), chain.end(), candidate) != chain.end();
    });
    if (is_last) ends.push_back(impl.urdf.joints[candidate].child);
  }
  return ends;
}

std::vector<std::size_t> group_joints(const Impl& impl, const SrdfGroup& group, const Srdf& srdf) {
  if (!group.fault.empty())
    throw InvalidArgument("group '" + group.name + "' of robot '" + impl.name + "' cannot be used: " + group.fault);
  auto joints = srdf.joints_of(group, impl.urdf);
  if (joints.empty())
    throw InvalidArgument("group '" + group.name + "' of robot '" + impl.name + "' has no movable joint");
  return joints;
}

/// The last links of the group's chains, and of those of its subgroups.
void add_chain_ends(const Impl& impl, const SrdfGroup& group, const Srdf& srdf, std::vector<std::size_t>& ends) {
  for (const auto& [base, last] : group.chains) ends.push_back(*impl.urdf.find_link(last));
  for (const std::string& name : group.subgroups)
    if (const SrdfGroup* subgroup = srdf.find_group(name)) add_chain_ends(impl, *subgroup, srdf, ends);
}

/// Of a group whose joints branch: the links of the SRDF's end effectors on the branches, or else the last links of the
/// branches, with what is fixed to them and ends a chain of the group.
std::vector<std::size_t> branch_ends(const Impl& impl, const SrdfGroup& group, const Srdf& srdf,
                                     const std::vector<std::size_t>& joints) {
  std::vector<std::size_t> ends = ends_of(impl, joints), hands;
  const auto is_on_branch = [&](std::size_t link) {
    const auto to_link = movable_chain(impl.urdf, link);
    return std::any_of(ends.begin(), ends.end(), [&](std::size_t end) {
      const auto to_end = movable_chain(impl.urdf, end);
      return to_link.size() <= to_end.size() && std::equal(to_link.begin(), to_link.end(), to_end.begin()) &&
             std::any_of(joints.begin(), joints.end(), [&](std::size_t joint) {
               return std::find(to_link.begin(), to_link.end(), joint) != to_link.end();
             });
    });
  };
  for (const SrdfEndEffector& effector : srdf.end_effectors) {
    const std::size_t link = *impl.urdf.find_link(effector.parent_link);
    if (is_on_branch(link) && std::find(hands.begin(), hands.end(), link) == hands.end()) hands.push_back(link);
  }
  if (!hands.empty()) return hands;
  std::vector<std::size_t> chain_ends;
  add_chain_ends(impl, group, srdf, chain_ends);
  for (std::size_t& end : ends)
    for (const std::size_t last : chain_ends)
      if (movable_chain(impl.urdf, last) == movable_chain(impl.urdf, end)) end = last;
  return ends;
}

std::vector<std::size_t> group_ends(const Impl& impl, const SrdfGroup& group, const Srdf& srdf,
                                    const std::vector<std::size_t>& joints) {
  if (group.chains.size() == 1) return {*impl.urdf.find_link(group.chains[0].second)};
  std::vector<std::size_t> ends = ends_of(impl, joints);
  return ends.size() == 1 ? ends : branch_ends(impl, group, srdf, joints);
}

/// Without a group, joint names or an end effector: the only group, or the chain to the only leaf.
Selection select_default(const Impl& impl, const Srdf* srdf) {
  if (srdf && srdf->groups.size() == 1) {
    const SrdfGroup& group = srdf->groups[0];
    auto joints = group_joints(impl, group, *srdf);
    auto ends = group_ends(impl, group, *srdf, joints);
    return {std::move(joints), std::move(ends)};
  }
  const auto leaves = impl.urdf.leaves();
  if (leaves.size() == 1) return {movable_chain(impl.urdf, leaves[0]), {leaves[0]}};
  const std::string groups = srdf && !srdf->groups.empty() ? " or a group: " + quoted_list(srdf->group_names()) : "";
  throw InvalidArgument("robot '" + impl.name + "' has several leaf links; give an end_effector, such as " +
                        leaf_names(impl) + groups);
}

Selection select(const Impl& impl, const Srdf* srdf) {
  const RobotDescription& d = impl.description;
  if (!d.group.empty() && !d.joint_names.empty())
    throw InvalidArgument("robot '" + impl.name + "': give either a group or joint_names, not both");
  Selection selection;
  const SrdfGroup* group = nullptr;
  if (!d.group.empty()) {
    if (!srdf) throw InvalidArgument("group '" + d.group + "' needs an SRDF, and robot '" + impl.name + "' has none");
    group = srdf->find_group(d.group);
    if (!group) {
      const std::string hint = did_you_mean(d.group, srdf->group_names());
      throw InvalidArgument("robot '" + impl.name + "' has no group '" + d.group + "'" +
                            (hint.empty() ? "; known are " + quoted_list(srdf->group_names()) : hint));
    }
    selection.joints = group_joints(impl, *group, *srdf);
  } else if (!d.joint_names.empty()) {
    selection.joints = named_joints(impl);
  } else if (d.end_effector.empty()) {
    return select_default(impl, srdf);
  }
  if (!d.end_effector.empty()) {
    selection.end_links = {require_end_effector(impl, srdf)};
    if (selection.joints.empty()) selection.joints = movable_chain(impl.urdf, selection.end_links[0]);
  } else if (group) {
    selection.end_links = group_ends(impl, *group, *srdf, selection.joints);
  } else {
    selection.end_links = ends_of(impl, selection.joints);
  }
  return selection;
}

Joint joint_of(const UrdfJoint& joint) {
  const JointKind kind = joint.type == UrdfJointType::continuous  ? JointKind::continuous
                         : joint.type == UrdfJointType::prismatic ? JointKind::prismatic
                                                                  : JointKind::revolute;
  return {joint.name, kind, joint.lower, joint.upper, joint.velocity.value_or(0.0), joint.effort.value_or(0.0)};
}

/// The limit of a planned joint to which the URDF gives none, or 0, as many exporters do; with a warning.
double velocity_without_limit(Impl& impl, const UrdfJoint& joint) {
  const std::string text =
      "joint '" + joint.name + "' of robot '" + impl.name + "' is planned but has no velocity limit above 0";
  if (impl.description.strict) throw InvalidArgument(text + "; give it <limit velocity=\"…\"> in the URDF");
  const char* unit = joint.type == UrdfJointType::prismatic ? " m/s" : " rad/s";
  impl.warnings.push_back(text + "; " + to_text(kDefaultVelocity) + unit + " is taken, as MoveIt does");
  return kDefaultVelocity;
}

/// The position of a joint in the SRDF's group states: in "default", otherwise in "home", otherwise in the first state
/// that gives one.
std::optional<double> value_in_states(const Srdf* srdf, const std::string& joint) {
  if (!srdf) return std::nullopt;
  for (const char* name : {"default", "home", ""})
    for (const SrdfState& state : srdf->states) {
      const auto it = state.positions.find(joint);
      if (it != state.positions.end() && (!*name || state.name == name)) return it->second;
    }
  return std::nullopt;
}

void check_fixed_joints(const Impl& impl) {
  for (const auto& [name, value] : impl.description.fixed_joints) {
    if (std::find(impl.joint_names.begin(), impl.joint_names.end(), name) != impl.joint_names.end())
      throw InvalidArgument("fixed_joints: joint '" + name + "' of robot '" + impl.name +
                            "' is planned; leave it out here, or name the joints to plan in joint_names");
    const Joint* joint = find_joint(impl.other_joints, name);
    if (!joint) throw InvalidArgument("fixed_joints: " + why_not_a_joint(impl, name));
    if (!(value >= joint->lower && value <= joint->upper) || !std::isfinite(value))
      throw InvalidArgument("fixed_joints: " + name + " is " + to_text(value) + "; allowed is " +
                            to_text(joint->lower) + " to " + to_text(joint->upper) + degrees_hint(*joint, value));
  }
}

void set_defaults(Impl& impl, const Srdf* srdf) {
  check_fixed_joints(impl);
  impl.default_other_positions.resize(static_cast<Eigen::Index>(impl.other_joints.size()));
  for (std::size_t i = 0; i < impl.other_joints.size(); ++i) {
    const Joint& joint = impl.other_joints[i];
    const auto given = impl.description.fixed_joints.find(joint.name);
    const double value =
        given != impl.description.fixed_joints.end() ? given->second : value_in_states(srdf, joint.name).value_or(0.0);
    impl.default_other_positions[static_cast<Eigen::Index>(i)] = std::clamp(value, joint.lower, joint.upper);
  }
}

/// Collects the states that give every planned joint. Where names repeat, the state of the planned group counts, then
/// the first.
void collect_group_states(Impl& impl, const Srdf& srdf) {
  for (const bool own : {true, false})
    for (const SrdfState& state : srdf.states) {
      if (own != (state.group == impl.description.group)) continue;
      Eigen::VectorXd q(static_cast<Eigen::Index>(impl.joints.size()));
      std::size_t found = 0;
      for (; found < impl.joints.size(); ++found) {
        const auto it = state.positions.find(impl.joint_names[found]);
        if (it == state.positions.end()) break;
        q[static_cast<Eigen::Index>(found)] = it->second;
      }
      if (found == impl.joints.size()) impl.group_states.emplace(state.name, q);
    }
}

/// Replaces files by their texts. Its paths are absolute, because the working directory may change before they are
/// used.
RobotDescription without_files(RobotDescription description) {
  RobotDescription& d = description;
  if (d.urdf_path.empty() == d.urdf_text.empty())
    throw InvalidArgument(d.urdf_path.empty() ? "a robot needs a URDF: give urdf_path or urdf_text"
                                              : "give either urdf_path or urdf_text, not both");
  if (!d.srdf_path.empty() && !d.srdf_text.empty())
    throw InvalidArgument("give either srdf_path or srdf_text, not both");
  if (!d.urdf_path.empty() && !d.urdf_directory.empty())
    throw InvalidArgument("urdf_directory is for a URDF given as text; with urdf_path it is the directory of the file");
  if (!d.urdf_path.empty()) {
    d.urdf_text = xml::read_text(d.urdf_path, "URDF");
    d.urdf_directory = std::filesystem::absolute(d.urdf_path).parent_path().string();
  }
  if (!d.srdf_path.empty()) d.srdf_text = xml::read_text(d.srdf_path, "SRDF");
  d.urdf_path.clear();
  d.srdf_path.clear();
  if (!d.urdf_directory.empty()) d.urdf_directory = std::filesystem::absolute(d.urdf_directory).string();
  for (std::string& directory : d.package_dirs) directory = std::filesystem::absolute(directory).string();
  return description;
}

/// Of planar and floating joints, one is planned where its bounds are given, and is no longer among them.
void warn_of_multi_dof_joints(RobotModelImpl& m) {
  for (const UrdfJoint& joint : m.urdf.joints) {
    const bool planar = joint.type == UrdfJointType::planar;
    if (!planar && joint.type != UrdfJointType::floating) continue;
    const bool given = planar ? m.description.planar_bounds.has_value() : m.description.floating_bounds.has_value();
    m.warnings.push_back("joint '" + joint.name +
                         "' has more than one degree of freedom; it is not planned and stays at its origin; " +
                         (planar ? "planar_bounds" : "floating_bounds") +
                         (given ? " plans the first joint of its type alone" : " plans it"));
  }
}

}  // namespace

RobotModelImpl& RobotModelBuilder::impl(RobotModel& model) { return *model.impl_; }

std::shared_ptr<RobotModel> RobotModelBuilder::build(const RobotDescription& description) {
  std::shared_ptr<RobotModel> model(new RobotModel);
  Impl& m = *model->impl_;
  m.description = description;
  m.self_contained = without_files(description);
  const RobotDescription& texts = m.self_contained;
  m.urdf = Urdf::parse(texts.urdf_text, description.urdf_path.empty() ? "URDF text" : description.urdf_path,
                       description.strict);
  m.warnings = m.urdf.warnings;
  m.name = m.self_contained.name = description.name.empty() ? m.urdf.name : description.name;
  std::optional<Srdf> srdf;
  if (!description.srdf_path.empty() || !description.srdf_text.empty()) {
    srdf = Srdf::parse(texts.srdf_text, m.urdf, description.srdf_path.empty() ? "SRDF text" : description.srdf_path,
                       description.strict);
    m.warnings.insert(m.warnings.end(), srdf->warnings.begin(), srdf->warnings.end());
  }
  if (srdf) m.virtual_joint = srdf->virtual_joint;
  if (texts.planar_bounds || texts.floating_bounds) {
    expand_multi_dof_joint(m.self_contained, m.urdf, srdf ? &*srdf : nullptr);
    m.urdf = Urdf::parse(texts.urdf_text);
    if (srdf) srdf = Srdf::parse(texts.srdf_text, m.urdf);
    m.description.joint_names = texts.joint_names;
  }
  m.link_names = m.urdf.link_names();
  warn_of_multi_dof_joints(m);
  m.tree = std::make_unique<KinematicTree>(m.urdf);
  choose_joints(m, srdf ? &*srdf : nullptr);
  build_actuated_joints(m);
  if (m.joint_support[m.tree->fixed_placement(m.end_effector_index).joint] == 0)
    throw InvalidArgument("none of the planned joints of robot '" + m.name + "' moves its end effector '" +
                          m.end_effector + "'");
  build_geometries(m);
  allow_by_rules(m, srdf ? &*srdf : nullptr);
  list_self_pairs(m);
  if (!srdf) allow_always_colliding(*model);
  return model;
}

void RobotModelBuilder::choose_joints(Impl& m, const Srdf* srdf) {
  const Selection selection = select(m, srdf);
  for (const std::size_t link : selection.end_links) m.end_links.push_back(m.link_names[link]);
  m.end_effector_index = selection.end_links[0];
  m.end_effector = m.end_links[0];
  if (selection.joints.empty())
    throw InvalidArgument("robot '" + m.name + "': no movable joint leads to end effector '" + m.end_effector + "'");
  for (const std::size_t index : selection.joints) {
    const UrdfJoint& joint = m.urdf.joints[index];
    m.joints.push_back(joint_of(joint));
    if (m.joints.back().max_velocity <= 0.0) m.joints.back().max_velocity = velocity_without_limit(m, joint);
    constexpr double min_velocity = 1e-6;  // [rad/s or m/s] below it no motion ends
    if (m.joints.back().max_velocity < min_velocity)
      throw InvalidArgument("joint '" + joint.name + "' of robot '" + m.name + "' has the velocity limit " +
                            to_text(m.joints.back().max_velocity) + "; it must be at least " + to_text(min_velocity));
    m.joint_names.push_back(joint.name);
  }
  for (const std::size_t index : m.urdf.joint_order) {
    const bool planned = std::find(selection.joints.begin(), selection.joints.end(), index) != selection.joints.end();
    if (can_be_planned(m.urdf.joints[index]) && !planned) m.other_joints.push_back(joint_of(m.urdf.joints[index]));
  }
  set_defaults(m, srdf);
  if (!srdf) return;
  collect_group_states(m, *srdf);
  list_end_effectors(m, *srdf);
  for (const SrdfGroup& group : srdf->groups) {
    if (!group.fault.empty()) continue;
    Names& joints = m.groups[group.name];
    for (const std::size_t joint : srdf->joints_of(group, m.urdf)) joints.push_back(m.urdf.joints[joint].name);
  }
}

void RobotModelBuilder::build_actuated_joints(Impl& m) {
  const auto find = [](const std::vector<Joint>& joints, const std::string& name) {
    return static_cast<std::size_t>(
        std::find_if(joints.begin(), joints.end(), [&](const Joint& j) { return j.name == name; }) - joints.begin());
  };
  m.joint_support.assign(m.tree->joint_count(), 0);
  std::vector<std::uint64_t> own(m.tree->joint_count(), 0);
  for (const std::size_t index : m.urdf.joint_order) {
    const UrdfJoint& joint = m.urdf.joints[index];
    if (!joint.scalar()) continue;
    const UrdfMimic mimic = joint.mimic.value_or(UrdfMimic{index, 1.0, 0.0});
    const std::string& source = m.urdf.joints[mimic.source].name;
    const std::size_t planned = find(m.joints, source);
    Follower follower{m.tree->slot(index), planned, mimic.multiplier, mimic.offset, joint.axis};
    if (planned < m.joints.size()) {
      if (m.actuated_joints.size() == kMaxActuatedJoints)
        throw InvalidArgument("robot '" + m.name + "' has more than " + std::to_string(kMaxActuatedJoints) +
                              " actuated joints");
      own[follower.slot.joint] = std::uint64_t{1} << m.actuated_joints.size();
      m.actuated_joints.push_back({planned, mimic.multiplier, joint.type == UrdfJointType::prismatic});
      m.planned_followers.push_back(follower);
    } else {
      follower.source = find(m.other_joints, source);
      m.other_followers.push_back(follower);
    }
  }
  for (std::size_t j = 1; j < own.size(); ++j) {  // Pinocchio numbers parents before children
    m.joint_support[j] = m.joint_support[m.tree->parent(j)] | own[j];
    if (m.joint_support[j] != 0) m.moving_joints.push_back(j);
  }
}

}  // namespace srmp
