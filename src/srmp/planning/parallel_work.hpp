#pragma once

#include <functional>

#include "srmp/core/jobs.hpp"
#include "srmp/planning/result.hpp"
#include "srmp/planning/statistics.hpp"

namespace srmp {

/// Adds what a part of a plan took: times, counts, and its notes that are new; of memory the larger.
void add_work(PlanStatistics& sum, const PlanStatistics& part);

/// Parts of one plan, several at a time, each with statistics of its own, which are added to the plan's in order, up to
/// the first that throws: of times they hold the sum over the threads.
class ParallelWork {
 public:
  /// The statistics outlive this.
  ParallelWork(std::size_t threads, PlanStatistics& statistics) : jobs_(threads), statistics_(statistics) {}

  using Part = std::function<void(std::size_t i, const Deadline& deadline, PlanStatistics& statistics)>;
  /// As Jobs::run.
  void run(std::size_t count, const Deadline& deadline, const Part& part);

 private:
  Jobs jobs_;
  PlanStatistics& statistics_;
};

}  // namespace srmp
