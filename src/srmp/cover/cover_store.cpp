#include "srmp/cover/cover_store.hpp"

namespace srmp {

CoverStore::CoverStore(std::filesystem::path directory, const CoverLevels& levels)
    : directory_(std::move(directory)), levels_(levels) {
  require_levels(levels);
}

const GeometryCover& CoverStore::cover(const coal::CollisionGeometry& shape) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto it = adopted_.find(&shape); it != adopted_.end()) return *it->second.cover;
  }
  Sha256 hash = cover_key("geometry");
  add_levels(hash, levels_);
  add_content(hash, shape);
  const auto build = [&] { return CoverSet{cover_geometry(shape, levels_)}; };
  return get(hash.digest(), build).covers->front();
}

void CoverStore::adopt(std::shared_ptr<const coal::CollisionGeometry> shape,
                       std::shared_ptr<const GeometryCover> cover) {
  const auto* address = shape.get();
  const std::lock_guard lock(mutex_);
  adopted_.try_emplace(address,
                       Adopted{std::move(shape), std::move(cover)});  // references to the first cover stay valid
}

bool CoverStore::has_adopted(const coal::CollisionGeometry& shape) const {
  const std::lock_guard lock(mutex_);
  return adopted_.contains(&shape);
}

void CoverStore::forget_unused() {
  const std::lock_guard lock(mutex_);
  std::erase_if(adopted_, [](const auto& entry) { return entry.second.shape.use_count() == 1; });
}

CoverStore::Result CoverStore::get(const Sha256::Digest& key, const std::function<CoverSet()>& build) {
  std::promise<Result> promise;
  Future known;
  {
    const std::lock_guard lock(mutex_);
    const auto [it, added] = results_.try_emplace(key);
    if (added)
      it->second = promise.get_future().share();
    else
      known = it->second;
  }
  if (known.valid()) return {known.get().covers, Origin::memory};
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
