#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "srmp/core/block_vector.hpp"
#include "srmp/search/graph.hpp"

namespace srmp::search {

/// OPEN: a 4-ary heap of states that knows each state's position, so that keys can change in place.
///
/// The order is total: smaller priority first, then smaller heuristic, then smaller insertion number (first in, first
/// out). A state gets a new number whenever its key changes. It grows in blocks, without pauses. Keys must not be NaN.
class OpenList {
 public:
  struct Entry {
    double priority{};
    double heuristic{};
    std::uint64_t number{};
    StateId state{no_state};
  };

  bool empty() const { return heap_.empty(); }
  std::size_t size() const { return heap_.size(); }
  bool contains(StateId s) const { return s < position_.size() && position_[s] != nowhere; }
  std::size_t memory() const { return heap_.memory() + position_.memory(); }
  /// The first entry; OPEN must not be empty.
  const Entry& top() const { return heap_.front(); }
  /// The smallest priority; infinity when empty.
  double min_priority() const { return heap_.empty() ? infinity : heap_.front().priority; }
  /// All entries, in the order of the heap (deterministic, not sorted).
  const BlockVector<Entry>& entries() const { return heap_; }

  /// Inserts `s`, or changes its key (up or down). Setting the same key again changes nothing.
  void set(StateId s, double priority, double heuristic) {
    if (!contains(s)) return insert({priority, heuristic, next_number_++, s});
    const std::size_t at = position_[s];
    if (heap_[at].priority == priority && heap_[at].heuristic == heuristic) return;
    move_to_place(at, {priority, heuristic, next_number_++, s});
  }

  /// Inserts an entry that was popped again, with its old insertion number.
  void restore(const Entry& entry) { insert(entry); }

  Entry pop() {
    const Entry first = heap_.front();
    remove_at(0);
    return first;
  }

  void erase(StateId s) {
    if (contains(s)) remove_at(position_[s]);
  }

  void clear() {
    heap_.for_each([&](const Entry& entry) { position_[entry.state] = nowhere; });
    heap_.clear();
  }

  /// Gives every entry the priority `priority_of(entry)`, keeping the insertion numbers. O(n).
  template <class F>
  void reprioritise(F&& priority_of) {
    for (std::size_t at = 0; at < heap_.size(); ++at) heap_[at].priority = priority_of(std::as_const(heap_)[at]);
    for (std::size_t at = heap_.size(); at-- > 0;) sift_down(at, Entry(heap_[at]));
  }

 private:
  static constexpr std::size_t arity = 4;
  static constexpr std::uint32_t nowhere = std::numeric_limits<std::uint32_t>::max();

  static bool before(const Entry& a, const Entry& b) {
    if (a.priority != b.priority) return a.priority < b.priority;
    if (a.heuristic != b.heuristic) return a.heuristic < b.heuristic;
    return a.number < b.number;
  }

  void put(std::size_t at, const Entry& entry) {
    heap_[at] = entry;
    position_[entry.state] = static_cast<std::uint32_t>(at);
  }

  void insert(const Entry& entry) {
    position_.grow_to(std::size_t{entry.state} + 1, nowhere);
    heap_.push_back(entry);
    sift_up(heap_.size() - 1, entry);
  }

  void remove_at(std::size_t at) {
    position_[heap_[at].state] = nowhere;
    const Entry last = heap_.back();
    heap_.pop_back();
    if (at < heap_.size()) move_to_place(at, last);
  }

  void move_to_place(std::size_t at, const Entry& entry) {
    if (at > 0 && before(entry, heap_[(at - 1) / arity])) return sift_up(at, entry);
    sift_down(at, entry);
  }

  void sift_up(std::size_t at, const Entry entry) {
    while (at > 0) {
      const std::size_t parent = (at - 1) / arity;
      if (!before(entry, heap_[parent])) break;
      put(at, heap_[parent]);
      at = parent;
    }
    put(at, entry);
  }

  void sift_down(std::size_t at, const Entry entry) {
    for (std::size_t child = arity * at + 1; child < heap_.size(); child = arity * at + 1) {
      const std::size_t end = std::min(child + arity, heap_.size());
      for (std::size_t other = child + 1; other < end; ++other) {
        if (before(heap_[other], heap_[child])) child = other;
      }
      if (!before(heap_[child], entry)) break;
      put(at, heap_[child]);
      at = child;
    }
    put(at, entry);
  }

  BlockVector<Entry> heap_;
  BlockVector<std::uint32_t> position_;  ///< by state: its index in heap_
  std::uint64_t next_number_{};
};

}  // namespace srmp::search
