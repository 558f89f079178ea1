#include "srmp/geometry/mesh_file.hpp"

#include <assimp/DefaultIOSystem.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <coal/BVH/BVH_model.h>
#include <coal/mesh_loader/loader.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>

#include "srmp/core/error.hpp"
#include "srmp/core/interruption.hpp"
#include "srmp/core/lengths.hpp"
#include "srmp/geometry/collada_check.hpp"
#include "srmp/geometry/header_check.hpp"

namespace srmp {

namespace {

constexpr std::size_t max_triangles = 20'000'000;

/// Collects the parts of a scene into one mesh; vertices are keyed by their exact position.
class Collector {
 public:
  explicit Collector(const Eigen::Vector3d& scale) : scale_(scale) {}

  void add(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent) {
    rare_interruption_point();
    const aiMatrix4x4 transform = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) add(*scene.mMeshes[node.mMeshes[i]], transform);
    for (unsigned i = 0; i < node.mNumChildren; ++i) add(scene, *node.mChildren[i], transform);
  }

  TriangleSoup mesh;

 private:
  void add(const aiMesh& part, const aiMatrix4x4& transform) {
    faces_ += part.mNumFaces;
    if (faces_ > max_triangles)
      throw FileError("it has more than " + std::to_string(max_triangles) + " triangles when instances are expanded");
    std::vector<int> index(part.mNumVertices);
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const aiVector3D p = transform * part.mVertices[i];
      index[i] = vertex(Eigen::Vector3d(p.x, p.y, p.z).cwiseProduct(scale_));
    }
    for (unsigned i = 0; i < part.mNumFaces; ++i) {
      const aiFace& face = part.mFaces[i];
      if (face.mNumIndices != 3) continue;  // points and lines, which some exporters write
      const std::array<int, 3> t{index[face.mIndices[0]], index[face.mIndices[1]], index[face.mIndices[2]]};
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) mesh.triangles.push_back(t);
    }
  }

  int vertex(const Eigen::Vector3d& p) {
    const auto [it, is_new] = known_.try_emplace({p.x(), p.y(), p.z()}, static_cast<int>(mesh.vertices.size()));
    if (is_new) mesh.vertices.push_back(p);
    return it->second;
  }

  Eigen::Vector3d scale_;
  std::size_t faces_{};
  std::map<std::array<double, 3>, int> known_;
};

/// Drops vertices that no triangle uses, such as those of dropped lines and points: they must not enlarge a hull.
void drop_unused_vertices(TriangleSoup& mesh) {
  std::vector<int> index(mesh.vertices.size(), -1);
  std::vector<Eigen::Vector3d> used;
  for (auto& triangle : mesh.triangles) {
    for (int& v : triangle) {
      if (index[v] < 0) {
        index[v] = static_cast<int>(used.size());
        used.push_back(mesh.vertices[v]);
      }
      v = index[v];
    }
  }
  mesh.vertices = std::move(used);
}

/// Opens files and nothing else: a pipe that a mesh file names as its material would be waited for.
class FilesOnly : public Assimp::IOSystem {
 public:
  bool Exists(const char* file) const override { return is_file(file) && files_.Exists(file); }
  char getOsSeparator() const override { return files_.getOsSeparator(); }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    if (is_file(file)) return files_.Open(file, mode);
    std::error_code ignored;
    names_other_things |= std::filesystem::exists(file, ignored);
    return nullptr;
  }
  void Close(Assimp::IOStream* file) override { files_.Close(file); }
  bool ComparePaths(const char* a, const char* b) const override { return files_.ComparePaths(a, b); }

  bool names_other_things{};

 private:
  static bool is_file(const char* file) {
    std::error_code ignored;
    return std::filesystem::is_regular_file(file, ignored);
  }
  Assimp::DefaultIOSystem files_;
};

/// assimp has readers of fifty formats, most of them rare and fragile.
void require_known_format(const std::string& path) {
  const std::vector<std::string> known{".stl", ".obj", ".dae", ".ply", ".off", ".gltf", ".glb"};
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (std::find(known.begin(), known.end(), extension) == known.end())
    throw FileError("mesh file '" + path + "' has the extension '" + extension + "'; supported are " +
                    quoted_list(known));
  if (extension == ".dae") require_sound_collada(path);
  if (extension == ".ply") require_sound_ply_header(path);
  if (extension == ".off") require_sound_off_header(path);
  if (extension == ".glb" || extension == ".gltf") require_gltf(path);
}

/// assimp itself trusts the numbers of vertices that files give, when it makes triangles of faces.
void require_valid_faces(const aiScene& scene, const std::string& path) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f)
      for (unsigned i = 0; i < mesh.mFaces[f].mNumIndices; ++i)
        if (mesh.mFaces[f].mIndices[i] >= mesh.mNumVertices)
          throw FileError("mesh file '" + path + "' has a face with vertex " +
                          std::to_string(mesh.mFaces[f].mIndices[i]) + ", but there are " +
                          std::to_string(mesh.mNumVertices) + " vertices, counted from 0");
  }
}

void require_sizes(const TriangleSoup& mesh, const std::string& path) {
  for (const Eigen::Vector3d& v : mesh.vertices) {
    if (!v.allFinite()) throw FileError("mesh file '" + path + "' contains a vertex that is not finite");
    if (const double farthest = v.cwiseAbs().maxCoeff(); farthest > max_length)
      throw FileError("mesh file '" + path + "' has a vertex " + to_text(farthest) + " m from its origin" +
                      length_rule() + "; a file in millimetres needs a scale of 0.001");
  }
}

}  // namespace

TriangleSoup read_mesh_file(const std::string& path, const Eigen::Vector3d& scale) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw FileError("mesh file '" + path + "' does not exist");
  if (!fs::is_regular_file(path, ignored)) throw FileError("mesh file '" + path + "' is not a file");
  if (fs::file_size(path, ignored) == 0) throw FileError("mesh file '" + path + "' is empty");

  require_known_format(path);

  Assimp::Importer importer;
  auto* files = new FilesOnly;
  importer.SetIOHandler(files);  // which owns it
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(path, 0);
  if (scene) {
    require_valid_faces(*scene, path);
    scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  }
  if (!scene || !scene->mRootNode)
    throw FileError("mesh file '" + path + "' cannot be read: " + importer.GetErrorString());
  if (files->names_other_things)
    throw FileError("mesh file '" + path + "' names something that is not a file, such as a directory or a pipe");

  Collector collector(scale);
  collector.mesh.parts = scene->mNumMeshes;
  try {
    collector.add(*scene, *scene->mRootNode, aiMatrix4x4());
  } catch (const FileError& error) {
    throw FileError("mesh file '" + path + "': " + error.what());
  }
  if (collector.mesh.triangles.empty()) throw FileError("mesh file '" + path + "' contains no triangles");
  require_sizes(collector.mesh, path);
  drop_unused_vertices(collector.mesh);
  return std::move(collector.mesh);
}

void add_coal_reading(const std::string& path, const Eigen::Vector3d& scale, TriangleSoup& mesh) {
  const coal::BVHModelPtr_t model = coal::MeshLoader(coal::BV_OBBRSS).load(path, scale);
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), model->vertices->begin(), model->vertices->end());
  for (const coal::Triangle& t : *model->tri_indices) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    mesh.triangles.push_back(
        {first + static_cast<int>(t[0]), first + static_cast<int>(t[1]), first + static_cast<int>(t[2])});
  }
  require_sizes(mesh, path);
}

}  // namespace srmp
