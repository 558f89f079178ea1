// A robot in the lanes of a slice: where its parts are, and how they move. No include guard: once per kernel file.

#include "srmp/collision/batch/kernel.hpp"
#include "srmp/collision/batch/obstacle-inl.hpp"

namespace srmp::batch {
namespace {

/// The robot at kWidth samples of its joints, each in the middle of an interval within which it moves. What is placed
/// is in the scratch memory, and placed when first needed.
class RobotLanes {
 protected:
  SRMP_INLINE RobotLanes(const KernelModel& model, const KernelRequest& request, float* scratch, int first_lane)
      : m_(model), request_(request), lane_(first_lane) {
    frames_ = scratch;
    centers_ = frames_ + 12 * kWidth * m_.node_count;
    stages_ = centers_ + 3 * kWidth * m_.body_count;
    spheres_ = stages_ + 8 * kWidth * m_.stage_count;
    placed_ = spheres_ + 3 * kWidth * m_.coarse_count;
    moved_ = placed_ + kWidth * m_.body_count;
  }

  /// The scratch memory that is left.
  SRMP_INLINE float* beyond() const { return moved_ + kWidth * m_.body_count; }

  SRMP_INLINE V row(const float* rows, int i) const { return load(rows + i * kWidth); }
  SRMP_INLINE void set_row(float* rows, int i, V a) const { store(rows + i * kWidth, a); }

  void place_nodes() {
    for (int k = 0; k < 9; ++k) set_row(frames_, k, all(k % 4 == 0 ? 1.0f : 0.0f));
    for (int k = 9; k < 12; ++k) set_row(frames_, k, all(0.0f));
    for (int i = 1; i < m_.node_count; ++i) place_node(i);
  }

  SRMP_INLINE void place_node(int i) {
    const KernelNode& node = m_.nodes[i];
    const float* parent = frames_ + 12 * kWidth * node.parent;
    if (node.exchanges) {
      const float *along_x = parent + node.axis[0] * kWidth, *along_y = parent + node.axis[1] * kWidth,
                  *along_z = parent + node.axis[2] * kWidth;
      const V dx = all(node.direction[0]), dy = all(node.direction[1]), dz = all(node.direction[2]);
      turn_node(i, [&](int k) {
        return V3{mul(row(along_x, 3 * k), dx), mul(row(along_y, 3 * k), dy), mul(row(along_z, 3 * k), dz)};
      });
    } else {
      const float* r = node.rotation;
      turn_node(i, [&](int k) {
        const V px = row(parent, 3 * k), py = row(parent, 3 * k + 1), pz = row(parent, 3 * k + 2);
        return V3{sum(mul(px, all(r[0])), mul(py, all(r[3])), mul(pz, all(r[6]))),
                  sum(mul(px, all(r[1])), mul(py, all(r[4])), mul(pz, all(r[7]))),
                  sum(mul(px, all(r[2])), mul(py, all(r[5])), mul(pz, all(r[8])))};
      });
    }
  }

  /// `axes(k)`: row k of the frame's rotation at value 0.
  template <class Axes>
  SRMP_INLINE void turn_node(int i, Axes&& axes) {
    const KernelNode& node = m_.nodes[i];
    const float* parent = frames_ + 12 * kWidth * node.parent;
    float* frame = frames_ + 12 * kWidth * i;
    const V value = load(request_.values + node.actuated_joint * kLanes + lane_);
    const V tx = all(node.translation[0]), ty = all(node.translation[1]), tz = all(node.translation[2]);
    SinCos angle{all(0.0f), all(1.0f)};
    if (!node.prismatic) angle = sincos(value);
    for (int k = 0; k < 3; ++k) {
      const auto [x, y, z] = axes(k);
      const V offset =
          sum(mul(row(parent, 3 * k), tx), mul(row(parent, 3 * k + 1), ty), mul(row(parent, 3 * k + 2), tz));
      V p = add(offset, row(parent, 9 + k));
      if (node.prismatic) p = add(p, mul(z, value));
      set_row(frame, 3 * k, add(mul(x, angle.cos), mul(y, angle.sin)));
      set_row(frame, 3 * k + 1, sub(mul(y, angle.cos), mul(x, angle.sin)));
      set_row(frame, 3 * k + 2, z);
      set_row(frame, 9 + k, p);
    }
  }

