// What speeds checks up changes no result: covers of every quality, and tables of pairs of links, decide as Coal alone
// does, also where a motion ends within micrometres of contact.

#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"
#include "srmp/collision/pair_table.hpp"
#include "srmp/cover/geometry_content.hpp"
#include "srmp/cover/quick_cover.hpp"
#include "srmp/robot/robot_cover.hpp"
#include "support/amount.hpp"

using namespace srmp;
using namespace worlds;

namespace {

/// Checkers of one scene: Coal alone, with quick covers, with refined covers, and with tables as well.
struct Checkers {
  explicit Checkers(const Scene& scene, const std::string& robot) {
    const RobotInstance& instance = scene.robot(robot);
    const auto quick = std::make_shared<CoverStore>(""), refined = std::make_shared<CoverStore>("");
    BOOST_TEST(!ensure_covered(*instance.model, *quick));
    cover_robot(*instance.model, *refined, {.levels = {.coarse = 0.04, .fine = 0.02}});
    BOOST_TEST(ensure_covered(*instance.model, *refined));
    const auto tables = std::make_shared<PairTableStore>("");
    tables->tables(instance.model, parts_of_all(*instance.model));
    add(scene, robot, {.mode = CheckMode::coal});
    add(scene, robot, {.covers = quick});
    add(scene, robot, {.covers = refined});
    add(scene, robot, {.covers = quick, .pair_tables = tables});
  }

  void add(const Scene& scene, const std::string& robot, const CheckerOptions& options) {
    all.push_back(make_checker(scene, robot, options));
    workspaces.push_back(all.back()->make_workspace());
  }

  /// Whether the motion is free, for all of them.
  bool check(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    const bool free = all[0]->is_motion_free(a, b, *workspaces[0]);
    for (std::size_t i = 1; i < all.size(); ++i) BOOST_TEST(all[i]->is_motion_free(a, b, *workspaces[i]) == free);
    return free;
  }

  std::vector<std::unique_ptr<const Checker>> all;
  std::vector<Checker::WorkspacePtr> workspaces;
};

/// Motions from free configurations that end `short_of` of contact [rad], found by bisection.
std::vector<std::pair<Eigen::VectorXd, Eigen::VectorXd>> grazing_motions(const Checker& checker, int count) {
  const auto workspace = checker.make_workspace();
  Dice dice(11);
  std::vector<std::pair<Eigen::VectorXd, Eigen::VectorXd>> motions;
  while (count > 0) {
    const Eigen::VectorXd a = dice.configuration(checker.robot());
    Eigen::VectorXd b = a;
    for (double& value : b) value += dice.in(-0.5, 0.5);
    if (!checker.is_free(a, *workspace) || checker.is_free(b, *workspace)) continue;
    double low = 0, high = 1;
    for (int i = 0; i < 40; ++i) {
      const double middle = (low + high) / 2;
      (checker.is_free(a + middle * (b - a), *workspace) ? low : high) = middle;
    }
    for (const double short_of : {1e-7, 1e-6, 5e-6, 1e-5, 2e-5, 4e-5, 1e-4, 1e-3})
      motions.emplace_back(a, a + std::max(0.0, low - short_of / (b - a).norm()) * (b - a));
    --count;
  }
  return motions;
}

void compare(const Scene& scene, const std::string& robot, int count) {
  Checkers checkers(scene, robot);
  int free = 0, all = 0;
  for (const auto& [a, b] : grazing_motions(*checkers.all[0], count)) {
    free += checkers.check(a, b);
    ++all;
  }
  BOOST_TEST((free > all / 10 && free < all));
  Dice dice(5);
  for (int i = 0; i < 10 * count; ++i) {
    const Eigen::VectorXd a = dice.configuration(checkers.all[0]->robot());
    Eigen::VectorXd b = a;
    for (double& value : b) value += dice.in(-0.5, 0.5);
    checkers.check(a, b);
    const auto nearest = checkers.all[0]->nearest(a, *checkers.workspaces[0]);
    for (std::size_t k = 1; k < checkers.all.size(); ++k) {
      const auto other = checkers.all[k]->nearest(a, *checkers.workspaces[k]);
      BOOST_REQUIRE(other.has_value() == nearest.has_value());
      if (nearest) BOOST_TEST((other->distance == nearest->distance && other->body_a == nearest->body_a));
    }
  }
}

}  // namespace

BOOST_AUTO_TEST_CASE(no_result_depends_on_covers_or_tables) {
  compare(crowd(arm7(), 3, 5, "arm7_hand"), "arm7", amount(60));
  compare(crowd(slide(), 7, 2, "tip"), "slide", amount(60));
}

BOOST_AUTO_TEST_CASE(no_result_of_robots_of_meshes_depends_on_covers_or_tables) {
  for (const auto& robot : robots_of_meshes()) {
    std::vector<std::string> fingers;
    for (const std::string& link : robot->link_names())
      if (link.find("finger") != std::string::npos) fingers.push_back(link);
    compare(crowd(robot, 5, 3, hand_of(*robot), fingers), robot->name(), amount(60));
  }
}

BOOST_AUTO_TEST_CASE(quick_covers_contain_their_geometries) {
  std::vector<std::shared_ptr<const RobotModel>> robots = robots_of_meshes();
  robots.insert(robots.end(), {arm7(), slide()});
  for (const auto& robot : robots) {
    for (const LinkGeometry& geometry : robot->geometries()) {
      const GeometryCover cover = quick_cover(*geometry.shape);
      const GeometryContent content = content_of(*geometry.shape);
      std::vector<Eigen::Vector3d> points = content.vertices;
      Dice dice(1);
      for (const auto& t : content.triangles) {
        const double u = dice.in(0, 1), v = dice.in(0, 1 - u);
        points.push_back(u * points[t[0]] + v * points[t[1]] + (1 - u - v) * points[t[2]]);
      }
      for (const Eigen::Vector3d& p : points) {
        const auto has = [&](const PlacedSphere& s) { return (p - s.center).norm() <= s.radius; };
        BOOST_TEST(has(cover.bound));
        bool by_children = false;
        for (std::size_t c = 0; c < cover.coarse.size() && !by_children; ++c)
          by_children = has(cover.coarse[c]) && std::any_of(cover.children[c].begin(), cover.children[c].end(),
                                                            [&](std::uint32_t f) { return has(cover.fine[f]); });
        BOOST_TEST((cover.exact || by_children));
      }
    }
  }
}
