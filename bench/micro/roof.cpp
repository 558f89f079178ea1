// The collision kernel beside what the arithmetic that it does would take at best, by instruction set. Prints JSON.
// bench/micro/roof.py starts it and says what the numbers mean.
//   bench_roof ROBOT.urdf ROBOT.srdf GROUP BLOCKS SIZE REPEATS SCENE.yaml [SCENE.yaml ...]

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "counted_kernel.hpp"
#include "cpu_seconds.hpp"
#include "peak.hpp"
#include "srmp/collision/batch/batch_model.hpp"
#include "srmp/collision/robot_group.hpp"
#include "srmp/collision/scene_model.hpp"
#include "srmp/cover/cover_store.hpp"
#include "srmp/io/moveit.hpp"

using namespace srmp;
using batch::kLanes;
using bench::cpu_seconds;

namespace {

struct Options {
  std::size_t blocks{};
  double size{};  // of a motion, of its fastest joint [rad]
  int repeats{};
};

using Floats = std::unique_ptr<float[], decltype(&std::free)>;

Floats floats(std::size_t count) {
  const std::size_t bytes = (count * sizeof(float) + 63) / 64 * 64;
  return {static_cast<float*>(std::aligned_alloc(64, bytes)), &std::free};
}

/// The kernel's memory for one model.
struct Memory {
  explicit Memory(const BatchModel& of)
      : model(of),
        scratch(floats(static_cast<std::size_t>(batch::scratch_floats(of.view())))),
        pair_lanes(of.pair_obstacles.size() + of.self_pairs.size()),
        undecided_pairs(pair_lanes.size()) {}

  batch::KernelResult run(batch::KernelFunction kernel, const float* values, const float* half_widths) {
    batch::KernelResult result{0, 0, {}, pair_lanes.data(), undecided_pairs.data(), 0};
    batch::KernelRequest request{};
    request.values = values;
    request.half_widths = half_widths;
    request.every_lane = half_widths == nullptr;
    request.used = kLanes;
    kernel(model.view(), request, scratch.get(), result);
    return result;
  }

  const BatchModel& model;
  Floats scratch;
  std::vector<batch::LaneMask> pair_lanes;
  std::vector<batch::KernelPair> undecided_pairs;
};

/// 16 configurations for the kernel, or the 16 parts of a motion.
struct Block {
  Floats values, half_widths;
};

Block random_block(const RobotModel& robot, const BatchModel& model, bool moving, double size, std::mt19937& random) {
  const auto uniform = [&](double low, double high) { return low + (high - low) * (random() * 0x1p-32); };
  const std::size_t joints = model.robot->actuated_joints.size();
  Block block{floats((joints + 1) * kLanes), floats((joints + 1) * kLanes)};
  std::vector<double> q(robot.dof()), difference(robot.dof());
  for (double& change : difference) change = uniform(-size, size);
  for (int lane = 0; lane < kLanes; ++lane) {
    if (lane == 0 || !moving)
      for (std::size_t j = 0; j < q.size(); ++j)
        q[j] = uniform(std::max(robot.joints()[j].lower, -M_PI), std::min(robot.joints()[j].upper, M_PI));
    for (std::size_t k = 0; k < joints; ++k) {
      const BatchActuatedJoint& actuated = model.robot->actuated_joints[k];
      const double change = actuated.ratio * difference[actuated.joint];
      double value = actuated.ratio * q[actuated.joint] + actuated.offset;
      if (moving) value += change * (lane + 0.5) / kLanes;
      if (!actuated.prismatic) value -= 2 * M_PI * std::nearbyint(value / (2 * M_PI));
      const std::size_t at = k * kLanes + static_cast<std::size_t>(lane);
      block.values[at] = static_cast<float>(value);
      block.half_widths[at] = static_cast<float>(change / (2 * kLanes) * 1.0001);
    }
  }
  return block;
}

/// Blocks that the kernel proves free, so that it looks at every pair.
std::vector<Block> free_blocks(const RobotModel& robot, const BatchModel& model, bool moving, const Options& options) {
  std::mt19937 random(1);
  Memory memory(model);
  std::vector<Block> blocks;
  for (std::size_t tries = 0; blocks.size() < options.blocks && tries < 400 * options.blocks; ++tries) {
    Block block = random_block(robot, model, moving, options.size, random);
    const auto found = memory.run(model.kernel, block.values.get(), moving ? block.half_widths.get() : nullptr);
    if (!found.undecided && !found.colliding) blocks.push_back(std::move(block));
  }
  return blocks;
}

double seconds_of(const BatchModel& model, const std::vector<Block>& blocks, bool moving, int repeats) {
  Memory memory(model);
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < repeats; ++i) {
    const double start = cpu_seconds();
    for (const Block& block : blocks)
      memory.run(model.kernel, block.values.get(), moving ? block.half_widths.get() : nullptr);
    best = std::min(best, cpu_seconds() - start);
  }
  return best;
}

