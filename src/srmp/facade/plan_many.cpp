#include "srmp/facade/plan_many.hpp"

#include <limits>

#include "srmp/core/jobs.hpp"
#include "srmp/planning/pipeline.hpp"

namespace srmp {

namespace {

/// Runs `call`; what it refuses says which request was meant.
template <class Call>
auto name_request(std::size_t number, Call&& call) {
  const std::string where = "request " + std::to_string(number) + ": ";
  try {
    return call();
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(where + error.what());
  } catch (const FileError& error) {
    throw FileError(where + error.what());
  } catch (const NotSupported& error) {
    throw NotSupported(where + error.what());
  }
}

PlanResult solve(const PlanProblem& problem, const Deadline& until) {
  PlanStatistics statistics;
  if (until.cancelled()) {
    statistics.status = Status::cancelled;
    statistics.reason = "the plan was cancelled before it began";
    return PlanResult(statistics);
  }
  const Deadline deadline(common_options(problem.options).time_limit, [&] { return until.cancelled(); });
  try {
    MultiTrajectory motions = run_pipeline(problem, deadline, statistics);
    return PlanResult(statistics, std::move(motions.robots.begin()->second));
  } catch (const PlanningError&) {
    return PlanResult(statistics);
  }
}

}  // namespace

std::vector<PlanResult> plan_many(const std::vector<PlanRequest>& requests, const MakeProblem& make_problem,
                                  std::size_t threads, const Deadline::Interrupt& interrupt,
                                  const PlanProgress& progress) {
  std::vector<OwnedProblem> problems;
  for (std::size_t i = 0; i < requests.size(); ++i)
    problems.push_back(name_request(i, [&] { return make_problem(requests[i]); }));
  std::vector<PlanResult> results(problems.size());
  const Deadline no_limit(std::numeric_limits<double>::infinity(), interrupt);
  const auto told = [&](std::size_t done) {
    if (progress) progress(done, problems.size());
  };
  Jobs(threads).run(
      problems.size(), no_limit,
      [&](std::size_t i, const Deadline& until) {
        results[i] = name_request(i, [&] { return solve(*problems[i].problem, until); });
      },
      told);
  return results;
}

}  // namespace srmp
