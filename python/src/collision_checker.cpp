#include "collision_checker.hpp"

#include <mutex>

#include "bind.hpp"
#include "interrupt.hpp"

namespace srmp::python {

namespace {

using BoolArray = nb::ndarray<nb::numpy, bool>;

std::size_t dof_of(const Checker& checker) { return checker.robot().dof(); }
std::size_t dof_of(const TimedChecker& checker) { return checker.dof(); }
const Checker& base_of(const Checker& checker) { return checker; }
const Checker& base_of(const TimedChecker& checker) { return checker.checker(); }

/// A checker and one workspace, which a mutex guards; no result depends on earlier queries.
template <class C>
class PyChecker {
 public:
  explicit PyChecker(std::shared_ptr<const C> checker)
      : checker_(std::move(checker)), workspace_(base_of(*checker_).make_workspace()) {}

  Eigen::Index dof() const { return static_cast<Eigen::Index>(dof_of(*checker_)); }

  /// Runs without the GIL.
  template <class Query>
  auto run(Query&& query) {
    const nb::gil_scoped_release no_gil;
    const std::lock_guard lock(mutex_);
    const InterruptionScope interruptible(raise_interrupt);
    return query(*checker_, *workspace_);
  }

 private:
  std::shared_ptr<const C> checker_;
  std::mutex mutex_;
  Checker::WorkspacePtr workspace_;
};

using Self = PyChecker<Checker>;
using Timed = PyChecker<TimedChecker>;

/// NumPy's own rows, not copied when they are float64 and contiguous; one configuration counts as one row.
class Rows {
 public:
  Rows(const ArrayLike& array, const std::string& what, Eigen::Index columns)
      : numbers_(to_numbers(array.value, what)) {
    const bool one = numbers_.ndim() == 1 && static_cast<Eigen::Index>(numbers_.size()) == columns;
    if (!one && (numbers_.ndim() != 2 || static_cast<Eigen::Index>(numbers_.shape(1)) != columns))
      throw wrong_shape(what, std::to_string(columns), numbers_);
    count_ = one ? 1 : static_cast<Eigen::Index>(numbers_.shape(0));
    columns_ = columns;
  }
  Eigen::Index count() const { return count_; }
  Eigen::Map<const RowMatrix> view() const { return {numbers_.data(), count_, columns_}; }

 private:
  Numbers numbers_;
  Eigen::Index count_{}, columns_{};
};

void require_as_many(const Rows& a, const Rows& b) {
  if (a.count() != b.count())
    throw InvalidArgument("a has " + std::to_string(a.count()) + " rows and b has " + std::to_string(b.count()) +
                          "; a motion goes from each row of a to the same row of b");
}

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
  self.run([&](const Checker& checker, Checker::Workspace& workspace) {
    checker.are_free(rows.view(), {free, static_cast<std::size_t>(rows.count())}, workspace);
  });
  return result;
}

BoolArray motions_free(Self& self, const ArrayLike& a, const ArrayLike& b) {
  const Rows from(a, "a", self.dof()), to(b, "b", self.dof());
  require_as_many(from, to);
  bool* free{};
  BoolArray result = new_array(static_cast<std::size_t>(from.count()), free);
  self.run([&](const Checker& checker, Checker::Workspace& workspace) {
    for (Eigen::Index i = 0; i < from.count(); ++i) {
      rare_interruption_point();
      free[i] = checker.is_motion_free(from.view().row(i).transpose(), to.view().row(i).transpose(), workspace);
    }
  });
  return result;
}

nb::ndarray<nb::numpy, double> clearance(Self& self, const ArrayLike& q) {
  const Rows rows(q, "q", self.dof());
  double* distance{};
  auto result = new_array(static_cast<std::size_t>(rows.count()), distance);
  self.run([&](const Checker& checker, Checker::Workspace& workspace) {
    for (Eigen::Index i = 0; i < rows.count(); ++i) {
      rare_interruption_point();
      const auto nearest = checker.nearest(rows.view().row(i).transpose(), workspace);
      distance[i] = nearest ? nearest->distance : std::numeric_limits<double>::infinity();
    }
  });
  return result;
}

/// One time for each row, or one for all.
class Times {
 public:
  Times(const ArrayLike& array, const std::string& what, Eigen::Index rows) : values_(to_numbers(array.value, what)) {
    one_ = values_.size() == 1;
    if (!one_ && (values_.ndim() != 1 || static_cast<Eigen::Index>(values_.size()) != rows))
      throw InvalidArgument(what + " must be one time [s] or one for each of the " + std::to_string(rows) + " rows");
  }
  double operator[](Eigen::Index row) const { return values_.data()[one_ ? 0 : row]; }

