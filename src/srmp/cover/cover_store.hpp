#pragma once

#include <unistd.h>

#include <chrono>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "srmp/cover/cover_file.hpp"

namespace srmp {

/// Sphere covers by content: each is computed once, kept in memory as long as the store lives, and in a directory for
/// later runs. Loaded covers are bit for bit those that were computed. A directory that cannot be read or written costs
/// time and nothing else. Threads may share a store; threads and processes may share a directory.
class CoverStore {
 public:
  /// Keeps its files in `directory`, or no files when that is empty. Throws InvalidArgument for levels out of range.
  explicit CoverStore(std::filesystem::path directory = default_cover_directory(), const CoverLevels& levels = {});

  /// The cover of a geometry: the adopted one if there is one, otherwise one with the store's levels, which the first
  /// call for this content computes. Throws as cover_geometry does.
  std::shared_ptr<const GeometryCover> cover(const coal::CollisionGeometry& shape);

  /// From now on, cover() returns `cover` for this geometry object (not for others of the same content), as for the
  /// geometries of a robot that was covered as a whole. The object may end before the store.
  void adopt(const std::shared_ptr<const coal::CollisionGeometry>& shape, std::shared_ptr<const GeometryCover> cover);
  /// The same for a cover that serves until a better one is adopted, and afterwards those who always want this one.
  void adopt_quick(const std::shared_ptr<const coal::CollisionGeometry>& shape,
                   std::shared_ptr<const GeometryCover> cover);
  /// The cover that was adopted last for this geometry object, or else the quick one, or null.
  std::shared_ptr<const GeometryCover> adopted(const coal::CollisionGeometry& shape) const;
  /// The quick one, or null.
  std::shared_ptr<const GeometryCover> adopted_quick(const coal::CollisionGeometry& shape) const;
  /// Forgets the covers adopted for geometry objects that have ended.
  void release_unused();

  /// Where a result comes from: an earlier call, a file, or a new computation.
  enum class Origin { memory, file, built };
  struct Result {
    std::shared_ptr<const CoverSet> covers;  ///< not null
    Origin origin{};
  };
  /// The covers under the key, from memory, from a file or computed by `build` (which one thread calls while others
  /// wait for the same key). An exception of `build` is rethrown to all of them, and the next call tries again. A
  /// process that was forked meanwhile computes its own.
  Result get(const Sha256::Digest& key, const std::function<CoverSet()>& build);
  /// The covers under the key where they are in memory or in a file; nullopt otherwise, also while they are computed.
  std::optional<Result> find(const Sha256::Digest& key);

  const CoverLevels& levels() const { return levels_; }
  const std::filesystem::path& directory() const { return directory_; }

 private:
  struct Known {
    std::shared_future<Result> result;
    pid_t process;  // that computes it

    bool is_ready() const { return result.wait_for(std::chrono::seconds(0)) == std::future_status::ready; }
    /// Was the process forked from one that was computing the result? Then it comes in that process only.
    bool is_lost() const { return process != getpid() && !is_ready(); }
  };
  /// The result under the key, if it is known or will be; the caller has the lock.
  const Known* known(const Sha256::Digest& key);
  struct Adopted {
    std::weak_ptr<const coal::CollisionGeometry> shape;  // expired: another object may have the address
    std::shared_ptr<const GeometryCover> cover, quick;
  };
  Adopted& entry_of(const std::shared_ptr<const coal::CollisionGeometry>& shape);  // the caller has the lock
  Adopted known_of(const coal::CollisionGeometry& shape) const;

  const std::filesystem::path directory_;
  const CoverLevels levels_;
  mutable std::mutex mutex_;
  std::map<Sha256::Digest, Known> results_;
  std::map<const coal::CollisionGeometry*, Adopted>
      adopted_;  // never iterated over: the order of addresses is arbitrary
};

}  // namespace srmp