  SRMP_INLINE V3 transform(int node, float x, float y, float z) const {
    const float* f = frames_ + 12 * kWidth * node;
    const V vx = all(x), vy = all(y), vz = all(z);
    return {add(sum(mul(row(f, 0), vx), mul(row(f, 1), vy), mul(row(f, 2), vz)), row(f, 9)),
            add(sum(mul(row(f, 3), vx), mul(row(f, 4), vy), mul(row(f, 5), vz)), row(f, 10)),
            add(sum(mul(row(f, 6), vx), mul(row(f, 7), vy), mul(row(f, 8), vz)), row(f, 11))};
  }

  /// How far any body can move, at most, while every actuated joint stays within its half width. It suffices for bodies
  /// that are far from everything, and is not below what move_body computes, operation by operation.
  SRMP_INLINE void bound_motion() {
    V moved = all(0.0f);
    if (request_.half_widths)
      for (int n = m_.node_count - 1; n > 0; --n) {
        const V width = abs(signed_width(n));
        moved = add(moved, m_.nodes[n].prismatic ? width : mul(width, add(all(m_.nodes[n].reach), moved)));
      }
    any_moved_ = moved;
  }

  /// Computes the centre of the body.
  SRMP_INLINE V3 place_body(int i) {
    const V3 c = around(m_.bodies[i]);
    set_row(centers_, 3 * i, c.x);
    set_row(centers_, 3 * i + 1, c.y);
    set_row(centers_, 3 * i + 2, c.z);
    placed_[i] = moved_[i] = 0.0f;
    return c;
  }

  SRMP_INLINE V3 center(int i) const {
    return {row(centers_, 3 * i), row(centers_, 3 * i + 1), row(centers_, 3 * i + 2)};
  }

  /// By how much the joint of a node changes from the middle of the interval to its end, at most, with its sign.
  SRMP_INLINE V signed_width(int node) const {
    return load(request_.half_widths + m_.nodes[node].actuated_joint * kLanes + lane_);
  }

  /// How a body moves: its point that is at x in the middle of the interval moves by no more than `reach`, and is
  /// within `bend` of a place x + s (velocity + turn x (x - center)), |s| <= 1.
  struct Motion {
    V3 velocity, turn;
    V reach, bend;
  };

  SRMP_INLINE Motion motion(int stage) const {
    const float* m = stages_ + 8 * kWidth * stage;
    return {{row(m, 0), row(m, 1), row(m, 2)}, {row(m, 3), row(m, 4), row(m, 5)}, row(m, 6), row(m, 7)};
  }
  SRMP_INLINE void set_motion(int stage, const Motion& motion) const {
    float* m = stages_ + 8 * kWidth * stage;
    set_row(m, 0, motion.velocity.x), set_row(m, 1, motion.velocity.y), set_row(m, 2, motion.velocity.z);
    set_row(m, 3, motion.turn.x), set_row(m, 4, motion.turn.y), set_row(m, 5, motion.turn.z);
    set_row(m, 6, motion.reach), set_row(m, 7, motion.bend);
  }
  /// That of a body relative to the base.
  SRMP_INLINE Motion motion(const KernelBody& body) const { return motion(body.first_stage + body.depth - 1); }
  /// Of a point of a body, at x.
  SRMP_INLINE V3 velocity_of(int body, const Motion& m, const V3& x) const {
    return m.velocity + cross(m.turn, x - center(body));
  }

