#pragma once

#include <functional>
#include <string>
#include <vector>

#include "fuzz/mutate.hpp"

namespace fuzz {

/// A way into the library for what others have written. `enter` may throw srmp::Error and nothing else.
struct Door {
  std::string name;
  std::string seeds;  ///< files of tests/fuzz/seeds whose names begin so; "": the input is made of `random`
  std::size_t cases;  ///< in the normal test run: a few seconds
  std::function<void(const std::string& input, Random& random)> enter;
  bool words{false};  ///< only words and lines of the seeds are changed, no bytes: mutate_words
};

/// All doors. `directory` is for the files that they read.
std::vector<Door> all_doors(const std::string& directory);

}  // namespace fuzz
