#include "srmp/core/write_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <optional>
#include <string>
#include <system_error>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"

namespace srmp {

namespace {

/// The number of an open file of this process that the path names.
std::optional<int> descriptor_of(const std::filesystem::path& path) {
  if (path.parent_path() != "/proc/self/fd" && path.parent_path() != "/dev/fd") return std::nullopt;
  const std::string name = path.filename();
  int number{};
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  return error == std::errc() && end == name.data() + name.size() ? std::optional(number) : std::nullopt;
}

/// Where symbolic links lead; there may be no file yet. Links of open files are not followed.
std::filesystem::path behind_links(std::filesystem::path path) {
  constexpr int max_links = 40;  // as the kernel
  std::error_code error;
  for (int links = 0; links < max_links && !descriptor_of(path) && std::filesystem::is_symlink(path, error); ++links)
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
    else if (errno == EINTR)
      rare_interruption_point();  // a reader may never read
    else
      return errno;
  }
  return 0;
}

/// Returns the error, or that of closing.
int closed(int descriptor, int error) { return ::close(descriptor) != 0 && error == 0 ? errno : error; }

/// The same as write_all, and waits until the text is on the disk.
int write_and_close(int descriptor, std::string_view text) {
  int error = write_all(descriptor, text);
  if (error == 0 && ::fsync(descriptor) != 0) error = errno;
  return closed(descriptor, error);
}

/// To an open file of this process, where it stands.
int write_to_open_file(int number, std::string_view text) {
  const int descriptor = ::fcntl(number, F_DUPFD_CLOEXEC, 0);
  return descriptor < 0 ? errno : closed(descriptor, write_all(descriptor, text));
}

/// Through a device or a pipe, which stays what it is. A pipe that nobody has open is an error: to wait for a reader
/// could take forever.
int write_through(const std::filesystem::path& path, std::string_view text) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return errno;
  return closed(descriptor, ::fcntl(descriptor, F_SETFL, 0) == 0 ? write_all(descriptor, text) : errno);
}

/// Owner, group and permissions of the old file, as far as that is allowed. Another group gets none of those that the
/// old one had.
void keep_permissions(int descriptor, const struct stat& old) {
  mode_t mode = old.st_mode & 07777;
  const bool same = ::fchown(descriptor, old.st_uid, old.st_gid) == 0 ||
                    ::fchown(descriptor, static_cast<uid_t>(-1), old.st_gid) == 0;
  struct stat now{};
  if (!same && !(::fstat(descriptor, &now) == 0 && now.st_gid == old.st_gid)) mode &= ~mode_t{07070};
  (void)::fchmod(descriptor, mode);  // some file systems have no permissions
}

}  // namespace

void write_file(const std::filesystem::path& path, std::string_view content) {
  const auto refuse = [&](int error) {
    throw FileError(path.string() + ": the file cannot be written: " + std::generic_category().message(error));
  };
  struct stat old{};
  const bool exists = ::stat(path.c_str(), &old) == 0;
  if (!exists && errno != ENOENT) refuse(errno);
  const std::filesystem::path target = behind_links(path);
  if (const auto number = descriptor_of(target)) {
    if (const int error = write_to_open_file(*number, content)) refuse(error);
    return;
  }
  if (exists && !S_ISREG(old.st_mode) && !S_ISDIR(old.st_mode)) {
    if (const int error = write_through(path, content)) refuse(error);
    return;
  }
  std::filesystem::path temporary;
  const int descriptor = open_beside(target, temporary);
  if (descriptor < 0) refuse(errno);
  if (exists) keep_permissions(descriptor, old);
  int error = write_and_close(descriptor, content);
  if (error == 0 && ::rename(temporary.c_str(), target.c_str()) != 0) error = errno;
  if (error == 0) return;
  ::unlink(temporary.c_str());
  refuse(error);
}

}  // namespace srmp
