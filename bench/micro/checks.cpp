// Collision checks of one robot in some scenes, by instruction set, against plain Coal in the same run. Prints JSON.
// bench/micro/checks.py starts it and says what the numbers mean.
//   bench_checks ROBOT.urdf ROBOT.srdf GROUP MOTIONS SIZE STEP REPEATS SCENE.yaml [SCENE.yaml ...]
// A motion starts at a random free configuration and moves each joint by up to SIZE [rad]. CPU time of one thread, best
// of REPEATS; the competitors take turns.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <random>

#include "cpu_seconds.hpp"
#include "plain_coal.hpp"
#include "srmp/collision/batch/batch_checker.hpp"
#include "srmp/collision/checker.hpp"
#include "srmp/collision/pair_table.hpp"
#include "srmp/cover/cover_store.hpp"
#include "srmp/io/moveit.hpp"

using namespace srmp;
using bench::cpu_seconds;
using bench::PlainCoal;

namespace {

/// The best of several runs.
class Stopwatch {
 public:
  template <class Body>
  void run(Body&& body) {
    const double start = cpu_seconds();
    body();
    best_ = std::min(best_, cpu_seconds() - start);
  }
  double seconds() const { return best_; }

 private:
  double best_{std::numeric_limits<double>::infinity()};
};

struct Options {
  std::size_t motions{};
  double size{}, step{};
  int repeats{};
};

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Queries {
  Rows configurations, starts;                    // random; free
  std::vector<Eigen::VectorXd> a, b, difference;  // motions from the starts
};

Queries random_queries(const RobotModel& robot, const Checker& coal, const Options& options) {
  std::mt19937 random(1);
  const auto uniform = [&](double low, double high) { return low + (high - low) * (random() * 0x1p-32); };
  const auto dof = static_cast<Eigen::Index>(robot.dof());
  const auto configuration = [&] {
    Eigen::VectorXd q(dof);
    for (Eigen::Index k = 0; k < dof; ++k) {
      const Joint& joint = robot.joints()[static_cast<std::size_t>(k)];
      q[k] = uniform(std::max(joint.lower, -M_PI), std::min(joint.upper, M_PI));
    }
    return q;
  };
  const auto count = static_cast<Eigen::Index>(options.motions);
  Queries queries{Rows(count, dof), Rows(count, dof), {}, {}, {}};
  const auto workspace = coal.make_workspace();
  for (Eigen::Index i = 0; i < queries.starts.rows(); ++i) {
    queries.configurations.row(i) = configuration().transpose();
    Eigen::VectorXd q = configuration();
    while (!coal.is_free(q, *workspace)) q = configuration();
    queries.starts.row(i) = q.transpose();
    Eigen::VectorXd d(dof);
    for (double& change : d) change = uniform(-1, 1);
    d *= options.size / d.cwiseAbs().maxCoeff();
    queries.a.push_back(q);
    queries.b.push_back(q + d);
    queries.difference.push_back(d);
  }
  return queries;
}

/// A way to check motions, and how long it takes for all of them and for those that are free.
struct Contender {
  Contender(std::string who, std::function<bool(std::size_t)> how) : name(std::move(who)), check(std::move(how)) {}

  std::string name;
  std::function<bool(std::size_t)> check;
  std::vector<char> results;
  Stopwatch all, free;

  void check_all(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) results.push_back(check(i));
  }
};

/// srmp's exact checker on one instruction set, motions and single configurations.
struct Exact {
  Exact(const Scene& scene, const std::string& robot, const std::shared_ptr<CoverStore>& covers, SimdBackend simd)
      : backend(simd), checker(make(scene, robot, covers, simd)), workspace(checker->make_workspace()) {}

  static std::unique_ptr<const Checker> make(const Scene& scene, const std::string& robot,
                                             const std::shared_ptr<CoverStore>& covers, SimdBackend simd) {
    setenv("SRMP_SIMD", to_string(simd).c_str(), 1);
    static const auto tables = std::make_shared<PairTableStore>(covers->directory());
    return make_checker(scene, robot, {.mode = CheckMode::exact, .covers = covers, .pair_tables = tables});
  }

  void time_states(const Rows& q, Stopwatch& watch, int repeats) {
    const auto count = static_cast<std::size_t>(q.rows());
    const std::unique_ptr<bool[]> free(new bool[count]);
    for (int i = 0; i < repeats; ++i) watch.run([&] { checker->are_free(q, {free.get(), count}, *workspace); });
  }

  SimdBackend backend;
  std::unique_ptr<const Checker> checker;
  Checker::WorkspacePtr workspace;
  Stopwatch random_states, free_states;
};

class Report {
 public:
  Report(const std::shared_ptr<const RobotModel>& robot, const std::shared_ptr<CoverStore>& covers,
         const Options& options)
      : robot_(robot), covers_(covers), options_(options) {}

