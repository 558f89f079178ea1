#pragma once

#include "srmp/core/deadline.hpp"

namespace srmp {

/// Adds the time from construction to destruction.
class PhaseTimer {
 public:
  PhaseTimer(const Deadline& clock, double& total) : clock_(clock), total_(total), start_(clock.elapsed()) {}
  ~PhaseTimer() { total_ += clock_.elapsed() - start_; }

 private:
  const Deadline& clock_;
  double& total_;
  double start_;
};

}  // namespace srmp
