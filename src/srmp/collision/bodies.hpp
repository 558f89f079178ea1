#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "srmp/collision/body.hpp"
#include "srmp/collision/broad_phase.hpp"
#include "srmp/collision/checker.hpp"
#include "srmp/collision/narrow_phase.hpp"
#include "srmp/collision/pair_table.hpp"
#include "srmp/collision/robot_group.hpp"

// What a SceneChecker keeps of a scene: bodies, and the pairs of them whose contact is a collision. All poses are in
// the base frame of the first robot of a group, which is the planned one. The others move too, but only their contact
// with the first one counts.
namespace srmp::detail {

/// Two bodies that move relative to each other and may not touch.
struct Pair {
  std::uint32_t a{};  // moving body
  std::uint32_t b{};  // moving or fixed body
  bool b_fixed{};
  bool solid{};              // both bodies are convex solids
  bool both_meshes{};        // neither is: both are many primitives
  int formula{-1};           // for the distance of their solids
  const PairTable* table{};  // null: none; its joints are counted from first_joint
  std::size_t first_joint{};
  double padding{};
  std::uint64_t support_a{}, support_b{};  // actuated joints between the body and the nearest common frame

  /// Those on which the relative pose of the two depends.
  std::uint64_t support() const { return support_a | support_b; }
  /// The sum of what `of` says of both bodies, each with its joints; fixed bodies do not count.
  template <class Of>
  double sum(Of&& of) const {
    return b_fixed ? of(a, support_a) : of(a, support_a) + of(b, support_b);
  }
  /// Does it depend on some, and on these alone?
  bool depends_only_on(std::uint64_t joints) const { return support() != 0 && (support() & ~joints) == 0; }
  /// Does its table, which there is, prove the two apart between `from` and `to` of the straight motion by `delta`?
  /// Angles may have any value.
  bool is_free_by_table(const Eigen::VectorXd& start, const Eigen::VectorXd& delta, double from, double to) const;
};

/// Two bodies that never move relative to each other, and overlap.
struct RigidOverlap {
  bool a_fixed{}, b_fixed{};
  std::uint32_t a{}, b{};
};

struct PairSide;

/// What a scene's change did to Bodies::fixed.
struct FixedChanges {
  static constexpr int changed = -1;
  std::vector<int> before;  // of each body, its number before, or `changed`: it is new, replaced or moved
  bool same_pairs{};        // are pairs those of the same bodies as before?
};

struct Bodies {
  /// `tables`: by robot of the group, may be null; they must outlive this.
  Bodies(const Scene& scene, const RobotGroup& group, const CheckerOptions& options,
         std::vector<const PairTables*> tables);

  /// Objects of these names that no robot holds were added to `scene`, removed, replaced or moved since, and nothing
  /// else has changed but where the joints of the group stand: all that depends on them is as if made anew. Returns
  /// what became of `fixed`, if any of it is here.
  std::optional<FixedChanges> follow_objects(const Scene& scene, const std::set<std::string>& names);

  /// Is this robot, which is not in the group, left out with all that it holds?
  bool leaves_out(const std::string& robot) const;
  /// CheckerOptions::clearance, which the padding of each pair holds; that of bodies does not.
  double clearance() const { return options_.clearance; }
  /// Body `index` of `fixed`, or of `moving`.
  const Body& body(bool is_fixed, std::size_t index) const {
    if (is_fixed) return fixed[index];
    return moving[index];
  }
  /// Body `index` of `moving`, or the envelope that is numbered after those.
  const MovingBody& moving_body(std::size_t index) const {
    return index < moving.size() ? moving[index] : envelopes[index - moving.size()];
  }

  std::vector<MovingBody> moving;
  std::vector<FixedBody> fixed;
  /// Spheres around all moving bodies that the same joints move, which stand still relative to each other. They have no
  /// geometry, and are numbered after those of `moving`.
  std::vector<MovingBody> envelopes;
  std::vector<std::uint32_t> envelope_of;  // by moving body; itself where it is alone
  /// By moving body: the centre of its bounding sphere, from that of its envelope's, in the frame of that one's pose.
  std::vector<Eigen::Vector3d> in_envelope;
  std::vector<Pair> pairs;
  std::vector<Pair> apart;                  // pairs whose tables prove that they never collide; not in `pairs`
  std::vector<std::int32_t> fixed_pair;     // [moving * fixed.size() + fixed] → pair, or -1
  std::vector<std::uint32_t> moving_pairs;  // pairs of two moving bodies
  std::vector<RigidOverlap> overlaps;
  /// Fixed bodies of the planned robot, and others that they may not touch; those too that overlap, because objects of
  /// a pair can move.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> fixed_pairs;
  BoxBvh tree;                 // over the boxes around fixed
  double max_fixed_padding{};  // with the clearance
  FormulaTable formulas;
  /// Pairs of links of one robot, "a and b", that need not keep the clearance, only not touch: those that are closer in
  /// at least half of 32 configurations spread over the joints' ranges, because of how the robot is built.
  std::vector<std::string> close_links;

 private:
  void exempt_close_links();
  bool are_closer(const Pair& pair, const RobotGroup::Data& data, double distance, NarrowPhase& narrow) const;
  void add_links(int robot);
  void add_objects(const Scene& scene);
  void add_other_robots(const Scene& scene);
  void add_fixed(Body body, const Eigen::Isometry3d& pose);
  FixedBody free_object(const Object& object) const;
  Eigen::Isometry3d in_base(const Pose& pose) const;
  void build_tree();
  void add_envelopes();
  MovingBody envelope_around(std::span<const std::uint32_t> bodies);
  void add_pairs(const Scene& scene);
  Pair pair_of(const PairSide& a, std::size_t ia, const PairSide& b, bool b_fixed, std::size_t ib);
  void add(const Pair& pair);
  void number_pairs();
  void add_rigid_pair(bool a_fixed, std::size_t ia, bool b_fixed, std::size_t ib);
  bool overlap(const RigidOverlap& pair) const;

  class Following;

  const PairTable* table_of(std::size_t robot, std::size_t geometry_a, std::size_t geometry_b) const;

  const RobotGroup& group_;
  CheckerOptions options_;
  std::vector<const PairTables*> tables_;
  RobotGroup::Data data_;  // with the planned joints at 0: nothing here depends on where they stand
  // Those of `formulas` that are of bodies that are gone or changed.
  std::vector<std::shared_ptr<const coal::CollisionGeometry>> examples_;
};

/// The pose of a moving body at the configuration in `data`.
inline Eigen::Isometry3d pose_of(const MovingBody& body, const RobotGroup& group, const RobotGroup::Data& data) {
  const auto robot = static_cast<std::size_t>(body.robot);
  return body.attached() ? group.link_pose(data, robot, body.source) * body.in_link
                         : group.geometry_pose(data, robot, body.source);
}

}  // namespace srmp::detail
