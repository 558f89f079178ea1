#include "srmp/io/trajectory_file.hpp"

#include <bit>
#include <boost/test/unit_test.hpp>
#include <cmath>

#include "srmp/core/error.hpp"
#include "support/files.hpp"
#include "support/throws.hpp"
#include "temp_file.hpp"

namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

srmp::Trajectory odd_numbers() {
  srmp::Trajectory t;
  t.joint_names = {"a", "b"};
  t.positions = srmp::RowMatrix(3, 2);
  t.positions << 0.1, 1.0 / 3, -0.0, 5e-324, 1.7976931348623157e308, -inf;
  t.velocities = srmp::RowMatrix::Constant(3, 2, 1e-7 / 3);
  t.accelerations = srmp::RowMatrix(0, 2);
  t.times = Eigen::Vector3d(0.0, std::nextafter(0.1, 1.0), std::nan(""));
  t.waypoints = srmp::RowMatrix::Constant(1, 2, 123456789.123456789);
  return t;
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) || (std::isnan(a) && std::isnan(b));
}

template <class A, class B>
bool same_bits(const A& a, const B& b) {
  bool same = a.rows() == b.rows() && a.cols() == b.cols();
  for (Eigen::Index i = 0; same && i < a.size(); ++i) same = same_bits(a.data()[i], b.data()[i]);
  return same;
}

srmp::Trajectory round_trip(const srmp::Trajectory& trajectory) {
  const TemporaryDirectory directory;
  srmp::io::save_trajectory(trajectory, directory.path("t.json"));
  return srmp::io::load_trajectory(directory.path("t.json"));
}

void check_refused(const std::string& text, const std::string& fragment) {
  const TempFile file(text);
  check_throws<srmp::FileError>([&] { srmp::io::load_trajectory(file.path()); }, fragment);
  check_throws<srmp::FileError>([&] { srmp::io::load_trajectory(file.path()); }, file.path());
}

}  // namespace

BOOST_AUTO_TEST_SUITE(trajectory_file)

BOOST_AUTO_TEST_CASE(numbers_are_read_back_bit_for_bit) {
  const srmp::Trajectory t = odd_numbers(), read = round_trip(t);
  BOOST_TEST(read.joint_names == t.joint_names);
  BOOST_CHECK(same_bits(read.positions, t.positions));
  BOOST_CHECK(same_bits(read.velocities, t.velocities));
  BOOST_CHECK(same_bits(read.accelerations, t.accelerations));
  BOOST_CHECK(same_bits(read.times, t.times));
  BOOST_CHECK(same_bits(read.waypoints, t.waypoints));
  BOOST_CHECK(!read.certificate);
  BOOST_CHECK_EQUAL(round_trip(srmp::Trajectory{}).dof(), 0u);
}

BOOST_AUTO_TEST_CASE(the_certificate_is_saved_too) {
  srmp::Certificate c;
  c.faults = {{srmp::FaultKind::not_at_rest, "it moves at its end", std::nan("")},
              {srmp::FaultKind::joint_names, "\"q\"", 0.1}};
  c.limits = {Eigen::Vector2d(1.0 / 3, inf), Eigen::Vector2d(2, 3), Eigen::Vector2d(4, 5), {true, false}};
  c.position = {0.1, "a", 0.2};
  c.velocity = {1.0 / 3, "b", -0.0};
  c.acceleration = {1.0000001, "a", 5e-324};
  c.jerk = {0.3, "", 0.4};
  c.collisions_checked = true;
  c.checked_from = 0.1 / 7;
  c.clearance_time = 0.3 / 7;
  c.body_a = "hand";
  c.body_b = "arm/elbow";
  c.deviation = 0.005;
  c.deviation_time = 1.1 / 7;
  c.time_s = 1e-3 / 7;
  c.clearance = inf;
  c.clearance_proved = 0.1 / 3;
  c.sampled = {{0.1, 0.2, "hand", "box"}};
  c.bound_graph = "every path";
  srmp::Trajectory t = odd_numbers();
  t.certificate = std::make_shared<const srmp::Certificate>(c);
  const auto read = round_trip(t).certificate;
  BOOST_REQUIRE(read);
  BOOST_REQUIRE_EQUAL(read->faults.size(), 2u);
  BOOST_CHECK(read->faults[0].kind == srmp::FaultKind::not_at_rest && std::isnan(read->faults[0].time));
  BOOST_CHECK(read->faults[1] == c.faults[1]);
  BOOST_CHECK(same_bits(read->limits.velocity, c.limits.velocity) && same_bits(read->limits.jerk, c.limits.jerk));
  BOOST_CHECK(read->limits.continuous == c.limits.continuous);
  BOOST_CHECK(read->position == c.position && read->jerk == c.jerk);
  BOOST_CHECK(read->sampled == c.sampled);
  BOOST_CHECK(read->clearance == inf && read->bound == inf && std::isnan(read->goal_error));
  BOOST_CHECK(read->clearance_proved == c.clearance_proved && read->bound_graph == c.bound_graph);
  BOOST_CHECK_EQUAL(read->report(), c.report());
  BOOST_CHECK_EQUAL(srmp::io::to_json(*read), srmp::io::to_json(c));  // every field, every bit
}

