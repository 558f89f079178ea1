#pragma once

#include <Eigen/Core>
#include <string>

namespace srmp {

struct Trajectory;

namespace detail {

// What the functions of a Trajectory refuse, by InvalidArgument.

[[noreturn]] void refuse(const std::string& why);
void require_shapes(const Trajectory& t);
/// A trajectory with times.
void require_motion(const Trajectory& t);
void require_times(const Eigen::VectorXd& times);
/// Returns the time unless it is NaN.
double require_time(double t, const char* what);

}  // namespace detail
}  // namespace srmp
