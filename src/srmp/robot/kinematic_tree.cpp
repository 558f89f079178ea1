#include "srmp/robot/kinematic_tree.hpp"

#include <cmath>
#include <mutex>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/kinematics.hpp>
#include <pinocchio/multibody.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

/// All but the last row, which stays.
void write(const pinocchio::SE3& pose, Eigen::Isometry3d& result) {
  result.linear() = pose.rotation();
  result.translation() = pose.translation();
}

Eigen::Isometry3d isometry(const pinocchio::SE3& pose) {
  Eigen::Isometry3d result;
  write(pose, result);
  result.makeAffine();
  return result;
}

/// What Pinocchio's forwardKinematics does for one joint, bit for bit. Poses are written where they stay: a copy would
/// wait until each of their numbers is stored.
struct JointPose : pinocchio::fusion::JointUnaryVisitorBase<JointPose> {
  using ArgsType = boost::fusion::vector<const pinocchio::Model&, pinocchio::Data&, const Eigen::VectorXd&>;

  template <class JointModel>
  [[gnu::flatten]] static void algo(const pinocchio::JointModelBase<JointModel>& joint,
                                    pinocchio::JointDataBase<typename JointModel::JointDataDerived>& own,
                                    const pinocchio::Model& model, pinocchio::Data& data, const Eigen::VectorXd& q) {
    const auto i = joint.id(), parent = model.parents[i];
    joint.calc(own.derived(), q);
    const pinocchio::SE3 in_parent = model.jointPlacements[i] * own.M();
    if (parent == 0) {
      data.oMi[i] = in_parent;
      return;
    }
    const pinocchio::SE3& carrier = data.oMi[parent];
    data.oMi[i].rotation().noalias() = carrier.rotation() * in_parent.rotation();
    data.oMi[i].translation().noalias() = carrier.translation() + carrier.rotation() * in_parent.translation();
  }
};

}  // namespace

class KinematicTree::Data {
 public:
  explicit Data(std::shared_ptr<Model> model);

  std::shared_ptr<Model> model;  // null while idle
  pinocchio::Data pinocchio;
  Eigen::VectorXd q;
};

struct KinematicTree::Model {
  pinocchio::Model pinocchio;
  Eigen::VectorXd neutral;
  std::mutex mutex;
  std::vector<std::unique_ptr<Data>> idle;  // data for the next make_data
  static constexpr std::size_t max_idle = 256;
};

KinematicTree::Data::Data(std::shared_ptr<Model> of) : model(std::move(of)), pinocchio(model->pinocchio) {}

void KinematicTree::DataDeleter::operator()(Data* data) const {
  std::unique_ptr<Data> idle(data);
  const std::shared_ptr<Model> model = std::move(data->model);
  const std::lock_guard lock(model->mutex);
  if (model->idle.size() < Model::max_idle) model->idle.push_back(std::move(idle));
}

KinematicTree::KinematicTree(const Urdf& urdf) {
  auto model = std::make_shared<Model>();
  try {
    pinocchio::urdf::buildModelFromXML(urdf.kinematics_text(), model->pinocchio);
  } catch (const std::exception& error) {
    throw FileError(urdf.label + ": Pinocchio rejects this robot: " + error.what());
  }
  const pinocchio::Model& m = model->pinocchio;
  for (const UrdfLink& link : urdf.links) {
    const auto& frame = m.frames[m.getFrameId(link.name, pinocchio::BODY)];
    placements_.push_back({frame.parentJoint, isometry(frame.placement)});
  }
  for (const UrdfJoint& joint : urdf.joints) {
    if (!joint.scalar()) {
      slots_.emplace_back();
      continue;
    }
    const auto id = m.getJointId(joint.name);
    slots_.push_back({id, m.joints[id].idx_q(), m.joints[id].nq() == 2});
  }
  model->neutral = pinocchio::neutral(m);
  model_ = std::move(model);
}

KinematicTree::~KinematicTree() = default;

std::size_t KinematicTree::joint_count() const { return static_cast<std::size_t>(model_->pinocchio.njoints); }
std::size_t KinematicTree::parent(std::size_t joint) const { return model_->pinocchio.parents[joint]; }

KinematicTree::DataPtr KinematicTree::make_data() const {
  DataPtr data;
  {
    const std::lock_guard lock(model_->mutex);
    if (!model_->idle.empty()) {
      data.reset(model_->idle.back().release());
      model_->idle.pop_back();
    }
  }
  if (data)
    data->model = model_;
  else
    data.reset(new Data(model_));
  data->q = model_->neutral;
  return data;
}

void KinematicTree::set(Data& data, const Slot& slot, double value) { set(data.q, slot, value); }

void KinematicTree::set(Eigen::VectorXd& q, const Slot& slot, double value) {
  if (slot.unit_circle) {
    q[slot.q] = std::cos(value);
    q[slot.q + 1] = std::sin(value);
  } else {
    q[slot.q] = value;
  }
}

void KinematicTree::forward(Data& data, std::vector<Eigen::Isometry3d>& poses) const {
  pinocchio::forwardKinematics(model_->pinocchio, data.pinocchio, data.q);
  for (std::size_t i = 1; i < poses.size(); ++i) write(data.pinocchio.oMi[i], poses[i]);
}

void KinematicTree::forward(Data& data, std::vector<Eigen::Isometry3d>& poses,
                            std::span<const std::size_t> joints) const {
  for (const std::size_t i : joints) {
    JointPose::run(model_->pinocchio.joints[i], data.pinocchio.joints[i],
                   JointPose::ArgsType(model_->pinocchio, data.pinocchio, data.q));
    write(data.pinocchio.oMi[i], poses[i]);
  }
}

}  // namespace srmp
