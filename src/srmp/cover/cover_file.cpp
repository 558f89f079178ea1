#include "srmp/cover/cover_file.hpp"

#include <cstdlib>
#include <cstring>
#include <string_view>

#include "srmp/core/cache_file.hpp"

namespace srmp {

namespace {

constexpr std::string_view kExtension = ".cover";
constexpr std::uint32_t kFileVersion = 3;   // incremented when the layout changes
constexpr std::uint32_t kCoverVersion = 3;  // incremented when covers of the same geometry change

class Writer {
 public:
  template <class T>
  void put(T number) {
    text_.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  void put(std::string_view bytes) { text_.append(bytes); }
  void put(const PlacedSphere& sphere) {
    for (const double x : sphere.center) put(x);
    put(sphere.radius);
  }
  void put(const Inflation& inflation) {
    put(inflation.max);
    put(inflation.mean);
  }
  template <class T>
  void put(const std::vector<T>& list) {
    put(static_cast<std::uint64_t>(list.size()));
    for (const T& item : list) put(item);
  }
  void put(const GeometryCover& cover) {
    put(cover.bound);
    put(cover.coarse);
    put(cover.fine);
    put(cover.inner);
    put(cover.children);
    put(static_cast<std::uint8_t>(cover.exact));
    put(static_cast<std::uint8_t>(cover.hollow));
    put(static_cast<std::uint8_t>(cover.quick));
    put(cover.coarse_inflation);
    put(cover.fine_inflation);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// Reads numbers from the front; `ok` becomes and stays false once the text is too short or wrong.
class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}
  bool ok{true};
  bool at_end() const { return ok && text_.empty(); }

  template <class T>
  void get(T& number) {
    const std::string_view bytes = take(sizeof number);
    if (ok) std::memcpy(&number, bytes.data(), sizeof number);
  }
  std::string_view take(std::size_t size) {
    ok = ok && size <= text_.size();
    if (!ok) return {};
    const std::string_view front = text_.substr(0, size);
    text_.remove_prefix(size);
    return front;
  }
  void get(PlacedSphere& sphere) {
    for (double& x : sphere.center) get(x);
    get(sphere.radius);
  }
  void get(Inflation& inflation) {
    get(inflation.max);
    get(inflation.mean);
  }
  template <class T>
  void get(std::vector<T>& list) {
    std::uint64_t size = 0;
    get(size);
    ok = ok && size <= text_.size();  // every item takes a byte or more
    if (!ok) return;
    list.resize(size);
    for (T& item : list)
      if (ok) get(item);
  }
  void get(bool& flag) {
    std::uint8_t byte = 0;
    get(byte);
    ok = ok && byte <= 1;
    flag = byte == 1;
  }
  void get(GeometryCover& cover) {
    get(cover.bound);
    get(cover.coarse);
    get(cover.fine);
    get(cover.inner);
    get(cover.children);
    get(cover.exact);
    get(cover.hollow);
    get(cover.quick);
    get(cover.coarse_inflation);
    get(cover.fine_inflation);
    ok = ok && (cover.children.empty() || cover.children.size() == cover.coarse.size());
    for (const auto& list : cover.children)
      for (const std::uint32_t child : list) ok = ok && child < cover.fine.size();
  }

 private:
  std::string_view text_;
};

}  // namespace

std::filesystem::path default_cover_directory() {
  if (const char* own = std::getenv("SRMP_CACHE_DIR"))
    return *own == '\0' ? std::filesystem::path() : std::filesystem::path(own) / "covers";
  // The XDG base directory specification requires that relative paths are ignored.
  if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg && *xdg == '/')
    return std::filesystem::path(xdg) / "srmp" / "covers";
  if (const char* home = std::getenv("HOME"); home && *home == '/')
    return std::filesystem::path(home) / ".cache" / "srmp" / "covers";
  return {};
}

std::optional<CoverSet> read_covers(const std::filesystem::path& directory, const Sha256::Digest& key) {
  const auto text = read_cached(directory, kExtension, key);
  if (!text) return std::nullopt;
  Reader in(*text);
  CoverSet covers;
  in.get(covers);
  if (!in.at_end()) return std::nullopt;
  return covers;
}

bool write_covers(const std::filesystem::path& directory, const Sha256::Digest& key, const CoverSet& covers) {
  Writer out;
  out.put(covers);
  return write_cached(directory, kExtension, key, out.text());
}

Sha256 cover_key(std::string_view what) {
  Sha256 hash;
  hash.add(static_cast<std::uint64_t>(what.size()));
  hash.add(what.data(), what.size());
  hash.add(kFileVersion);
  hash.add(kCoverVersion);
  // Covers of another compiler may differ, because its rounding may.
  constexpr std::string_view compiler = __VERSION__;
  hash.add(compiler.data(), compiler.size());
  return hash;
}

void add_levels(Sha256& hash, const CoverLevels& levels) {
  for (const double x : {levels.coarse, levels.fine, levels.closing, levels.full_size}) hash.add(x);
  hash.add(static_cast<std::uint64_t>(levels.inner));
}

}  // namespace srmp
