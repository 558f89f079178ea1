#include "srmp/planning/search_trace.hpp"

#include <memory>

#include "bind.hpp"

namespace srmp::python {

namespace {

/// A trace, and the scope in which it is filled.
struct PyTrace {
  SearchTrace trace;
  std::unique_ptr<TraceScope> scope;

  void enter() {
    if (scope) throw InvalidArgument("this SearchTrace is recording already");
    if (trace.records || !trace.lattices.empty())
      throw InvalidArgument("this SearchTrace has recorded before; make another one for another plan");
    scope = std::make_unique<TraceScope>(trace);
  }

  void exit() {
    if (scope && TraceScope::current() != &trace)
      throw InvalidArgument("a SearchTrace must end in the thread in which it began, after those that began later");
    scope.reset();
  }
};

template <class Records, class Get>
NumpyArray column(const Records& records, Get get) {
  std::vector<Eigen::VectorXd> rows;
  for (const auto& record : records) rows.push_back(get(record));
  return to_numpy_rows(rows, rows.empty() ? 0 : static_cast<std::size_t>(rows.front().size()));
}

template <class Records, class Get>
NumpyArray numbers(const Records& records, Get get) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(records.size()));
  for (std::size_t i = 0; i < records.size(); ++i) values[static_cast<Eigen::Index>(i)] = get(records[i]);
  return to_numpy(values);
}

nb::object in_viewer(const char* function) { return nb::module_::import_("srmp.viewer._search").attr(function); }

std::string repr(const PyTrace& self) {
  std::size_t edges = 0;
  for (const SearchTrace::Lattice& lattice : self.trace.lattices) edges += lattice.edges.size();
  return "SearchTrace(" + std::to_string(self.trace.lattices.size()) + " lattices, " +
         std::to_string(self.trace.expansions) + " expansions, " + std::to_string(edges) + " edges, " +
         std::to_string(self.trace.constraint_nodes.size()) + " constraint nodes)";
}

void bind_lattice(nb::module_& m) {
  using Lattice = SearchTrace::Lattice;
  using Expansion = SearchTrace::Expansion;
  using Edge = SearchTrace::Edge;
  nb::class_<Lattice>(m, "LatticeTrace",
                      "What a search did in one lattice; joint values in rad, or m of prismatic joints.")
      .def_prop_ro(
          "robot", [](const Lattice& self) { return self.robot; }, "The robot's name.")
      .def_prop_ro(
          "name", [](const Lattice& self) { return self.name; }, "Such as 'the lattice of 15 degrees from the start'.")
      .def_prop_ro(
          "expanded",
          [](const Lattice& self) { return column(self.expansions, [](const Expansion& e) { return e.q; }); },
          "(n, dof) configurations of the states that were expanded, in their order.")
      .def_prop_ro(
          "to_targets",
          [](const Lattice& self) { return numbers(self.expansions, [](const Expansion& e) { return e.to_targets; }); },
          "(n,) straight joint-space distances of these to the nearest target: a goal, or the start backward.")
      .def_prop_ro(
          "order",
          [](const Lattice& self) {
            return numbers(self.expansions, [](const Expansion& e) { return static_cast<double>(e.number); });
          },
          "(n,) numbers of these among the expansions of all lattices.")
      .def_prop_ro(
          "edges_from", [](const Lattice& self) { return column(self.edges, [](const Edge& e) { return e.from; }); },
          "(m, dof) where the motions began that were checked, in their order.")
      .def_prop_ro(
          "edges_to", [](const Lattice& self) { return column(self.edges, [](const Edge& e) { return e.to; }); },
          "(m, dof) where they ended.")
      .def_prop_ro(
          "edges_free",
          [](const Lattice& self) { return numbers(self.edges, [](const Edge& e) { return e.free ? 1.0 : 0.0; }); },
          "(m,) 1 where the motion is free of collisions, else 0.")
      .def("__repr__", [](const Lattice& self) {
        return "LatticeTrace(" + self.name + ", " + std::to_string(self.expansions.size()) + " expansions, " +
               std::to_string(self.edges.size()) + " edges)";
      });
}

