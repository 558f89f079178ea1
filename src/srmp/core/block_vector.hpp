#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace srmp {

/// A sequence that grows at its end, held in blocks of 4096 elements that stay where they are: however long it is, no
/// single call moves more than a block. That keeps searches with millions of states from pausing where a vector would
/// be copied. An access costs one load more than that of a vector.
template <class T>
class BlockVector {
 public:
  static constexpr std::size_t block_size = 4096;

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  std::size_t memory() const {
    return blocks_.empty() ? 0 : ((blocks_.size() - 1) * block_size + blocks_.front().capacity()) * sizeof(T);
  }

  const T& operator[](std::size_t i) const { return blocks_[i / block_size][i % block_size]; }
  T& operator[](std::size_t i) { return blocks_[i / block_size][i % block_size]; }
  const T& front() const { return blocks_.front().front(); }
  const T& back() const { return (*this)[size_ - 1]; }

  /// The first block grows as a vector does, so short sequences are small.
  void push_back(T value) {
    if (size_ == blocks_.size() * block_size) {
      blocks_.emplace_back();
      if (blocks_.size() > 1) blocks_.back().reserve(block_size);
    }
    blocks_[size_++ / block_size].push_back(std::move(value));
  }
  void pop_back() { blocks_[--size_ / block_size].pop_back(); }
  void clear() {
    for (std::vector<T>& block : blocks_) block.clear();
    size_ = 0;
  }
  /// Appends copies of `value` until there are `size` elements.
  void grow_to(std::size_t size, const T& value) {
    while (size_ < size) push_back(value);
  }

  /// Calls f(element) for each in turn.
  template <class F>
  void for_each(F&& f) const {
    for (const std::vector<T>& block : blocks_) std::for_each(block.begin(), block.end(), f);
  }

 private:
  std::vector<std::vector<T>> blocks_;
  std::size_t size_{0};
};

}  // namespace srmp
