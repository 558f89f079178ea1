#include "planners.hpp"

#include <ompl/base/ConstrainedSpaceInformation.h>
#include <ompl/base/Constraint.h>
#include <ompl/base/goals/GoalState.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/base/spaces/SO2StateSpace.h>
#include <ompl/base/spaces/constraint/ProjectedStateSpace.h>
#include <ompl/config.h>
#include <ompl/geometric/PathSimplifier.h>
#include <ompl/geometric/planners/est/BiEST.h>
#include <ompl/geometric/planners/prm/PRM.h>
#include <ompl/geometric/planners/rrt/BiTRRT.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>
#include <ompl/util/Time.h>
#if __has_include(<ompl/geometric/planners/rrt/AORRTC.h>)
#include <ompl/geometric/planners/rrt/AORRTC.h>
#define BENCH_HAS_AORRTC
#endif

#include <algorithm>
#include <functional>
#include <map>
#include <mutex>
#include <stdexcept>

namespace bench {

namespace ob = ompl::base;
namespace og = ompl::geometric;

namespace {

using MakePlanner = std::function<ob::PlannerPtr(const ob::SpaceInformationPtr&)>;

template <class Planner>
ob::PlannerPtr make(const ob::SpaceInformationPtr& information) {
  return std::make_shared<Planner>(information);
}

const std::map<std::string, MakePlanner>& planners() {
  static const std::map<std::string, MakePlanner> all{
#ifdef BENCH_HAS_AORRTC
      {"AORRTC", make<og::AORRTC>},
#endif
      {"BiEST", make<og::BiEST>},   {"BiTRRT", make<og::BiTRRT>},          {"PRM", make<og::PRM>},
      {"RRT*", make<og::RRTstar>},  {"RRT-Connect", make<og::RRTConnect>},
  };
  return all;
}

/// OMPL's equality of the error and 0, whose tolerance is nearly that of the constraint: states are projected only
/// until they keep it.
class Equality final : public ob::Constraint {
 public:
  Equality(std::size_t dof, std::shared_ptr<bench::Constraint> constraint)
      : ob::Constraint(static_cast<unsigned>(dof), static_cast<unsigned>(constraint->size()),
                       0.98 * constraint->tolerance()),  // the rest is for the straight motions between states
        constraint_(std::move(constraint)) {}

  void function(const Eigen::Ref<const Eigen::VectorXd>& q, Eigen::Ref<Eigen::VectorXd> out) const override {
    const std::lock_guard lock(mutex_);
    constraint_->error(q, out);
  }
  void jacobian(const Eigen::Ref<const Eigen::VectorXd>& q, Eigen::Ref<Eigen::MatrixXd> out) const override {
    const std::lock_guard lock(mutex_);
    constraint_->jacobian(q, out);
  }

 private:
  std::shared_ptr<bench::Constraint> constraint_;
  mutable std::mutex mutex_;
};

/// The bounded dimensions as one vector, then a circle for each continuous one.
class Space {
 public:
  Space(const std::vector<Dimension>& dimensions, const std::shared_ptr<bench::Constraint>& constraint)
      : space_(std::make_shared<ob::CompoundStateSpace>()), planned_(space_) {
    ob::RealVectorBounds bounds(0);
    for (std::size_t i = 0; i < dimensions.size(); ++i) {
      if (dimensions[i].continuous) {
        circles_.push_back(static_cast<Eigen::Index>(i));
      } else {
        bounds.low.push_back(dimensions[i].lower);
        bounds.high.push_back(dimensions[i].upper);
        bounded_.push_back(static_cast<Eigen::Index>(i));
      }
    }
    const auto vector = std::make_shared<ob::RealVectorStateSpace>(static_cast<unsigned>(bounded_.size()));
    vector->setBounds(bounds);
    space_->addSubspace(vector, 1.0);
    for (std::size_t i = 0; i < circles_.size(); ++i) space_->addSubspace(std::make_shared<ob::SO2StateSpace>(), 1.0);
    space_->lock();
    space_->registerDefaultProjection(std::make_shared<ob::SubspaceProjectionEvaluator>(space_.get(), 0));
    if (!constraint) return;
    if (!circles_.empty()) throw std::invalid_argument("OMPL's constrained spaces need joint limits");
    planned_ =
        std::make_shared<ob::ProjectedStateSpace>(space_, std::make_shared<Equality>(dimensions.size(), constraint));
  }

