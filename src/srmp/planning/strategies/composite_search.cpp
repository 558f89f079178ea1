#include "srmp/planning/strategies/composite_search.hpp"

#include <algorithm>
#include <cmath>

#include "srmp/planning/strategies/lattice_portfolio.hpp"

namespace srmp {

namespace {

using search::StateId;

/// Lattices of all robots' joints.
class CompositeLattices : public LatticeFamily {
 public:
  explicit CompositeLattices(const CompositeSpace& space) : space_(space) {
    for (std::size_t i = 0; i < space_.size(); ++i)
      for (const auto& [j, k] : parallel_pairs(space_.model(i)))
        pairs_.emplace_back(j + space_.first(i), k + space_.first(i));
    make_weights();
  }

  Lattice lattice(const LatticeChoice& choice) override {
    std::vector<Eigen::VectorXd> roots{space_.start()}, targets = space_.targets();
    if (choice.from_goals()) roots.swap(targets);
    return Lattice(space_.joints(), std::move(roots), std::move(targets), {.primitives = primitives(choice.scale)},
                   [this](std::size_t, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
                     return space_.is_motion_free(a, b);
                   });
  }

  search::InadmissibleHeuristics inadmissible_heuristics(Lattice& lattice) override {
    const auto count = static_cast<std::size_t>(weights_.rows()) + 1;
    return {count, [&lattice, count, this](std::span<const StateId> states, std::span<double> out) {
              for (std::size_t i = 0; i < states.size(); ++i)
                lattice.distances_to_targets(states[i], weights_, out.subspan(i * count, count));
            }};
  }

  FoundPath path_of(const search::Result& result, const Lattice& lattice, const LatticeChoice& choice) const override {
    std::vector<Eigen::VectorXd> rows = lattice.configurations(result.path);
    if (choice.from_goals()) std::reverse(rows.begin(), rows.end());
    rows.front() = space_.start();  // unwrapped from the start on
    FoundPath found{.path = space_.path(rows), .graph = describe(choice), .found_by = "composite lattice"};
    found.cost = found.path.length();
    return found;
  }

  std::string describe(const LatticeChoice& choice) const override {
    return "the composite lattice of " + to_text(choice.scale) + " times the resolution from " +
           (choice.from_goals() ? "the goals" : "the start");
  }
  std::string no_path_sentence(const search::Result& result, const std::string& no_path) const override {
    return no_path + " path (" + std::string(to_string(result.status)) + ")";
  }

 private:
  PrimitiveSet primitives(double scale) const {
    const MultiRobotWorld::Options& lattice = space_.world().options();
    const Eigen::VectorXd step = lattice_step(space_.joints(), scale * std::min(lattice.resolution, M_PI / 2 / scale),
                                              scale * lattice.prismatic_resolution);
    PrimitiveSet set = rich_primitives(space_.joints(), step, pairs_);
    PrimitiveFamily one_robot{"one robot", PrimitiveUse::to_targets, {}};  // the others stay
    const Eigen::VectorXd& all = set.families.front().moves.front();
    for (std::size_t i = 0; i < space_.size(); ++i) {
      Eigen::VectorXd& move = one_robot.moves.emplace_back(Eigen::VectorXd::Zero(step.size()));
      space_.part(move, i) = space_.part(all, i);
    }
    set.families.push_back(std::move(one_robot));
    return set;
  }

  /// All joints alike; those near the bases counting for more; those near the end effectors; and one robot after the
  /// other.
  void make_weights() {
    const std::size_t robots = space_.size();
    weights_ = RowMatrix::Ones(3 + static_cast<Eigen::Index>(robots), space_.first(robots));
    for (std::size_t i = 0; i < robots; ++i) {
      const Eigen::Index first = space_.first(i), last = space_.first(i + 1);
      weights_.block(0, first, 3, last - first) = distance_weights(static_cast<std::size_t>(last - first));
      weights_.row(3 + static_cast<Eigen::Index>(i)).segment(first, last - first).setConstant(3.0);
    }
  }

  const CompositeSpace& space_;
  std::vector<JointPair> pairs_;
  RowMatrix weights_;
};

}  // namespace

CompositeResult composite_search(const CompositeSpace& space, const CompositeOptions& options,
                                 const Deadline& deadline) {
  if (space.targets().empty()) return {};
  LatticePortfolioOptions portfolio{.weight = options.weight, .scales = {}, .max_expansions = options.max_expansions};
  for (const double scale : options.scales)
    if (scale >= 1.0 || options.max_expansions >= options.fine_from) portfolio.scales.push_back(scale);
  CompositeLattices lattices(space);
  LatticePortfolio searches(lattices, portfolio);
  Attempt attempt = searches.run(deadline);
  return {attempt.status, std::move(attempt.found.path), searches.statistics()};
}

}  // namespace srmp
