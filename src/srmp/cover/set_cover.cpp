#include "srmp/cover/set_cover.hpp"

#include <algorithm>
#include <limits>

#include "srmp/core/interruption.hpp"

namespace srmp {

namespace {

class Search {
 public:
  Search(const SetSystem& system, const std::vector<int>& cover)
      : system_(system),
        holders_(system.elements),
        times_(system.elements, 0),
        holder_sum_(system.elements, 0),
        weight_(system.elements, 1),
        place_(system.elements, kClosed),
        gain_(system.sets.size(), 0),
        loss_(system.sets.size(), 0),
        changed_(system.sets.size(), 0),
        barred_until_(system.sets.size(), 0) {
    for (const int s : cover)
      for (const std::uint32_t e : system.sets[s]) place_[e] = kOpen;  // is to be covered
    for (std::size_t s = 0; s < system.sets.size(); ++s)
      for (const std::uint32_t e : system.sets[s])
        if (place_[e] != kClosed) holders_[e].push_back(static_cast<int>(s));
    for (std::uint32_t e = 0; e < system.elements; ++e)
      if (place_[e] != kClosed) {
        open(e);
        for (const int s : holders_[e]) ++gain_[s];
      }
    for (const int s : cover) add(s);
    best_ = chosen_;
  }

  std::vector<int> run(std::size_t work) {
    for (work_ = 0; work_ < work && best_.size() > 1;) {
      if (open_.empty()) {
        best_ = chosen_;
        remove(cheapest());
        continue;
      }
      ++step_;
      const int dropped = cheapest();
      remove(dropped);
      barred_until_[dropped] = step_ + 2 + random() % 4;
      const int added = best_for(open_[random() % open_.size()]);
      add(added);
      for (const std::uint32_t e : open_) {
        ++weight_[e];
        for (const int s : holders_[e]) ++gain_[s];
        work_ += holders_[e].size();
      }
    }
    std::sort(best_.begin(), best_.end());
    return best_;
  }

 private:
  static constexpr std::int32_t kClosed = -1, kOpen = 0;

  std::uint32_t random() {
    return static_cast<std::uint32_t>((seed_ = seed_ * 6364136223846793005u + 1442695040888963407u) >> 33);
  }

  void open(std::uint32_t e) {
    place_[e] = static_cast<std::int32_t>(open_.size());
    open_.push_back(e);
  }
  void close(std::uint32_t e) {
    place_[open_.back()] = place_[e];
    open_[place_[e]] = open_.back();
    open_.pop_back();
  }

  void add(int s) {
    interruption_point();
    for (const std::uint32_t e : system_.sets[s]) {
      if (holders_[e].empty()) continue;
      if (times_[e] == 0) {
        close(e);
        for (const int other : holders_[e]) gain_[other] -= weight_[e];
        loss_[s] += weight_[e];
        work_ += holders_[e].size();
      } else if (times_[e] == 1) {
        loss_[holder_sum_[e]] -= weight_[e];
      }
      ++times_[e];
      holder_sum_[e] += s;
    }
    chosen_.push_back(s);
    changed_[s] = step_;
    work_ += system_.sets[s].size();
  }

  void remove(int s) {
    for (const std::uint32_t e : system_.sets[s]) {
      if (holders_[e].empty()) continue;
      --times_[e];
      holder_sum_[e] -= s;
      if (times_[e] == 0) {
        open(e);
        for (const int other : holders_[e]) gain_[other] += weight_[e];
        loss_[s] -= weight_[e];
        work_ += holders_[e].size();
      } else if (times_[e] == 1) {
        loss_[holder_sum_[e]] += weight_[e];
      }
    }
    chosen_.erase(std::find(chosen_.begin(), chosen_.end(), s));
    changed_[s] = step_;
    work_ += system_.sets[s].size();
  }

  /// The chosen set whose removal loses the least weight; of equals, the one that was added longest ago.
  int cheapest() const {
    return *std::min_element(chosen_.begin(), chosen_.end(), [&](int a, int b) {
      return std::pair(loss_[a], changed_[a]) < std::pair(loss_[b], changed_[b]);
    });
  }

  /// The set that covers this element and gains the most weight; sets removed a few steps ago are barred.
  int best_for(std::uint32_t e) const {
    int best = -1;
    for (const int s : holders_[e]) {
      if (barred_until_[s] > step_) continue;
      if (best < 0 || gain_[s] > gain_[best] || (gain_[s] == gain_[best] && changed_[s] < changed_[best])) best = s;
    }
    return best < 0 ? holders_[e].front() : best;
  }

  const SetSystem& system_;
  std::vector<std::vector<int>>
      holders_;                           // sets that contain each element; empty for elements that need not be covered
  std::vector<int> times_;                // how many chosen sets contain each element
  std::vector<std::int64_t> holder_sum_;  // sum of the chosen sets that contain it: the set itself when there is one
  std::vector<std::int64_t> weight_;
  std::vector<std::int32_t> place_;  // in open_
  std::vector<std::uint32_t> open_;  // elements not covered
  std::vector<std::int64_t> gain_;   // weight of open elements in the set
  std::vector<std::int64_t> loss_;   // weight of elements that only this chosen set contains
  std::vector<std::uint64_t> changed_, barred_until_;
  std::vector<int> chosen_, best_;
  std::uint64_t seed_{1}, step_{0};
  std::size_t work_{0};
};

}  // namespace

std::vector<int> smaller_cover(const SetSystem& system, const std::vector<int>& cover, std::size_t work) {
  return Search(system, cover).run(work);
}

}  // namespace srmp
