#include "srmp/cover/cover_store.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <boost/test/unit_test.hpp>
#include <future>
#include <thread>

using srmp::CoverSet;
using srmp::CoverStore;

BOOST_AUTO_TEST_SUITE(cover_store)

BOOST_AUTO_TEST_CASE(a_forked_process_computes_what_its_parent_was_computing) {
  CoverStore store("");
  const srmp::Sha256::Digest key = srmp::Sha256().digest();
  std::promise<void> begun, end;
  std::thread computing([&] {
    store.get(key, [&] {
      begun.set_value();
      end.get_future().wait();
      return CoverSet(1);
    });
  });
  begun.get_future().wait();
  const pid_t child = fork();
  if (child == 0) {
    alarm(20);  // instead of a wait for ever
    const bool is_unknown = !store.find(key);
    _exit(is_unknown && store.get(key, [] { return CoverSet(2); }).covers->size() == 2 ? 0 : 1);
  }
  int status = -1;
  waitpid(child, &status, 0);
  BOOST_TEST(status == 0);
  end.set_value();
  computing.join();
  BOOST_TEST(store.get(key, [] { return CoverSet(3); }).covers->size() == 1u);
}

BOOST_AUTO_TEST_SUITE_END()
