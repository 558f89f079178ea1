#include "srmp/core/write_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

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

BOOST_AUTO_TEST_CASE(permissions_of_an_old_file_are_kept) {
  const TemporaryDirectory directory;
  const std::string path = directory.path("a");
  std::ofstream(path) << "x";
  for (const mode_t mode : {0640u, 0600u, 0755u}) {
    BOOST_REQUIRE_EQUAL(::chmod(path.c_str(), mode), 0);
    srmp::write_file(path, "y");
    struct stat now{};
    BOOST_REQUIRE_EQUAL(::stat(path.c_str(), &now), 0);
    BOOST_CHECK_EQUAL(now.st_mode & 07777u, mode);
  }
}

BOOST_AUTO_TEST_CASE(links_stay_and_what_they_lead_to_is_written) {
  const TemporaryDirectory directory;
  std::filesystem::create_directory(directory.path("other"));
  std::filesystem::create_symlink("other/b", directory.path("a"));  // not there yet
  std::filesystem::create_symlink("a", directory.path("to_a"));
  for (const char* text : {"first", "second"}) {
    srmp::write_file(directory.path("to_a"), text);
    BOOST_TEST(std::filesystem::is_symlink(directory.path("a")));
    BOOST_TEST(std::filesystem::is_symlink(directory.path("to_a")));
    BOOST_CHECK_EQUAL(text_of(directory.path("other/b")), text);
  }
  std::filesystem::create_symlink("round", directory.path("round"));
  check_throws<srmp::FileError>([&] { srmp::write_file(directory.path("round"), "x"); },
                                "round: the file cannot be written: Too many levels of symbolic links");
}

BOOST_AUTO_TEST_CASE(pipes_are_written_to_and_stay) {
  const TemporaryDirectory directory;
  const std::string path = directory.path("pipe");
  BOOST_REQUIRE_EQUAL(::mkfifo(path.c_str(), 0600), 0);
  check_throws<srmp::FileError>([&] { srmp::write_file(path, "x"); }, "pipe: the file cannot be written: ");
  const int reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK);
  std::filesystem::create_symlink("pipe", directory.path("to_pipe"));
  srmp::write_file(directory.path("to_pipe"), "text");
  char text[8]{};
  BOOST_CHECK_EQUAL(::read(reader, text, sizeof text), 4);
  BOOST_CHECK_EQUAL(std::string(text), "text");
  ::close(reader);
  BOOST_TEST(std::filesystem::is_fifo(path));
}

BOOST_AUTO_TEST_CASE(open_files_of_the_process_are_continued) {
  const TemporaryDirectory directory;
  const std::string log = directory.path("log");
  const int descriptor = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  BOOST_REQUIRE_EQUAL(::write(descriptor, "before ", 7), 7);
  srmp::write_file("/proc/self/fd/" + std::to_string(descriptor), "text");
  srmp::write_file("/dev/fd/" + std::to_string(descriptor), " more");
  BOOST_REQUIRE_EQUAL(::write(descriptor, " after", 6), 6);
  ::close(descriptor);
  BOOST_CHECK_EQUAL(text_of(log), "before text more after");
  check_throws<srmp::FileError>([] { srmp::write_file("/proc/self/fd/987654", "x"); }, "cannot be written");
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
