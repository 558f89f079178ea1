#include "collision_checker.hpp"

#include <mutex>

#include "bind.hpp"

namespace srmp::python {

namespace {

using BoolArray = nb::ndarray<nb::numpy, bool>;

/// A checker and one workspace; threads take turns, and no answer depends on the one before.
class PyCollisionChecker {
 public:
  explicit PyCollisionChecker(std::shared_ptr<const Checker> checker)
      : checker_(std::move(checker)), workspace_(checker_->make_workspace()) {}

  const Checker& checker() const { return *checker_; }
  Eigen::Index dof() const { return static_cast<Eigen::Index>(checker_->robot().dof()); }

  /// Runs without the GIL.
  template <class Ask>
  auto ask(Ask&& question) {
    const nb::gil_scoped_release no_gil;
    const std::lock_guard lock(mutex_);
    return question(*checker_, *workspace_);
  }

 private:
  std::shared_ptr<const Checker> checker_;
  std::mutex mutex_;
  Checker::WorkspacePtr workspace_;
};

using Self = PyCollisionChecker;

/// NumPy's own rows, not copied when they are float64 and contiguous; one configuration counts as one row.
class Rows {
 public:
  Rows(const ArrayLike& array, const std::string& what, Eigen::Index columns)
      : numbers_(to_numbers(array.value, what)) {
    const bool one = numbers_.ndim() == 1 && static_cast<Eigen::Index>(numbers_.size()) == columns;
    if (!one && (numbers_.ndim() != 2 || static_cast<Eigen::Index>(numbers_.shape(1)) != columns))
      throw InvalidArgument(what + " must have the shape (n, " + std::to_string(columns) + ")");
    count_ = one ? 1 : static_cast<Eigen::Index>(numbers_.shape(0));
    columns_ = columns;
  }
  Eigen::Index count() const { return count_; }
  Eigen::Map<const RowMatrix> view() const { return {numbers_.data(), count_, columns_}; }

