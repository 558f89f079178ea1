#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <vector>

#include "srmp/robot/robot_model.hpp"

namespace srmp {

/// The torques that a robot's joints need for a motion, by the masses of its URDF and what it carries, in gravity. With
/// scratch memory: one thread uses it at a time. The recursive Newton-Euler algorithm is Pinocchio's.
class RobotDynamics {
 public:
  static constexpr double gravity = 9.81;  ///< [m/s^2] along the world's -z

  /// `base`: of the robot, in the world. `other_positions`: of the joints that are not planned; empty: at their
  /// defaults. The model outlives this. Throws InvalidArgument for an unknown link of the payload, with the nearest
  /// name, and where no link has a mass.
  RobotDynamics(const RobotModel& robot, const Pose& base, const Eigen::VectorXd& other_positions,
                const std::optional<Payload>& payload);
  ~RobotDynamics();
  RobotDynamics(RobotDynamics&&) noexcept;

  /// (dof,) [N m, prismatic joints N] of the planned joints at q with this velocity and acceleration; a planned joint
  /// carries its mimic joints.
  Eigen::VectorXd torques(const Eigen::VectorXd& q, const Eigen::VectorXd& velocity,
                          const Eigen::VectorXd& acceleration);

  /// A body of the tree: what is rigidly joined to one joint. Lengths do not depend on the configuration.
  struct Body {
    std::size_t parent{};               ///< 0: the base, which is bodies()[0]
    std::optional<std::size_t> joint;   ///< planned joint that moves it; none: it is fixed to its parent
    double ratio{}, shift{};            ///< its own joint is at ratio * planned + shift
    bool prismatic{};                   ///< its own joint
    double offset{};                    ///< [m] from the parent's joint to this one, without its own travel
    double mass{}, lever{}, inertia{};  ///< [kg], [m] from the joint to the centre of mass, [kg m^2] at most
  };
  const std::vector<Body>& bodies() const { return bodies_; }  ///< parents before children

 private:
  struct Model;
  std::unique_ptr<Model> model_;
  std::vector<Body> bodies_;
};

}  // namespace srmp
