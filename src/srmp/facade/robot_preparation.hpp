#pragma once

#include <unistd.h>

#include <atomic>
#include <map>
#include <memory>

#include "srmp/collision/pair_table.hpp"
#include "srmp/core/background.hpp"
#include "srmp/cover/cover_store.hpp"
#include "srmp/scene/scene.hpp"

namespace srmp {

/// What makes collision checks of robots faster and changes no result: sphere covers, and tables of pairs of links.
/// They take seconds to minutes to compute for a robot seen for the first time. So they are computed in the background;
/// until then quick covers and no tables serve. A process that forks meanwhile leaves that work with the parent, and
/// the child begins its own. Not thread-safe.
class RobotPreparation {
 public:
  RobotPreparation(std::shared_ptr<CoverStore> covers, std::shared_ptr<PairTableStore> tables)
      : covers_(std::move(covers)), tables_(std::move(tables)) {}

  /// Begins to prepare robots that are new. Returns whether another one has become ready: checkers made before would be
  /// faster if they were made again.
  bool update(const Scene& scene);
  /// Prepares all robots of the scene now, with all cores. What `progress` throws ends it and passes through. Returns
  /// as update.
  bool finish(const Scene& scene, const StepProgress& progress);

 private:
  struct Robot {
    std::weak_ptr<const RobotModel> model;
    std::shared_ptr<std::atomic<bool>> computed{std::make_shared<std::atomic<bool>>(false)};
    pid_t begun_by{};  // the process whose background prepares it; 0: none
    bool ready{};      // its covers are adopted and its tables are known
    Background::Ticket job;
  };
  Robot& robot_of(const std::shared_ptr<const RobotModel>& model);
  void begin(Robot& robot, const RobotInstance& instance) const;

  std::shared_ptr<CoverStore> covers_;
  std::shared_ptr<PairTableStore> tables_;
  std::map<const RobotModel*, Robot> robots_;
};

}  // namespace srmp
