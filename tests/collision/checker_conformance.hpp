#pragma once

#include <boost/test/unit_test.hpp>
#include <functional>
#include <string>
#include <thread>

#include "collision/worlds.hpp"
#include "srmp/collision/checker.hpp"
#include "srmp/core/error.hpp"
#include "support/throws.hpp"

// The laws of a collision backend (srmp/collision/checker.hpp), for whoever writes one:
//
//   conformance::check_laws({"mine", my_factory, scene, "robot"});
namespace conformance {

using namespace srmp;

struct Backend {
  std::string name;
  CheckerFactory make;
  Scene scene;
  std::string robot;
  CheckerOptions options{};
  /// Does it find every motion free that keeps 5 mm of clearance? A conservative backend need not.
  bool complete{true};
};

constexpr double distance_tolerance = 5e-6;  // [m] two computations of one distance may differ by this
constexpr double sample_step = 5e-4;         // [m] that no point of the robot moves between two samples of a motion
constexpr double clearance = 5e-3;           // [m] with which a motion must be found free

struct Motion {
  Eigen::VectorXd a, b;
};

inline std::vector<Motion> random_motions(const Checker& checker, unsigned seed, int count, double size) {
  worlds::Dice dice(seed);
  std::vector<Motion> motions;
  for (int i = 0; i < count; ++i) {
    Motion motion{dice.configuration(checker.robot()), {}};
    motion.b = motion.a;
    for (double& value : motion.b) value += dice.in(-size, size);
    motions.push_back(std::move(motion));
  }
  return motions;
}

/// Visits samples of the motion, both ends included, until `visit` returns false.
template <class Visit>
bool all_samples(const Checker& checker, const Motion& motion, Visit&& visit) {
  const Eigen::VectorXd change = checker.robot().difference(motion.a, motion.b);
  const int steps = 1 + static_cast<int>(checker.reach().dot(change.cwiseAbs()) / sample_step);
  for (int i = 0; i <= steps; ++i)
    if (!visit(Eigen::VectorXd(motion.a + change * (static_cast<double>(i) / steps)))) return false;
  return true;
}

/// A motion that is called free has free samples; one with clearance is called free.
inline void motions_agree_with_samples(const Checker& checker, bool complete) {
  const auto workspace = checker.make_workspace();
  int free = 0, total = 0;
  for (const Motion& motion : random_motions(checker, 1, 60, 0.4)) {
    const bool is_free = checker.is_motion_free(motion.a, motion.b, *workspace);
    const bool by_spheres = checker.is_motion_free(motion.a, motion.b, *workspace, {.spheres_only = true});
    const bool certified = checker.certify_motion(motion.a, motion.b, *workspace).proved;
    const auto is_free_at = [&](const Eigen::VectorXd& q) { return checker.is_free(q, *workspace); };
    if (is_free || by_spheres || certified) BOOST_TEST(all_samples(checker, motion, is_free_at));
    const auto keeps_clear = [&](const Eigen::VectorXd& q) {
      const auto nearest = checker.nearest(q, *workspace);
      return !nearest || nearest->distance > clearance;
    };
    if (complete && !(is_free && certified)) BOOST_TEST(!all_samples(checker, motion, keeps_clear));
    if (is_free_at(motion.a))
      BOOST_TEST(is_free == checker.is_motion_free(motion.a, motion.b, *workspace, {.start_is_free = true}));
    free += is_free;
    ++total;
  }
  BOOST_TEST((free > 0 && free < total));
}

/// Both ends belong to a motion, and a motion from a configuration to itself is the configuration.
inline void ends_belong_to_motions(const Checker& checker, bool complete) {
  const auto workspace = checker.make_workspace();
  for (const Motion& motion : random_motions(checker, 2, 200, 0.2)) {
    const bool ends = checker.is_free(motion.a, *workspace) && checker.is_free(motion.b, *workspace);
    if (checker.is_motion_free(motion.a, motion.b, *workspace)) BOOST_TEST(ends);
    const bool stays = checker.is_motion_free(motion.a, motion.a, *workspace);
    const auto nearest = checker.nearest(motion.a, *workspace);
    if (stays) BOOST_TEST(checker.is_free(motion.a, *workspace));
    if (complete && (!nearest || nearest->distance > clearance)) BOOST_TEST(stays);
  }
}

/// are_free says what is_free says; with spheres only, never more.
inline void rows_agree_with_single_configurations(const Checker& checker, bool complete) {
  const auto workspace = checker.make_workspace();
  const auto motions = random_motions(checker, 3, 37, 0.1);  // not a multiple of a block
  const auto count = static_cast<Eigen::Index>(motions.size());
  RowMatrix rows(count, static_cast<Eigen::Index>(checker.dof()));
  for (Eigen::Index i = 0; i < count; ++i) rows.row(i) = motions[static_cast<std::size_t>(i)].a.transpose();
  const std::unique_ptr<bool[]> free(new bool[motions.size()]), by_spheres(new bool[motions.size()]);
  checker.are_free(rows, {free.get(), motions.size()}, *workspace);
  checker.are_free(rows, {by_spheres.get(), motions.size()}, *workspace, {.spheres_only = true});
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const bool single = checker.is_free(motions[i].a, *workspace);
    if (complete) BOOST_TEST(free[i] == single);
    if (free[i] || by_spheres[i]) BOOST_TEST(single);
  }
  checker.are_free(RowMatrix(0, rows.cols()), {}, *workspace);
}

