#include "srmp/planner/plan_many.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>

#include "srmp/core/worker_pool.hpp"

namespace srmp {

namespace {

constexpr auto watch_period = std::chrono::milliseconds(10);

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

/// One call of plan_many: workers take the next request each, the caller keeps watch.
class ManyPlans {
 public:
  ManyPlans(const std::vector<SingleRobotProblem>& problems, const Deadline::Interrupt& interrupt,
            const PlannerInterface::Progress& progress)
      : problems_(problems),
        clock_(std::numeric_limits<double>::infinity(), interrupt),
        progress_(progress),
        results_(problems.size()) {}

  std::vector<PlanResult> run(std::size_t threads) {
    WorkerPool pool(threads + 1);
    pool.run(threads + 1, [this](std::size_t worker, std::size_t) { worker == 0 ? watch() : work(); });
    for (const std::exception_ptr& error : {watch_error_, error_})
      if (error) std::rethrow_exception(error);
    return std::move(results_);
  }

 private:
  void work() {
    for (std::size_t i; (i = next_++) < problems_.size();) {
      try {
        if (i < wrong_) results_[i] = answer(problems_[i]);
      } catch (...) {
        note_error(i, std::current_exception());
      }
      const std::lock_guard lock(mutex_);
      ++done_;
      changed_.notify_one();
    }
  }

  PlanResult answer(const SingleRobotProblem& problem) const {
    PlanStatistics statistics;
    if (stop_) {
      statistics.status = Status::cancelled;
      statistics.reason = "the plan was cancelled before it began";
      return PlanResult(statistics);
    }
    const Deadline deadline(common_options(problem.options).time_limit, [this] { return stop_.load(); });
    try {
      Trajectory trajectory = plan_single_robot(problem, deadline, statistics);
      return PlanResult(statistics, std::move(trajectory));
    } catch (const PlanningError&) {
      return PlanResult(statistics);
    }
  }

  /// Of several wrong questions the first is told, whichever was noticed first: those before it are still asked.
  void note_error(std::size_t request, std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    if (request >= wrong_) return;
    wrong_ = request;
    try {
      name_request(request, [&] { std::rethrow_exception(error); });
    } catch (...) {
      error_ = std::current_exception();
    }
  }

  void watch() {
    std::unique_lock lock(mutex_);
    for (std::size_t told = 0; told < problems_.size();) {
      changed_.wait_for(lock, watch_period, [&] { return done_ > told; });
      const std::size_t done = done_;
      lock.unlock();
      if (!stop_) report(done, done > told);
      told = done;
      lock.lock();
    }
  }

  void report(std::size_t done, bool news) {
    try {
      stop_ = clock_.cancelled();
      if (news && progress_ && !stop_) progress_(done, problems_.size());
    } catch (...) {
      watch_error_ = std::current_exception();
      stop_ = true;
    }
  }

  const std::vector<SingleRobotProblem>& problems_;
  const Deadline clock_;
  const PlannerInterface::Progress& progress_;
  std::vector<PlanResult> results_;
  std::atomic<std::size_t> next_{0};
  std::atomic<std::size_t> wrong_{std::numeric_limits<std::size_t>::max()};  // request that error_ speaks of
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t done_{0};
  std::exception_ptr error_, watch_error_;
};

}  // namespace

std::vector<PlanResult> plan_many(const std::vector<PlanRequest>& requests, const PoseProblem& pose,
                                  std::size_t threads, const Deadline::Interrupt& interrupt,
                                  const PlannerInterface::Progress& progress) {
  std::vector<SingleRobotProblem> problems;
  for (std::size_t i = 0; i < requests.size(); ++i)
    problems.push_back(name_request(i, [&] { return pose(requests[i]); }));
  return ManyPlans(problems, interrupt, progress).run(std::clamp<std::size_t>(requests.size(), 1, threads));
}

}  // namespace srmp
