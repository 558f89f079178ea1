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

/// Where two meshes of a robot, which one or two revolute joints turn against each other, are surely apart: over a
/// whole turn of each joint, whatever its limits, a grid of cells, each proved free or not.
class PairTable {
 public:
  static constexpr int cells = 256;  ///< of a turn

  std::size_t geometry_a{}, geometry_b{};  ///< RobotModel::geometries(), a < b
  std::array<int, 2> joints{-1, -1};       ///< planned joints; the second is -1 where there is one
  std::vector<std::uint64_t> free;         ///< bit [second * cells + first]

  /// Are all cells proved that the joints' ranges [low, high] [rad] touch?
  bool is_free(const std::array<double, 2>& low, const std::array<double, 2>& high) const;
  bool never_meet() const;  ///< every cell is proved
};

/// The tables of one robot. They hold wherever the joints stand that are not planned: links that such a joint moves
/// against each other have none.
using PairTables = std::vector<PairTable>;

/// Tables are made once, kept in memory as long as the store lives, and in a directory for later runs. Threads share
/// it.
class PairTableStore {
 public:
  /// Keeps its files in `directory`; an empty one: no files.
  explicit PairTableStore(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// `parts`: parts_of each geometry. The first call for a robot takes some seconds; waiting calls wait.
  std::shared_ptr<const PairTables> tables(const std::shared_ptr<const RobotModel>& model,
                                           const std::vector<GeometryParts>& parts);

 private:
  struct Known {
    std::shared_ptr<const RobotModel> model;  // keeps the address taken
    std::shared_ptr<const PairTables> tables;
  };
  const std::filesystem::path directory_;
  std::mutex mutex_;
  std::vector<Known> known_;
};

}  // namespace srmp
