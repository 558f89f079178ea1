#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "srmp/core/steps.hpp"
#include "srmp/robot/robot_model.hpp"
#include "srmp/scene/shape_geometry.hpp"

namespace srmp {

/// Where two geometries of a robot, which one or two revolute joints move relative to each other, are proved apart: a
/// grid of cells over a whole turn of each joint, whatever its limits, each proved free or not.
class PairTable {
 public:
  static constexpr int cells = 256;          ///< of a turn
  static constexpr double reserve = 2.6e-5;  ///< [m] the two are farther apart than this where they are proved apart

  std::size_t geometry_a{}, geometry_b{};  ///< RobotModel::geometries(), a < b
  std::array<int, 2> joints{-1, -1};       ///< planned joints; the second is -1 where there is one
  std::vector<std::uint64_t> free;         ///< bit [second * cells + first]

  /// Are all cells that the joints' ranges [low, high] [rad] touch proved free?
  bool is_free(const std::array<double, 2>& low, const std::array<double, 2>& high) const;
  bool never_collide() const;  ///< every cell is proved free
};

/// The tables of one robot. They hold wherever the joints that are not planned stand: links that such a joint moves
/// relative to each other have none.
using PairTables = std::vector<PairTable>;

/// Tables are computed once, kept in memory as long as the store and the robot live, and in a directory for later runs.
/// Threads share the store.
class PairTableStore {
 public:
  /// Keeps its files in `directory`; an empty path: no files.
  explicit PairTableStore(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// The tables, from memory, from a file, or computed, which takes seconds. `parts`: parts_of each geometry;
  /// `threads`: at least 1, the tables do not depend on it.
  std::shared_ptr<const PairTables> tables(const std::shared_ptr<const RobotModel>& model,
                                           const std::vector<GeometryParts>& parts, std::size_t threads = 1,
                                           const StepProgress& progress = {});
  /// The tables where they are in memory or in a file, or null.
  std::shared_ptr<const PairTables> find(const std::shared_ptr<const RobotModel>& model);

 private:
  struct Known {
    std::weak_ptr<const RobotModel> model;
    std::shared_ptr<const PairTables> tables;  // null: neither computed yet nor in a file
  };
  Known* known(const std::shared_ptr<const RobotModel>& model);
  void keep(const std::shared_ptr<const RobotModel>& model, std::shared_ptr<const PairTables> tables);

  const std::filesystem::path directory_;
  std::mutex mutex_;
  std::vector<Known> known_;
};

}  // namespace srmp
