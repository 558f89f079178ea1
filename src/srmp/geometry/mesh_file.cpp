#include "srmp/geometry/mesh_file.hpp"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <coal/BVH/BVH_model.h>
#include <coal/mesh_loader/loader.h>

#include <assimp/Importer.hpp>
#include <filesystem>
#include <map>

#include "srmp/core/error.hpp"

namespace srmp {

namespace {

/// Collects the parts of a scene into one mesh; vertices are keyed by their exact position.
class Collector {
 public:
  explicit Collector(const Eigen::Vector3d& scale) : scale_(scale) {}

  void add(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent) {
    const aiMatrix4x4 transform = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) add(*scene.mMeshes[node.mMeshes[i]], transform);
    for (unsigned i = 0; i < node.mNumChildren; ++i) add(scene, *node.mChildren[i], transform);
  }

  TriangleSoup mesh;

 private:
  void add(const aiMesh& part, const aiMatrix4x4& transform) {
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

}  // namespace

TriangleSoup read_mesh_file(const std::string& path, const Eigen::Vector3d& scale) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw FileError("mesh file '" + path + "' does not exist");
  if (!fs::is_regular_file(path, ignored)) throw FileError("mesh file '" + path + "' is not a file");
  if (fs::file_size(path, ignored) == 0) throw FileError("mesh file '" + path + "' is empty");

  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = importer.ReadFile(path, aiProcess_Triangulate);
  if (!scene || !scene->mRootNode)
    throw FileError("mesh file '" + path + "' cannot be read: " + importer.GetErrorString());

  Collector collector(scale);
  collector.mesh.parts = scene->mNumMeshes;
  collector.add(*scene, *scene->mRootNode, aiMatrix4x4());
  if (collector.mesh.triangles.empty()) throw FileError("mesh file '" + path + "' contains no triangles");
  for (const Eigen::Vector3d& v : collector.mesh.vertices)
    if (!v.allFinite()) throw FileError("mesh file '" + path + "' contains a vertex that is not finite");
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
}

}  // namespace srmp
