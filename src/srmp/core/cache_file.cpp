#include "srmp/core/cache_file.hpp"

#include <algorithm>
#include <fstream>

#include "srmp/core/error.hpp"
#include "srmp/core/write_file.hpp"

namespace srmp {

namespace {

// A file consists of the magic, the key, the content, and the SHA-256 of these.
constexpr std::string_view kMagic = "SRMPFILE";

constexpr std::uintmax_t kMaxSize = std::uintmax_t{1} << 28;  // bytes; more than any content has

std::string_view as_text(const Sha256::Digest& digest) {
  return {reinterpret_cast<const char*>(digest.data()), digest.size()};
}

Sha256::Digest digest_of(std::string_view text) {
  Sha256 hash;
  hash.add(text.data(), text.size());
  return hash.digest();
}

std::string header_of(const Sha256::Digest& key) { return std::string(kMagic) + std::string(as_text(key)); }

std::filesystem::path file_of(const std::filesystem::path& directory, std::string_view extension,
                              const Sha256::Digest& key) {
  return directory / (to_hex(key) + std::string(extension));
}

}  // namespace

std::optional<std::string> read_cached(const std::filesystem::path& directory, std::string_view extension,
                                       const Sha256::Digest& key) {
  if (directory.empty()) return std::nullopt;
  const std::filesystem::path path = file_of(directory, extension, key);
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;  // a pipe would be waited for
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error || size > kMaxSize) return std::nullopt;
  std::ifstream file(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!file.read(text.data(), static_cast<std::streamsize>(text.size()))) return std::nullopt;
  const std::string header = header_of(key);
  const std::size_t sum_size = Sha256::Digest().size();
  if (text.size() < header.size() + sum_size || !text.starts_with(header)) return std::nullopt;
  const std::string_view body(text.data(), text.size() - sum_size);
  if (as_text(digest_of(body)) != std::string_view(text).substr(body.size())) return std::nullopt;
  return text.substr(header.size(), body.size() - header.size());
}

bool write_cached(const std::filesystem::path& directory, std::string_view extension, const Sha256::Digest& key,
                  std::string_view content) {
  if (directory.empty() || content.size() > kMaxSize / 2) return false;
  std::string text = header_of(key) + std::string(content);
  text += as_text(digest_of(text));
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  try {
    write_file(file_of(directory, extension, key), text);
  } catch (const FileError&) {
    return false;
  }
  return true;
}

}  // namespace srmp
