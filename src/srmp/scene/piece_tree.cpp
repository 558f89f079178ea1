#include "srmp/scene/piece_tree.hpp"

#include <coal/BVH/BVH_model.h>
#include <coal/octree.h>

#include <algorithm>
#include <bit>
#include <numeric>

#include "srmp/core/error.hpp"
#include "srmp/scene/morton.hpp"

namespace srmp {

namespace {

constexpr std::size_t most_triangles = 2, most_cubes = 4;  // of a leaf

Eigen::Vector3d middle(const PieceTree::Triangle& t) {
  return (t[0].cwiseMin(t[1]).cwiseMin(t[2]) + t[0].cwiseMax(t[1]).cwiseMax(t[2])) / 2;
}

}  // namespace

std::uint32_t PieceTree::add_node(std::size_t depth) {
  depth_ = std::max(depth_, depth);
  nodes_.emplace_back();
  return static_cast<std::uint32_t>(nodes_.size() - 1);
}

void PieceTree::add_leaf(std::uint32_t index, std::size_t first, std::size_t size) {
  Node& node = nodes_[index];
  node.first = static_cast<std::uint32_t>(first);
  node.size = static_cast<std::uint32_t>(size);
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (std::size_t i = first; i < first + size; ++i)
    if (of_cubes()) {
      low = low.cwiseMin(cubes_[i] - Eigen::Vector3d::Constant(edge_ / 2));
      high = high.cwiseMax(cubes_[i] + Eigen::Vector3d::Constant(edge_ / 2));
    } else {
      for (const Eigen::Vector3d& v : triangles_[i]) {
        low = low.cwiseMin(v);
        high = high.cwiseMax(v);
      }
    }
  node.center = (low + high) / 2;
  node.half = (high - low) / 2;
}

void PieceTree::add_children(std::uint32_t index, std::uint32_t right) {
  Node& node = nodes_[index];
  const Node &a = nodes_[index + 1], &b = nodes_[right];
  const Eigen::Vector3d low = (a.center - a.half).cwiseMin(b.center - b.half),
                        high = (a.center + a.half).cwiseMax(b.center + b.half);
  node.right = right;
  node.center = (low + high) / 2;
  node.half = (high - low) / 2;
}

PieceTree::PieceTree(std::vector<Triangle> triangles) : triangles_(std::move(triangles)) {
  if (triangles_.empty()) throw InvalidArgument("a tree of pieces needs at least one triangle");
  std::vector<std::uint32_t> order(triangles_.size());
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(2 * triangles_.size());
  const std::vector<Triangle> unordered = triangles_;
  // Leaves take their pieces in the order in which they are made, so each half is put in place before it is split.
  build_triangles(order, 0, 1);
  for (std::size_t i = 0; i < order.size(); ++i) triangles_[i] = unordered[order[i]];
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    const auto index = static_cast<std::uint32_t>(i);
    if (nodes_[i].size > 0)
      add_leaf(index, nodes_[i].first, nodes_[i].size);
    else
      add_children(index, nodes_[i].right);
  }
}

/// Splits at the median of the middles, along the axis on which they spread most. Boxes come later.
std::uint32_t PieceTree::build_triangles(std::span<std::uint32_t> order, std::size_t done, std::size_t depth) {
  const std::uint32_t node = add_node(depth);
  if (order.size() <= most_triangles) {
    nodes_[node].first = static_cast<std::uint32_t>(done);
    nodes_[node].size = static_cast<std::uint32_t>(order.size());
    return node;
  }
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const std::uint32_t i : order) {
    low = low.cwiseMin(middle(triangles_[i]));
    high = high.cwiseMax(middle(triangles_[i]));
  }
  Eigen::Index axis;
  (high - low).maxCoeff(&axis);
  const std::size_t half = order.size() / 2;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(half), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double x = middle(triangles_[a])[axis], y = middle(triangles_[b])[axis];
                     return x != y ? x < y : a < b;
                   });
  build_triangles(order.first(half), done, depth + 1);
  const std::uint32_t right = build_triangles(order.subspan(half), done + half, depth + 1);
  nodes_[node].right = right;
  return node;
}

PieceTree::PieceTree(std::vector<std::array<std::int32_t, 3>> keys, double edge) : edge_(edge) {
  if (keys.empty()) throw InvalidArgument("a tree of pieces needs at least one cube");
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
  build_cubes(codes, 0, 1);
}

/// Splits where the codes' highest differing bit changes: the halves of an octree's cell along one axis.
std::uint32_t PieceTree::build_cubes(std::span<const std::uint64_t> codes, std::size_t done, std::size_t depth) {
  const std::uint32_t node = add_node(depth);
  if (codes.size() <= most_cubes) {
    add_leaf(node, done, codes.size());
    return node;
  }
  const std::uint64_t bit = std::bit_floor(codes.front() ^ codes.back());
  const std::uint64_t border = (codes.back() & ~(bit - 1));
  const auto half = static_cast<std::size_t>(std::lower_bound(codes.begin(), codes.end(), border) - codes.begin());
  build_cubes(codes.first(half), done, depth + 1);
  add_children(node, build_cubes(codes.subspan(half), done + half, depth + 1));
  return node;
}

namespace {

PieceTree tree_of_mesh(const coal::BVHModelBase& mesh) {
  std::vector<PieceTree::Triangle> triangles;
  triangles.reserve(mesh.num_tris);
  for (unsigned i = 0; i < mesh.num_tris; ++i) {
    const coal::Triangle& t = (*mesh.tri_indices)[i];
    triangles.push_back({(*mesh.vertices)[t[0]], (*mesh.vertices)[t[1]], (*mesh.vertices)[t[2]]});
  }
  return PieceTree(std::move(triangles));
}

/// Leaves may stand for many cubes of the finest level.
PieceTree tree_of_octree(const coal::OcTree& geometry) {
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
  return PieceTree(std::move(keys), geometry.getResolution());
}

}  // namespace

std::shared_ptr<const PieceTree> make_piece_tree(const coal::CollisionGeometry& geometry) {
  if (geometry.getObjectType() == coal::OT_GEOM) return nullptr;
  if (const auto* mesh = dynamic_cast<const coal::BVHModelBase*>(&geometry))
    return std::make_shared<const PieceTree>(tree_of_mesh(*mesh));
  if (const auto* octree = dynamic_cast<const coal::OcTree*>(&geometry))
    return std::make_shared<const PieceTree>(tree_of_octree(*octree));
  throw NotSupported("a geometry of Coal's type " + std::to_string(geometry.getNodeType()) +
                     " is neither a convex solid, a mesh nor an octree");
}

}  // namespace srmp