  /// Computes, when first needed, how the body moves relative to each node below it: joints from the distal to the
  /// proximal, each turning what it carries, which may have moved already. The acceleration of a point is at most the
  /// sum of w_i (w_i l_i + 2 sum of w_j l_j, joints j beyond i) over the joints i, which turn by w at distances l.
  __attribute__((noinline)) void move_body(int i) {
    if (moved_[i] != 0.0f) return;
    moved_[i] = 1.0f;
    const KernelBody& body = m_.bodies[i];
    const V3 c = center(i);
    const V zero = all(0.0f);
    Motion m{{zero, zero, zero}, {zero, zero, zero}, zero, zero};
    int stage = body.first_stage;
    for (int n = body.node; n != 0; n = m_.nodes[n].parent) {
      set_motion(stage++, m);
      if (!request_.half_widths) continue;
      const V signed_by = signed_width(n), width = abs(signed_by);
      const float* f = frames_ + 12 * kWidth * n;
      const V3 axis{row(f, 2), row(f, 5), row(f, 8)}, step = axis * signed_by;
      if (m_.nodes[n].prismatic) {
        m.velocity = m.velocity + step;
        m.reach = add(m.reach, width);
        m.bend = add(m.bend, mul(width, all(1e-5f)));
        continue;
      }
      const V3 by_turn = cross(axis, c - V3{row(f, 9), row(f, 10), row(f, 11)});
      const V lever = add(norm(by_turn), all(body.reach_radius));
      const V further = mul(width, add(lever, m.reach));
      m.velocity = m.velocity + by_turn * signed_by;
      m.turn = m.turn + step;
      m.bend =
          sum(m.bend, mul(width, sum(mul(all(0.5f), further), m.reach, all(body.rounding))), mul(further, all(1e-5f)));
      m.reach = add(m.reach, further);
    }
    set_motion(stage, m);
  }

  /// A direction in a node's frame.
  SRMP_INLINE V3 turned_to_node(int node, const V3& direction) const {
    const float* f = frames_ + 12 * kWidth * node;
    const auto along = [&](int axis) {
      return sum(mul(row(f, axis), direction.x), mul(row(f, axis + 3), direction.y),
                 mul(row(f, axis + 6), direction.z));
    };
    return {along(0), along(1), along(2)};
  }

  /// At both ends of an interval.
  struct Ends {
    V start, end;
  };

  /// How far along a direction anything within a sphere's children is from the sphere's centre, at least, but for what
  /// the body's `bend` holds.
  SRMP_INLINE Ends min_along(const V3& direction, int body, const Motion& m, const KernelSphere& sphere) const {
    if (sphere.children == 0) return {all(-sphere.radius), all(-sphere.radius)};
    const int node = m_.bodies[body].node;
    const V3 along = turned_to_node(node, direction), change = turned_to_node(node, cross(direction, m.turn));
    Ends lowest{all(1e30f), all(1e30f)};
    for (int k = sphere.first_child; k < sphere.first_child + sphere.children; ++k) {
      const KernelChild& child = m_.children[k];
      const V3 from{all(child.x), all(child.y), all(child.z)};
      const V at = sub(dot(along, from), all(child.radius)), by = dot(change, from);
      lowest = {min(lowest.start, sub(at, by)), min(lowest.end, add(at, by))};
    }
    return lowest;
  }

  SRMP_INLINE V3 coarse(int b) const {
    return {row(spheres_, 3 * b), row(spheres_, 3 * b + 1), row(spheres_, 3 * b + 2)};
  }

  SRMP_INLINE V3 fine(const KernelBody& body, const KernelSphere& sphere) const {
    return transform(body.node, sphere.x, sphere.y, sphere.z);
  }

  /// The centre of the sphere around a body.
  SRMP_INLINE V3 around(const KernelBody& body) const { return transform(body.node, body.x, body.y, body.z); }

  /// Places the coarse spheres of a body when first needed.
  SRMP_INLINE void place_spheres(int i) {
    if (placed_[i] != 0.0f) return;
    placed_[i] = 1.0f;
    const KernelBody& body = m_.bodies[i];
    for (int b = body.first_sphere; b < body.first_sphere + body.spheres; ++b) {
      const V3 c = fine(body, m_.spheres[b]);
      set_row(spheres_, 3 * b, c.x);
      set_row(spheres_, 3 * b + 1, c.y);
      set_row(spheres_, 3 * b + 2, c.z);
    }
  }

  const KernelModel& m_;
  const KernelRequest& request_;
  const int lane_;
  V any_moved_;  // an upper bound of how far a body can move

 private:
  // In rows of kWidth, placed_ and moved_ as well, so that what is beyond is aligned.
  float *frames_, *centers_, *stages_, *spheres_, *placed_, *moved_;
};

}  // namespace
}  // namespace srmp::batch
