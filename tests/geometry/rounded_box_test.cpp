#include "srmp/geometry/rounded_box.hpp"

#include <algorithm>
#include <array>
#include <boost/test/unit_test.hpp>
#include <cmath>

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

/// In the frame of either box: both are bounds.
std::pair<double, double> bounds(const RoundedBox& a, const RoundedBox& b, const Eigen::Isometry3d& b_in_a) {
  const BoxDistanceBounds distances(b_in_a, a.reach(), b.reach());
  const RoundedBoxes of_a(a), of_b(b);
  return {std::sqrt(std::max(0.0f, distances.squared_bounds(of_a, distances.in_a(of_b))[0])),
          std::sqrt(std::max(0.0f, distances.squared_bounds(distances.in_b(of_a), of_b)[0]))};
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
    const auto [in_a, in_b] = bounds(a.rounded(), b.rounded(), b_in_a);
    const double exact = distance(a, b, b_in_a);
    BOOST_TEST((in_a <= exact && in_b <= exact));
    BOOST_TEST(std::abs(in_a - in_b) <= 1e-4 * scale);
    apart += in_a > 0.5 * exact && exact > 0.0;
  }
  BOOST_TEST(apart > 1000);
}

BOOST_AUTO_TEST_CASE(four_boxes_have_the_bounds_that_each_has_alone) {
  Dice dice(6);
  for (int i = 0; i < 200; ++i) {
    Eigen::Isometry3d b_in_a = Eigen::Isometry3d::Identity();
    b_in_a.linear() = ExactBox::turn(dice);
    b_in_a.translation() = ExactBox::within_one(dice);
    std::vector<RoundedBox> a, b;
    RoundedBoxes all_a, all_b;
    for (int k = 0; k < RoundedBoxes::count; ++k) {
      a.push_back(ExactBox(dice, 1.0, 0.3).rounded());
      b.push_back(ExactBox(dice, 1.0, 0.3).rounded());
      all_a.set(k, a.back());
      all_b.set(k, b.back());
      BOOST_TEST((all_a[k].axes == a.back().axes && all_a[k].center == a.back().center &&
                  all_a[k].half_extents == a.back().half_extents));
    }
    const BoxDistanceBounds distances(b_in_a, 3.0f, 3.0f);
    const Eigen::Array4f found = distances.squared_bounds(all_a, distances.in_a(all_b));
    for (int k = 0; k < RoundedBoxes::count; ++k) {
      const auto number = static_cast<std::size_t>(k);
      const Eigen::Array4f alone = distances.squared_bounds(RoundedBoxes(a[number]), distances.in_a(all_b.repeated(k)));
      BOOST_TEST((alone == found[k]).all());
    }
  }
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
    BOOST_TEST((bounds(a.rounded(), in_frame.rounded(), frame) == std::pair(0.0, 0.0)));
  }
}

BOOST_AUTO_TEST_CASE(of_boxes_that_overlap_the_deepest_has_the_least_bound) {
  const Eigen::Vector3d half(0.5, 0.4, 0.3);
  const RoundedBox box(Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero(), half);
  RoundedBoxes others;
  const std::array depths{-0.1, 0.05, 0.2, 0.3};  // along z
  for (int k = 0; k < RoundedBoxes::count; ++k) {
    const Eigen::Vector3d center(0.1, 0.1, 0.6 - depths[static_cast<std::size_t>(k)]);
    others.set(k, RoundedBox(Eigen::Matrix3d::Identity(), center, half));
  }
  const BoxDistanceBounds distances(Eigen::Isometry3d::Identity(), box.reach(), 2.0f);
  const Eigen::Array4f found = distances.squared_bounds(RoundedBoxes(box), distances.in_a(others));
  BOOST_TEST(found[0] == 0.01f, boost::test_tools::tolerance(1e-3f));
  for (int k = 1; k < RoundedBoxes::count; ++k)
    BOOST_TEST(found[k] == -static_cast<float>(depths[static_cast<std::size_t>(k)]),
               boost::test_tools::tolerance(1e-3f));
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
    const std::pair near{0.0, 0.0};
    for (const RoundedBox& box : {away, large}) BOOST_TEST((bounds(here, box, Eigen::Isometry3d::Identity()) == near));
    BOOST_TEST((bounds(here, here, Eigen::Isometry3d(Eigen::Translation3d(far * one))) == near));
  }
}
