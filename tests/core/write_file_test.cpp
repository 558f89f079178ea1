#include "srmp/core/write_file.hpp"

#include <sys/stat.h>

#include <boost/test/unit_test.hpp>

#include "srmp/core/error.hpp"
#include "support/files.hpp"
#include "support/throws.hpp"

namespace {

std::string text_of(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::size_t files_in(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

}  // namespace

BOOST_AUTO_TEST_SUITE(write_file)

BOOST_AUTO_TEST_CASE(a_file_is_replaced_and_nothing_else_is_left) {
  const TemporaryFolder folder;
  const std::string path = folder.path("a.json");
  srmp::write_file(path, "first");
  srmp::write_file(path, std::string(1 << 20, 'x'));
  BOOST_CHECK(text_of(path) == std::string(1 << 20, 'x'));
  BOOST_CHECK_EQUAL(files_in(folder.path()), 1u);
}

BOOST_AUTO_TEST_CASE(others_may_read_it_as_any_file_of_this_user) {
  const TemporaryFolder folder;
  std::ofstream(folder.path("plain")) << "x";
  srmp::write_file(folder.path("ours"), "x");
  struct stat plain{}, ours{};
  BOOST_REQUIRE(::stat(folder.path("plain").c_str(), &plain) == 0 && ::stat(folder.path("ours").c_str(), &ours) == 0);
  BOOST_CHECK_EQUAL(plain.st_mode, ours.st_mode);
}

BOOST_AUTO_TEST_CASE(what_cannot_be_written_is_refused_and_leaves_nothing) {
  const TemporaryFolder folder;
  check_throws<srmp::FileError>([&] { srmp::write_file(folder.path("nowhere/a"), "x"); },
                                "nowhere/a: the file cannot be written: No such file or directory");
  std::filesystem::create_directory(folder.path("taken"));
  std::ofstream(folder.path("taken/inside")) << "x";
  check_throws<srmp::FileError>([&] { srmp::write_file(folder.path("taken"), "x"); }, "cannot be written");
  BOOST_CHECK_EQUAL(files_in(folder.path()), 1u);
}

BOOST_AUTO_TEST_SUITE_END()
