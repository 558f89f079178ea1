#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "srmp/search/graph.hpp"

namespace srmp::search {

/// No limit on expansions.
inline constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();

/// A search of one graph that is done in slices and goes on where it stopped. How often it is stopped changes nothing
/// in what it finds.
class ResumableSearch {
 public:
  virtual ~ResumableSearch() = default;

  /// Expands until finished, or about `expansions` states more. Says why when it had to stop earlier.
  virtual std::optional<Status> improve(const Deadline& deadline, std::uint64_t expansions) = 0;
  /// Nothing is left to do: there is a path within the bound that the search guarantees, or the graph holds none.
  virtual bool finished() const = 0;
  /// The best path so far with its proven bound. Without a path the status is `stop`, or exhausted when it is empty.
  virtual Result result(std::optional<Status> stop) const = 0;
  virtual bool solved() const = 0;
  /// Of the best path; infinity while there is none.
  virtual double cost() const = 0;
  virtual Statistics statistics() const = 0;
};

}  // namespace srmp::search
