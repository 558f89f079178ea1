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

std::size_t files_in(const std::string& directory) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(directory), {}));
}

}  // namespace

BOOST_AUTO_TEST_SUITE(write_file)

BOOST_AUTO_TEST_CASE(a_file_is_replaced_and_no_temporary_file_remains) {
  const TemporaryDirectory directory;
  const std::string path = directory.path("a.json");
  srmp::write_file(path, "first");
  srmp::write_file(path, std::string(1 << 20, 'x'));
  BOOST_CHECK(text_of(path) == std::string(1 << 20, 'x'));
  BOOST_CHECK_EQUAL(files_in(directory.path()), 1u);
}

BOOST_AUTO_TEST_CASE(the_file_has_the_default_permissions) {
  const TemporaryDirectory directory;
  std::ofstream(directory.path("plain")) << "x";
  srmp::write_file(directory.path("ours"), "x");
  struct stat plain{}, ours{};
  BOOST_REQUIRE(::stat(directory.path("plain").c_str(), &plain) == 0 &&
                ::stat(directory.path("ours").c_str(), &ours) == 0);
  BOOST_CHECK_EQUAL(plain.st_mode, ours.st_mode);
}

BOOST_AUTO_TEST_CASE(a_file_that_cannot_be_written_is_an_error_and_leaves_no_file) {
  const TemporaryDirectory directory;
  check_throws<srmp::FileError>([&] { srmp::write_file(directory.path("nowhere/a"), "x"); },
                                "nowhere/a: the file cannot be written: No such file or directory");
  std::filesystem::create_directory(directory.path("taken"));
  std::ofstream(directory.path("taken/inside")) << "x";
  check_throws<srmp::FileError>([&] { srmp::write_file(directory.path("taken"), "x"); }, "cannot be written");
  BOOST_CHECK_EQUAL(files_in(directory.path()), 1u);
}

BOOST_AUTO_TEST_SUITE_END()