BOOST_AUTO_TEST_CASE(arrays_of_mismatched_sizes_are_neither_saved_nor_loaded) {
  srmp::Trajectory t = odd_numbers();
  t.times.conservativeResize(2);
  const TemporaryDirectory directory;
  check_throws<srmp::InvalidArgument>([&] { srmp::io::save_trajectory(t, directory.path("t.json")); },
                                      "trajectory: times has 2 numbers; there are 3 rows of positions");
  BOOST_CHECK(!std::filesystem::exists(directory.path("t.json")));

  srmp::io::save_trajectory(odd_numbers(), directory.path("t.json"));
  const std::string text = read_text(directory.path("t.json"));
  check_refused(replaced(text, "\"waypoints\": [\n", "\"waypoints\": [[1], \n"),
                "waypoints[1] is 2 numbers, but the row before it 1; all rows have one length");
  check_refused(replaced(text, "[\"a\", \"b\"]", "[\"a\"]"), "positions has 3 rows of 2 numbers; there are");
  check_refused(replaced(text, "\"velocities\": [\n", "\"velocities\": [[1, 2], \n"), "velocities has 4 rows");
  check_refused(replaced(text, "\"nan\"", "null"), "times must be a number, not nothing");
  check_refused(replaced(text, "\"nan\"", "\"NaN\""), "one of the strings");
  check_refused(replaced(text, "\"times\"", "\"tims\""), "it has no 'times'");
}

BOOST_AUTO_TEST_CASE(result_files_are_read_too) {
  const std::string solved = R"({"srmp_version": "0.1.0", "status": "solved", "reason": "", "joint_names": ["a", "b"],
    "statistics": {"bound": null}, "path": [[1, 2]], "times": [0.0, 1.0], "positions": [[1, 2], [3, 4]],
    "velocities": [[0, 0], [0, 0]], "accelerations": [[0, 0], [0, 0]]})";
  const TempFile file(solved);
  BOOST_CHECK(srmp::io::load_trajectory(file.path()).positions == (srmp::RowMatrix(2, 2) << 1, 2, 3, 4).finished());
  BOOST_CHECK(!srmp::io::load_trajectory(file.path()).certificate);
  srmp::Certificate certificate;
  certificate.body_b = "box";
  const TempFile proved(
      replaced(solved, "\"path\"", "\"certificate\": " + srmp::io::to_json(certificate) + ", \"path\""));
  BOOST_REQUIRE(srmp::io::load_trajectory(proved.path()).certificate);
  BOOST_CHECK_EQUAL(srmp::io::to_json(*srmp::io::load_trajectory(proved.path()).certificate),
                    srmp::io::to_json(certificate));
  check_refused(replaced(read_text(proved.path()), "\"clearance\"", "\"clearence\""),
                "certificate: it has no 'clearance'");
  check_refused(R"({"srmp_version": "0.1.0", "status": "exhausted", "reason": "", "joint_names": ["a"]})",
                "it holds no trajectory; its status is 'exhausted'");
}

BOOST_AUTO_TEST_SUITE_END()