/// find_colliding says true only where is_free says no, before motions were checked and after.
inline void colliding_rows_are_not_free(const Checker& checker) {
  const auto workspace = checker.make_workspace();
  const auto motions = random_motions(checker, 9, 200, 0.5);
  RowMatrix ends(static_cast<Eigen::Index>(motions.size()), static_cast<Eigen::Index>(checker.dof()));
  for (std::size_t i = 0; i < motions.size(); ++i) ends.row(static_cast<Eigen::Index>(i)) = motions[i].b.transpose();
  const std::unique_ptr<bool[]> colliding(new bool[motions.size()]);
  for (int round = 0; round < 2; ++round) {
    checker.find_colliding(ends, {colliding.get(), motions.size()}, *workspace);
    for (std::size_t i = 0; i < motions.size(); ++i) {
      if (colliding[i]) BOOST_TEST(!checker.is_free(motions[i].b, *workspace));
      checker.is_motion_free(motions[i].a, motions[i].b, *workspace);
    }
  }
  checker.find_colliding(RowMatrix(0, ends.cols()), {}, *workspace);
}

/// contacts is empty exactly where is_free; nearest is its first entry, or farther apart than 0.
inline void reports_agree_with_is_free(const Checker& checker) {
  const auto workspace = checker.make_workspace();
  int free = 0, colliding = 0;
  for (const auto& [q, unused] : random_motions(checker, 4, 300, 0.0)) {
    const bool is_free = checker.is_free(q, *workspace);
    const std::vector<Contact> contacts = checker.contacts(q, *workspace);
    const auto nearest = checker.nearest(q, *workspace);
    ++(is_free ? free : colliding);
    BOOST_TEST(contacts.empty() == is_free);
    const double clearance = checker.clearance(q, *workspace);
    if (nearest)
      BOOST_TEST(std::abs(clearance - nearest->distance) < distance_tolerance);
    else
      BOOST_TEST(clearance == std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      BOOST_TEST(contacts[i].distance <= distance_tolerance);
      if (i > 0) BOOST_TEST(contacts[i - 1].distance <= contacts[i].distance);
      for (std::size_t j = 0; j < i; ++j)
        BOOST_TEST((contacts[i].body_a != contacts[j].body_a || contacts[i].body_b != contacts[j].body_b));
    }
    if (is_free && nearest) {
      BOOST_TEST(nearest->distance > -distance_tolerance);
      const double between = (nearest->point_a - nearest->point_b).norm() - nearest->padding;
      BOOST_TEST(std::abs(between - nearest->distance) < distance_tolerance);
    } else if (!is_free) {
      BOOST_REQUIRE(nearest.has_value());
      BOOST_TEST(nearest->distance == contacts.front().distance);
      BOOST_TEST(nearest->describe() == contacts.front().describe());
    }
  }
  BOOST_TEST((free > 0 && colliding > 0));
}

/// reach() bounds how fast the distance of nearest changes.
inline void reach_bounds_the_change_of_distance(const Checker& checker) {
  const auto workspace = checker.make_workspace();
  const Eigen::VectorXd reach = checker.reach();
  BOOST_REQUIRE(reach.size() == static_cast<Eigen::Index>(checker.dof()));
  for (const Motion& motion : random_motions(checker, 5, 200, 0.1)) {
    if (!checker.is_free(motion.a, *workspace) || !checker.is_free(motion.b, *workspace)) continue;
    const auto a = checker.nearest(motion.a, *workspace), b = checker.nearest(motion.b, *workspace);
    BOOST_REQUIRE(a.has_value() == b.has_value());
    if (!a) continue;
    const double moved = reach.dot((motion.b - motion.a).cwiseAbs());
    BOOST_TEST(std::abs(a->distance - b->distance) <= 2.0 * moved + distance_tolerance);
  }
}

