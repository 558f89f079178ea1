#pragma once

#include <Eigen/Core>
#include <cmath>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "srmp/robot/robot_model.hpp"
#include "support/files.hpp"

/// The package's own arm with meshes in place of its primitives, and inside them: cylinders become prisms, spheres
/// polyhedra, and the palm an angle bracket, which is not convex. A robot of meshes for checkouts without
/// MotionBenchMaker's data.
namespace mesh_arm {

using Points = std::vector<Eigen::Vector3d>;
using Faces = std::vector<std::array<std::size_t, 3>>;

/// Wavefront OBJ.
inline std::string obj(const Points& points, const Faces& faces) {
  std::ostringstream text;
  text.precision(17);
  for (const Eigen::Vector3d& p : points) text << "v " << p.x() << " " << p.y() << " " << p.z() << "\n";
  for (const auto& f : faces) text << "f " << f[0] + 1 << " " << f[1] + 1 << " " << f[2] + 1 << "\n";
  return text.str();
}

/// A polygon in the xy plane, counter-clockwise, moved along z. Its first vertex sees all others.
inline std::string prism(const std::vector<Eigen::Vector2d>& polygon, double length) {
  Points points;
  Faces faces;
  const std::size_t n = polygon.size();
  for (const double z : {-0.5 * length, 0.5 * length})
    for (const Eigen::Vector2d& p : polygon) points.emplace_back(p.x(), p.y(), z);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    faces.push_back({i, j, n + j});
    faces.push_back({i, n + j, n + i});
    if (i == 0 || j == 0) continue;
    faces.push_back({0, j, i});
    faces.push_back({n, n + i, n + j});
  }
  return obj(points, faces);
}

inline std::string cylinder(double radius, double length) {
  constexpr int sides = 12;
  std::vector<Eigen::Vector2d> polygon;
  for (int i = 0; i < sides; ++i)
    polygon.emplace_back(radius * std::cos(2 * M_PI * i / sides), radius * std::sin(2 * M_PI * i / sides));
  return prism(polygon, length);
}

inline std::string sphere(double radius) {
  constexpr std::size_t rings = 5, sides = 8;
  Points points{{0, 0, radius}};
  Faces faces;
  for (std::size_t ring = 1; ring <= rings; ++ring)
    for (std::size_t i = 0; i < sides; ++i) {
      const double down = M_PI * static_cast<double>(ring) / (rings + 1),
                   about = 2 * M_PI * static_cast<double>(i) / sides;
      points.push_back(
          radius * Eigen::Vector3d(std::sin(down) * std::cos(about), std::sin(down) * std::sin(about), std::cos(down)));
    }
  points.emplace_back(0, 0, -radius);
  for (std::size_t i = 0; i < sides; ++i) {
    const std::size_t j = (i + 1) % sides, last = points.size() - 1;
    faces.push_back({0, 1 + i, 1 + j});
    for (std::size_t ring = 0; ring + 1 < rings; ++ring) {
      const std::size_t a = 1 + ring * sides, b = a + sides;
      faces.push_back({a + i, b + i, b + j});
      faces.push_back({a + i, b + j, a + j});
    }
    faces.push_back({last, last - sides + j, last - sides + i});
  }
  return obj(points, faces);
}

/// Two plates of a box that share an edge.
inline std::string bracket(const Eigen::Vector3d& size) {
  const double x = 0.5 * size.x(), y = 0.5 * size.y(), plate = 0.3;
  const Eigen::Vector2d inner(-x + plate * size.x(), -y + plate * size.y());
  return prism({inner, {-x + plate * size.x(), y}, {-x, y}, {-x, -y}, {x, -y}, {x, -y + plate * size.y()}}, size.z());
}

inline std::string box(const Eigen::Vector3d& size) {
  const double x = 0.5 * size.x(), y = 0.5 * size.y();
  return prism({{-x, -y}, {x, -y}, {x, y}, {-x, y}}, size.z());
}

/// The files, written once for the whole program.
struct Files {
  TemporaryDirectory directory;
  std::string urdf;
  std::vector<std::string> meshes;  ///< paths

  Files() {
    std::ifstream file(SRMP_SOURCE_DIR "/python/srmp/data/arm7.urdf");
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const std::regex primitive("<(cylinder|sphere|box) [^>]*/>"), number("[0-9.]+(?=[ \"])");
    std::string changed;
    auto rest = text.begin();
    for (std::sregex_iterator it(text.begin(), text.end(), primitive), end; it != end; ++it) {
      const std::string tag = it->str();
      std::vector<double> sizes;
      for (std::sregex_iterator n(tag.begin(), tag.end(), number); n != end; ++n) sizes.push_back(std::stod(n->str()));
      const std::string name = "mesh" + std::to_string(meshes.size()) + ".obj";
      meshes.push_back(directory.write(name, mesh(it->str(1), sizes)));
      changed.append(rest, text.begin() + it->position()).append("<mesh filename=\"" + name + "\"/>");
      rest = text.begin() + it->position() + it->length();
    }
    urdf = directory.write("arm7.urdf", changed.append(rest, text.end()));
  }

  static std::string mesh(const std::string& kind, const std::vector<double>& sizes) {
    if (kind == "cylinder") return cylinder(sizes.at(0), sizes.at(1));
    if (kind == "sphere") return sphere(sizes.at(0));
    const Eigen::Vector3d size(sizes.at(0), sizes.at(1), sizes.at(2));
    return size.y() > 0.1 ? bracket(size) : box(size);
  }
};

inline const Files& files() {
  static const Files written;
  return written;
}

inline srmp::RobotDescription description() {
  srmp::RobotDescription arm;
  arm.urdf_path = files().urdf;
  arm.srdf_path = SRMP_SOURCE_DIR "/python/srmp/data/arm7.srdf";
  arm.end_effector = "arm7_hand";
  return arm;
}

}  // namespace mesh_arm
