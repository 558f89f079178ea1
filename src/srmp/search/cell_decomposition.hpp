#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

namespace srmp::search {

/// A closed box of points.
struct Cell {
  Eigen::VectorXd low, high;
};

enum class CellLabel {
  free,     ///< all points are
  blocked,  ///< none is free
  mixed,    ///< or not known
};

/// Looks for a proof that no path leads from one point of a box to another: approximate cell decomposition (Zhu,
/// Latombe 1991, "New heuristic algorithms for efficient hierarchical path planning"; Zhang, Kim, Manocha 2008,
/// "Efficient cell labelling and path non-existence computation using C-obstacle query"). Of the cells that are not
/// blocked, those on a way through the fewest mixed cells are halved, until no way is left or one leads through free
/// cells alone.
class CellDecomposition {
 public:
  static constexpr std::size_t no_cell = std::numeric_limits<std::size_t>::max();

  struct Problem {
    Cell whole;
    std::vector<char> wraps;   ///< by axis: are the two ends the same? Empty: none is
    Eigen::VectorXd from, to;  ///< in `whole`; both are free
    double min_width{1e-3};    ///< cells are not made smaller
  };
  /// Labels a new cell, which is half of cell `parent` (no_cell: of none). Cells are numbered as they are labelled.
  using Label = std::function<CellLabel(const Cell& cell, std::size_t parent)>;

  CellDecomposition(Problem problem, Label label) : problem_(std::move(problem)), label_(std::move(label)) {}

  enum class Outcome {
    unfinished,
    no_path,   ///< proved
    unproved,  ///< there is a path, or what blocks it is smaller than cells can be
  };
  /// Goes on until an outcome is known or `max_cells` are labelled in all.
  Outcome run(std::size_t max_cells);
  std::size_t cells() const { return nodes_.size(); }
  const Cell& cell(std::size_t number) const { return nodes_[number].cell; }
  /// Once there is no_path: the blocked cells next to those that can be reached.
  const std::vector<std::size_t>& barrier() const { return barrier_; }

 private:
  struct Node {
    Cell cell;
    CellLabel label;
    std::size_t child{no_cell};  // the first of two
    Eigen::Index axis{};         // across which it is halved
  };

  void add(Cell cell, std::size_t parent);
  std::size_t leaf_at(const Eigen::VectorXd& point) const;
  bool halve(std::size_t leaf);
  std::vector<std::size_t> shortest_way();
  template <class Visit>
  void for_each_neighbour(std::size_t leaf, Visit&& visit) const;
  template <class Visit>
  void for_each_leaf_beside(std::size_t node, const Cell& face, Eigen::Index axis, bool above, Visit& visit) const;

  const Problem problem_;
  const Label label_;
  std::vector<Node> nodes_;
  std::vector<std::size_t> barrier_;
  Outcome outcome_{Outcome::unfinished};
};

}  // namespace srmp::search
