#include "srmp/planning/trace_recorders.hpp"

namespace srmp {

namespace {

/// Is there room for one more?
bool counted(SearchTrace& trace) { return trace.records++ < trace.max_records; }

}  // namespace

LatticeObserver lattice_recorder(const std::string& robot, const std::string& name) {
  SearchTrace* trace = TraceScope::current();
  if (!trace) return {};
  const std::size_t own = trace->lattices.size();
  trace->lattices.push_back({robot, name});
  return {.expanded =
              [trace, own](const Eigen::VectorXd& q, double to_targets) {
                const std::size_t number = trace->expansions++;
                if (counted(*trace)) trace->lattices[own].expansions.push_back({number, q, to_targets});
              },
          .evaluated =
              [trace, own](const Eigen::VectorXd& from, const Eigen::VectorXd& to, bool free) {
                if (counted(*trace)) trace->lattices[own].edges.push_back({from, to, free});
              }};
}

multi::OnOpenedNode constraint_tree_recorder(const MultiRobotWorld& world, const std::vector<std::size_t>& robots) {
  SearchTrace* trace = TraceScope::current();
  if (!trace) return {};
  return [trace, &world, &robots, tree = trace->constraint_trees++](const multi::OpenedNode& node) {
    if (!counted(*trace)) return;
    SearchTrace::ConstraintNode record{.tree = tree,
                                       .number = node.number,
                                       .parent = node.parent,
                                       .cost = node.cost,
                                       .conflicts = static_cast<int>(node.conflicts)};
    if (const auto& conflict = node.first) {
      for (const std::size_t side : {0, 1}) {
        const std::size_t robot = robots[conflict->agents[side]];
        record.robots[side] = world.checkers().names()[robot];
        record.configurations[side] = world.at(robot, conflict->moves[side], conflict->step);
      }
      record.time_s = conflict->step * world.step_time();
    }
    trace->constraint_nodes.push_back(std::move(record));
  };
}

}  // namespace srmp
