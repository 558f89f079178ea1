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

/// A node of the hierarchy as it is built, before those of two levels become one. Its left child is the next node.
struct PrimitiveBvh::BinaryNode {
  RoundedBox box;
  std::uint32_t right{};  // right child
  Part part{};            // its primitives; none: an inner node
};

PrimitiveBvh::PrimitiveBvh(const coal::BVHModelBase& mesh) {
  const auto* boxes = dynamic_cast<const Boxes*>(&mesh);
  if (!boxes || boxes->getNumBVs() == 0) throw NotSupported("a mesh needs Coal's hierarchy of oriented boxes (OBBRSS)");
  std::vector<BinaryNode> binary;
  binary.reserve(boxes->getNumBVs());
  triangles_.reserve(mesh.num_tris);
  const auto copy = [&](const auto& self, unsigned from) -> std::uint32_t {
    const auto& box = boxes->getBV(from);
    const auto index = static_cast<std::uint32_t>(binary.size());
    binary.push_back({RoundedBox(box.bv.obb.axes, box.bv.obb.To, box.bv.obb.extent)});
    if (box.isLeaf()) {
      const coal::Triangle& t = (*mesh.tri_indices)[static_cast<std::size_t>(box.primitiveId())];
      binary[index].part = {static_cast<std::uint32_t>(triangles_.size()), 1};
      triangles_.push_back({(*mesh.vertices)[t[0]], (*mesh.vertices)[t[1]], (*mesh.vertices)[t[2]]});
      return index;
    }
    self(self, static_cast<unsigned>(box.leftChild()));
    const std::uint32_t right = self(self, static_cast<unsigned>(box.rightChild()));
    binary[index].right = right;
    return index;
  };
  copy(copy, 0);
  add_nodes(binary);
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
  std::vector<BinaryNode> binary;
  build_cubes(codes, 0, binary);
  add_nodes(binary);
}

/// Splits where the highest bit in which the codes differ changes: at the middle of a cell of the octree, along one
/// axis. Returns the box around the cubes.
Eigen::AlignedBox3d PrimitiveBvh::build_cubes(std::span<const std::uint64_t> codes, std::size_t done,
                                              std::vector<BinaryNode>& binary) const {
  const auto index = static_cast<std::uint32_t>(binary.size());
  binary.emplace_back();
  Eigen::AlignedBox3d extent;
  if (codes.size() <= max_cubes) {
    binary[index].part = {static_cast<std::uint32_t>(done), static_cast<std::uint32_t>(codes.size())};
    for (std::size_t i = done; i < done + codes.size(); ++i) extent.extend(cubes_[i]);
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(edge_ / 2);
    extent = {extent.min() - half, extent.max() + half};
  } else {
    const std::uint64_t bit = std::bit_floor(codes.front() ^ codes.back()), border = codes.back() & ~(bit - 1);
    const auto half = static_cast<std::size_t>(std::lower_bound(codes.begin(), codes.end(), border) - codes.begin());
    extent = build_cubes(codes.first(half), done, binary);
    binary[index].right = static_cast<std::uint32_t>(binary.size());
    extent.extend(build_cubes(codes.subspan(half), done + half, binary));
  }
  binary[index].box = RoundedBox(Eigen::Matrix3d::Identity(), extent.center(), extent.sizes() / 2);
  return extent;
}

void PrimitiveBvh::add_nodes(const std::vector<BinaryNode>& binary) {
  nodes_.reserve(binary.size() / 4 + 1);  // mostly enough; what is not used takes no memory
  add_node(binary, std::array<std::uint32_t, 1>{0});
}

/// A node of these boxes, with all that is below them. The largest children are replaced by their own, until a node is
/// full.
void PrimitiveBvh::add_node(const std::vector<BinaryNode>& binary, std::span<const std::uint32_t> members) {
  const std::size_t index = nodes_.size();
  nodes_.emplace_back().size = static_cast<int>(members.size());
  for (std::size_t i = 0; i < RoundedBoxes::count; ++i) {
    const BinaryNode& member = binary[members[std::min(i, members.size() - 1)]];
    nodes_[index].boxes.set(static_cast<int>(i), member.box);
    nodes_[index].squared_sizes[i] = member.box.squared_size();
    // A box of fewer primitives may stick out of the one around it, so the largest reach is not always that of box 0.
    reach_ = std::max(reach_, member.box.reach());
  }
  for (std::size_t i = 0; i < members.size(); ++i) {
    nodes_[index].parts[i] = binary[members[i]].part;
    if (nodes_[index].parts[i].has_primitives()) continue;
    nodes_[index].parts[i].first = static_cast<std::uint32_t>(nodes_.size());
    std::array<std::uint32_t, RoundedBoxes::count> below{members[i] + 1, binary[members[i]].right};
    std::size_t count = 2;
    const auto size_of = [&](std::uint32_t k) {
      return binary[k].part.has_primitives() ? 0.0f : binary[k].box.squared_size();
    };
    while (count < below.size()) {
      const auto largest = std::max_element(below.begin(), below.begin() + static_cast<std::ptrdiff_t>(count),
                                            [&](auto a, auto b) { return size_of(a) < size_of(b); });
      if (binary[*largest].part.has_primitives()) break;
      below[count++] = binary[*largest].right;
      ++*largest;
    }
    add_node(binary, {below.data(), count});
  }
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
