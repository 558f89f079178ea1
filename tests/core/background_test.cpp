#include "srmp/core/background.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <future>
#include <vector>

#include "srmp/core/interruption.hpp"
#include "srmp/core/steps.hpp"

using namespace srmp;

namespace {

struct Stop {};

/// A computation that ends when it is interrupted, and only then.
void run_until_interrupted() {
  for (;;) interruption_point();
}

}  // namespace

BOOST_AUTO_TEST_CASE(jobs_in_the_background_run_in_their_order) {
  std::vector<int> order;
  std::promise<void> ended;
  std::vector<Background::Ticket> tickets;
  for (int i = 0; i < 3; ++i)
    tickets.push_back(Background::submit([&, i](const std::atomic<bool>&) {
      order.push_back(i);
      if (i == 1) throw Stop();
      if (i == 2) ended.set_value();
    }));
  ended.get_future().wait();
  BOOST_TEST(order == (std::vector<int>{0, 1, 2}), boost::test_tools::per_element());
}

BOOST_AUTO_TEST_CASE(a_ticket_that_ends_stops_its_job) {
  std::promise<void> begun;
  std::atomic<bool> second{false};
  Background::Ticket running = Background::submit([&](const std::atomic<bool>& stop) {
    begun.set_value();
    const InterruptionScope scope([&] {
      if (stop) throw Stop();
    });
    run_until_interrupted();
  });
  begun.get_future().wait();
  Background::Ticket queued = Background::submit([&](const std::atomic<bool>&) { second = true; });
  queued.cancel();
  running = Background::Ticket();  // returns once the job has ended
  std::promise<void> third;
  const Background::Ticket last = Background::submit([&](const std::atomic<bool>&) { third.set_value(); });
  third.get_future().wait();
  BOOST_TEST(!second);
}

BOOST_AUTO_TEST_CASE(a_forked_process_has_a_background_of_its_own) {
  std::promise<void> begun;
  const Background::Ticket running = Background::submit([&](const std::atomic<bool>& stop) {
    begun.set_value();
    while (!stop) usleep(100);
  });
  begun.get_future().wait();
  const pid_t child = fork();
  if (child == 0) {
    std::promise<void> ended;
    const Background::Ticket own = Background::submit([&](const std::atomic<bool>&) { ended.set_value(); });
    const auto status = ended.get_future().wait_for(std::chrono::seconds(20));
    _exit(status == std::future_status::ready ? 0 : 1);
  }
  int status = -1;
  waitpid(child, &status, 0);
  BOOST_TEST(status == 0);
}

BOOST_AUTO_TEST_CASE(the_innermost_scope_interrupts) {
  int outer = 0;
  const InterruptionScope scope([&] { ++outer; });
  {
    const InterruptionScope inner([] { throw Stop(); });
    BOOST_CHECK_THROW(run_until_interrupted(), Stop);
  }
  BOOST_TEST(outer == 0);
  while (outer == 0) interruption_point();
}

BOOST_AUTO_TEST_CASE(the_caller_can_end_the_last_step_that_runs) {
  const auto last_is_long = [](std::size_t i) {
    if (i == 1) run_until_interrupted();
  };
  for (const std::size_t threads : {1, 3}) {
    int calls = 0;
    Steps told(threads, 2, [&](std::size_t, std::size_t) {
      if (++calls > 3) throw Stop();
    });
    BOOST_CHECK_THROW(told.run(2, last_is_long), Stop);
    int checks = 0;
    const InterruptionScope scope([&] {
      if (++checks > 3) throw Stop();
    });
    BOOST_CHECK_THROW(Steps(threads, 2, {}).run(2, last_is_long), Stop);
  }
}

BOOST_AUTO_TEST_CASE(steps_end_early_when_one_fails_or_progress_throws) {
  for (const std::size_t threads : {1, 3}) {
    Steps failing(threads, 6, {});
    const auto fail = [](std::size_t i) {
      if (i == 1) throw Stop();
      if (i > 2) run_until_interrupted();
    };
    if (threads == 3) BOOST_CHECK_THROW(failing.run(6, fail), Stop);
    int calls = 0;
    Steps stopped(threads, 2, [&](std::size_t, std::size_t total) {
      BOOST_TEST(total == 2u);
      if (++calls > 3) throw Stop();
    });
    BOOST_CHECK_THROW(stopped.run(2, [](std::size_t) { run_until_interrupted(); }), Stop);
    std::vector<char> done(5, 0);
    std::size_t last = 0;
    Steps steps(threads, 5, [&](std::size_t n, std::size_t) { last = n; });
    steps.run(5, [&](std::size_t i) { done[i] = 1; });
    BOOST_TEST(last == 5u);
    BOOST_TEST(std::count(done.begin(), done.end(), 1) == 5);
  }
}
