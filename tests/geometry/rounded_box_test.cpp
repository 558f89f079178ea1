#include "srmp/geometry/rounded_box.hpp"

#include <boost/test/unit_test.hpp>

#include "collision/worlds.hpp"

using namespace srmp;
using namespace worlds;

// What searches for near primitives rest on: a bound is never above the distance, and what is enclosed stays enclosed.

namespace {

struct ExactBox {
  Eigen::Matrix3d axes;
  Eigen::Vector3d middle, half;

  ExactBox(Dice& dice, double far, double size)
      : axes(turn(dice)), middle(far * within_one(dice)), half(size * within_one(dice).cwiseAbs()) {}
  static Eigen::Vector3d within_one(Dice& dice) { return {dice.in(-1, 1), dice.in(-1, 1), dice.in(-1, 1)}; }
  static Eigen::Matrix3d turn(Dice& dice) {
    return at(0, 0, 0, dice.in(-3, 3), dice.in(-3, 3), dice.in(-3, 3)).isometry().linear();
  }
  RoundedBox rounded() const { return {axes, middle, half}; }
  /// The point of the box at these parts of its half edges.
  Eigen::Vector3d point(const Eigen::Vector3d& parts) const { return middle + axes * half.cwiseProduct(parts); }
  Eigen::Vector3d nearest_to(const Eigen::Vector3d& p) const {
    return middle + axes * (axes.transpose() * (p - middle)).cwiseMax(-half).cwiseMin(half);
  }
};

/// The distance, by projections back and forth.
double distance(const ExactBox& a, const ExactBox& b, const Eigen::Isometry3d& b_in_a) {
  Eigen::Vector3d of_a = a.middle, of_b = b.middle;
  for (int i = 0; i < 2000; ++i) {
    of_b = b.nearest_to(b_in_a.inverse() * of_a);
    of_a = a.nearest_to(b_in_a * of_b);
  }
  return (of_a - b_in_a * of_b).norm();
}

}  // namespace

BOOST_AUTO_TEST_CASE(a_bound_of_the_distance_of_two_boxes_is_never_above_it) {
  Dice dice(3);
  int apart = 0;
  for (int i = 0; i < 2000; ++i) {
    const double scale = std::pow(10.0, dice.in(-3, 3));
    const ExactBox a(dice, scale, 0.3 * scale), b(dice, scale, 0.3 * scale);
    Eigen::Isometry3d b_in_a = Eigen::Isometry3d::Identity();
    b_in_a.linear() = ExactBox::turn(dice);
    b_in_a.translation() = scale * ExactBox::within_one(dice);
    const RoundedBox box_a = a.rounded(), box_b = b.rounded();
    const BoxDistanceBounds distances(b_in_a, box_a.reach(), box_b.reach());
    const float far = std::numeric_limits<float>::infinity();
    const double bound = std::sqrt(distances.squared_bound(box_a, distances.in_a(box_b), far));
    const double early = std::sqrt(distances.squared_bound(box_a, distances.in_a(box_b), 0.0f));
    const double exact = distance(a, b, b_in_a);
    BOOST_TEST((early <= bound && bound <= exact));
    BOOST_TEST(((early > 0.0) == (bound > 0.0)));
    apart += bound > 0.5 * exact && exact > 0.0;
  }
  BOOST_TEST(apart > 1000);
}

BOOST_AUTO_TEST_CASE(boxes_that_overlap_by_a_hair_or_touch_are_not_apart) {
  Dice dice(4);
  for (int i = 0; i < 2000; ++i) {
    // Side by side, after the same turn and shift: in exact numbers the distance is 0.
    const ExactBox a(dice, 3.0, 0.5);
    ExactBox b = a;
    b.middle += a.axes.col(0) * (a.half.x() + b.half.x());
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    frame.linear() = ExactBox::turn(dice);
    frame.translation() = 5.0 * ExactBox::within_one(dice);
    ExactBox in_frame = b;
    in_frame.axes = frame.linear().transpose() * b.axes;
    in_frame.middle = frame.inverse() * b.middle;
    const RoundedBox box_a = a.rounded(), box_b = in_frame.rounded();
    const BoxDistanceBounds distances(frame, box_a.reach(), box_b.reach());
    BOOST_TEST(distances.squared_bound(box_a, distances.in_a(box_b), 0.0f) == 0.0f);
  }
}

BOOST_AUTO_TEST_CASE(a_rounded_box_contains_the_box) {
  Dice dice(5);
  for (int i = 0; i < 2000; ++i) {
    const ExactBox box(dice, std::pow(10.0, dice.in(-3, 6)), 1.0);
    const RoundedBox rounded = box.rounded();
    const Eigen::Vector3d corner = box.point({i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0});
    BOOST_TEST(squared_distance(corner, rounded) == 0.0);
    const Eigen::Vector3d direction = ExactBox::within_one(dice);
    BOOST_TEST(support_along(direction, rounded) >= direction.dot(corner) - 1e-12 * corner.norm());
  }
}

BOOST_AUTO_TEST_CASE(boxes_beyond_what_single_precision_holds_are_near_everything) {
  const Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  const Eigen::Vector3d one = Eigen::Vector3d::Ones();
  const RoundedBox here(axes, Eigen::Vector3d::Zero(), one);
  for (const double far : {1e16, 1e30, 1e60, 1e300}) {
    const RoundedBox away(axes, far * one, one), large(axes, Eigen::Vector3d::Zero(), far * one);
    const float enough = 1e30f;
    for (const RoundedBox& box : {away, large}) {
      const BoxDistanceBounds distances(Eigen::Isometry3d::Identity(), here.reach(), box.reach());
      BOOST_TEST(distances.squared_bound(here, distances.in_a(box), enough) == 0.0f);
    }
    const BoxDistanceBounds distances(Eigen::Isometry3d(Eigen::Translation3d(far * one)), here.reach(), here.reach());
    BOOST_TEST(distances.squared_bound(here, distances.in_a(here), enough) == 0.0f);
  }
}