/// Wrong sizes, NaN and the workspace of another checker are refused.
inline void bad_input_is_refused(const Checker& checker, const Checker& other) {
  const auto workspace = checker.make_workspace(), foreign = other.make_workspace();
  const auto dof = static_cast<Eigen::Index>(checker.dof());
  const Eigen::VectorXd good = Eigen::VectorXd::Zero(dof), longer = Eigen::VectorXd::Zero(dof + 1);
  Eigen::VectorXd bad = good;
  bad[dof - 1] = std::numeric_limits<double>::quiet_NaN();
  check_throws<InvalidArgument>([&] { checker.is_free(longer, *workspace); }, "configuration has");
  check_throws<InvalidArgument>([&] { checker.is_free(bad, *workspace); }, "NaN");
  check_throws<InvalidArgument>([&] { checker.is_motion_free(bad, good, *workspace); }, "start of the motion");
  check_throws<InvalidArgument>([&] { checker.is_motion_free(good, bad, *workspace); }, "end of the motion");
  check_throws<InvalidArgument>([&] { checker.certify_motion(good, longer, *workspace); }, "end of the motion");
  check_throws<InvalidArgument>([&] { checker.contacts(bad, *workspace); }, "NaN");
  check_throws<InvalidArgument>([&] { checker.nearest(longer, *workspace); }, "configuration has");
  RowMatrix rows = RowMatrix::Zero(2, dof);
  bool free[2];
  check_throws<InvalidArgument>([&] { checker.are_free(rows, {free, 1}, *workspace); }, "room for 1");
  check_throws<InvalidArgument>([&] { checker.find_colliding(rows, {free, 1}, *workspace); }, "room for 1");
  rows(1, 0) = std::numeric_limits<double>::infinity();
  check_throws<InvalidArgument>([&] { checker.are_free(rows, {free, 2}, *workspace); }, "configuration 1");
  check_throws<InvalidArgument>([&] { checker.find_colliding(rows, {free, 2}, *workspace); }, "configuration 1");
  check_throws<InvalidArgument>([&] { checker.is_free(good, *foreign); }, "another checker");
  check_throws<InvalidArgument>([&] { checker.is_motion_free(good, good, *foreign); }, "another checker");
}

/// All results for some motions, as text.
inline std::string results(const Checker& checker, const std::vector<Motion>& motions, Checker::Workspace& workspace) {
  std::string text;
  for (const Motion& motion : motions) {
    text += checker.is_free(motion.a, workspace) ? "free " : "not free ";
    text += checker.is_motion_free(motion.a, motion.b, workspace) ? "free " : "not free ";
    const MotionCertificate certificate = checker.certify_motion(motion.a, motion.b, workspace);
    text.append(to_text(certificate.from)).append(" ").append(to_text(certificate.to));
    text.append(certificate.body_a).append(certificate.body_b);
    if (const auto nearest = checker.nearest(motion.a, workspace))
      text.append(nearest->describe()).append(to_text(nearest->distance));
    text += "\n";
  }
  return text;
}

/// Results depend neither on earlier queries nor on the workspace; threads share a checker.
inline void results_depend_on_the_arguments_alone(const Checker& checker) {
  const std::vector<Motion> motions = random_motions(checker, 6, 40, 0.3);
  std::string fresh;
  for (const Motion& motion : motions) fresh += results(checker, {motion}, *checker.make_workspace());
  const auto used = checker.make_workspace(), other = checker.make_workspace();
  results(checker, random_motions(checker, 7, 20, 0.5), *used);
  BOOST_TEST(results(checker, motions, *used) == fresh);
  std::string interleaved;
  for (const Motion& motion : motions) {
    interleaved += results(checker, {motion}, *used);
    results(checker, random_motions(checker, 8, 1, 0.5), *other);
  }
  BOOST_TEST(interleaved == fresh);
  std::string first, second;
  const auto run = [&](std::string& text) { text = results(checker, motions, *checker.make_workspace()); };
  std::thread one([&] { run(first); }), two([&] { run(second); });
  one.join();
  two.join();
  BOOST_TEST(first == fresh);
  BOOST_TEST(second == fresh);
}

/// The public functions count.
inline void statistics_count_queries(const Checker& checker) {
  const auto workspace = checker.make_workspace(), idle = checker.make_workspace();
  const auto [a, b] = random_motions(checker, 9, 1, 0.1).front();
  RowMatrix rows(3, a.size());
  rows.rowwise() = a.transpose();
  bool free[3];
  checker.is_free(a, *workspace);
  checker.are_free(rows, free, *workspace);
  checker.is_motion_free(a, b, *workspace);
  checker.certify_motion(a, b, *workspace);
  BOOST_TEST(checker.statistics(*workspace).states == 4u);
  BOOST_TEST(checker.statistics(*workspace).motions == 2u);
  BOOST_TEST(checker.statistics(*idle).states == 0u);
}

inline void check_laws(const Backend& backend) {
  BOOST_TEST_CONTEXT(backend.name) {
    const auto checker = backend.make(backend.scene, backend.robot, backend.options);
    const auto other = backend.make(backend.scene, backend.robot, backend.options);
    BOOST_TEST(checker->robot().name() == backend.robot);
    BOOST_TEST(checker->dof() == checker->robot().dof());
    motions_agree_with_samples(*checker, backend.complete);
    ends_belong_to_motions(*checker, backend.complete);
    rows_agree_with_single_configurations(*checker, backend.complete);
    colliding_rows_are_not_free(*checker);
    reports_agree_with_is_free(*checker);
    reach_bounds_the_change_of_distance(*checker);
    bad_input_is_refused(*checker, *other);
    results_depend_on_the_arguments_alone(*checker);
    statistics_count_queries(*checker);
  }
}

}  // namespace conformance
