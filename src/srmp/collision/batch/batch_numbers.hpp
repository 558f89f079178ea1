#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <string>

#include "srmp/core/error.hpp"

/// What BatchRobotModel and BatchModel do with the numbers that they are given. Internal.
namespace srmp::batch {

constexpr double unit = 0x1p-24;  ///< half a unit in the last place of float32, relative

/// Conversions to float32 that round to the safe side.
inline float above(double x) {
  const auto f = static_cast<float>(x);
  return f >= x ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}
inline float below(double x) { return -above(-x); }

inline void copy_rotation(const Eigen::Matrix3d& rotation, float* out) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out[3 * r + c] = static_cast<float>(rotation(r, c));
}

/// A part of the world, for messages; the text is made only for what is refused.
struct Part {
  const char* kind;
  std::size_t number;
  std::string name() const { return std::string("batch checker: ") + kind + " " + std::to_string(number); }
};

inline void require(bool fine, const Part& part, const char* what) {
  if (!fine) throw InvalidArgument(part.name() + what);
}

[[noreturn]] inline void refuse_index(int index, std::size_t size, const Part& part, const char* what) {
  throw InvalidArgument(part.name() + ": its " + what + " is " + std::to_string(index) + "; there are " +
                        std::to_string(size));
}

inline void require_index(int index, std::size_t size, const Part& part, const char* what) {
  if (index < 0 || static_cast<std::size_t>(index) >= size) refuse_index(index, size, part, what);
}

}  // namespace srmp::batch
