#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

// OMPL's planners on a configuration space and a collision checker of ours. Nothing of OMPL is in this header: it needs
// the system's Boost, the rest of the module that of Coal's package.
namespace bench {

/// A dimension of the configuration space.
struct Dimension {
  double lower{}, upper{};  ///< [rad or m]
  bool continuous{};        ///< without limits: the angle counts modulo 2 pi
};

/// The collision checker. Called by one thread at a time.
class Validity {
 public:
  virtual ~Validity() = default;
  virtual bool is_free(const Eigen::VectorXd& q) = 0;
  /// The straight motion between two configurations; a is known to be free.
  virtual bool is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b) = 0;
};

/// What a path is to keep: an error (size(),) of at most `tolerance` in length. Called by one thread at a time.
class Constraint {
 public:
  virtual ~Constraint() = default;
  virtual Eigen::Index size() const = 0;
  virtual double tolerance() const = 0;
  virtual void error(const Eigen::VectorXd& q, Eigen::Ref<Eigen::VectorXd> out) = 0;
  /// (size(), dof)
  virtual void jacobian(const Eigen::VectorXd& q, Eigen::Ref<Eigen::MatrixXd> out) = 0;
};

enum class Motions {
  by_validity,  ///< Validity::is_motion_free decides
  /// OMPL's own validators: is_free of samples, half a percent of the space's extent apart, which is MoveIt's default;
  /// with a constraint of the projected states, 0.05 rad apart.
  sampled,
};

struct Query {
  std::vector<Dimension> space;
  Eigen::VectorXd start, goal;
  std::string planner;
  double time_limit{};   ///< [s]
  std::uint32_t seed{};  ///< above 0
  Motions motions{};
  std::shared_ptr<Constraint> constraint{};  ///< null: there is none; else the space is OMPL's ProjectedStateSpace
};

struct Answer {
  std::string status;                      ///< solved, timed_out, start_invalid, goal_invalid or failed
  double search_time_s{}, plan_time_s{};   ///< until a path was found; with its simplification
  std::vector<Eigen::VectorXd> waypoints;  ///< continuous dimensions within [-pi, pi]
};

/// Of OMPL.
std::string ompl_version();
/// Names of the planners that this OMPL has, of those that the benchmark knows.
std::vector<std::string> ompl_planners();
/// Plans, then simplifies the path with OMPL's PathSimplifier, in the time that is left or at least once. With a
/// constraint, the waypoints are the states of the projected path. Throws std::invalid_argument for a planner that is
/// not one of ompl_planners(), and for a constraint of continuous dimensions.
Answer plan(const Query& query, const std::shared_ptr<Validity>& validity);

}  // namespace bench