void bind_node(nb::module_& m) {
  using Node = SearchTrace::ConstraintNode;
  nb::class_<Node>(m, "ConstraintNode", "A node of a constraint tree, with its earliest conflict.")
      .def_ro("tree", &Node::tree, "Number of the search that it belongs to.")
      .def_ro("number", &Node::number, "Within its tree; 0 is the root.")
      .def_ro("parent", &Node::parent, "Its parent's number; 0 of the root.")
      .def_ro("cost", &Node::cost, "Sum over the robots, as the search counts it [rad, prismatic joints m, waits].")
      .def_ro("conflicts", &Node::conflicts, "Pairs of robots that collide; 0: a solution.")
      .def_prop_ro(
          "robots",
          [](const Node& self) {
            return self.conflicts ? std::vector<std::string>(self.robots.begin(), self.robots.end())
                                  : std::vector<std::string>();
          },
          "The two robots of the earliest conflict; none where there is none.")
      .def_prop_ro(
          "configurations",
          [](const Node& self) {
            nb::dict found;
            for (const std::size_t side : {0, 1})
              if (self.conflicts) found[self.robots[side].c_str()] = to_numpy(self.configurations[side]);
            return found;
          },
          nb::sig("def configurations(self) -> dict[str, numpy.typing.NDArray[numpy.float64]]"),
          "Where these robots are at the step in which they first collide: (dof,) by robot.")
      .def_ro("time_s", &Node::time_s, "When they do, at full speed [s].")
      .def("__repr__", [](const Node& self) {
        return "ConstraintNode(" + std::to_string(self.number) + ", parent=" + std::to_string(self.parent) +
               ", conflicts=" + std::to_string(self.conflicts) + ")";
      });
}

}  // namespace

void bind_search_trace(nb::module_& m) {
  bind_lattice(m);
  bind_node(m);
  nb::class_<PyTrace>(m, "SearchTrace",
                      R"(What searches do, for drawing: records the plans of a with statement in its thread.

Planning is the same with and without, bit for bit. Recorded are the lattices of a robot that is planned alone, and
the constraint trees of several robots; not RRT-Connect, roadmaps, and lattices of several robots as one. plan_many
plans in threads of its own, of which nothing is recorded.)")
      .def(
          "__init__",
          [](PyTrace* self, int max_records) {
            if (max_records < 1)
              throw InvalidArgument("max_records is " + std::to_string(max_records) + "; it must be at least 1");
            new (self) PyTrace();
            self->trace.max_records = static_cast<std::size_t>(max_records);
          },
          nb::kw_only(), nb::arg("max_records") = 1'000'000,
          R"(max_records: how many expansions, edges and nodes are kept together; further ones are counted.

Raises InvalidArgument for less than 1.)")
      .def(
          "__enter__",
          [](nb::handle self) {
            nb::cast<PyTrace&>(self).enter();
            return nb::borrow(self);
          },
          nb::sig("def __enter__(self) -> SearchTrace"), "Begins to record; once for each object.")
      .def(
          "__exit__", [](PyTrace& self, nb::handle, nb::handle, nb::handle) { self.exit(); }, nb::arg("type").none(),
          nb::arg("value").none(), nb::arg("traceback").none(),
          nb::sig("def __exit__(self, type: object, value: object, traceback: object) -> None"), "Ends the record.")
      .def_prop_ro(
          "lattices", [](const PyTrace& self) { return self.trace.lattices; },
          nb::sig("def lattices(self) -> list[LatticeTrace]"), "Every lattice that was searched.")
      .def_prop_ro(
          "constraint_nodes", [](const PyTrace& self) { return self.trace.constraint_nodes; },
          nb::sig("def constraint_nodes(self) -> list[ConstraintNode]"),
          "The nodes of all constraint trees, in the order in which they were opened.")
      .def_prop_ro(
          "complete", [](const PyTrace& self) { return self.trace.records <= self.trace.max_records; },
          "Whether everything was kept.")
      .def("__repr__", &repr)
      .def(
          "plot",
          [](nb::handle self, nb::handle planner, nb::handle path) { return in_viewer("plot")(self, planner, path); },
          nb::arg("planner").none(), nb::arg("path") = nb::none(),
          nb::sig(
              "def plot(self, planner: PlannerInterface, path: str | os.PathLike[str] | None = None) -> typing.Any"),
          R"(Draws the scene with what was searched, where the end effector is there: a matplotlib Figure, which is returned.

planner: has the scene. path: writes it too (PNG, PDF or SVG, by the suffix).

Raises InvalidArgument where no lattice was searched, or the planner has not its robot; FileError when the file
cannot be written; ModuleNotFoundError where matplotlib is not installed.)")
      .def(
          "to_html",
          [](nb::handle self, nb::handle planner, nb::handle path) {
            return in_viewer("to_html")(self, planner, path);
          },
          nb::arg("planner").none(), nb::arg("path") = nb::none(),
          nb::sig(
              "def to_html(self, planner: PlannerInterface, path: str | os.PathLike[str] | None = None) -> str | None"),
          R"(Writes PlannerInterface.to_html's page with what was searched. Without a path, the text is returned.

Raises InvalidArgument and FileError as plot does.)")
      .def(
          "plot_constraints",
          [](nb::handle self, nb::handle path) { return in_viewer("plot_constraints")(self, path); },
          nb::arg("path") = nb::none(),
          nb::sig("def plot_constraints(self, path: str | os.PathLike[str] | None = None) -> typing.Any"),
          R"(Draws the constraint trees with their conflicts: a matplotlib Figure, which is returned.

Raises InvalidArgument where there is none; FileError when the file cannot be written; ModuleNotFoundError where
matplotlib is not installed.)");
}

}  // namespace srmp::python