 private:
  Numbers values_;
  bool one_{};
};

BoolArray are_free_at(Timed& self, const ArrayLike& q, const ArrayLike& times) {
  const Rows rows(q, "q", self.dof());
  const Times when(times, "times", rows.count());
  bool* free{};
  BoolArray result = new_array(static_cast<std::size_t>(rows.count()), free);
  self.run([&](const TimedChecker& checker, Checker::Workspace& workspace) {
    for (Eigen::Index i = 0; i < rows.count(); ++i)
      free[i] = checker.is_free(rows.view().row(i).transpose(), when[i], workspace);
  });
  return result;
}

BoolArray motions_free_at(Timed& self, const ArrayLike& a, const ArrayLike& b, const ArrayLike& from,
                          const ArrayLike& to) {
  const Rows starts(a, "a", self.dof()), ends(b, "b", self.dof());
  require_as_many(starts, ends);
  const Times departures(from, "from_times", starts.count()), arrivals(to, "to_times", starts.count());
  bool* free{};
  BoolArray result = new_array(static_cast<std::size_t>(starts.count()), free);
  self.run([&](const TimedChecker& checker, Checker::Workspace& workspace) {
    for (Eigen::Index i = 0; i < starts.count(); ++i)
      free[i] = checker.is_motion_free(starts.view().row(i).transpose(), ends.view().row(i).transpose(), departures[i],
                                       arrivals[i], workspace);
  });
  return result;
}

nb::ndarray<nb::numpy, double> clearance_at(Timed& self, const ArrayLike& q, const ArrayLike& times) {
  const Rows rows(q, "q", self.dof());
  const Times when(times, "times", rows.count());
  double* distance{};
  auto result = new_array(static_cast<std::size_t>(rows.count()), distance);
  self.run([&](const TimedChecker& checker, Checker::Workspace& workspace) {
    for (Eigen::Index i = 0; i < rows.count(); ++i) {
      rare_interruption_point();
      const auto nearest = checker.nearest(rows.view().row(i).transpose(), when[i], workspace);
      distance[i] = nearest ? nearest->distance : std::numeric_limits<double>::infinity();
    }
  });
  return result;
}

template <class C>
nb::dict stats(PyChecker<C>& self) {
  const CheckStatistics s =
      self.run([](const C& checker, Checker::Workspace& w) { return base_of(checker).statistics(w); });
  nb::dict d;
  d["states"] = s.states;
  d["states_by_spheres"] = s.states_by_spheres;
  d["motions"] = s.motions;
  d["motions_by_spheres"] = s.motions_by_spheres;
  d["blocks"] = s.blocks;
  d["undecided"] = s.undecided;
  d["configurations"] = s.configurations;
  d["by_tables"] = s.by_tables;
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
  return nb::cast(new Self(std::move(checker)), nb::rv_policy::take_ownership);
}

nb::object wrap_checker(std::shared_ptr<const TimedChecker> checker) {
  return nb::cast(new Timed(std::move(checker)), nb::rv_policy::take_ownership);
}

std::map<std::string, TimedPath> to_timed_paths(nb::handle others) {
  std::map<std::string, TimedPath> paths;
  if (!nb::isinstance<nb::dict>(others))
    throw InvalidArgument("others must be a dict: robot name -> (times, configurations)");
  for (const auto& [key, value] : nb::cast<nb::dict>(others)) {
    if (!nb::isinstance<nb::str>(key)) throw InvalidArgument("others: a key is no robot name");
    const auto name = nb::cast<std::string>(key);
    if (!nb::isinstance<nb::sequence>(value) || nb::len(value) != 2)
      throw InvalidArgument("others['" + name + "'] must be (times, configurations)");
    const Eigen::VectorXd times = ArrayLike{value[0]}.vector("times of robot '" + name + "'");
    const auto rows = to_numbers(value[1], "configurations of robot '" + name + "'");
    if (rows.ndim() != 2) throw wrong_shape("configurations of robot '" + name + "'", "dof", rows);
    TimedPath& path = paths[name];
    path.times.assign(times.begin(), times.end());
    const auto columns = static_cast<Eigen::Index>(rows.shape(1));
    for (std::size_t i = 0; i < rows.shape(0); ++i)
      path.configurations.emplace_back(
          Eigen::Map<const Eigen::VectorXd>(rows.data() + static_cast<Eigen::Index>(i) * columns, columns));
  }
  return paths;
}

void bind_collision_checker(nb::module_& m) {
  nb::class_<MotionCertificate> certificate(
      m, "MotionCertificate",
      "Proof that a motion is free, or a contact on it, or the first part that could not be proved.");
  certificate.def_ro("proved", &MotionCertificate::proved, "Free between samples too.")
      .def_prop_ro(
          "interval", [](const MotionCertificate& c) { return std::pair(c.from, c.to); },
          "Part of the motion, 0..1, that could not be proved; both ends the same: a contact there; (0, 0) when "
          "proved.")
      .def_ro("body_a", &MotionCertificate::body_a, "The pair there: link or attached object of the robot; '' if none.")
      .def_ro("body_b", &MotionCertificate::body_b, "The pair there: object or link; '' if none.")
      .def("__bool__", [](const MotionCertificate& c) { return c.proved; })
      .def("__repr__", [](const MotionCertificate& c) {
        return c.proved ? std::string("MotionCertificate(proved)")
                        : "MotionCertificate(not proved: " + c.body_a + " and " + c.body_b + ", from " +
                              to_text(c.from) + " to " + to_text(c.to) + " of the motion)";
      });
  make_value(
      certificate,
      [](const MotionCertificate& c) { return nb::make_tuple(c.proved, c.from, c.to, c.body_a, c.body_b); },
      [](const State& s) {
        return MotionCertificate{nb::cast<bool>(s[0]), nb::cast<double>(s[1]), nb::cast<double>(s[2]),
                                 nb::cast<std::string>(s[3]), nb::cast<std::string>(s[4])};
      });
  nb::class_<Self>(m, "CollisionChecker",
                   "Collision checks of one robot in the scene as it was when planner.collision_checker made this.\n\n"
                   "Arrays are (n, dof) [rad or m]; float64 and contiguous ones are not copied. The GIL is released. "
                   "All methods\n"
                   "raise InvalidArgument for wrong shapes, NaN and infinity. Joint limits are not checked.")
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
            return self.run([&](const Checker& c, Checker::Workspace& w) { return c.nearest(v, w); });
          },
          nb::arg("q"),
          "The nearest pair at q (dof,) [rad or m] as a Contact, or None with nothing around. Pairs that never move\n"
          "relative to each other count only while in collision; PlannerInterface.nearest sees the base too.")
      .def(
          "certify_motion",
          [](Self& self, const ArrayLike& a, const ArrayLike& b) {
            const Eigen::VectorXd from = a.vector("a"), to = b.vector("b");
            return self.run([&](const Checker& c, Checker::Workspace& w) { return c.certify_motion(from, to, w); });
          },
          nb::arg("a"), nb::arg("b"),
          "Proves the straight motion a to b, each (dof,) [rad or m], free by conservative advancement on Coal's "
          "distances (Schwarzer,\n"
          "Saha, Latombe 2004), without spheres: an independent check of motions_free.")
      .def("stats", &stats<Checker>,
           "What this checker's checks did so far: how many of what, and which layer decided.")
      .def_prop_ro(
          "reach",
          [](Self& self) {
            return to_numpy(self.run([](const Checker& c, Checker::Workspace&) { return c.reach(); }));
          },
          "(dof,) [m/rad, prismatic joints 1]: how far a unit of each joint moves any point of the robot, or of what "
          "it "
          "holds, at most.")
      .def_prop_ro(
          "dof", [](const Self& self) { return self.dof(); }, "Number of planned joints.")
      .def("__repr__", [](const Self& self) { return "CollisionChecker(" + std::to_string(self.dof()) + " joints)"; });
  nb::class_<Timed>(m, "TimedCollisionChecker",
                    "Collision checks of one robot among others whose motions are known, in the scene as it was when\n"
                    "planner.timed_collision_checker made this. Arrays as for CollisionChecker; times are one [s], or "
                    "(n,), one for each row.")
      .def("are_free", &are_free_at, nb::arg("q"), nb::arg("times"),
           nb::sig("def are_free(self, q: numpy.typing.ArrayLike, times: numpy.typing.ArrayLike) -> "
                   "numpy.typing.NDArray[numpy.bool_]"),
           "(n,) bool: is each configuration, (n, dof) [rad or m], free at its time?")
      .def("motions_free", &motions_free_at, nb::arg("a"), nb::arg("b"), nb::arg("from_times"), nb::arg("to_times"),
           nb::sig("def motions_free(self, a: numpy.typing.ArrayLike, b: numpy.typing.ArrayLike, from_times: "
                   "numpy.typing.ArrayLike, to_times: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.bool_]"),
           "(n,) bool: is the straight motion from each row of a, where it departs at from_times, to that of b, where "
           "it "
           "arrives at\n"
           "to_times, at constant speed, proved free of everything that moves meanwhile?")
      .def("clearance", &clearance_at, nb::arg("q"), nb::arg("times"),
           nb::sig("def clearance(self, q: numpy.typing.ArrayLike, times: numpy.typing.ArrayLike) -> "
                   "numpy.typing.NDArray[numpy.float64]"),
           "(n,) [m]: distance of the nearest pair at each configuration and time, less its padding; negative in "
           "collision.")
      .def(
          "certify_motion",
          [](Timed& self, const ArrayLike& a, const ArrayLike& b, double from, double to) {
            const Eigen::VectorXd start = a.vector("a"), end = b.vector("b");
            return self.run([&](const TimedChecker& c, Checker::Workspace& w) {
              return c.certify_motion(start, end, from, to, w);
            });
          },
          nb::arg("a"), nb::arg("b"), nb::arg("from_time"), nb::arg("to_time"),
          "Proves the motion free by Coal's distances alone, as CollisionChecker.certify_motion does.")
      .def("stats", &stats<TimedChecker>, "What this checker's checks did so far.")
      .def_prop_ro(
          "dof", [](const Timed& self) { return self.dof(); }, "Planned joints of the one robot.")
      .def("__repr__",
           [](const Timed& self) { return "TimedCollisionChecker(" + std::to_string(self.dof()) + " joints)"; });
}

}  // namespace srmp::python