bench::KernelOperations operations_of(batch::KernelFunction counted, const BatchModel& model,
                                      const std::vector<Block>& blocks, bool moving) {
  Memory memory(model);
  bench::kernel_operations = {};
  for (const Block& block : blocks) memory.run(counted, block.values.get(), moving ? block.half_widths.get() : nullptr);
  return bench::kernel_operations;
}

/// An instruction set's counting kernel and its peak.
struct Roof {
  batch::KernelFunction counted;
  bench::Peak peak;
};

Roof roof_of(SimdBackend backend) {
#if defined(__x86_64__)
  if (backend == SimdBackend::avx512) return {&batch::run_counted_avx512, bench::peak_avx512()};
  if (backend == SimdBackend::avx2) return {&batch::run_counted_avx2, bench::peak_avx2()};
#endif
  return {&batch::run_counted_portable, bench::peak_portable()};
}

void report(const std::shared_ptr<const RobotModel>& robot, const std::shared_ptr<CoverStore>& covers,
            const std::string& file, const Options& options) {
  Scene scene;
  scene.add_robot(robot);
  io::apply(io::read_moveit_scene(file), scene);
  const detail::RobotGroup group(scene, {robot->name()});
  const detail::SceneModel scene_model(scene, group, {.mode = CheckMode::exact, .covers = covers});
  for (const bool moving : {false, true})
    for (const SimdBackend backend : available_simd_backends()) {
      const BatchModel model(scene_model.batch_scene.robot, scene_model.batch_scene.pairs, backend);
      const std::vector<Block> blocks = free_blocks(*robot, model, moving, options);
      const auto [kernel, peak] = roof_of(backend);
      const bench::KernelOperations counted = operations_of(kernel, model, blocks, moving);
      const double at_best = static_cast<double>(counted.arithmetic) / peak.arithmetic +
                             static_cast<double>(counted.square_root) / peak.square_root +
                             static_cast<double>(counted.gather) / peak.gather;
      std::printf(
          "{\"scene\": \"%s\", \"moving\": %s, \"backend\": \"%s\", \"blocks\": %zu, \"seconds\": %.9f, \"at_best_s\": "
          "%.9f, \"arithmetic\": %llu, \"square_roots\": %llu, \"gathers\": %llu, \"peak_arithmetic\": %.4g}\n",
          file.c_str(), moving ? "true" : "false", to_string(backend).c_str(), blocks.size(),
          seconds_of(model, blocks, moving, options.repeats), at_best,
          static_cast<unsigned long long>(counted.arithmetic), static_cast<unsigned long long>(counted.square_root),
          static_cast<unsigned long long>(counted.gather), peak.arithmetic);
      std::fflush(stdout);
    }
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 8) {
    std::fprintf(stderr, "usage: bench_roof URDF SRDF GROUP BLOCKS SIZE REPEATS SCENE.yaml ...\n");
    return 2;
  }
  RobotDescription description;
  description.urdf_path = arguments[1];
  description.srdf_path = arguments[2];
  description.group = arguments[3];
  const Options options{std::stoul(arguments[4]), std::atof(arguments[5]), std::atoi(arguments[6])};
  try {
    const auto robot = RobotModel::load(description);
    const auto covers = std::make_shared<CoverStore>();
    for (int i = 7; i < count; ++i) report(robot, covers, arguments[i], options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
  return 0;
}
