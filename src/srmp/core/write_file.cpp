#include "srmp/core/write_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

/// Where symbolic links lead; there may be no file yet.
std::filesystem::path behind_links(std::filesystem::path path) {
  constexpr int most = 40;  // as the kernel
  std::error_code error;
  for (int links = 0; links < most && std::filesystem::is_symlink(path, error); ++links)
    path = path.parent_path() / std::filesystem::read_symlink(path, error);
  return path;
}

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
int write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written >= 0)
      text.remove_prefix(static_cast<std::size_t>(written));
    else if (errno != EINTR)
      return errno;
  }
  return 0;
}

/// The same, and waits until the text is on the disk.
int write_and_close(int descriptor, std::string_view text) {
  int error = write_all(descriptor, text);
  if (error == 0 && ::fsync(descriptor) != 0) error = errno;
  if (::close(descriptor) != 0 && error == 0) error = errno;
  return error;
}

/// Through a device or a pipe, which stays what it is. A pipe that nobody reads is an error: to wait could take
/// forever.
int write_through(const std::filesystem::path& path, std::string_view text) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return errno;
  int error = ::fcntl(descriptor, F_SETFL, 0) == 0 ? write_all(descriptor, text) : errno;
  if (::close(descriptor) != 0 && error == 0) error = errno;
  return error;
}

/// The permissions of the old file, and its owner where that is allowed.
int keep_permissions(int descriptor, const struct stat& old) {
  if (::fchown(descriptor, old.st_uid, old.st_gid) != 0 && errno != EPERM) return errno;
  return ::fchmod(descriptor, old.st_mode & 07777) == 0 ? 0 : errno;
}

}  // namespace

void write_file(const std::filesystem::path& path, std::string_view content) {
  const auto refuse = [&](int error) {
    throw FileError(path.string() + ": the file cannot be written: " + std::generic_category().message(error));
  };
  struct stat old{};
  const bool exists = ::stat(path.c_str(), &old) == 0;
  if (!exists && errno != ENOENT) refuse(errno);
  if (exists && !S_ISREG(old.st_mode) && !S_ISDIR(old.st_mode)) {
    if (const int error = write_through(path, content)) refuse(error);
    return;
  }
  const std::filesystem::path target = behind_links(path);
  std::filesystem::path temporary;
  const int descriptor = open_beside(target, temporary);
  if (descriptor < 0) refuse(errno);
  int error = exists ? keep_permissions(descriptor, old) : 0;
  if (error == 0)
    error = write_and_close(descriptor, content);
  else
    ::close(descriptor);
  if (error == 0 && ::rename(temporary.c_str(), target.c_str()) != 0) error = errno;
  if (error == 0) return;
  ::unlink(temporary.c_str());
  refuse(error);
}

}  // namespace srmp
