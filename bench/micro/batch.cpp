// Motions and configurations a second, by SIMD backend, against the exact checker in the same run, as JSON.
//   bench_batch ROBOT.urdf ROBOT.srdf GROUP SCENE.yaml [SCENE.yaml ...]
// A motion is 0.13 rad (7.5 degrees) in its fastest joint, from a random free configuration. CPU time, one thread.

#include <cmath>
#include <cstdio>
#include <ctime>
#include <map>
#include <random>

#include "srmp/collision/batch/batch_world.hpp"
#include "srmp/collision/bodies.hpp"
#include "srmp/collision/checker.hpp"
#include "srmp/io/moveit.hpp"
#include "srmp/robot/cover_store.hpp"

using namespace srmp;

namespace {

double cpu_seconds() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Motion {
  std::vector<double> a, d;
};

std::vector<Motion> random_motions(const RobotModel& robot, const Checker& exact, Checker::Workspace& w, int count) {
  std::mt19937 random(1);
  const auto uniform = [&](double low, double high) { return low + (high - low) * (random() * 0x1p-32); };
  std::vector<Motion> motions;
  Eigen::VectorXd q(static_cast<Eigen::Index>(robot.dof()));
  while (static_cast<int>(motions.size()) < count) {
    for (Eigen::Index k = 0; k < q.size(); ++k) {
      const Joint& joint = robot.joints()[static_cast<std::size_t>(k)];
      q[k] = uniform(std::max(joint.lower, -M_PI), std::min(joint.upper, M_PI));
    }
    if (!exact.is_free(q, w)) continue;
    Motion m{{q.begin(), q.end()}, std::vector<double>(robot.dof())};
    double most = 0;
    for (double& d : m.d) most = std::max(most, std::abs(d = uniform(-1, 1)));
    for (double& d : m.d) d *= 0.13 / most;
    motions.push_back(m);
  }
  return motions;
}

void run_backend(const BatchWorld& world, SimdBackend backend, const std::vector<Motion>& motions,
                 const std::vector<char>& free) {
  const BatchChecker checker(world, backend);
  const auto w = checker.make_workspace();
  int counts[3]{};
  std::vector<const Motion*> proved;
  int wrong = 0;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Verdict v = checker.motion(motions[i].a, motions[i].d, *w, {});
    ++counts[static_cast<int>(v)];
    wrong += (v == Verdict::free && !free[i]) || (v == Verdict::colliding && free[i]);
    if (checker.motion_block(motions[i].a, motions[i].d, *w) == Verdict::free) proved.push_back(&motions[i]);
  }
  const auto time = [&](auto&& body) {
    double best = 1e9;
    for (int repeat = 0; repeat < 5; ++repeat) {
      const double start = cpu_seconds();
      body();
      best = std::min(best, cpu_seconds() - start);
    }
    return best;
  };
  const double block = time([&] {
    for (const Motion* m : proved) checker.motion_block(m->a, m->d, *w);
  });
  const double all = time([&] {
    for (const Motion& m : motions) checker.motion(m.a, m.d, *w, {});
  });
  std::printf(
      "\"%s\": {\"free\": %d, \"colliding\": %d, \"undecided\": %d, \"wrong\": %d, \"one_block\": %zu, "
      "\"free_block_configurations_per_s\": %.3g, \"motion_us\": %.3f}",
      to_string(backend).c_str(), counts[0], counts[1], counts[2], wrong, proved.size(),
      16.0 * static_cast<double>(proved.size()) / block, 1e6 * all / static_cast<double>(motions.size()));
}

void run_scene(const std::shared_ptr<const RobotModel>& robot, const std::string& file,
               const std::shared_ptr<CoverStore>& covers) {
  Scene scene;
  scene.add_robot(robot);
  io::apply(io::read_moveit_scene(file), scene);
  const Checker coal(scene, robot->name(), {.mode = CheckMode::coal});
  const Checker exact(scene, robot->name(), {.mode = CheckMode::exact, .covers = covers});
  const std::vector<Motion> motions = random_motions(*robot, coal, *coal.make_workspace(), 500);
  const auto judge = [&](const Checker& checker, double& seconds) {
    const auto w = checker.make_workspace();
    std::vector<char> free;
    const double start = cpu_seconds();
    for (const Motion& m : motions) {
      const auto n = static_cast<Eigen::Index>(m.a.size());
      const Eigen::VectorXd a = Eigen::Map<const Eigen::VectorXd>(m.a.data(), n);
      free.push_back(checker.is_motion_free(a, a + Eigen::Map<const Eigen::VectorXd>(m.d.data(), n), *w, true));
    }
    seconds = cpu_seconds() - start;
    return free;
  };
  double coal_s{}, exact_s{};
  const std::vector<char> free = judge(coal, coal_s);
  const bool agree = free == judge(exact, exact_s);
  const detail::RobotGroup group(scene, {robot->name()});
  const detail::Bodies bodies(scene, group);
  const double before = cpu_seconds();
  const detail::BatchScene batch =
      detail::make_batch_scene(bodies, group, [&](const auto& s) -> auto& { return covers->cover(s); });
  std::printf(
      "{\"scene\": \"%s\", \"setup_s\": %.3f, \"coal_motion_us\": %.3f, \"exact_motion_us\": %.3f, \"agree\": %s, "
      "\"free\": %d",
      file.c_str(), cpu_seconds() - before, 1e6 * coal_s / static_cast<double>(motions.size()),
      1e6 * exact_s / static_cast<double>(motions.size()), agree ? "true" : "false",
      static_cast<int>(std::count(free.begin(), free.end(), 1)));
  for (SimdBackend backend : available_simd_backends()) {
    std::printf(",\n  ");
    run_backend(batch.world, backend, motions, free);
  }
  std::printf("}");
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 5) {
    std::fprintf(stderr, "usage: bench_batch ROBOT.urdf ROBOT.srdf GROUP SCENE.yaml ...\n");
    return 2;
  }
  RobotDescription description;
  description.urdf_path = arguments[1];
  description.srdf_path = arguments[2];
  description.group = arguments[3];
  const auto robot = RobotModel::load(description);
  const auto covers = std::make_shared<CoverStore>();
  std::printf("[");
  for (int i = 4; i < count; ++i) {
    run_scene(robot, arguments[i], covers);
    std::printf(i + 1 < count ? ",\n" : "]\n");
  }
  return 0;
}
