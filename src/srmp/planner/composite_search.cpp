#include "srmp/planner/composite_search.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/lattice/lattice.hpp"
#include "srmp/search/portfolio.hpp"

namespace srmp {

namespace {

using search::AnyHeuristic;
using search::StateId;

constexpr double scales[] = {3.0, 1.5, 0.75};  // of the resolution asked for
constexpr std::uint64_t fine_from = 1024;      // expansions: before, lattices finer than asked for are left out
constexpr std::size_t most_targets = 16;

class CompositeSearch {
 public:
  CompositeSearch(ArmWorld& world, const std::vector<std::size_t>& arms, const CompositeOptions& options)
      : world_(world), arms_(arms), options_(options) {
    for (const std::size_t arm : arms_) {
      const RobotModel& robot = world.robot(arm);
      first_.push_back(joints_.size());
      for (const auto& [j, k] : parallel_pairs(robot))
        pairs_.emplace_back(j + static_cast<Eigen::Index>(joints_.size()),
                            k + static_cast<Eigen::Index>(joints_.size()));
      joints_.insert(joints_.end(), robot.joints().begin(), robot.joints().end());
    }
    first_.push_back(joints_.size());
    start_.resize(static_cast<Eigen::Index>(joints_.size()));
    for (std::size_t i = 0; i < arms_.size(); ++i) part(start_, i) = world.task(arms_[i]).start;
    add_targets(0, start_);
    make_weights();
  }

  CompositeResult run(const Deadline& deadline) {
    CompositeResult answer;
    if (targets_.empty()) return answer;
    for (const double scale : scales)
      if (scale >= 1.0 || options_.max_expansions >= fine_from)
        for (const bool backward : {true, false}) members_.push_back({nullptr, {}, backward, scale});
    const auto make = [this](std::size_t i) { return make_member(members_[i]); };
    const auto found = search::portfolio<Lattice, AnyHeuristic>(
        members_.size(), make, {.weight = options_.weight, .max_expansions = options_.max_expansions}, deadline);
    answer.status = found.result.status;
    answer.statistics = found.result.statistics;
    if (answer.status == Status::solved) answer.path = path_of(found);
    return answer;
  }

 private:
  struct Member {
    std::unique_ptr<Lattice> lattice;  // it cannot move
    AnyHeuristic anchor;
    bool backward;
    double scale;
  };

  Eigen::VectorBlock<Eigen::VectorXd> part(Eigen::VectorXd& q, std::size_t i) const {
    return q.segment(static_cast<Eigen::Index>(first_[i]), static_cast<Eigen::Index>(first_[i + 1] - first_[i]));
  }
  Eigen::VectorXd part_of(const Eigen::VectorXd& q, std::size_t i) const {
    return q.segment(static_cast<Eigen::Index>(first_[i]), static_cast<Eigen::Index>(first_[i + 1] - first_[i]));
  }

  /// Goals of all arms that go together, the first ones first.
  void add_targets(std::size_t i, Eigen::VectorXd q) {
    if (targets_.size() >= most_targets) return;
    if (i == arms_.size()) {
      targets_.push_back(std::move(q));
      return;
    }
    const ArmTask& task = world_.task(arms_[i]);
    const std::vector<Eigen::VectorXd> choices =
        task.anywhere ? std::vector<Eigen::VectorXd>{task.start} : task.targets;
    for (const Eigen::VectorXd& choice : choices) {
      part(q, i) = choice;
      bool apart = true;
      for (std::size_t k = 0; k < i && apart; ++k)
        apart = world_.are_apart(arms_[k], part_of(q, k), part_of(q, k), arms_[i], choice, choice);
      if (apart) add_targets(i + 1, q);
    }
  }

  bool is_end(const Eigen::VectorXd& q) const {
    return q == start_ || std::find(targets_.begin(), targets_.end(), q) != targets_.end();
  }