  ob::SpaceInformationPtr information() const {
    if (is_constrained()) return std::make_shared<ob::ConstrainedSpaceInformation>(planned_);
    return std::make_shared<ob::SpaceInformation>(planned_);
  }
  const ob::StateSpacePtr& ompl() const { return planned_; }
  bool is_constrained() const { return planned_ != space_; }

  Eigen::VectorXd configuration(const ob::State* state) const {
    Eigen::VectorXd q(static_cast<Eigen::Index>(bounded_.size() + circles_.size()));
    const auto& compound = *unconstrained(state)->as<ob::CompoundState>();
    const auto& vector = *compound.as<ob::RealVectorStateSpace::StateType>(0);
    for (std::size_t i = 0; i < bounded_.size(); ++i) q[bounded_[i]] = vector[static_cast<unsigned>(i)];
    for (std::size_t i = 0; i < circles_.size(); ++i)
      q[circles_[i]] = compound.as<ob::SO2StateSpace::StateType>(static_cast<unsigned>(i + 1))->value;
    return q;
  }

  /// The straight motions that lead from a to b; empty: OMPL's projection does not get there.
  std::vector<Eigen::VectorXd> motion(const ob::State* a, const ob::State* b) const {
    if (!is_constrained()) return {configuration(a), configuration(b)};
    const auto& projected = *planned_->as<ob::ProjectedStateSpace>();
    std::vector<ob::State*> states;
    const bool reaches = projected.getConstraint()->isSatisfied(b) && projected.discreteGeodesic(a, b, false, &states);
    std::vector<Eigen::VectorXd> path{configuration(a)};
    for (ob::State* state : states) {
      path.push_back(configuration(state));
      planned_->freeState(state);
    }
    path.push_back(configuration(b));
    path.erase(std::unique(path.begin(), path.end()), path.end());
    return reaches ? path : std::vector<Eigen::VectorXd>{};
  }

  void set(ob::State* state, const Eigen::VectorXd& q) const {
    auto& compound = *unconstrained(state)->as<ob::CompoundState>();
    auto& vector = *compound.as<ob::RealVectorStateSpace::StateType>(0);
    for (std::size_t i = 0; i < bounded_.size(); ++i) vector[static_cast<unsigned>(i)] = q[bounded_[i]];
    for (std::size_t i = 0; i < circles_.size(); ++i) {
      const auto number = static_cast<unsigned>(i + 1);
      compound.as<ob::SO2StateSpace::StateType>(number)->value = q[circles_[i]];
      space_->getSubspace(number)->enforceBounds(compound[number]);  // bounded ones stay: OMPL refuses what is outside
    }
  }

 private:
  template <class State>
  State* unconstrained(State* state) const {
    return is_constrained() ? state->template as<ob::WrapperStateSpace::StateType>()->getState() : state;
  }

  std::shared_ptr<ob::CompoundStateSpace> space_;
  ob::StateSpacePtr planned_;  // space_, or its states that keep the constraint
  std::vector<Eigen::Index> bounded_, circles_;
};

/// One checker for states and motions: PRM looks for paths in a thread of its own.
class Guarded {
 public:
  explicit Guarded(std::shared_ptr<Validity> validity) : validity_(std::move(validity)) {}
  bool is_free(const Eigen::VectorXd& q) const {
    const std::lock_guard lock(mutex_);
    return validity_->is_free(q);
  }
  bool is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
    const std::lock_guard lock(mutex_);
    return validity_->is_motion_free(a, b);
  }

 private:
  std::shared_ptr<Validity> validity_;
  mutable std::mutex mutex_;
};

class StateValidity final : public ob::StateValidityChecker {
 public:
  StateValidity(const ob::SpaceInformationPtr& information, const Space& space, const Guarded& checker)
      : ob::StateValidityChecker(information), space_(space), checker_(checker) {}
  bool isValid(const ob::State* state) const override {
    if (space_.is_constrained() && !si_->satisfiesBounds(state)) return false;  // projections may leave the limits
    return checker_.is_free(space_.configuration(state));
  }

