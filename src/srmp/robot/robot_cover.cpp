#include "srmp/robot/robot_cover.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>
#include <thread>

#include "srmp/core/interruption.hpp"
#include "srmp/cover/quick_cover.hpp"
#include "srmp/robot/robot_geometry.hpp"

namespace srmp {

namespace {

using Shape = std::shared_ptr<const coal::CollisionGeometry>;
using Geometries = std::vector<const LinkGeometry*>;  // of a robot

/// The distinct envelopes of a robot's geometries: equal ones are covered once.
struct Distinct {
  std::vector<Shape> shapes;
  std::vector<std::size_t> times;  // how often each occurs in the robot
  std::vector<std::size_t> index;  // into shapes, by geometry of the robot
  Sha256 key{cover_key("robot")};
};

Distinct find_distinct(const Geometries& geometries) {
  Distinct distinct;
  std::map<Sha256::Digest, std::size_t> by_content;
  std::map<const coal::CollisionGeometry*, std::size_t> by_address;  // hashes each object once
  for (const LinkGeometry* geometry : geometries) {
    const Shape& shape = geometry->envelope;
    const auto [known, is_new_address] = by_address.try_emplace(shape.get(), 0);
    if (is_new_address) {
      Sha256 hash;
      add_content(hash, *shape);
      const auto [it, is_new] = by_content.try_emplace(hash.digest(), distinct.shapes.size());
      known->second = it->second;
      if (is_new) {
        distinct.shapes.push_back(shape);
        distinct.times.push_back(0);
        distinct.key.add(it->first.data(), it->first.size());
      }
    }
    ++distinct.times[known->second];
    distinct.index.push_back(known->second);
  }
  for (const std::size_t times : distinct.times) distinct.key.add(static_cast<std::uint64_t>(times));
  return distinct;
}

/// Increases coarse inflations until the robot has at most `budget` coarse spheres: always that of the geometry with
/// the most spheres per inflation, where an increase removes the most.
void keep_to_budget(std::vector<std::optional<GeometryCoverBuilder>>& builders, const std::vector<std::size_t>& times,
                    std::size_t budget) {
  if (budget == 0) return;
  for (;;) {
    std::size_t total = 0;
    GeometryCoverBuilder* worst = nullptr;
    double max_score = 0;
    for (std::size_t i = 0; i < builders.size(); ++i) {
      GeometryCoverBuilder& builder = *builders[i];
      total += times[i] * builder.coarse_count();
      const double score = static_cast<double>(times[i] * builder.coarse_count()) / builder.coarse_target();
      if (builder.coarse_count() == 1 || score <= max_score) continue;
      max_score = score;
      worst = &builder;
    }
    if (total <= budget || !worst) return;
    const double too_many = static_cast<double>(total) / static_cast<double>(budget);
    worst->cover_coarsely(std::clamp(std::sqrt(too_many), too_many < 1.04 ? 1.03 : 1.1, 1.5) * worst->coarse_target());
  }
}

CoverSet build(const Distinct& distinct, const RobotCoverOptions& options, const StepProgress& progress) {
  const std::size_t count = distinct.shapes.size();
  const std::size_t threads = options.threads ? options.threads : std::max(1U, std::thread::hardware_concurrency());
  Steps steps(std::min(count, threads), 2 * count, progress);
  std::vector<std::optional<GeometryCoverBuilder>> builders(count);
  steps.run(count, [&](std::size_t i) { builders[i].emplace(*distinct.shapes[i], options.levels); });
  {
    const InterruptionScope scope([&] {
      if (progress) progress(count, 2 * count);
    });
    keep_to_budget(builders, distinct.times, options.max_coarse);
  }
  CoverSet covers(count);
  steps.run(count, [&](std::size_t i) { covers[i] = builders[i]->finish(); });
  return covers;
}

Sha256::Digest key_of(const Distinct& distinct, const RobotCoverOptions& options) {
  Sha256 key = distinct.key;
  add_levels(key, options.levels);
  key.add(static_cast<std::uint64_t>(options.max_coarse));
  return key.digest();
}

/// Of quick covers.
Sha256::Digest quick_key_of(const Distinct& distinct) {
  Sha256 key = cover_key("quick");
  key.add(quick_cover_version);
  const Sha256::Digest content = Sha256(distinct.key).digest();
  key.add(content.data(), content.size());
  return key.digest();
}

/// The cover of a geometry, given that of its envelope.
std::shared_ptr<const GeometryCover> within_envelope(const LinkGeometry& geometry,
                                                     std::shared_ptr<const GeometryCover> envelope) {
  if (geometry.envelope == geometry.shape) return envelope;
  auto cover = std::make_shared<GeometryCover>(*envelope);
  cover->exact = false;
  cover->hollow = true;
  cover->inner.clear();
  return cover;
}

/// The cover of geometries whose distinct envelopes have these covers; the caller places its parts.
RobotCover robot_cover(const Geometries& geometries, const Distinct& distinct, const CoverStore::Result& result) {
  RobotCover cover;
  cover.origin = result.origin;
  for (std::size_t i = 0; i < geometries.size(); ++i)
    cover.parts.push_back({geometries[i]->link, geometries[i]->name, Eigen::Isometry3d::Identity(),
                           within_envelope(*geometries[i], {result.covers, &result.covers->at(distinct.index[i])})});
  return cover;
}

RobotCover cover_geometries(const Geometries& geometries, CoverStore& store, const RobotCoverOptions& options,
                            const StepProgress& progress) {
  const auto start = std::chrono::steady_clock::now();
  require_levels(options.levels);
  const Distinct distinct = find_distinct(geometries);
  const CoverStore::Result result =
      store.get(key_of(distinct, options), [&] { return build(distinct, options, progress); });
  RobotCover cover = robot_cover(geometries, distinct, result);
  cover.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return cover;
}

Geometries geometries_of(const RobotModel& model) {
  Geometries geometries;
  for (const LinkGeometry& geometry : model.geometries()) geometries.push_back(&geometry);
  return geometries;
}

void adopt(const RobotCover& cover, const RobotModel& model, CoverStore& store) {
  for (std::size_t i = 0; i < cover.parts.size(); ++i) store.adopt(model.geometries()[i].shape, cover.parts[i].cover);
}

void adopt_quick(const RobotCover& cover, const RobotModel& model, CoverStore& store) {
  for (std::size_t i = 0; i < cover.parts.size(); ++i)
    store.adopt_quick(model.geometries()[i].shape, cover.parts[i].cover);
}

/// Where they have to be made, each cover is adopted at once: a call that is interrupted leaves less to the next. They
/// are kept when one call has made them all.
void cover_quickly(const RobotModel& model, const Distinct& distinct, CoverStore& store) {
  const Sha256::Digest key = quick_key_of(distinct);
  if (const auto known = store.find(key))
    return adopt_quick(robot_cover(geometries_of(model), distinct, *known), model, store);
  std::vector<std::shared_ptr<const GeometryCover>> made(distinct.shapes.size());
  for (std::size_t i = 0; i < distinct.index.size(); ++i) {
    const LinkGeometry& geometry = model.geometries()[i];
    if (store.adopted_quick(*geometry.shape)) continue;
    rare_interruption_point();
    auto& cover = made[distinct.index[i]];
    if (!cover) cover = std::make_shared<const GeometryCover>(quick_cover(*distinct.shapes[distinct.index[i]]));
    store.adopt_quick(geometry.shape, within_envelope(geometry, cover));
  }
  CoverSet all;
  for (const auto& cover : made)
    if (cover) all.push_back(*cover);
  if (all.size() == made.size()) store.get(key, [&] { return all; });
}

bool is_quickly_covered(const RobotModel& model, const CoverStore& store) {
  return std::all_of(model.geometries().begin(), model.geometries().end(),
                     [&](const LinkGeometry& geometry) { return store.adopted_quick(*geometry.shape) != nullptr; });
}

template <class Value>
auto largest(const RobotCover& cover, Value&& value) {
  double result = 0;
  for (const RobotCover::Part& part : cover.parts) result = std::max(result, value(*part.cover));
  return result;
}

}  // namespace

std::size_t RobotCover::coarse_spheres() const {
  std::size_t sum = 0;
  for (const Part& part : parts) sum += part.cover->coarse.size();
  return sum;
}

std::size_t RobotCover::fine_spheres() const {
  std::size_t sum = 0;
  for (const Part& part : parts) sum += part.cover->exact ? part.cover->coarse.size() : part.cover->fine.size();
  return sum;
}

double RobotCover::coarse_inflation() const {
  return largest(*this, [](const GeometryCover& cover) { return cover.coarse_inflation.max; });
}

double RobotCover::fine_inflation() const {
  return largest(*this, [](const GeometryCover& cover) { return cover.fine_inflation.max; });
}

RobotCover cover_robot(const RobotModel& model, CoverStore& store, const RobotCoverOptions& options,
                       const StepProgress& progress) {
  RobotCover cover = cover_geometries(geometries_of(model), store, options, progress);
  const RobotDataPtr data = model.make_data();
  for (std::size_t i = 0; i < cover.parts.size(); ++i)
    cover.parts[i].in_link =
        model.link_pose(*data, model.geometries()[i].link_index).inverse() * model.geometry_pose(*data, i);
  adopt(cover, model, store);
  return cover;
}

void ensure_quickly_covered(const RobotModel& model, CoverStore& store) {
  if (!is_quickly_covered(model, store)) cover_quickly(model, find_distinct(geometries_of(model)), store);
}

bool ensure_covered(const RobotModel& model, CoverStore& store) {
  const auto are_adopted = [&](bool as_quick) {
    return std::all_of(model.geometries().begin(), model.geometries().end(), [&](const LinkGeometry& geometry) {
      const auto known = store.adopted(*geometry.shape);
      return known && (as_quick || !known->quick);
    });
  };
  if (are_adopted(true)) return are_adopted(false);
  const Geometries geometries = geometries_of(model);
  const Distinct distinct = find_distinct(geometries);
  if (const auto known = store.find(key_of(distinct, {}))) {
    adopt(robot_cover(geometries, distinct, *known), model, store);
    return true;
  }
  if (!is_quickly_covered(model, store)) cover_quickly(model, distinct, store);
  return are_adopted(false);
}

RobotCover cover_urdf(const std::string& urdf_path, const std::vector<std::string>& package_dirs, CoverStore& store,
                      const RobotCoverOptions& options, const StepProgress& progress) {
  const std::string directory = std::filesystem::absolute(urdf_path).parent_path().string();
  const std::vector<PlacedGeometry> placed = load_geometries(Urdf::read_file(urdf_path), directory, package_dirs);
  Geometries geometries;
  for (const PlacedGeometry& one : placed) geometries.push_back(&one.geometry);
  RobotCover cover = cover_geometries(geometries, store, options, progress);
  for (std::size_t i = 0; i < placed.size(); ++i) cover.parts[i].in_link = placed[i].in_link;
  return cover;
}

}  // namespace srmp