  /// `a` is free. Where the arms must be, it matters how near they are exactly; elsewhere balls are quicker.
  bool is_motion_free(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    const bool by_balls = !is_end(a) && !is_end(b);
    std::vector<char> moves(arms_.size());
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      moves[i] = part_of(a, i) != part_of(b, i);
      if (moves[i] && !world_.is_free_alone(arms_[i], part_of(a, i), part_of(b, i))) return false;
    }
    for (std::size_t i = 0; i < arms_.size(); ++i)
      for (std::size_t k = i + 1; k < arms_.size(); ++k)
        if ((moves[i] || moves[k]) && !world_.are_apart(arms_[i], part_of(a, i), part_of(b, i), arms_[k], part_of(a, k),
                                                        part_of(b, k), true, by_balls))
          return false;
    return true;
  }

  PrimitiveSet primitives(double scale) const {
    const ArmWorld::Options& lattice = world_.options();
    const Eigen::VectorXd step = lattice_step(joints_, scale * std::min(lattice.resolution, M_PI / 2 / scale),
                                              scale * lattice.prismatic_resolution);
    PrimitiveSet set = rich_primitives(joints_, step, pairs_);
    PrimitiveFamily one_arm{"one arm", PrimitiveUse::towards, {}};  // the others stay
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      Eigen::VectorXd& move = one_arm.moves.emplace_back(Eigen::VectorXd::Zero(step.size()));
      part(move, i) = part_of(set.families.front().moves.front(), i);
    }
    set.families.push_back(std::move(one_arm));
    return set;
  }

  search::PortfolioMember<Lattice, AnyHeuristic> make_member(Member& member) {
    std::vector<Eigen::VectorXd> anchors{start_}, targets = targets_;
    if (member.backward) anchors.swap(targets);
    member.lattice = std::make_unique<Lattice>(
        joints_, std::move(anchors), std::move(targets), Lattice::Options{.primitives = primitives(member.scale)},
        [this](std::size_t, const Eigen::VectorXd& a, const Eigen::VectorXd& b) { return is_motion_free(a, b); });
    Lattice& lattice = *member.lattice;
    member.anchor = [&lattice](StateId s) { return lattice.distance_to_targets(s); };
    const auto count = static_cast<std::size_t>(weights_.rows()) + 1;
    const search::Guides guides{count, [&lattice, count, this](std::span<const StateId> states, std::span<double> out) {
                                  for (std::size_t i = 0; i < states.size(); ++i)
                                    lattice.measure_to_targets(states[i], weights_, out.subspan(i * count, count));
                                }};
    return {&lattice, lattice.starts(), &member.anchor, guides};
  }

  /// All joints alike; those near the bases counting for more; those near the hands; and one arm after the other.
  void make_weights() {
    weights_ = RowMatrix::Ones(3 + static_cast<Eigen::Index>(arms_.size()), start_.size());
    for (std::size_t i = 0; i < arms_.size(); ++i) {
      const auto first = static_cast<Eigen::Index>(first_[i]), last = static_cast<Eigen::Index>(first_[i + 1]);
      weights_.block(0, first, 3, last - first) = measure_weights(static_cast<std::size_t>(last - first));
      weights_.row(3 + static_cast<Eigen::Index>(i)).segment(first, last - first).setConstant(3.0);
    }
  }

  CoupledPath path_of(const search::PortfolioResult& found) const {
    const Member& winner = members_[found.winner];
    std::vector<Eigen::VectorXd> rows = winner.lattice->configurations(found.result.path);
    if (winner.backward) std::reverse(rows.begin(), rows.end());
    rows.front() = start_;  // unwrapped from the start on
    std::vector<std::vector<Eigen::VectorXd>> ways(arms_.size());
    for (std::size_t i = 0; i < arms_.size(); ++i)
      for (const Eigen::VectorXd& row : rows) ways[i].push_back(part_of(row, i));
    return coupled_path(world_, arms_, ways);
  }

  ArmWorld& world_;
  const std::vector<std::size_t>& arms_;
  const CompositeOptions& options_;
  std::vector<Joint> joints_;
  std::vector<std::size_t> first_;  // joint of each arm
  std::vector<JointPair> pairs_;
  Eigen::VectorXd start_;
  std::vector<Eigen::VectorXd> targets_;
  RowMatrix weights_;
  std::vector<Member> members_;
};

}  // namespace

CompositeResult composite_search(ArmWorld& world, const std::vector<std::size_t>& arms, const CompositeOptions& options,
                                 const Deadline& deadline) {
  return CompositeSearch(world, arms, options).run(deadline);
}

}  // namespace srmp
