#include "srmp/planning/strategies/composite_search.hpp"

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

class CompositeSearch {
 public:
  CompositeSearch(const CompositeSpace& space, const CompositeOptions& options) : space_(space), options_(options) {
    for (std::size_t i = 0; i < space_.size(); ++i)
      for (const auto& [j, k] : parallel_pairs(space_.robot(i)))
        pairs_.emplace_back(j + space_.first(i), k + space_.first(i));
    make_weights();
  }

  CompositeResult run(const Deadline& deadline) {
    CompositeResult answer;
    if (space_.targets().empty()) return answer;
    for (const double scale : scales)
      if (scale >= 1.0 || options_.max_expansions >= fine_from)
        for (const bool backward : {true, false}) members_.push_back({nullptr, {}, backward, scale});
    const auto make = [this](std::size_t i) { return make_member(members_[i]); };
    const auto found = search::portfolio<Lattice, AnyHeuristic>(
        members_.size(), make, {.weight = options_.weight, .max_expansions = options_.max_expansions}, deadline);
    answer.status = found.result.status;
    answer.statistics = found.result.statistics;
    for (const Member& member : members_)
      if (member.lattice) answer.statistics.memory += member.lattice->memory();
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

  PrimitiveSet primitives(double scale) const {
    const MultiRobotWorld::Options& lattice = space_.world().options();
    const Eigen::VectorXd step = lattice_step(space_.joints(), scale * std::min(lattice.resolution, M_PI / 2 / scale),
                                              scale * lattice.prismatic_resolution);
    PrimitiveSet set = rich_primitives(space_.joints(), step, pairs_);
    PrimitiveFamily one_arm{"one arm", PrimitiveUse::to_targets, {}};  // the others stay
    const Eigen::VectorXd& all = set.families.front().moves.front();
    for (std::size_t i = 0; i < space_.size(); ++i) {
      Eigen::VectorXd& move = one_arm.moves.emplace_back(Eigen::VectorXd::Zero(step.size()));
      space_.part(move, i) = space_.part(all, i);
    }
    set.families.push_back(std::move(one_arm));
    return set;
  }

  search::PortfolioMember<Lattice, AnyHeuristic> make_member(Member& member) {
    std::vector<Eigen::VectorXd> roots{space_.start()}, targets = space_.targets();
    if (member.backward) roots.swap(targets);
    member.lattice = std::make_unique<Lattice>(space_.joints(), std::move(roots), std::move(targets),
                                               Lattice::Options{.primitives = primitives(member.scale)},
                                               [this](std::size_t, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
                                                 return space_.is_motion_free(a, b);
                                               });
    Lattice& lattice = *member.lattice;
    member.anchor = [&lattice](StateId s) { return lattice.distance_to_targets(s); };
    const auto count = static_cast<std::size_t>(weights_.rows()) + 1;
    const search::InadmissibleHeuristics inadmissible_heuristics{
        count, [&lattice, count, this](std::span<const StateId> states, std::span<double> out) {
          for (std::size_t i = 0; i < states.size(); ++i)
            lattice.distances_to_targets(states[i], weights_, out.subspan(i * count, count));
        }};
    return {&lattice, lattice.starts(), &member.anchor, inadmissible_heuristics};
  }

  /// All joints alike; those near the bases counting for more; those near the hands; and one arm after the other.
  void make_weights() {
    const std::size_t arms = space_.size();
    weights_ = RowMatrix::Ones(3 + static_cast<Eigen::Index>(arms), space_.first(arms));
    for (std::size_t i = 0; i < arms; ++i) {
      const Eigen::Index first = space_.first(i), last = space_.first(i + 1);
      weights_.block(0, first, 3, last - first) = distance_weights(static_cast<std::size_t>(last - first));
      weights_.row(3 + static_cast<Eigen::Index>(i)).segment(first, last - first).setConstant(3.0);
    }
  }

  JointPath path_of(const search::PortfolioResult& found) const {
    const Member& winner = members_[found.winner];
    std::vector<Eigen::VectorXd> rows = winner.lattice->configurations(found.result.path);
    if (winner.backward) std::reverse(rows.begin(), rows.end());
    rows.front() = space_.start();  // unwrapped from the start on
    return space_.path(rows);
  }

  const CompositeSpace& space_;
  const CompositeOptions& options_;
  std::vector<JointPair> pairs_;
  RowMatrix weights_;
  std::vector<Member> members_;
};

}  // namespace

CompositeResult composite_search(const CompositeSpace& space, const CompositeOptions& options,
                                 const Deadline& deadline) {
  return CompositeSearch(space, options).run(deadline);
}

}  // namespace srmp