 private:
  const Space& space_;
  const Guarded& checker_;
};

class MotionValidity final : public ob::MotionValidator {
 public:
  MotionValidity(const ob::SpaceInformationPtr& information, const Space& space, const Guarded& checker)
      : ob::MotionValidator(information), space_(space), checker_(checker) {}
  bool checkMotion(const ob::State* a, const ob::State* b) const override {
    const auto path = space_.motion(a, b);
    for (std::size_t i = 1; i < path.size(); ++i)
      if (!checker_.is_motion_free(path[i - 1], path[i])) return false;
    return !path.empty();
  }
  bool checkMotion(const ob::State* a, const ob::State* b, std::pair<ob::State*, double>& last_valid) const override {
    if (checkMotion(a, b)) return true;
    last_valid.second = 0.0;  // no more is known of it
    if (last_valid.first) si_->copyState(last_valid.first, a);
    return false;
  }

 private:
  const Space& space_;
  const Guarded& checker_;
};

std::string status_of(ob::PlannerStatus status) {
  switch (static_cast<ob::PlannerStatus::StatusType>(status)) {
    case ob::PlannerStatus::EXACT_SOLUTION: return "solved";
    case ob::PlannerStatus::INVALID_START: return "start_invalid";
    case ob::PlannerStatus::INVALID_GOAL: return "goal_invalid";
    case ob::PlannerStatus::TIMEOUT:
    case ob::PlannerStatus::APPROXIMATE_SOLUTION: return "timed_out";
    default: return "failed";
  }
}

}  // namespace

std::string ompl_version() {
  return std::to_string(OMPL_MAJOR_VERSION) + "." + std::to_string(OMPL_MINOR_VERSION) + "." +
         std::to_string(OMPL_PATCH_VERSION);
}

std::vector<std::string> ompl_planners() {
  std::vector<std::string> names;
  for (const auto& [name, make] : planners()) names.push_back(name);
  return names;
}

Answer plan(const Query& query, const std::shared_ptr<Validity>& validity) {
  const auto found = planners().find(query.planner);
  if (found == planners().end()) throw std::invalid_argument("'" + query.planner + "' is not a planner of this OMPL");
  ompl::msg::noOutputHandler();
  ompl::RNG::setSeed(query.seed);

  const Space space(query.space, query.constraint);
  const Guarded checker(validity);
  const auto information = space.information();
  information->setStateValidityChecker(std::make_shared<StateValidity>(information, space, checker));
  if (query.motions == Motions::by_validity)
    information->setMotionValidator(std::make_shared<MotionValidity>(information, space, checker));
  else if (!space.is_constrained())
    space.ompl()->setLongestValidSegmentFraction(0.005);
  information->setup();

  const auto problem = std::make_shared<ob::ProblemDefinition>(information);
  ob::ScopedState<> start(space.ompl()), goal(space.ompl());
  space.set(start.get(), query.start);
  space.set(goal.get(), query.goal);
  problem->setStartAndGoalStates(start, goal);
  const ob::PlannerPtr planner = found->second(information);
  planner->setProblemDefinition(problem);
  planner->setup();

  Answer answer;
  const auto begin = ompl::time::now();
  const auto elapsed = [&] { return ompl::time::seconds(ompl::time::now() - begin); };
  answer.status = status_of(planner->solve(ob::timedPlannerTerminationCondition(query.time_limit)));
  answer.search_time_s = answer.plan_time_s = elapsed();
  if (answer.status != "solved") return answer;
  auto& path = *problem->getSolutionPath()->as<og::PathGeometric>();
  og::PathSimplifier(information).simplify(path, std::max(0.0, query.time_limit - elapsed()));
  if (space.is_constrained()) path.interpolate();  // to the states of the projected path
  answer.plan_time_s = elapsed();
  for (const ob::State* state : path.getStates()) answer.waypoints.push_back(space.configuration(state));
  return answer;
}

}  // namespace bench
