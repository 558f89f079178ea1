#pragma once

#include <boost/test/unit_test.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "srmp/robot/robot_model.hpp"

/// The package's own demonstration arm.
inline srmp::RobotDescription arm7() {
  srmp::RobotDescription description;
  description.urdf_path = SRMP_SOURCE_DIR "/python/srmp/data/arm7.urdf";
  description.srdf_path = SRMP_SOURCE_DIR "/python/srmp/data/arm7.srdf";
  return description;
}

/// A robot of the MotionBenchMaker data, which SRMP_MBM_DIR points to; "" and a message where it is not there.
inline std::string mbm_file(const std::string& robot, const std::string& file) {
  const char* directory = std::getenv("SRMP_MBM_DIR");
  const std::string path = directory ? std::string(directory) + "/" + robot + "/" + file : "";
  if (!path.empty() && std::filesystem::exists(path)) return path;
  BOOST_TEST_MESSAGE("skipped: set SRMP_MBM_DIR to a directory that holds " << robot << "/" << file);
  return "";
}
