#include "srmp/trajectory/prove_clearance.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "srmp/collision/motion_proof.hpp"
#include "srmp/collision/scene_checker.hpp"
#include "srmp/core/error.hpp"

namespace srmp {

namespace {

constexpr double sample_step = 1e-3;     // [rad or m] of a joint, between samples near the ends
constexpr double rule_tolerance = 2e-5;  // [m] of the clearance at samples
constexpr double proof_reserve = 1e-4;   // [m] beyond the clearance, from where on it is proved

/// By `amount` [m]; the worst is told.
void add_violation(Certificate& certificate, ClearanceKept& kept, const std::string& a, const std::string& b,
                   double amount, double time) {
  if (kept.violation > 0.0 && amount <= kept.violation) return;
  std::erase_if(certificate.faults, [](const Fault& fault) { return fault.kind == FaultKind::clearance; });
  kept.violation = std::max(amount, std::numeric_limits<double>::min());
  certificate.faults.push_back({FaultKind::clearance,
                                "'" + a + "' and '" + b + "' break the clearance of " + to_text(kept.required) +
                                    " m by " + to_text(amount) + " m at " + to_text(time) + " s",
                                time});
}

class ClearanceProof {
 public:
  ClearanceProof(Certificate& certificate, const Trajectory& trajectory, const Checker& checker,
                 const Deadline& deadline)
      : certificate_(certificate),
        t_(trajectory),
        checker_(checker),
        workspace_(checker.make_workspace()),
        deadline_(deadline),
        last_row_(trajectory.times.size() - 1) {}

  void run() {
    kept_.required = checker_.clearance_kept();
    if (const auto* scene = dynamic_cast<const SceneChecker*>(&checker_)) kept_.close_links = scene->close_links();
    const Eigen::Index first = first_clear_row(0, last_row_, 1), last = first_clear_row(last_row_, first, -1);
    if (deadline_.stop_requested()) {  // it is not known where the clearance is kept
      certificate_.sampled.push_back({t_.times[0], t_.times[last_row_], "", ""});
      return;
    }
    kept_.from = t_.times[first];
    kept_.to = t_.times[last];
    prove_between(first, last);
    check_samples(0, first, 1);
    check_samples(last_row_, last, -1);
    certificate_.clearance_kept = std::move(kept_);
  }

 private:
  using Depths =
      std::map<std::pair<std::string, std::string>, double>;  // of pairs that are closer: the least so far [m]

  Eigen::VectorXd row(Eigen::Index i) const { return t_.positions.row(i).transpose(); }

  /// The first row that keeps the clearance with some reserve, or the one that comes nearest to that; `begin`, if it
  /// keeps the clearance itself.
  Eigen::Index first_clear_row(Eigen::Index begin, Eigen::Index end, Eigen::Index step) {
    if (checker_.is_free(row(begin), *workspace_)) return begin;
    Eigen::Index best = begin;
    double most = -std::numeric_limits<double>::infinity();
    for (Eigen::Index i = begin;; i += step) {
      const double clearance = checker_.clearance(row(i), *workspace_);
      if (clearance > most) {
        most = clearance;
        best = i;
      }
      if (clearance > proof_reserve || i == end || deadline_.stop_requested()) return best;
    }
  }

  void prove_between(Eigen::Index first, Eigen::Index last) {
    const Eigen::Index rows = last - first + 1;
    const Eigen::VectorXd times = t_.times.segment(first, rows);
    const bool moves = t_.velocities.rows() > 0;
    const CubicMotion motion{times, t_.positions.middleRows(first, rows),
                             t_.velocities.middleRows(moves ? first : 0, moves ? rows : 0)};
    const MotionProof proof =
        prove_motion(checker_, motion, *workspace_, {.gap_tolerance = 1.0, .deadline = &deadline_});
    for (const MotionProof::Part& part : proof.unproved)
      certificate_.sampled.push_back({part.from, part.to, part.body_a, part.body_b});
    if (!proof.free) broken(proof.body_a, proof.body_b, std::max(-proof.clearance, 0.0), proof.time);
  }

