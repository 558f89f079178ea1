#include <boost/test/unit_test.hpp>

#include "srmp/core/error.hpp"
#include "srmp/planning/strategies/strategy.hpp"

using namespace srmp;

namespace {

/// Gives these attempts, one a round, and the last one from then on.
class Scripted : public Strategy {
 public:
  Scripted(bool can_exhaust, std::vector<Attempt> attempts)
      : can_exhaust_(can_exhaust), attempts_(std::move(attempts)) {}
  Attempt attempt(const AttemptBudget& budget, const Deadline&) override {
    return attempts_[std::min(static_cast<std::size_t>(budget.round), attempts_.size() - 1)];
  }
  bool can_exhaust() const override { return can_exhaust_; }

 private:
  bool can_exhaust_;
  std::vector<Attempt> attempts_;
};

Attempt ended(Status status, const std::string& reason) {
  Attempt attempt;
  attempt.status = status;
  attempt.reason = reason;
  return attempt;
}

template <class... Parts>
Strategies strategies(Parts... parts) {
  Strategies all;
  (all.push_back(std::make_unique<Scripted>(std::move(parts))), ...);
  return all;
}

PlanningError error_of(const Strategies& all, double seconds) {
  try {
    attempt_in_rounds(all, 0.0, 1.0, Deadline(seconds));
  } catch (const PlanningError& error) {
    return error;
  }
  throw std::logic_error("no error");
}

}  // namespace

BOOST_AUTO_TEST_CASE(rounds_end_when_all_that_can_exhaust_have) {
  const auto error = error_of(strategies(Scripted(true, {ended(Status::timed_out, ""), ended(Status::exhausted, "no")}),
                                         Scripted(false, {ended(Status::timed_out, "late")})),
                              1e9);
  BOOST_TEST((error.status() == Status::exhausted));
  BOOST_TEST(std::string(error.what()) == "no");
}

BOOST_AUTO_TEST_CASE(rounds_end_at_a_proof_that_there_is_no_path_at_all) {
  Attempt proof = ended(Status::exhausted, "a wall");
  proof.of_all_paths = true;
  const auto error =
      error_of(strategies(Scripted(false, {proof}), Scripted(true, {ended(Status::timed_out, "")})), 1e9);
  BOOST_TEST((error.status() == Status::exhausted));
  BOOST_TEST(std::string(error.what()) == "a wall");
}

BOOST_AUTO_TEST_CASE(a_plan_that_is_stopped_is_not_called_exhausted) {
  const Scripted exhausted(true, {ended(Status::exhausted, "no")});
  const auto silent = error_of(strategies(exhausted, Scripted(true, {ended(Status::timed_out, "")})), 0.01);
  BOOST_TEST((silent.status() == Status::timed_out));
  BOOST_TEST(std::string(silent.what()) == "the plan was stopped before all of its searches had ended");
  const auto said = error_of(strategies(Scripted(true, {ended(Status::timed_out, "late")}), exhausted), 0.01);
  BOOST_TEST((said.status() == Status::timed_out));
  BOOST_TEST(std::string(said.what()) == "late");
}

BOOST_AUTO_TEST_CASE(rounds_end_at_the_same_place_when_the_work_is_used_up) {
  int rounds = 0;
  const auto used_up = [&] { return ++rounds == 5 ? std::optional<std::string>("enough") : std::nullopt; };
  const Strategies all = strategies(Scripted(true, {ended(Status::timed_out, "")}));
  BOOST_CHECK_EXCEPTION(attempt_in_rounds(all, 0.0, 1.0, Deadline(1e9), used_up), PlanningError,
                        [](const PlanningError& error) {
                          return error.status() == Status::timed_out && std::string(error.what()) == "enough";
                        });
  BOOST_TEST(rounds == 5);
}
