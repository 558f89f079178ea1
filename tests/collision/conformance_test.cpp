#include <boost/test/unit_test.hpp>

#include "collision/checker_conformance.hpp"
#include "srmp/collision/motion_proof.hpp"
#include "srmp/collision/timed_checker.hpp"
#include "srmp/cover/cover_store.hpp"
#include "support/amount.hpp"

using namespace srmp;
using namespace worlds;

namespace {

// docs/collision-checking.md shows this class, from here to the end of it.

/// A collision backend of one's own: two bars of discs (worlds::spheres) in the plane, among discs, by formulas.
class DiscChecker final : public Checker {
 public:
  DiscChecker(const Scene& scene, const std::string& robot, const CheckerOptions& options)
      : Checker(scene, robot, options) {
    for (const auto& [name, object] : scene.objects())
      obstacles_.push_back({name, object.pose.p, std::get<Sphere>(object.shape).radius, object.padding});
  }

 private:
  struct Disc {
    std::string body;
    Eigen::Vector3d center;  // world frame [m]
    double radius, padding;
  };

  std::vector<Disc> robot_discs(ConstVector q) const {
    std::vector<Disc> discs;
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    double angle = 0.0;
    for (const char* bar : {"upper", "lower"}) {
      angle += q[bar == std::string("upper") ? 0 : 1];
      const Eigen::Vector3d along(std::cos(angle), std::sin(angle), 0.0);
      for (const double x : {0.1, 0.3, 0.5, 0.7, 0.9}) discs.push_back({bar, base() * (origin + x * along), 0.05, 0.0});
      origin += along;
    }
    return discs;
  }

  /// The nearest discs of each pair of bodies, the deepest pair first.
  std::vector<Contact> pairs(ConstVector q) const {
    std::map<std::pair<std::string, std::string>, Contact> nearest;
    for (const Disc& a : robot_discs(q))
      for (const Disc& b : obstacles_) {
        const Eigen::Vector3d offset = b.center - a.center, direction = offset.normalized();
        const double padding = a.padding + b.padding;
        const Contact pair{a.body,
                           b.body,
                           offset.norm() - a.radius - b.radius - padding,
                           a.center + a.radius * direction,
                           b.center - b.radius * direction,
                           padding,
                           BodyKind::link,
                           BodyKind::object};
        const auto [known, added] = nearest.try_emplace({a.body, b.body}, pair);
        if (pair.distance < known->second.distance) known->second = pair;
      }
    std::vector<Contact> sorted;
    for (const auto& [names, pair] : nearest) sorted.push_back(pair);
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const Contact& a, const Contact& b) { return a.distance < b.distance; });
    return sorted;
  }

  bool do_is_free(ConstVector q, Workspace& workspace) const override { return do_contacts(q, workspace).empty(); }

  std::vector<Contact> do_contacts(ConstVector q, Workspace&) const override {
    std::vector<Contact> contacts = pairs(q);
    std::erase_if(contacts, [](const Contact& pair) { return pair.distance > 0.0; });
    return contacts;
  }

  std::optional<Contact> do_nearest(ConstVector q, Workspace&) const override {
    const std::vector<Contact> all = pairs(q);
    return all.empty() ? std::nullopt : std::optional(all.front());
  }

  std::vector<Disc> obstacles_;
};

// To here.

std::unique_ptr<const Checker> make_disc_checker(const Scene& scene, const std::string& robot,
                                                 const CheckerOptions& options) {
  return std::make_unique<const DiscChecker>(scene, robot, options);
}

Scene discs() {
  Scene scene;
  scene.add_robot(spheres(), at(0.2, -0.1, 0, 0, 0, 0.4));
  scene.add_object("near", Sphere{0.2}, at(1.2, 0.6, 0), 0.01);
  scene.add_object("far", Sphere{0.3}, at(-1.3, 1.2, 0));
  scene.add_object("small", Sphere{0.05}, at(0.3, -1.5, 0));
  return scene;
}

}  // namespace

