#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <limits>
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
/// blocked, those on a path with the fewest mixed cells are halved, until there is no path or one of free cells alone.
class CellDecomposition {
 public:
  static constexpr std::size_t no_cell = std::numeric_limits<std::size_t>::max();

  struct Space {
    Cell whole;
    std::vector<char> wraps{};  ///< by axis: are the two ends the same? Empty: none is
    double min_width{1e-3};     ///< cells are not made smaller
  };
  /// Labels a new cell, which is half of cell `parent` (no_cell: of none). Cells are numbered as they are labelled.
  using Label = std::function<CellLabel(const Cell& cell, std::size_t parent)>;

  CellDecomposition(Space space, Label label);

  enum class Outcome {
    unfinished,
    no_path,   ///< proved
    unproved,  ///< there is a path, or what blocks it is smaller than cells can be, or an end is not free
  };
  /// Goes on with a path between two points of the space until an outcome is known or `max_cells` are labelled in all.
  /// Labels do not depend on the points.
  Outcome run(const Eigen::VectorXd& from, const Eigen::VectorXd& to, std::size_t max_cells);
  std::size_t cells() const { return nodes_.size(); }
  /// Cells that searches for paths have visited, of which some hundreds take as long as a label.
  std::size_t visits() const { return visits_; }
  const Cell& cell(std::size_t number) const { return nodes_[number].cell; }
  /// If the last outcome is no_path: the blocked cells next to those that can be reached.
  const std::vector<std::size_t>& barrier() const { return barrier_; }

 private:
  struct Node {
    Cell cell;
    CellLabel label;
    std::vector<std::size_t> neighbours{};  // of a leaf: leaves with which it shares a part of a face
    std::size_t child{no_cell};             // the first of two
    Eigen::Index axis{};                    // across which it is halved
  };

  bool contains(const Eigen::VectorXd& point) const;
  void add(Cell cell, std::size_t parent);
  std::size_t leaf_at(const Eigen::VectorXd& point) const;
  bool halve(std::size_t leaf);
  bool are_neighbours(const Cell& a, const Cell& b) const;
  std::vector<std::size_t> find_path(std::size_t first, std::size_t last);

  const Space space_;
  const Label label_;
  std::vector<Node> nodes_;
  std::size_t visits_{};
  std::vector<std::size_t> barrier_;
};

}  // namespace srmp::search