  void run(const std::string& file) {
    Scene scene;
    scene.add_robot(robot_);
    io::apply(io::read_moveit_scene(file), scene);
    const std::string& name = robot_->name();
    const std::unique_ptr<const Checker> coal = make_checker(scene, name, {.mode = CheckMode::coal});
    const Queries queries = random_queries(*robot_, *coal, options_);
    const auto& [states, starts, a, b, d] = queries;

    PlainCoal boxes(scene, name, PlainCoal::BroadPhase::boxes), tree(scene, name, PlainCoal::BroadPhase::tree);
    std::vector<Contender> contenders;
    contenders.emplace_back("boxes", [&](std::size_t i) { return boxes.is_motion_free(a[i], d[i], options_.step); });
    contenders.emplace_back("tree", [&](std::size_t i) { return tree.is_motion_free(a[i], d[i], options_.step); });
    std::vector<Exact> exact;
    for (SimdBackend simd : available_simd_backends()) exact.emplace_back(scene, name, covers_, simd);
    for (Exact& e : exact)
      contenders.emplace_back(to_string(e.backend), [&](std::size_t i) {
        return e.checker->is_motion_free(a[i], b[i], *e.workspace, {.start_is_free = true});
      });
    const auto coal_workspace = coal->make_workspace();
    contenders.emplace_back("certified", [&](std::size_t i) {
      return coal->is_motion_free(a[i], b[i], *coal_workspace, {.start_is_free = true});
    });

    std::vector<std::size_t> free = check_all(contenders);
    time_motions(contenders, free);
    for (Exact& e : exact) {
      e.time_states(states, e.random_states, options_.repeats);
      e.time_states(starts, e.free_states, options_.repeats);
    }
    double samples = 0;
    for (std::size_t i = 0; i < options_.motions; ++i) samples += boxes.samples(a[i], d[i], options_.step);
    print(file, contenders, exact, free, samples);
  }

 private:
  /// Checks every motion once with each contender; returns those that are free.
  std::vector<std::size_t> check_all(std::vector<Contender>& contenders) const {
    for (Contender& c : contenders) c.check_all(options_.motions);
    std::vector<std::size_t> free;
    for (std::size_t i = 0; i < options_.motions; ++i)
      if (contenders.back().results[i]) free.push_back(i);
    return free;
  }

  void time_motions(std::vector<Contender>& contenders, const std::vector<std::size_t>& free) const {
    for (int repeat = 0; repeat < options_.repeats; ++repeat)
      for (Contender& c : contenders) {
        c.all.run([&] {
          for (std::size_t i = 0; i < options_.motions; ++i) c.check(i);
        });
        c.free.run([&] {
          for (std::size_t i : free) c.check(i);
        });
      }
  }

  void print(const std::string& file, const std::vector<Contender>& contenders, const std::vector<Exact>& exact,
             const std::vector<std::size_t>& free, double samples) const {
    const std::vector<char>& truth = contenders.back().results;  // Coal's distances, certified
    std::printf("{\"scene\": \"%s\", \"motions\": %zu, \"free_motions\": %zu, \"samples\": %.0f, \"contenders\": {",
                file.c_str(), options_.motions, free.size(), samples);
    for (std::size_t k = 0; k < contenders.size(); ++k) {
      const Contender& c = contenders[k];
      int missed = 0, refused = 0;  // sampling does not see what is between the samples
      for (std::size_t i = 0; i < truth.size(); ++i) {
        missed += c.results[i] && !truth[i];
        refused += !c.results[i] && truth[i];
      }
      std::printf(
          "%s\"%s\": {\"all_s\": %.9f, \"free_s\": %.9f, \"free_not_certified\": %d, \"certified_not_free\": %d",
          k ? ", " : "", c.name.c_str(), c.all.seconds(), c.free.seconds(), missed, refused);
      if (k >= 2 && k < 2 + exact.size()) {
        const Exact& e = exact[k - 2];
        std::printf(", \"random_states_s\": %.9f, \"free_states_s\": %.9f", e.random_states.seconds(),
                    e.free_states.seconds());
      }
      std::printf("}");
    }
    std::printf("}}\n");
    std::fflush(stdout);
  }

  std::shared_ptr<const RobotModel> robot_;
  std::shared_ptr<CoverStore> covers_;
  Options options_;
};

}  // namespace

int main(int count, char** arguments) {
  if (count < 9) {
    std::fprintf(stderr, "usage: bench_checks URDF SRDF GROUP MOTIONS SIZE STEP REPEATS SCENE.yaml ...\n");
    return 2;
  }
  RobotDescription description;
  description.urdf_path = arguments[1];
  description.srdf_path = arguments[2];
  description.group = arguments[3];
  const Options options{std::stoul(arguments[4]), std::atof(arguments[5]), std::atof(arguments[6]),
                        std::atoi(arguments[7])};
  try {
    Report report(RobotModel::load(description), std::make_shared<CoverStore>(), options);
    for (int i = 8; i < count; ++i) report.run(arguments[i]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
  return 0;
}
