// BarrierProof, by flood fill over the space of a robot that has two joints, and by the planners of one with more.
#include "srmp/planning/strategies/barrier_proof.hpp"

#include <algorithm>
#include <boost/test/unit_test.hpp>
#include <cmath>
#include <vector>

#include "collision/worlds.hpp"

using namespace srmp;
using namespace worlds;

namespace {

/// Which points of a grid over both joints, from -3 to 3 [rad], are reached from the first one by free motions.
class Flood {
 public:
  Flood(const Checker& checker, const Eigen::Vector2d& from) : checker_(checker), reached_(size * size) {
    const auto workspace = checker.make_workspace();
    std::vector<std::size_t> open;
    const auto enter = [&](const Eigen::VectorXd& before, std::size_t to) {
      if (reached_[to] || !checker_.is_free(point(to), *workspace) ||
          !checker_.is_motion_free(before, point(to), *workspace))
        return;
      reached_[to] = 1;
      open.push_back(to);
    };
    for_each_near(from, [&](std::size_t to) { enter(from, to); });
    while (!open.empty()) {
      const Eigen::VectorXd here = point(open.back());
      open.pop_back();
      for_each_near(here, [&](std::size_t to) { enter(here, to); });
    }
  }

  bool reaches(const Eigen::Vector2d& to) const {
    const auto workspace = checker_.make_workspace();
    bool result = false;
    for_each_near(to, [&](std::size_t from) {
      result = result || (reached_[from] && checker_.is_motion_free(point(from), to, *workspace));
    });
    return result;
  }

 private:
  static constexpr std::size_t size = 121;
  static constexpr double step = 6.0 / (size - 1);

  static Eigen::VectorXd point(std::size_t i) { return Eigen::Vector2d(i % size, i / size).array() * step - 3.0; }
  template <class Visit>
  static void for_each_near(const Eigen::Vector2d& q, Visit&& visit) {
    const Eigen::Array2i at = ((q.array() + 3.0) / step).round().cast<int>();
    for (int i = std::max(at[0] - 1, 0); i <= std::min(at[0] + 1, int(size) - 1); ++i)
      for (int j = std::max(at[1] - 1, 0); j <= std::min(at[1] + 1, int(size) - 1); ++j)
        visit(static_cast<std::size_t>(i + j * int(size)));
  }

  const Checker& checker_;
  std::vector<char> reached_;
};

Scene random_boxes(Dice& dice) {
  Scene scene;
  scene.add_robot(spheres());
  for (int i = 0; i < 5; ++i) {
    const double angle = dice.in(-3, 3), distance = dice.in(0.7, 2.0);  // the base is free
    scene.add_object("box" + std::to_string(i), Box{{dice.in(0.1, 0.5), dice.in(0.1, 0.5), 0.4}},
                     at(distance * std::cos(angle), distance * std::sin(angle), 0.0, 0, 0, dice.in(-3, 3)));
  }
  return scene;
}

}  // namespace

BOOST_AUTO_TEST_CASE(what_is_proved_to_have_no_path_has_none_on_a_grid) {
  int count_proved = 0, reached = 0, neither = 0;
  for (unsigned seed = 1; seed <= 120; ++seed) {
    Dice dice(seed);
    const Scene scene = random_boxes(dice);
    const auto checker = make_checker(scene, "planar");
    const auto workspace = checker->make_workspace();
    const auto draw = [&] {
      Eigen::VectorXd q = Eigen::Vector2d(dice.in(-3, 3), 0.0);
      for (q[1] = dice.in(-3, 3); !checker->is_free(q, *workspace); q[1] = dice.in(-3, 3)) q[0] = dice.in(-3, 3);
      return q;
    };
    const Eigen::VectorXd from = draw();
    const Flood flood(*checker, from);
    BarrierProof proof(checker->robot(), {0, 1}, from, *workspace);
    for (int trial = 0; trial < 3; ++trial) {
      const Eigen::VectorXd to = draw();
      auto outcome = BarrierProof::Outcome::unfinished;
      while (outcome == BarrierProof::Outcome::unfinished && proof.cells() < 60'000) outcome = proof.run(to, 1000);
      const bool proved = outcome == BarrierProof::Outcome::no_path;
      const bool reaches = flood.reaches(to);
      BOOST_CHECK_MESSAGE(!(proved && reaches), "seed " << seed);
      ++(proved ? count_proved : reaches ? reached : neither);
      if (proved) BOOST_TEST(proof.reason(to).find("'a' and 'b' cannot get from (") != std::string::npos);
    }
  }
  BOOST_TEST_MESSAGE(count_proved << " proved, " << reached << " reached, " << neither << " neither");
  BOOST_TEST(count_proved > 40);
  BOOST_TEST(reached > 100);
  BOOST_TEST(neither <= 3);
}
