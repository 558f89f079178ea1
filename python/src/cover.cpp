#include <nanobind/stl/shared_ptr.h>

#include <cmath>

#include "bind.hpp"
#include "interrupt.hpp"
#include "srmp/cover/cover_file.hpp"
#include "srmp/geometry/mesh_geometry.hpp"
#include "srmp/robot/robot_cover.hpp"

namespace srmp::python {

namespace {

/// The covers of all geometries of a link, merged, in the link's frame.
struct LinkCover {
  std::string link;
  std::vector<PlacedSphere> coarse, fine, inner;
  std::vector<std::vector<std::uint32_t>> children;
  double coarse_inflation{}, fine_inflation{};            // largest
  double mean_coarse_inflation{}, mean_fine_inflation{};  // over spheres

  void add(const RobotCover::Part& part) {
    const GeometryCover& cover = *part.cover;
    const auto first_fine = static_cast<std::uint32_t>(fine.size());
    // An exact sphere belongs to all levels.
    const std::vector<PlacedSphere>& finest = cover.exact ? cover.coarse : cover.fine;
    mean_coarse_inflation =
        mean(coarse.size(), mean_coarse_inflation, cover.coarse.size(), cover.coarse_inflation.mean);
    mean_fine_inflation = mean(fine.size(), mean_fine_inflation, finest.size(), cover.fine_inflation.mean);
    coarse_inflation = std::max(coarse_inflation, cover.coarse_inflation.max);
    fine_inflation = std::max(fine_inflation, cover.fine_inflation.max);
    append(coarse, cover.coarse, part.in_link);
    append(fine, finest, part.in_link);
    append(inner, cover.exact ? cover.coarse : cover.inner, part.in_link);
    if (cover.exact) children.push_back({first_fine});
    for (const auto& list : cover.children) {
      children.push_back(list);
      for (std::uint32_t& child : children.back()) child += first_fine;
    }
  }

