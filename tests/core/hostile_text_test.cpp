#include <sys/stat.h>

#include <boost/test/unit_test.hpp>

#include "srmp/core/cache_file.hpp"
#include "srmp/core/error.hpp"
#include "srmp/core/lengths.hpp"
#include "srmp/core/run_interruptibly.hpp"
#include "srmp/core/sentence.hpp"
#include "srmp/core/utf8.hpp"
#include "support/files.hpp"
#include "support/throws.hpp"

using namespace srmp;

BOOST_AUTO_TEST_SUITE(utf8)

BOOST_AUTO_TEST_CASE(valid_text_of_every_length_is_accepted) {
  for (const char* text : {"", "plain", "\xc2\x80", "\xdf\xbf", "\xe0\xa0\x80", "\xed\x9f\xbf", "\xee\x80\x80",
                           "\xef\xbf\xbf", "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf", "a\xc3\xa9z"})
    BOOST_TEST(is_utf8(text));
}

BOOST_AUTO_TEST_CASE(the_first_byte_that_is_wrong_is_found) {
  for (const char* bad : {"\x80", "\xff", "\xc0\x80", "\xc1\xbf", "\xe0\x9f\xbf", "\xed\xa0\x80", "\xf0\x8f\xbf\xbf",
                          "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xc3", "\xe2\x82", "\xc3("})
    BOOST_TEST(find_invalid_utf8("ab" + std::string(bad)) == 2u);
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(sentences)

BOOST_AUTO_TEST_CASE(a_sentence_is_one_short_line_of_utf8) {
  BOOST_TEST(one_sentence("as it is: 'é'") == "as it is: 'é'");
  BOOST_TEST(one_sentence("two\nlines\r\n\tand\x7fmore") == "two lines and more");
  BOOST_TEST(one_sentence("byte \xff and \xc3") == "byte \\xff and \\xc3");
  std::string longer;
  for (int i = 0; i < 400; ++i) longer += "é";
  const std::string shorter = one_sentence("front " + longer + " back");
  BOOST_TEST(shorter.size() < 500u);
  BOOST_TEST(is_utf8(shorter));
  BOOST_TEST(shorter.starts_with("front "));
  BOOST_TEST(shorter.ends_with(" back"));
}

BOOST_AUTO_TEST_CASE(very_long_names_have_no_nearest_one) {
  const std::vector<std::string> known{std::string(1'000'000, 'a')};
  BOOST_TEST(did_you_mean(std::string(1'000'000, 'b'), known).empty());
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(lengths)

BOOST_AUTO_TEST_CASE(lengths_end_at_a_kilometre) {
  require_length(1000.0, "edge");
  check_throws<InvalidArgument>([] { require_length(1000.1, "edge"); }, "edge is 1000.1 m; at most 1000 m");
  check_throws<InvalidArgument>([] { require_length(0.0, "edge"); }, "above 0");
  require_position({-1000, 0, 1000}, "place");
  check_throws<InvalidArgument>([] { require_position({0, -1e80, 0}, "place"); }, "place is -1e+80 m from the origin");
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(interrupts)

struct Stop {};

BOOST_AUTO_TEST_CASE(the_innermost_scope_counts) {
  rare_interruption_point();  // none
  const InterruptionScope outer([] { throw Stop(); });
  std::this_thread::sleep_for(std::chrono::milliseconds(20));  // checks are about 10 ms apart
  BOOST_CHECK_THROW(rare_interruption_point(), Stop);
  {
    const InterruptionScope inner({});
    interruption_point();
  }
}

BOOST_AUTO_TEST_CASE(a_job_returns_its_result_and_its_exception) {
  BOOST_TEST(run_interruptibly([] { return 7; }) == 7);
  const InterruptionScope scope([] {});
  const auto caller = std::this_thread::get_id();
  BOOST_TEST(run_interruptibly([caller] { return std::this_thread::get_id() != caller; }));
  check_throws<InvalidArgument>([] { run_interruptibly([]() -> int { throw InvalidArgument("no"); }); }, "no");
  // A job within a job needs no further thread.
  BOOST_TEST(run_interruptibly([] {
    const auto worker = std::this_thread::get_id();
    return run_interruptibly([worker] { return std::this_thread::get_id() == worker; });
  }));
}

BOOST_AUTO_TEST_CASE(an_abandoned_job_ends_at_its_next_poll) {
  const auto ended = std::make_shared<std::promise<void>>();
  {
    const InterruptionScope scope([] { throw Stop(); });
    BOOST_CHECK_THROW(run_interruptibly([ended]() -> int {
                        try {
                          for (;;) interruption_point();
                        } catch (...) {
                          ended->set_value();
                          throw;
                        }
                      }),
                      Stop);
  }
  ended->get_future().wait();  // for ever, if it does not
}

BOOST_AUTO_TEST_SUITE_END()

BOOST_AUTO_TEST_SUITE(cache_files)

BOOST_AUTO_TEST_CASE(what_is_no_file_counts_as_missing) {
  const TemporaryDirectory directory;
  const Sha256::Digest key{};
  BOOST_REQUIRE(write_cached(directory.path(), ".x", key, "content"));
  BOOST_TEST(read_cached(directory.path(), ".x", key).value() == "content");
  const std::string file = directory.path(to_hex(key) + ".x");
  const auto replaced_by = [&](auto&& make) {
    std::filesystem::remove_all(file);
    make();
    BOOST_TEST(!read_cached(directory.path(), ".x", key).has_value());
  };
  replaced_by([&] { std::filesystem::create_directory(file); });
  BOOST_TEST(!write_cached(directory.path(), ".x", key, "content"));
  replaced_by([&] { BOOST_REQUIRE(::mkfifo(file.c_str(), 0600) == 0); });
  replaced_by([&] {
    std::ofstream(file) << "x";
    std::filesystem::resize_file(file, std::uintmax_t{1} << 40);
  });
  std::filesystem::remove_all(file);
  BOOST_TEST(write_cached(directory.path(), ".x", key, "content"));
  BOOST_TEST(read_cached(directory.path(), ".x", key).value() == "content");
}

BOOST_AUTO_TEST_SUITE_END()
