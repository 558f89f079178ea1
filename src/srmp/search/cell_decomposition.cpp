#include "srmp/search/cell_decomposition.hpp"

#include <algorithm>
#include <deque>
#include <utility>

namespace srmp::search {

CellDecomposition::CellDecomposition(Space space, Label label) : space_(std::move(space)), label_(std::move(label)) {}

CellDecomposition::Outcome CellDecomposition::run(const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                                                  std::size_t max_cells) {
  if (!contains(from) || !contains(to)) return Outcome::unproved;
  if (nodes_.empty() && max_cells > 0) add(space_.whole, no_cell);
  while (nodes_.size() + 2 <= max_cells) {
    const std::size_t first = leaf_at(from), last = leaf_at(to);
    if (nodes_[first].label == CellLabel::blocked || nodes_[last].label == CellLabel::blocked) return Outcome::unproved;
    const std::vector<std::size_t> path = find_path(first, last);
    if (path.empty()) return Outcome::no_path;
    bool has_halved = false, may_go_on = true;
    for (const std::size_t leaf : path)
      if (nodes_[leaf].label == CellLabel::mixed && (may_go_on = nodes_.size() + 2 <= max_cells))
        has_halved = halve(leaf) || has_halved;
    if (!has_halved && may_go_on) return Outcome::unproved;
  }
  return Outcome::unfinished;
}

bool CellDecomposition::contains(const Eigen::VectorXd& point) const {
  return (space_.whole.low.array() <= point.array()).all() && (point.array() <= space_.whole.high.array()).all();
}

void CellDecomposition::add(Cell cell, std::size_t parent) {
  const CellLabel label = label_(cell, parent);
  nodes_.push_back({.cell = std::move(cell), .label = label});
}

/// false: it would be too small.
bool CellDecomposition::halve(std::size_t leaf) {
  Cell below = nodes_[leaf].cell, above = below;
  Eigen::Index axis = 0;
  if ((below.high - below.low).maxCoeff(&axis) < 2 * space_.min_width) return false;
  below.high[axis] = above.low[axis] = (below.low[axis] + below.high[axis]) / 2;
  const std::size_t child = nodes_.size();
  add(std::move(below), leaf);
  add(std::move(above), leaf);
  nodes_[leaf].axis = axis;
  nodes_[leaf].child = child;
  nodes_[child].neighbours.push_back(child + 1);
  nodes_[child + 1].neighbours.push_back(child);
  for (const std::size_t neighbour : std::exchange(nodes_[leaf].neighbours, {})) {
    std::erase(nodes_[neighbour].neighbours, leaf);
    for (const std::size_t half : {child, child + 1})
      if (are_neighbours(nodes_[half].cell, nodes_[neighbour].cell)) {
        nodes_[half].neighbours.push_back(neighbour);
        nodes_[neighbour].neighbours.push_back(half);
      }
  }
  return true;
}

/// Through a corner of cells no path needs to lead: cells are closed, so those around a corner that are not blocked
/// are connected by faces if the corner is not in a blocked one.
bool CellDecomposition::are_neighbours(const Cell& a, const Cell& b) const {
  const Cell& whole = space_.whole;
  Eigen::Index overlapping = 0;
  bool touch = false;
  for (Eigen::Index k = 0; k < a.low.size(); ++k) {
    const bool fixed = whole.low[k] == whole.high[k];
    if (fixed || (a.low[k] < b.high[k] && b.low[k] < a.high[k])) {
      ++overlapping;
      continue;
    }
    const bool at_ends = (a.low[k] == whole.low[k] && b.high[k] == whole.high[k]) ||
                         (b.low[k] == whole.low[k] && a.high[k] == whole.high[k]);
    touch = a.high[k] == b.low[k] || b.high[k] == a.low[k] ||
            (at_ends && !space_.wraps.empty() && space_.wraps[static_cast<std::size_t>(k)]);
  }
  return touch && overlapping + 1 == a.low.size();
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

/// Breadth first through leaves that are not blocked, free ones before mixed ones, so that as few as possible are
/// mixed. Empty where there is none; then barrier_ is complete.
std::vector<std::size_t> CellDecomposition::find_path(std::size_t first, std::size_t last) {
  barrier_.clear();
  std::vector<std::size_t> before(nodes_.size(), no_cell), mixed(nodes_.size(), no_cell);  // mixed ones up to a leaf
  std::deque<std::size_t> open{first};
  mixed[first] = nodes_[first].label == CellLabel::mixed;
  std::vector<char> done(nodes_.size());
  while (!open.empty()) {
    const std::size_t leaf = open.front();
    open.pop_front();
    if (std::exchange(done[leaf], 1)) continue;
    ++visits_;
    if (leaf == last) {
      std::vector<std::size_t> path{last};
      while (path.back() != first) path.push_back(before[path.back()]);
      return path;
    }
    for (const std::size_t next : nodes_[leaf].neighbours) {
      const CellLabel label = nodes_[next].label;
      if (label == CellLabel::blocked) {
        if (!std::exchange(done[next], 1)) barrier_.push_back(next);
        continue;
      }
      const std::size_t count = mixed[leaf] + (label == CellLabel::mixed);
      if (count >= mixed[next]) continue;
      mixed[next] = count;
      before[next] = leaf;
      label == CellLabel::mixed ? open.push_back(next) : open.push_front(next);
    }
  }
  return {};
}

}  // namespace srmp::search
