// CheckerOptions::clearance: by the distances of a checker without it.
#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"
#include "srmp/core/error.hpp"
#include "support/throws.hpp"

using namespace srmp;
using namespace worlds;

namespace {

constexpr double rounding = 1e-5;  // [m] of distances

std::unique_ptr<const Checker> make(const Scene& scene, double clearance, CheckMode mode) {
  return make_checker(scene, "arm7", {.mode = mode, .clearance = clearance});
}

}  // namespace

BOOST_AUTO_TEST_CASE(configurations_are_free_where_every_pair_keeps_the_clearance) {
  constexpr double clearance = 0.015;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Scene scene = crowd(arm7(), seed, seed, "arm7_hand", {"arm7_palm", "arm7_flange"});
    const auto plain = make(scene, 0.0, CheckMode::coal);
    const auto there = plain->make_workspace();
    Dice dice(seed);
    RowMatrix q(200, 7);
    for (Eigen::Index i = 0; i < q.rows(); ++i) q.row(i) = dice.configuration(plain->robot()).transpose();
    int close = 0, free_ones = 0;
    for (const CheckMode mode : {CheckMode::coal, CheckMode::exact, CheckMode::conservative}) {
      const auto checker = make(scene, clearance, mode);
      BOOST_CHECK_EQUAL(checker->clearance_kept(), clearance);
      const auto workspace = checker->make_workspace();
      const auto free = std::make_unique<bool[]>(static_cast<std::size_t>(q.rows()));
      checker->are_free(q, {free.get(), static_cast<std::size_t>(q.rows())}, *workspace);
      for (Eigen::Index i = 0; i < q.rows(); ++i) {
        const Eigen::VectorXd row = q.row(i).transpose();
        const double distance = plain->clearance(row, *there);
        if (std::abs(distance - clearance) < rounding) continue;
        const bool expected = distance > clearance;
        close += distance > 0.0 && !expected;
        free_ones += expected;
        if (mode != CheckMode::conservative || !expected) BOOST_CHECK_EQUAL(free[i], expected);
        BOOST_CHECK_EQUAL(checker->is_free(row, *workspace), expected);
        if (plain->is_free(row, *there))
          BOOST_CHECK_SMALL(checker->clearance(row, *workspace) + clearance - distance, rounding);
      }
    }
    BOOST_CHECK_GT(close, 0);
    BOOST_CHECK_GT(free_ones, 0);
  }
}

BOOST_AUTO_TEST_CASE(motions_that_are_free_keep_the_clearance_everywhere) {
  constexpr double clearance = 0.01;
  const Scene scene = crowd(arm7(), 7, 0, "arm7_hand", {"arm7_palm", "arm7_flange"});
  const auto plain = make(scene, 0.0, CheckMode::coal), exact = make(scene, clearance, CheckMode::exact),
             coal = make(scene, clearance, CheckMode::coal);
  const auto there = plain->make_workspace(), workspace = exact->make_workspace(), other = coal->make_workspace();
  Dice dice(7);
  int free = 0;
  for (int i = 0; i < 300; ++i) {
    const Eigen::VectorXd a = dice.configuration(plain->robot());
    const Eigen::VectorXd b = a + 0.15 * (dice.configuration(plain->robot()) - a);
    const bool is_free = exact->is_motion_free(a, b, *workspace);
    BOOST_CHECK_EQUAL(is_free, coal->is_motion_free(a, b, *other));
    if (!is_free) continue;
    ++free;
    for (int k = 0; k <= 50; ++k)
      BOOST_CHECK_GT(plain->clearance(a + k / 50.0 * (b - a), *there), clearance - rounding);
  }
  BOOST_CHECK_GT(free, 10);
}

BOOST_AUTO_TEST_CASE(links_that_are_built_closer_only_may_not_touch) {
  Scene scene;
  scene.add_robot(arm7());
  const auto names = [&](double clearance) {
    return SceneChecker(scene, "arm7", {.mode = CheckMode::coal, .clearance = clearance}).close_links();
  };
  BOOST_CHECK(names(0.0).empty());
  BOOST_CHECK(names(0.015).empty());
  BOOST_CHECK(!names(0.025).empty());
  const SceneChecker checker(scene, "arm7", {.mode = CheckMode::exact, .clearance = 0.05});
  BOOST_CHECK(checker.is_free(Eigen::VectorXd::Constant(7, 0.3), *checker.make_workspace()));
}

BOOST_AUTO_TEST_CASE(a_clearance_that_is_no_distance_is_refused) {
  Scene scene;
  scene.add_robot(arm7());
  for (const double bad : {-0.01, std::nan(""), HUGE_VAL})
    check_throws<InvalidArgument>([&] { make(scene, bad, CheckMode::coal); }, "the clearance of a checker is");
}
