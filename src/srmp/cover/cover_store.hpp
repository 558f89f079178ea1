#pragma once

#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>

#include "srmp/cover/cover_file.hpp"

namespace srmp {

/// Sphere covers by content: each is made once, kept in memory as long as the store lives, and in a directory for later
/// runs. What is loaded has the bits of what was built. A directory that cannot be read or written costs time and
/// nothing else. Threads share a store; threads and processes share a directory.
class CoverStore {
 public:
  /// Keeps its files in `directory`; an empty one: no files.
  explicit CoverStore(std::filesystem::path directory = default_cover_directory(), const CoverLevels& levels = {});

  /// The cover of a geometry: that of the robot it belongs to (see adopt), else one with the store's levels, made at
  /// the first call for this content. The reference lives as long as the store. Throws as cover_geometry does.
  const GeometryCover& cover(const coal::CollisionGeometry& shape);

  /// From now on `cover` is the answer for this very geometry object.
  void adopt(std::shared_ptr<const coal::CollisionGeometry> shape, std::shared_ptr<const GeometryCover> cover);
  bool has_adopted(const coal::CollisionGeometry& shape) const;

  enum class Origin { memory, file, built };
  struct Answer {
    std::shared_ptr<const CoverSet> covers;
    Origin origin{};
  };
  /// What the store keeps under the key, or makes by `build` (called by one thread; the others wait). What `build`
  /// throws goes to all of them, and the next call tries again.
  Answer get(const Sha256::Digest& key, const std::function<CoverSet()>& build);

  const CoverLevels& levels() const { return levels_; }
  const std::filesystem::path& directory() const { return directory_; }

 private:
  using Future = std::shared_future<Answer>;
  struct Adopted {
    std::shared_ptr<const coal::CollisionGeometry> shape;  // keeps the address taken
    std::shared_ptr<const GeometryCover> cover;
  };

  const std::filesystem::path directory_;
  const CoverLevels levels_;
  mutable std::mutex mutex_;
  std::map<Sha256::Digest, Future> answers_;
  std::map<const coal::CollisionGeometry*, Adopted> adopted_;  // looked up, never walked
};

}  // namespace srmp
