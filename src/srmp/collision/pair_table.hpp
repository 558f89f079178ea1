#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "srmp/robot/robot_model.hpp"
#include "srmp/scene/shape_geometry.hpp"

namespace srmp {

/// Where two geometries of a robot, which one or two revolute joints move relative to each other, are proved apart: a
/// grid of cells over a whole turn of each joint, whatever its limits, each proved free or not.
class PairTable {
 public:
  static constexpr int cells = 256;  ///< of a turn

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

  /// `parts`: parts_of each geometry. The first call for a robot takes some seconds; concurrent calls wait for it.
  std::shared_ptr<const PairTables> tables(const std::shared_ptr<const RobotModel>& model,
                                           const std::vector<GeometryParts>& parts);

 private:
  struct Known {
    std::weak_ptr<const RobotModel> model;
    std::shared_ptr<const PairTables> tables;
  };
  const std::filesystem::path directory_;
  std::mutex mutex_;
  std::vector<Known> known_;
};

}  // namespace srmp
