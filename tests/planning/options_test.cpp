#include "srmp/planning/options.hpp"

#include <boost/test/unit_test.hpp>
#include <set>

#include "srmp/core/error.hpp"
#include "srmp/planning/options/registry.hpp"
#include "support/throws.hpp"

using srmp::InvalidArgument;
using srmp::OptionInfo;
using srmp::OptionMap;
using srmp::OptionType;
using srmp::PlannerInfo;
using srmp::PlannerOptions;

namespace {

const OptionInfo& info_of(const PlannerInfo& planner, const std::string& name) {
  for (const OptionInfo& option : planner.options)
    if (option.name == name) return option;
  BOOST_FAIL(planner.id << " has no option " << name);
  throw InvalidArgument(name);
}

/// A value that is allowed and is not the default.
srmp::OptionValue other_value(const srmp::OptionSpec& spec) {
  const OptionInfo& info = spec.info;
  switch (info.type) {
    case OptionType::boolean: return !std::get<bool>(info.default_value);
    case OptionType::integer: return std::get<double>(info.default_value) + 1.0;
    case OptionType::number: {
      const double value = std::get<double>(info.default_value);
      return value < spec.allowed.high ? value + 0.25 : value / 2;
    }
    case OptionType::text: return info.choices.empty() ? std::string("other") : info.choices.back();
    case OptionType::text_list: break;
  }
  return std::vector<std::string>{"one", "two"};
}

}  // namespace

BOOST_AUTO_TEST_CASE(options_every_type_of_the_variant_is_registered_once) {
  std::set<std::size_t> types;
  std::set<std::string> ids, classes;
  for (const srmp::RegisteredPlanner& planner : srmp::registry()) {
    types.insert(planner.defaults.index());
    ids.insert(planner.info.id);
    classes.insert(planner.info.class_name);
    BOOST_TEST((planner.info.one_robot || planner.info.many_robots));
    const bool has_lattices = planner.info.id != "RRTConnect";
    BOOST_TEST((planner.robots != nullptr) == (planner.info.many_robots && has_lattices));
    BOOST_TEST(srmp::planner_id(planner.defaults) == planner.info.id);
  }
  BOOST_TEST(types.size() == std::variant_size_v<PlannerOptions>);
  BOOST_TEST(ids.size() == srmp::registry().size());
  BOOST_TEST(classes.size() == srmp::registry().size());
}

BOOST_AUTO_TEST_CASE(options_every_default_is_allowed_and_is_that_of_the_struct) {
  for (const srmp::RegisteredPlanner& planner : srmp::registry()) {
    BOOST_TEST_CONTEXT(planner.info.id) {
      srmp::validate(planner.defaults);
      OptionMap map = srmp::to_map(planner.defaults);
      BOOST_TEST(map.size() == planner.info.options.size() + 1);
      for (const OptionInfo& option : planner.info.options) {
        BOOST_TEST((map.at(option.name) == option.default_value), option.name);
        BOOST_TEST((option.description.ends_with(".") && !option.description.ends_with("..")), option.name);
      }
      BOOST_TEST((map == srmp::to_map(srmp::parse_options({{"planner_id", planner.info.id}}))));
    }
  }
}

BOOST_AUTO_TEST_CASE(options_each_is_read_and_written_alone) {
  for (const srmp::RegisteredPlanner& planner : srmp::registry())
    for (const srmp::OptionSpec& spec : planner.options) BOOST_TEST_CONTEXT(planner.info.id << ", " << spec.info.name) {
        OptionMap expected = srmp::to_map(planner.defaults);
        const srmp::OptionValue value = other_value(spec);
        expected[spec.info.name] = value;
        const PlannerOptions options = srmp::parse_options({{"planner_id", planner.info.id}, {spec.info.name, value}});
        BOOST_TEST((srmp::to_map(options) == expected));
        BOOST_TEST((srmp::to_map(srmp::parse_options(expected)) == expected));
      }
}