BOOST_AUTO_TEST_CASE(the_own_checker_keeps_the_laws_in_every_mode) {
  const Scene scene = crowd(arm7(), 3, 5, "arm7_hand");
  const auto covers = std::make_shared<CoverStore>();
  for (const auto& [name, mode] : {std::pair("exact", CheckMode::exact), std::pair("coal", CheckMode::coal),
                                   std::pair("conservative", CheckMode::conservative)})
    conformance::check_laws(
        {name, make_checker, scene, "arm7", {.mode = mode, .covers = covers}, mode != CheckMode::conservative});
}

BOOST_AUTO_TEST_CASE(a_backend_of_three_functions_keeps_the_laws) {
  conformance::check_laws({"discs", make_disc_checker, discs(), "planar"});
}

BOOST_AUTO_TEST_CASE(two_backends_give_the_same_results) {
  const Scene scene = discs();
  const auto own = make_checker(scene, "planar"), other = make_disc_checker(scene, "planar", {});
  const auto a = own->make_workspace(), b = other->make_workspace();
  int free = 0;
  for (const auto& [from, to] : conformance::random_motions(*own, 10, amount(300), 0.4)) {
    const auto nearest = own->nearest(from, *a), by_formula = other->nearest(from, *b);
    BOOST_TEST(std::abs(nearest->distance - by_formula->distance) < conformance::distance_tolerance);
    BOOST_TEST((nearest->body_a == by_formula->body_a && nearest->body_b == by_formula->body_b));
    if (std::abs(by_formula->distance) < 1e-4) continue;
    BOOST_TEST(own->is_free(from, *a) == other->is_free(from, *b));
    const bool is_free = own->is_motion_free(from, to, *a);
    BOOST_TEST(is_free == other->is_motion_free(from, to, *b));
    free += is_free;
  }
  BOOST_TEST((free > amount(30) && free < amount(270)));
}

BOOST_AUTO_TEST_CASE(a_long_check_of_the_default_stops_at_the_deadline) {
  Scene scene;
  scene.add_robot(spheres());
  scene.add_object("x", Sphere{0.2}, at(1.95 + 0.2 + 1e-4, 0, 0));  // the last disc passes 0.1 mm beside it
  const auto checker = make_disc_checker(scene, "planar", {});
  const auto workspace = checker->make_workspace();
  const Eigen::Vector2d a(-0.5, 0.0), b(0.5, 0.0);
  BOOST_TEST(checker->is_motion_free(a, b, *workspace));
  const Deadline passed(1e-9);
  checker->stop_at(passed, *workspace);
  BOOST_CHECK_THROW(checker->is_motion_free(a, b, *workspace), MotionCheckStopped);
  BOOST_TEST(checker->is_motion_free(a, a, *workspace));
}

BOOST_AUTO_TEST_CASE(a_timed_checker_takes_a_backend) {
  int made = 0;
  const CheckerFactory factory = [&](const Scene& scene, const std::string& robot, const CheckerOptions& options) {
    ++made;
    BOOST_TEST(options.other_robots.size() == 1u);
    return make_checker(scene, robot, options);
  };
  Scene scene;
  scene.add_robot(arm7("left"), at(0, 0.35, 0));
  scene.add_robot(arm7("right"), at(0, -0.35, 0));
  const TimedPath still{{0.0}, {Eigen::VectorXd::Zero(7)}};
  const TimedChecker timed(scene, "left", {{"right", still}}, {.mode = CheckMode::coal}, factory);
  BOOST_TEST(made == 1);
  BOOST_TEST(timed.is_free(Eigen::VectorXd::Zero(7), 0.0, *timed.checker().make_workspace()));
}

BOOST_AUTO_TEST_CASE(proofs_of_motions_refuse_another_backend) {
  const auto checker = make_disc_checker(discs(), "planar", {});
  const Eigen::VectorXd times = Eigen::Vector2d(0, 1);
  const RowMatrix rows = RowMatrix::Zero(2, 2);
  check_throws<InvalidArgument>(
      [&] { prove_motion(*checker, {times, rows, RowMatrix(0, 2)}, *checker->make_workspace()); },
      "the library's own checker");
}
