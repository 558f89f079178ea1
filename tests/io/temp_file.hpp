#pragma once

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>

/// A file of its own, gone with the object.
class TempFile {
 public:
  explicit TempFile(const std::string& text) {
    static std::atomic<int> number{0};
    path_ = std::filesystem::temp_directory_path() /
            ("srmp_test_" + std::to_string(::getpid()) + "_" + std::to_string(number++) + ".yaml");
    std::ofstream(path_) << text;
  }
  ~TempFile() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  TempFile(const TempFile&) = delete;
  TempFile& operator=(const TempFile&) = delete;

  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

/// `text` with the one place that reads `from` changed to `to`.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("the test's file does not hold: " + from);
  return text.replace(at, from.size(), to);
}

inline std::string read_text(const std::string& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), {}};
}