 private:
  static double mean(std::size_t n, double a, std::size_t m, double b) {
    return n + m == 0 ? 0.0 : (static_cast<double>(n) * a + static_cast<double>(m) * b) / static_cast<double>(n + m);
  }
  static void append(std::vector<PlacedSphere>& to, const std::vector<PlacedSphere>& spheres,
                     const Eigen::Isometry3d& pose) {
    for (const PlacedSphere& sphere : spheres) to.push_back({pose * sphere.center, sphere.radius});
  }
};

nb::object rows(const std::vector<PlacedSphere>& spheres) {
  std::vector<Eigen::VectorXd> rows;
  for (const PlacedSphere& sphere : spheres)
    rows.push_back((Eigen::VectorXd(4) << sphere.center, sphere.radius).finished());
  return to_numpy_rows(rows, 4);
}

struct PyRobotCover {
  std::vector<LinkCover> links;
  bool from_cache{};
  double seconds{};
};

PyRobotCover by_links(const RobotCover& cover) {
  PyRobotCover result;
  result.from_cache = cover.origin != CoverStore::Origin::built;
  result.seconds = cover.seconds;
  for (const RobotCover::Part& part : cover.parts) {
    if (result.links.empty() || result.links.back().link != part.link) {
      result.links.emplace_back();
      result.links.back().link = part.link;
    }
    result.links.back().add(part);
  }
  return result;
}

PyRobotCover cover(const std::string& urdf_path, const std::vector<std::string>& package_dirs, double accuracy,
                   double coarse_accuracy, int max_coarse, bool cache, const std::optional<nb::callable>& progress) {
  if (max_coarse < 0) throw InvalidArgument("max_coarse must not be negative, got " + std::to_string(max_coarse));
  RobotCoverOptions options;
  options.levels.fine = accuracy;
  options.levels.coarse = coarse_accuracy;
  options.max_coarse = static_cast<std::size_t>(max_coarse);
  const StepProgress report = report_to_python(progress);
  const nb::gil_scoped_release no_gil;
  CoverStore store(cache ? default_cover_directory() : std::filesystem::path(), options.levels);
  return by_links(cover_urdf(urdf_path, package_dirs, store, options, report));
}

}  // namespace

void bind_cover(nb::module_& m) {
  m.def(
      "cover_directory", [] { return default_cover_directory().string(); },
      "The directory that keeps covers between runs: $SRMP_CACHE_DIR/covers, else $XDG_CACHE_HOME/srmp/covers, else\n"
      "~/.cache/srmp/covers; \"\" when no files are kept (docs/covers.md).");
  m.def(
      "convex_hull",
      [](const ArrayLike& points) {
        std::vector<Eigen::Vector3d> list;
        const RowMatrix rows = points.rows("points of a convex hull", 3);
        for (const auto& row : rows.rowwise()) list.emplace_back(row.transpose());
        const TriangleSoup hull = convex_hull(list);
        std::vector<Eigen::VectorXd> vertices(hull.vertices.begin(), hull.vertices.end());
        return std::pair(to_numpy_rows(vertices, 3), hull.triangles);
      },
      nb::arg("points"),
      "The convex hull of points of shape (n, 3): its corners, shape (k, 3), and its triangles, three indices of "
      "corners\n"
      "each, which face outwards.\n\n"
      "Raises InvalidArgument for fewer than four points, points in one plane, and NaN.");
  nb::class_<LinkCover>(m, "LinkCover",
                        "The spheres of one link, in its frame: arrays of shape (n, 4) with rows x, y, z, radius [m].")
      .def_ro("link", &LinkCover::link, "Name of the link.")
      .def_prop_ro(
          "coarse", [](const LinkCover& c) { return rows(c.coarse); },
          "Together they contain the link's collision geometry.")
      .def_prop_ro(
          "fine", [](const LinkCover& c) { return rows(c.fine); }, "Together they contain it too, more closely.")
      .def_prop_ro(
          "inner", [](const LinkCover& c) { return rows(c.inner); }, "Spheres inside the collision geometry.")
      .def_ro("children", &LinkCover::children, "For each coarse sphere, the rows of `fine` to check when it collides.")
      .def_ro("coarse_inflation", &LinkCover::coarse_inflation,
              "How far the worst sphere extends beyond the geometry [m].")
      .def_ro("mean_coarse_inflation", &LinkCover::mean_coarse_inflation, "The mean of that over the spheres [m].")
      .def_ro("fine_inflation", &LinkCover::fine_inflation, "How far the worst sphere extends beyond the geometry [m].")
      .def_ro("mean_fine_inflation", &LinkCover::mean_fine_inflation, "The mean of that over the spheres [m].")
      .def("__repr__", [](const LinkCover& c) {
        return "LinkCover('" + c.link + "': " + std::to_string(c.coarse.size()) + " coarse, " +
               std::to_string(c.fine.size()) + " fine, " + std::to_string(c.inner.size()) + " inner spheres)";
      });
  nb::class_<PyRobotCover>(m, "RobotCover", "The spheres of a robot, as srmp.cover returns them.")
      .def_ro("links", &PyRobotCover::links, "Links with collision geometry, in the order of the URDF.")
      .def_ro("from_cache", &PyRobotCover::from_cache, "Was the cover loaded from the cache directory?")
      .def_ro("seconds", &PyRobotCover::seconds, "Time to compute or load the spheres [s], without reading meshes.")
      .def("__repr__",
           [](const PyRobotCover& c) { return "RobotCover(" + std::to_string(c.links.size()) + " links)"; });
  m.def(
      "cover", &cover, nb::arg("urdf_path"), nb::kw_only(), nb::arg("package_dirs") = std::vector<std::string>(),
      nb::arg("accuracy") = 0.004, nb::arg("coarse_accuracy") = 0.015, nb::arg("max_coarse") = 160,
      nb::arg("cache") = true, nb::arg("progress") = nb::none(),
      "Spheres that provably contain each link of a robot, in two levels, and spheres inside each link.\n\n"
      "No fine sphere extends beyond the geometry by more than `accuracy` [m] and no coarse sphere by more than\n"
      "`coarse_accuracy` [m], unless that needs more than `max_coarse` coarse spheres for the robot (0: no limit); in\n"
      "that case coarse spheres grow. Cavities that a sphere of 15 mm radius cannot enter count as filled. The result\n"
      "is the same on every run. With `cache`, it is kept in cover_directory() for later runs. `progress` is called\n"
      "with (steps done, all steps) while spheres are computed; what it raises ends the computation.\n\n"
      "Raises FileError for missing or wrong files, InvalidArgument for numbers out of range.");
}

}  // namespace srmp::python