BOOST_AUTO_TEST_CASE(options_a_range_is_told_as_it_is_checked) {
  const PlannerInfo& planner = srmp::planner_info("wAstar");
  BOOST_TEST(info_of(planner, "weight").range == ">= 1");
  BOOST_TEST(info_of(planner, "time_limit").range == "> 0");
  BOOST_TEST(info_of(planner, "time_limit").unit == "s");
  BOOST_TEST(info_of(planner, "velocity_scaling").range == "> 0 and <= 1");
  BOOST_TEST(info_of(planner, "timing").choices.size() == 3U);
  BOOST_TEST(info_of(planner, "shortcut").range == "");
  check_throws<InvalidArgument>([] { srmp::parse_options({{"velocity_scaling", 1.5}}); },
                                "option 'velocity_scaling' is 1.5; it must be above 0 and at most 1");
  check_throws<InvalidArgument>([] { srmp::parse_options({{"timing", std::string("toppr")}}); },
                                "option 'timing' is 'toppr', did you mean 'toppra'?");
  srmp::WAStar options{.weight = 0.5};
  check_throws<InvalidArgument>([&] { srmp::validate(options); }, "option 'weight' is 0.5; it must be at least 1");
}

BOOST_AUTO_TEST_CASE(options_of_single_robots) {
  for (const PlannerInfo& planner : srmp::available_planners())
    for (const OptionInfo& option : planner.options) {
      const bool of_robots = option.name == "heuristic" || option.name == "mprim_path";
      const bool has_lattices = planner.many_robots && planner.id != "RRTConnect";
      BOOST_TEST(option.per_robot == (of_robots && has_lattices), planner.id << ", " << option.name);
    }
  const OptionMap given{{"planner_id", std::string("ecbs")},
                        {"heuristic_left", std::string("bfs(0.1)")},
                        {"mprim_path_right_arm", std::string("a.yaml")}};
  const PlannerOptions options = srmp::parse_options(given);
  const OptionMap map = srmp::to_map(options);
  BOOST_TEST((map.at("heuristic_left") == srmp::OptionValue("bfs(0.1)")));
  BOOST_TEST((map.at("mprim_path_right_arm") == srmp::OptionValue("a.yaml")));
  BOOST_TEST(!map.contains("heuristic_right_arm"));
  BOOST_TEST((srmp::to_map(srmp::parse_options(map)) == map));
  BOOST_TEST(srmp::common_options(options, "left").heuristic == "bfs(0.1)");
  BOOST_TEST(srmp::common_options(options, "right_arm").heuristic == "joint_euclidean");
  BOOST_TEST(srmp::common_options(options, "right_arm").mprim_path == "a.yaml");
  const std::vector<std::string> named{"joint_euclidean", "bfs(0.1)"};
  BOOST_TEST(srmp::named_heuristics(options) == named, boost::test_tools::per_element());
  check_throws<InvalidArgument>(
      [] { srmp::parse_options({{"planner_id", std::string("CBS")}, {"heuristic_a", true}}); },
      "option 'heuristic_a' is true; it must be a word");
}

BOOST_AUTO_TEST_CASE(options_planners_by_other_spellings) {
  for (const char* id : {"wAstar", "WASTAR", "wA*", "weighted A-star"})
    BOOST_TEST(srmp::planner_info(id).id == "wAstar");
  BOOST_TEST(srmp::planner_info("PBS").id == "prioritised");
  check_throws<InvalidArgument>([] { srmp::planner_info("wAstr"); },
                                "there is no planner 'wAstr', did you mean 'wAstar'?");
}

BOOST_AUTO_TEST_CASE(options_that_pa_se_has_are_checked_and_ignored) {
  const OptionMap defaults = srmp::to_map(srmp::WPASE{});
  const OptionMap given{
      {"planner_id", std::string("wPASE")}, {"i_heuristic", std::string("any")}, {"i_weight", std::string("2")}};
  BOOST_TEST((srmp::to_map(srmp::parse_options(given)) == defaults));
  check_throws<InvalidArgument>([] { srmp::parse_options({{"planner_id", std::string("wPASE")}, {"i_weight", 0.5}}); },
                                "'i_weight' is 0.5");
}
