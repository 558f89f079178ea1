#include "srmp/geometry/primitive_bvh.hpp"

#include <coal/BVH/BVH_model.h>
#include <coal/octree.h>

#include <algorithm>
#include <bit>

#include "srmp/core/error.hpp"
#include "srmp/geometry/morton.hpp"

namespace srmp {

namespace {

constexpr std::size_t max_cubes = 4;  // of a leaf

using Boxes = coal::BVHModel<coal::OBBRSS>;

}  // namespace

PrimitiveBvh::PrimitiveBvh(const coal::BVHModelBase& mesh) {
  const auto* boxes = dynamic_cast<const Boxes*>(&mesh);
  if (!boxes || boxes->getNumBVs() == 0) throw NotSupported("a mesh needs Coal's hierarchy of oriented boxes (OBBRSS)");
  nodes_.reserve(boxes->getNumBVs());
  triangles_.reserve(mesh.num_tris);
  const auto copy = [&](const auto& self, unsigned from) -> std::uint32_t {
    const auto& box = boxes->getBV(from);
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    set_box(index, RoundedBox(box.bv.obb.axes, box.bv.obb.To, box.bv.obb.extent));
    if (box.isLeaf()) {
      const coal::Triangle& t = (*mesh.tri_indices)[static_cast<std::size_t>(box.primitiveId())];
      nodes_[index].first = static_cast<std::uint32_t>(triangles_.size());
      nodes_[index].size = 1;
      triangles_.push_back({(*mesh.vertices)[t[0]], (*mesh.vertices)[t[1]], (*mesh.vertices)[t[2]]});
      return index;
    }
    self(self, static_cast<unsigned>(box.leftChild()));
    const std::uint32_t right = self(self, static_cast<unsigned>(box.rightChild()));
    nodes_[index].right = right;
    return index;
  };
  copy(copy, 0);
}

PrimitiveBvh::PrimitiveBvh(std::vector<std::array<std::int32_t, 3>> keys, double edge) : edge_(edge) {
  if (keys.empty()) throw InvalidArgument("a bounding volume hierarchy needs at least one cube");
  std::vector<std::uint64_t> codes;
  codes.reserve(keys.size());
  for (const auto& key : keys) codes.push_back(morton_code(key));
  if (!std::is_sorted(codes.begin(), codes.end())) std::sort(codes.begin(), codes.end());
  codes.erase(std::unique(codes.begin(), codes.end()), codes.end());
  cubes_.reserve(codes.size());
  for (const std::uint64_t code : codes) {
    const auto key = morton_key(code);
    cubes_.emplace_back((key[0] + 0.5) * edge, (key[1] + 0.5) * edge, (key[2] + 0.5) * edge);
  }
  nodes_.reserve(codes.size());
  build_cubes(codes, 0);
}

/// A box of fewer primitives may stick out of the one around it, so the largest reach is not always the root's.
void PrimitiveBvh::set_box(std::uint32_t node, const RoundedBox& box) {
  nodes_[node].box = box;
  reach_ = std::max(reach_, box.reach());
}

/// Splits where the highest bit in which the codes differ changes: at the middle of a cell of the octree, along one
/// axis. Returns the box around the cubes.
Eigen::AlignedBox3d PrimitiveBvh::build_cubes(std::span<const std::uint64_t> codes, std::size_t done) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Eigen::AlignedBox3d extent;
  if (codes.size() <= max_cubes) {
    nodes_[index].first = static_cast<std::uint32_t>(done);
    nodes_[index].size = static_cast<std::uint32_t>(codes.size());
    for (std::size_t i = done; i < done + codes.size(); ++i) extent.extend(cubes_[i]);
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(edge_ / 2);
    extent = {extent.min() - half, extent.max() + half};
  } else {
    const std::uint64_t bit = std::bit_floor(codes.front() ^ codes.back()), border = codes.back() & ~(bit - 1);
    const auto half = static_cast<std::size_t>(std::lower_bound(codes.begin(), codes.end(), border) - codes.begin());
    extent = build_cubes(codes.first(half), done);
    nodes_[index].right = static_cast<std::uint32_t>(nodes_.size());
    extent.extend(build_cubes(codes.subspan(half), done + half));
  }
  set_box(index, RoundedBox(Eigen::Matrix3d::Identity(), extent.center(), extent.sizes() / 2));
  return extent;
}

namespace {

/// The occupied cells of an octree. A leaf above the finest level becomes many cubes.
PrimitiveBvh bvh_of_octree(const coal::OcTree& geometry) {
  const octomap::OcTree& octree = *geometry.getTree();
  const auto middle = static_cast<std::int32_t>(1u << (octree.getTreeDepth() - 1));
  std::vector<std::array<std::int32_t, 3>> keys;
  for (auto leaf = octree.begin_leafs(); leaf != octree.end_leafs(); ++leaf) {
    if (!geometry.isNodeOccupied(&*leaf)) continue;
    const auto width = static_cast<std::int32_t>(1u << (octree.getTreeDepth() - leaf.getDepth()));
    const auto corner = leaf.getIndexKey();
    for (std::int32_t z = 0; z < width; ++z)
      for (std::int32_t y = 0; y < width; ++y)
        for (std::int32_t x = 0; x < width; ++x)
          keys.push_back({corner[0] + x - middle, corner[1] + y - middle, corner[2] + z - middle});
  }
  return PrimitiveBvh(std::move(keys), geometry.getResolution());
}

}  // namespace

std::shared_ptr<const PrimitiveBvh> make_primitive_bvh(const coal::CollisionGeometry& geometry) {
  if (geometry.getObjectType() == coal::OT_GEOM) return nullptr;
  if (const auto* mesh = dynamic_cast<const coal::BVHModelBase*>(&geometry))
    return std::make_shared<const PrimitiveBvh>(*mesh);
  if (const auto* octree = dynamic_cast<const coal::OcTree*>(&geometry))
    return std::make_shared<const PrimitiveBvh>(bvh_of_octree(*octree));
  throw NotSupported("a geometry of Coal's type " + std::to_string(geometry.getNodeType()) +
                     " is neither a convex solid, a mesh nor an octree");
}

}  // namespace srmp
