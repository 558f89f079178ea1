#include "srmp/core/write_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

/// Opens a new file beside `path` with the user's default permissions; mkstemp would create a private file.
int open_beside(const std::filesystem::path& path, std::filesystem::path& temporary) {
  static std::atomic<unsigned> number{0};
  int descriptor = -1;
  do {
    temporary = path;
    temporary.concat(".")
        .concat(std::to_string(::getpid()))
        .concat(".")
        .concat(std::to_string(number++))
        .concat(".tmp");
    descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (descriptor < 0 && errno == EEXIST);
  return descriptor;
}

/// Returns 0, or the errno of the call that failed.
int write_and_close(int descriptor, std::string_view text) {
  int error = 0;
  while (error == 0 && !text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written >= 0)
      text.remove_prefix(static_cast<std::size_t>(written));
    else if (errno != EINTR)
      error = errno;
  }
  if (error == 0 && ::fsync(descriptor) != 0) error = errno;
  if (::close(descriptor) != 0 && error == 0) error = errno;
  return error;
}

}  // namespace

void write_file(const std::filesystem::path& path, std::string_view content) {
  const auto refuse = [&](const std::error_code& why) {
    throw FileError(path.string() + ": the file cannot be written: " + why.message());
  };
  std::filesystem::path temporary;
  const int descriptor = open_beside(path, temporary);
  if (descriptor < 0) refuse({errno, std::generic_category()});
  std::error_code error(write_and_close(descriptor, content), std::generic_category());
  if (!error) std::filesystem::rename(temporary, path, error);
  if (!error) return;
  std::error_code ignored;
  std::filesystem::remove(temporary, ignored);
  refuse(error);
}

}  // namespace srmp