  /// The rule for the part from an end of the motion to the row that keeps the clearance.
  void check_samples(Eigen::Index begin, Eigen::Index end, Eigen::Index step) {
    if (begin == end) return;
    Depths least;
    const std::size_t first_relaxed = kept_.relaxed.size();
    for (const Contact& contact : checker_.contacts(row(begin), *workspace_)) {
      least[{contact.body_a, contact.body_b}] = -contact.distance;
      const double time = t_.times[begin];
      kept_.relaxed.push_back({contact.body_a, contact.body_b, contact.distance + kept_.required, time, time});
    }
    for (Eigen::Index i = begin; i != end; i += step) {
      const double travel = (t_.positions.row(i + step) - t_.positions.row(i)).cwiseAbs().maxCoeff();
      const int samples = std::max(1, static_cast<int>(std::ceil(travel / sample_step)));
      for (int k = 1; k <= samples; ++k) {
        const double fraction = static_cast<double>(k) / samples;
        const double time = (1.0 - fraction) * t_.times[i] + fraction * t_.times[i + step];
        if (deadline_.stop_requested()) return leave_unproved(time, t_.times[end], first_relaxed);
        check_sample(time, least, first_relaxed);
      }
    }
  }

  void check_sample(double time, Depths& least, std::size_t first_relaxed) {
    Depths next;  // without the pairs that keep the clearance now: they have to from now on
    for (const Contact& contact : checker_.contacts(t_.sample(time), *workspace_)) {
      const auto known = least.find({contact.body_a, contact.body_b});
      const double depth = known == least.end() ? 0.0 : known->second;
      if (-contact.distance > depth + rule_tolerance)
        broken(contact.body_a, contact.body_b, -contact.distance - depth, time);
      next[{contact.body_a, contact.body_b}] = std::min(depth, -contact.distance);
      for (std::size_t k = first_relaxed; k < kept_.relaxed.size(); ++k) {
        RelaxedClearance& pair = kept_.relaxed[k];
        if (pair.body_a != contact.body_a || pair.body_b != contact.body_b) continue;
        pair.from = std::min(pair.from, time);
        pair.to = std::max(pair.to, time);
      }
    }
    least = std::move(next);
  }

  void leave_unproved(double from, double to, std::size_t first_relaxed) {
    const bool named = first_relaxed < kept_.relaxed.size();
    certificate_.sampled.push_back({std::min(from, to), std::max(from, to),
                                    named ? kept_.relaxed[first_relaxed].body_a : "",
                                    named ? kept_.relaxed[first_relaxed].body_b : ""});
  }

  void broken(const std::string& a, const std::string& b, double amount, double time) {
    add_violation(certificate_, kept_, a, b, amount, time);
  }

  Certificate& certificate_;
  const Trajectory& t_;
  const Checker& checker_;
  const Checker::WorkspacePtr workspace_;
  const Deadline& deadline_;
  const Eigen::Index last_row_;
  ClearanceKept kept_;
};

}  // namespace

void add_clearance(Certificate& certificate, const Trajectory& trajectory, const Checker& checker,
                   const Deadline& deadline) {
  ClearanceProof(certificate, trajectory, checker, deadline).run();
}

void add_clearance(Certificate& certificate, const MotionProof& proof, double required) {
  for (const MotionProof::Part& part : proof.unproved)
    certificate.sampled.push_back({part.from, part.to, part.body_a, part.body_b});
  if (!certificate.clearance_kept) certificate.clearance_kept = ClearanceKept{.required = required};
  if (proof.free) return;
  add_violation(certificate, *certificate.clearance_kept, proof.body_a, proof.body_b,
                std::min(std::max(-proof.clearance, 0.0), required), proof.time);
}

MotionProof without_clearance(MotionProof proof, double required) {
  if (proof.free && proof.unproved.empty()) proof.proved += required;
  proof.clearance += required;
  proof.free = proof.clearance > detail::NarrowPhase::contact_distance;
  proof.unproved.clear();
  return proof;
}

bool keeps_clearance(const Certificate& certificate) {
  return std::none_of(certificate.faults.begin(), certificate.faults.end(),
                      [](const Fault& fault) { return fault.kind == FaultKind::clearance; });
}

}  // namespace srmp
