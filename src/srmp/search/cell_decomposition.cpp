#include "srmp/search/cell_decomposition.hpp"

#include <algorithm>
#include <deque>
#include <utility>

namespace srmp::search {

CellDecomposition::Outcome CellDecomposition::run(std::size_t max_cells) {
  if (nodes_.empty() && max_cells > 0) add(problem_.whole, no_cell);
  while (outcome_ == Outcome::unfinished && nodes_.size() < max_cells) {
    const std::vector<std::size_t> way = shortest_way();
    if (way.empty()) {
      outcome_ = barrier_.empty() ? Outcome::unproved : Outcome::no_path;
      break;
    }
    bool halved = false;
    for (const std::size_t leaf : way)
      if (nodes_[leaf].label == CellLabel::mixed && nodes_.size() < max_cells) halved = halve(leaf) || halved;
    if (!halved) outcome_ = Outcome::unproved;
  }
  return outcome_;
}

void CellDecomposition::add(Cell cell, std::size_t parent) {
  const CellLabel label = label_(cell, parent);
  nodes_.push_back({.cell = std::move(cell), .label = label});
}

bool CellDecomposition::halve(std::size_t leaf) {
  const Cell cell = nodes_[leaf].cell;
  Eigen::Index axis = 0;
  const double width = (cell.high - cell.low).maxCoeff(&axis);
  if (width < 2 * problem_.min_width) return false;
  const double middle = (cell.low[axis] + cell.high[axis]) / 2;
  nodes_[leaf].axis = axis;
  const std::size_t child = nodes_.size();
  Cell below = cell, above = cell;
  below.high[axis] = above.low[axis] = middle;
  add(std::move(below), leaf);
  add(std::move(above), leaf);
  nodes_[leaf].child = child;
  return true;
}

std::size_t CellDecomposition::leaf_at(const Eigen::VectorXd& point) const {
  std::size_t at = 0;
  while (nodes_[at].child != no_cell) {
    const std::size_t below = nodes_[at].child;
    const Eigen::Index axis = nodes_[at].axis;
    at = point[axis] <= nodes_[below].cell.high[axis] ? below : below + 1;
  }
  return at;
}

/// The leaves below `node` that have a part of the face in theirs: that of `face` at its upper or lower end of `axis`.
template <class Visit>
void CellDecomposition::for_each_leaf_beside(std::size_t node, const Cell& face, Eigen::Index axis, bool above,
                                             Visit& visit) const {
  const Cell& cell = nodes_[node].cell;
  for (Eigen::Index k = 0; k < cell.low.size(); ++k)
    if (k != axis && !(cell.low[k] < face.high[k] && face.low[k] < cell.high[k])) return;
  const double at = above ? face.high[axis] : face.low[axis];
  const bool beside = above ? cell.low[axis] <= at && at < cell.high[axis]   //
                            : cell.low[axis] < at && at <= cell.high[axis];  //
  if (!beside) return;
  if (nodes_[node].child == no_cell) return visit(node);
  for (const std::size_t child : {nodes_[node].child, nodes_[node].child + 1})
    for_each_leaf_beside(child, face, axis, above, visit);
}

template <class Visit>
void CellDecomposition::for_each_neighbour(std::size_t leaf, Visit&& visit) const {
  const Cell& cell = nodes_[leaf].cell;
  const Cell& whole = problem_.whole;
  for (Eigen::Index axis = 0; axis < cell.low.size(); ++axis)
    for (const bool above : {false, true}) {
      Cell face = cell;
      const bool at_end = above ? cell.high[axis] == whole.high[axis] : cell.low[axis] == whole.low[axis];
      if (at_end) {
        if (problem_.wraps.empty() || !problem_.wraps[static_cast<std::size_t>(axis)]) continue;
        (above ? face.high : face.low)[axis] = above ? whole.low[axis] : whole.high[axis];
      }
      for_each_leaf_beside(0, face, axis, above, visit);
    }
}

/// From the one point to the other through leaves that are not blocked, of which as few as possible are mixed; empty
/// when there is none, with barrier_ then. (Breadth first, free leaves before mixed ones.)
std::vector<std::size_t> CellDecomposition::shortest_way() {
  const std::size_t first = leaf_at(problem_.from), last = leaf_at(problem_.to);
  barrier_.clear();
  if (nodes_[first].label == CellLabel::blocked || nodes_[last].label == CellLabel::blocked)
    return {};  // an end is not free: nothing is proved
  std::vector<std::size_t> before(nodes_.size(), no_cell), mixed(nodes_.size(), no_cell);
  std::vector<char> done(nodes_.size()), is_barrier(nodes_.size());
  std::deque<std::size_t> open{first};
  mixed[first] = nodes_[first].label == CellLabel::mixed;
  while (!open.empty()) {
    const std::size_t leaf = open.front();
    open.pop_front();
    if (std::exchange(done[leaf], 1)) continue;
    if (leaf == last) {
      barrier_.clear();
      std::vector<std::size_t> way{last};
      while (way.back() != first) way.push_back(before[way.back()]);
      return way;
    }
    for_each_neighbour(leaf, [&](std::size_t next) {
      const CellLabel label = nodes_[next].label;
      if (label == CellLabel::blocked) {
        if (!std::exchange(is_barrier[next], 1)) barrier_.push_back(next);
        return;
      }
      const std::size_t count = mixed[leaf] + (label == CellLabel::mixed);
      if (count >= mixed[next]) return;
      mixed[next] = count;
      before[next] = leaf;
      label == CellLabel::mixed ? open.push_back(next) : open.push_front(next);
    });
  }
  return {};
}

}  // namespace srmp::search
