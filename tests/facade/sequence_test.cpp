#include <boost/test/unit_test.hpp>

#include "srmp/planner_interface.hpp"
#include "support/robots.hpp"
#include "support/throws.hpp"

using Eigen::Vector2d;
using srmp::Goal;
using srmp::PlannerInterface;
using srmp::Segment;
using srmp::SegmentType;
using srmp::SequenceResult;

namespace {

/// Two bars.
PlannerInterface planar() {
  PlannerInterface planner;
  planner.add_articulation(robots::planar_description());
  return planner;
}

const Vector2d rest(-1.0, 0.0), turned(1.0, 0.0);

}  // namespace

BOOST_AUTO_TEST_SUITE(sequence)

BOOST_AUTO_TEST_CASE(motions_and_rests_are_one_trajectory) {
  PlannerInterface planner = planar();
  const SequenceResult result =
      planner.plan_sequence(rest, {Segment::move(turned), Segment::wait(0.5), Segment::move(rest)});
  BOOST_REQUIRE_EQUAL(result.parts.size(), 3u);
  BOOST_CHECK(result.parts[1].type == SegmentType::wait);
  BOOST_TEST(result.parts[1].end - result.parts[1].begin == 0.5, boost::test_tools::tolerance(1e-12));
  BOOST_TEST(result.parts[0].end == result.parts[1].begin);
  BOOST_TEST(result.parts[2].end == result.trajectory.duration());
  BOOST_TEST((result.trajectory.positions.bottomRows<1>().transpose() == rest));
  BOOST_REQUIRE(result.trajectory.certificate);
  BOOST_TEST(result.trajectory.certificate->holds());
  BOOST_TEST(result.trajectory.certificate->proved_free());
}

BOOST_AUTO_TEST_CASE(the_scene_is_as_before) {
  PlannerInterface planner = planar();
  const srmp::Pose tip = planner.compute_fk("planar", rest);
  planner.add_box("box", {0.02, 0.02, 0.02}, {tip.p + Eigen::Vector3d(0, 0, 0.5), tip.q});
  planner.set_qpos("planar", rest);
  planner.plan_sequence(rest, {Segment::attach("box", "tip"), Segment::move(turned), Segment::detach("box")});
  BOOST_TEST((planner.scene().object("box").pose.p == tip.p + Eigen::Vector3d(0, 0, 0.5)));
  BOOST_TEST((planner.scene().robot("planar").q == rest));
  BOOST_CHECK_THROW(planner.detach_object("box"), srmp::InvalidArgument);
}

BOOST_AUTO_TEST_CASE(bad_segments_are_named) {
  PlannerInterface planner = planar();
  check_throws<srmp::InvalidArgument>([&] { planner.plan_sequence(rest, {}); }, "has no segments");
  Segment nothing;
  check_throws<srmp::InvalidArgument>([&] { planner.plan_sequence(rest, {Segment::wait(1), nothing}); },
                                      "segment 1 (move): it has no goal");
  check_throws<srmp::InvalidArgument>([&] { planner.plan_sequence(rest, {Segment::wait(-1)}); },
                                      "segment 0 (wait): duration is -1");
}

BOOST_AUTO_TEST_SUITE_END()