 private:
  nb::ndarray<const double, nb::c_contig, nb::device::cpu> numbers_;
  Eigen::Index count_{}, columns_{};
};

template <class T>
nb::ndarray<nb::numpy, T> new_array(std::size_t size, T*& data) {
  data = new T[size]();
  const nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
  return nb::ndarray<nb::numpy, T>(data, {size}, owner);
}

BoolArray are_free(Self& self, const ArrayLike& q) {
  const Rows rows(q, "q", self.dof());
  bool* free{};
  BoolArray result = new_array(static_cast<std::size_t>(rows.count()), free);
  self.ask([&](const Checker& checker, Checker::Workspace& workspace) {
    checker.are_free(rows.view(), {free, static_cast<std::size_t>(rows.count())}, workspace);
  });
  return result;
}

BoolArray motions_free(Self& self, const ArrayLike& a, const ArrayLike& b) {
  const Rows from(a, "a", self.dof()), to(b, "b", self.dof());
  if (from.count() != to.count())
    throw InvalidArgument("a has " + std::to_string(from.count()) + " rows and b has " + std::to_string(to.count()) +
                          "; a motion goes from each row of a to the same row of b");
  bool* free{};
  BoolArray result = new_array(static_cast<std::size_t>(from.count()), free);
  self.ask([&](const Checker& checker, Checker::Workspace& workspace) {
    for (Eigen::Index i = 0; i < from.count(); ++i)
      free[i] = checker.is_motion_free(from.view().row(i).transpose(), to.view().row(i).transpose(), workspace);
  });
  return result;
}

nb::ndarray<nb::numpy, double> clearance(Self& self, const ArrayLike& q) {
  const Rows rows(q, "q", self.dof());
  double* distance{};
  auto result = new_array(static_cast<std::size_t>(rows.count()), distance);
  self.ask([&](const Checker& checker, Checker::Workspace& workspace) {
    for (Eigen::Index i = 0; i < rows.count(); ++i) {
      const auto nearest = checker.nearest(rows.view().row(i).transpose(), workspace);
      distance[i] = nearest ? nearest->distance : std::numeric_limits<double>::infinity();
    }
  });
  return result;
}

nb::dict stats(Self& self) {
  const CheckStatistics s =
      self.ask([](const Checker& checker, Checker::Workspace& w) { return checker.statistics(w); });
  nb::dict d;
  d["states"] = s.states;
  d["states_by_balls"] = s.states_by_balls;
  d["motions"] = s.motions;
  d["motions_by_balls"] = s.motions_by_balls;
  d["blocks"] = s.blocks;
  d["undecided"] = s.undecided;
  d["configurations"] = s.configurations;
  d["narrow_phase"] = s.narrow_phase;
  return d;
}

}  // namespace

CheckMode to_check_mode(const std::string& mode) {
  if (mode == "exact") return CheckMode::exact;
  if (mode == "conservative") return CheckMode::conservative;
  if (mode == "coal") return CheckMode::coal;
  const std::vector<std::string> known{"exact", "conservative", "coal"};
  const std::string suggestion = did_you_mean(mode, known);
  throw InvalidArgument("mode is '" + mode + "'" +
                        (suggestion.empty() ? "; it may be " + quoted_list(known) : suggestion));
}

nb::object wrap_checker(std::shared_ptr<const Checker> checker) {
  return nb::cast(new PyCollisionChecker(std::move(checker)), nb::rv_policy::take_ownership);
}

void bind_collision_checker(nb::module_& m) {
  nb::class_<MotionCertificate>(m, "MotionCertificate",
                                "Proof that a motion is free, or the first part of it that could not be proved.")
      .def_ro("proved", &MotionCertificate::proved, "Free between samples too.")
      .def_prop_ro(
          "interval", [](const MotionCertificate& c) { return std::pair(c.from, c.to); },
          "Part of the motion, 0..1, that is not free or could not be proved; (0, 0) when proved.")
      .def_ro("body_a", &MotionCertificate::body_a, "The pair there: link or attached object of the robot; '' if none.")
      .def_ro("body_b", &MotionCertificate::body_b, "The pair there: object or link; '' if none.")
      .def("__bool__", [](const MotionCertificate& c) { return c.proved; });
  nb::class_<Self>(m, "CollisionChecker",
                   "Collision checks of one robot in the scene as it was when planner.collision_checker made this.\n\n"
                   "Arrays are (n, dof) [rad or m]; float64 and contiguous ones are not copied. The GIL is released. "
                   "All methods\n"
                   "raise InvalidArgument for wrong shapes, NaN and infinity. Joint limits are not looked at.")
      .def("are_free", &are_free, nb::arg("q"),
           nb::sig("def are_free(self, q: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.bool_]"),
           "(n,) bool: is each configuration, (n, dof) [rad or m], free? 16 at a time.")
      .def("motions_free", &motions_free, nb::arg("a"), nb::arg("b"),
           nb::sig("def motions_free(self, a: numpy.typing.ArrayLike, b: numpy.typing.ArrayLike) -> "
                   "numpy.typing.NDArray[numpy.bool_]"),
           "(n,) bool: is the straight motion from each row of a to that of b, (n, dof) [rad or m], proved free, "
           "between "
           "samples too?\n"
           "Continuous joints go the short way.")
      .def("clearance", &clearance, nb::arg("q"),
           nb::sig("def clearance(self, q: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]"),
           "(n,) [m]: distance of the nearest pair at each configuration, less its padding; negative in collision, inf "
           "with nothing\n"
           "around. Always by Coal.")
      .def(
          "nearest",
          [](Self& self, const ArrayLike& q) {
            const Eigen::VectorXd v = q.vector("q");
            return self.ask([&](const Checker& c, Checker::Workspace& w) { return c.nearest(v, w); });
          },
          nb::arg("q"), "The nearest pair at q (dof,) [rad or m] as a Contact, or None with nothing around.")
      .def(
          "certify_motion",
          [](Self& self, const ArrayLike& a, const ArrayLike& b) {
            const Eigen::VectorXd from = a.vector("a"), to = b.vector("b");
            return self.ask([&](const Checker& c, Checker::Workspace& w) { return c.certify_motion(from, to, w); });
          },
          nb::arg("a"), nb::arg("b"),
          "Proves the straight motion a to b, each (dof,) [rad or m], free by conservative advancement on Coal's "
          "distances (Schwarzer,\n"
          "Saha, Latombe 2004), without balls: an independent check of motions_free.")
      .def("stats", &stats, "What this checker's checks did so far: how many of what, and which layer decided.")
      .def_prop_ro("dof", [](const Self& self) { return self.dof(); }, "Planned joints.");
}

}  // namespace srmp::python
