#include "srmp/cover/cover_store.hpp"

namespace srmp {

CoverStore::CoverStore(std::filesystem::path directory, const CoverLevels& levels)
    : directory_(std::move(directory)), levels_(levels) {
  require_levels(levels);
}

std::shared_ptr<const GeometryCover> CoverStore::cover(const coal::CollisionGeometry& shape) {
  if (auto known = adopted(shape)) return known;
  Sha256 hash = cover_key("geometry");
  add_levels(hash, levels_);
  add_content(hash, shape);
  const Result result = get(hash.digest(), [&] { return CoverSet{cover_geometry(shape, levels_)}; });
  return {result.covers, &result.covers->front()};
}

CoverStore::Adopted& CoverStore::entry_of(const std::shared_ptr<const coal::CollisionGeometry>& shape) {
  Adopted& entry = adopted_[shape.get()];
  if (entry.shape.expired()) entry = {.shape = shape, .cover = nullptr, .quick = nullptr};
  return entry;
}

void CoverStore::adopt(const std::shared_ptr<const coal::CollisionGeometry>& shape,
                       std::shared_ptr<const GeometryCover> cover) {
  const std::lock_guard lock(mutex_);
  entry_of(shape).cover = std::move(cover);
}

void CoverStore::adopt_quick(const std::shared_ptr<const coal::CollisionGeometry>& shape,
                             std::shared_ptr<const GeometryCover> cover) {
  const std::lock_guard lock(mutex_);
  entry_of(shape).quick = std::move(cover);
}

CoverStore::Adopted CoverStore::known_of(const coal::CollisionGeometry& shape) const {
  const std::lock_guard lock(mutex_);
  const auto it = adopted_.find(&shape);
  return it != adopted_.end() && !it->second.shape.expired() ? it->second : Adopted{};
}

std::shared_ptr<const GeometryCover> CoverStore::adopted(const coal::CollisionGeometry& shape) const {
  const Adopted known = known_of(shape);
  return known.cover ? known.cover : known.quick;
}

std::shared_ptr<const GeometryCover> CoverStore::adopted_quick(const coal::CollisionGeometry& shape) const {
  return known_of(shape).quick;
}

std::optional<CoverStore::Result> CoverStore::find(const Sha256::Digest& key) {
  {
    const std::lock_guard lock(mutex_);
    if (const Known* entry = known(key)) {
      if (!entry->is_ready()) return std::nullopt;
      return Result{entry->result.get().covers, Origin::memory};
    }
  }
  auto covers = read_covers(directory_, key);
  if (!covers) return std::nullopt;
  std::promise<Result> read;
  read.set_value({std::make_shared<const CoverSet>(std::move(*covers)), Origin::file});
  const std::lock_guard lock(mutex_);
  const auto [entry, added] = results_.emplace(key, Known{read.get_future().share(), getpid()});
  if (added || entry->second.is_ready()) return entry->second.result.get();
  return std::nullopt;
}

const CoverStore::Known* CoverStore::known(const Sha256::Digest& key) {
  const auto entry = results_.find(key);
  if (entry == results_.end()) return nullptr;
  if (!entry->second.is_lost()) return &entry->second;
  results_.erase(entry);
  return nullptr;
}

void CoverStore::release_unused() {
  const std::lock_guard lock(mutex_);
  std::erase_if(adopted_, [](const auto& entry) { return entry.second.shape.expired(); });
}

CoverStore::Result CoverStore::get(const Sha256::Digest& key, const std::function<CoverSet()>& build) {
  std::promise<Result> promise;
  std::shared_future<Result> other;  // of an earlier call
  {
    const std::lock_guard lock(mutex_);
    if (const Known* entry = known(key))
      other = entry->result;
    else
      results_.emplace(key, Known{promise.get_future().share(), getpid()});
  }
  if (other.valid()) return {other.get().covers, Origin::memory};
  Result result;
  try {
    if (auto covers = read_covers(directory_, key)) {
      result = {std::make_shared<const CoverSet>(std::move(*covers)), Origin::file};
    } else {
      result = {std::make_shared<const CoverSet>(build()), Origin::built};
      write_covers(directory_, key, *result.covers);
    }
  } catch (...) {
    {
      const std::lock_guard lock(mutex_);
      results_.erase(key);
    }
    promise.set_exception(std::current_exception());
    throw;
  }
  promise.set_value(result);
  return result;
}

}  // namespace srmp
