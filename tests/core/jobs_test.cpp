#include "srmp/core/jobs.hpp"

#include <atomic>
#include <boost/test/unit_test.hpp>
#include <chrono>
#include <numeric>
#include <stdexcept>
#include <string>
#include <thread>

using srmp::Deadline;
using srmp::Jobs;

BOOST_AUTO_TEST_SUITE(jobs)

BOOST_AUTO_TEST_CASE(each_job_runs_once_on_any_number_of_threads) {
  for (const std::size_t threads : {0, 1, 2, 3, 8})
    for (const std::size_t count : {0, 1, 2, 100}) {
      std::vector<int> done(count, 0);
      Jobs(threads).run(count, Deadline(), [&](std::size_t i, const Deadline&) { ++done[i]; });
      BOOST_CHECK_EQUAL(std::accumulate(done.begin(), done.end(), 0), static_cast<int>(count));
      BOOST_CHECK(std::all_of(done.begin(), done.end(), [](int times) { return times == 1; }));
    }
}

BOOST_AUTO_TEST_CASE(threads_are_reused) {
  Jobs jobs(2);
  std::atomic<int> done{0};
  for (int round = 0; round < 50; ++round) jobs.run(5, Deadline(), [&](std::size_t, const Deadline&) { ++done; });
  BOOST_CHECK_EQUAL(done, 250);
}

BOOST_AUTO_TEST_CASE(the_exception_of_the_first_job_in_order_is_rethrown) {
  for (const std::size_t threads : {1, 2, 4})
    for (int repeat = 0; repeat < 20; ++repeat) {
      const auto run = [&] {
        Jobs(threads).run(20, Deadline(), [](std::size_t i, const Deadline&) {
          if (i == 3) std::this_thread::sleep_for(std::chrono::milliseconds(2));  // throws later than the jobs after it
          if (i >= 3) throw std::runtime_error(std::to_string(i));
        });
      };
      BOOST_CHECK_EXCEPTION(run(), std::runtime_error,
                            [](const std::runtime_error& error) { return error.what() == std::string("3"); });
    }
}

BOOST_AUTO_TEST_CASE(only_the_calling_thread_checks_the_deadline) {
  const std::thread::id caller = std::this_thread::get_id();
  std::atomic<bool> elsewhere{false};
  for (const std::size_t threads : {1, 2, 4}) {
    int asked = 0;
    const Deadline deadline(1e9, [&] {
      if (std::this_thread::get_id() != caller) elsewhere = true;
      return ++asked > 2;
    });
    std::atomic<int> stopped{0};
    Jobs(threads).run(6, deadline, [&](std::size_t, const Deadline& until) {
      while (!until.stop_requested()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      stopped += until.cancelled();
    });
    BOOST_CHECK_EQUAL(stopped, 6);
  }
  BOOST_CHECK(!elsewhere);
}

BOOST_AUTO_TEST_CASE(jobs_get_the_remaining_time) {
  for (const std::size_t threads : {1, 3}) {
    const Deadline deadline(0.02);
    std::atomic<int> expired{0};
    Jobs(threads).run(4, deadline, [&](std::size_t, const Deadline& until) {
      while (!until.expired()) std::this_thread::yield();
      expired += deadline.expired();
    });
    BOOST_CHECK_EQUAL(expired, 4);
  }
}

BOOST_AUTO_TEST_CASE(the_calling_thread_reports_progress_which_may_stop_the_run) {
  for (const std::size_t threads : {1, 2}) {
    std::vector<std::size_t> told;
    Jobs(threads).run(
        5, Deadline(), [](std::size_t, const Deadline&) {}, [&](std::size_t done) { told.push_back(done); });
    BOOST_REQUIRE(!told.empty());
    BOOST_CHECK(std::is_sorted(told.begin(), told.end()));
    BOOST_CHECK_EQUAL(told.back(), 5u);
    const auto refuse = [](std::size_t) { throw std::logic_error("enough"); };
    BOOST_CHECK_THROW(Jobs(threads).run(5, Deadline(), [](std::size_t, const Deadline&) {}, refuse), std::logic_error);
  }
}

BOOST_AUTO_TEST_SUITE_END()
