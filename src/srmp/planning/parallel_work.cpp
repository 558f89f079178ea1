#include "srmp/planning/parallel_work.hpp"

#include <algorithm>
#include <exception>
#include <vector>

namespace srmp {

void add_work(PlanStatistics& sum, const PlanStatistics& part) {
  sum.ik_time_s += part.ik_time_s;
  sum.heuristic_time_s += part.heuristic_time_s;
  sum.search_time_s += part.search_time_s;
  sum.shortcut_time_s += part.shortcut_time_s;
  sum.timing_time_s += part.timing_time_s;
  sum.verification_time_s += part.verification_time_s;
  sum.expansions += part.expansions;
  sum.generated += part.generated;
  sum.samples += part.samples;
  sum.edge_checks += part.edge_checks;
  sum.edges_free_by_spheres += part.edges_free_by_spheres;
  sum.edges_colliding_by_spheres += part.edges_colliding_by_spheres;
  sum.edges_free_by_coal += part.edges_free_by_coal;
  sum.edges_colliding_by_coal += part.edges_colliding_by_coal;
  sum.configurations += part.configurations;
  sum.narrow_phase += part.narrow_phase;
  sum.states += part.states;
  sum.tree_nodes += part.tree_nodes;
  sum.memory_bytes = std::max(sum.memory_bytes, part.memory_bytes);
  if (sum.note.find(part.note) == std::string::npos) sum.note += (sum.note.empty() ? "" : "; ") + part.note;
}

void ParallelWork::run(std::size_t count, const Deadline& deadline, const Part& part) {
  std::vector<PlanStatistics> own(count);
  std::vector<char> failed(count, false);
  std::exception_ptr error;
  try {
    jobs_.run(count, deadline, [&](std::size_t i, const Deadline& until) {
      failed[i] = true;
      part(i, until, own[i]);
      failed[i] = false;
    });
  } catch (...) {
    error = std::current_exception();
  }
  for (std::size_t i = 0; i < count; ++i) {
    add_work(statistics_, own[i]);
    if (failed[i]) break;  // what other threads did meanwhile does not count
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace srmp
