// The kernel, included once per instruction set by kernel_*.cpp, which names the entry point SRMP_KERNEL. The result of
// a lane depends on this lane alone, so it does not depend on how many lanes an instruction set has.

#include "srmp/collision/batch/kernel.hpp"
#include "srmp/collision/batch/simd-inl.hpp"

namespace srmp::batch {
namespace {

struct V3 {
  V x, y, z;
};

/// Is a lane found that is not free, where one such lane decides the request?
SRMP_INLINE bool is_decided(const KernelRequest& request, const KernelResult& result) {
  return (result.colliding | (result.undecided & request.decisive)) != 0;
}

/// One slice of kWidth lanes of a block.
class Slice {
 public:
  SRMP_INLINE Slice(const KernelModel& model, const KernelRequest& request, float* scratch, KernelResult& result,
                    int first_lane)
      : m_(model),
        request_(request),
        result_(result),
        lane_(first_lane),
        proofs_only_(request.proofs_only ? all_lanes : 0),
        ends_((static_cast<unsigned>(request.decisive) >> first_lane) & all_lanes) {
    frames_ = scratch;
    centers_ = frames_ + 12 * kWidth * m_.node_count;
    stages_ = centers_ + 3 * kWidth * m_.body_count;
    margins_ = stages_ + kWidth * m_.stage_count;
    spheres_ = margins_ + kWidth * m_.body_count;
    near_ = spheres_ + 3 * kWidth * m_.coarse_count;
    near_radii_ = near_ + 3 * kWidth * m_.max_children;
    near_lanes_ = near_radii_ + m_.max_children;
    placed_ = near_lanes_ + m_.max_children;
    moved_ = placed_ + m_.body_count;
    self_near_ = moved_ + m_.body_count;
  }

  void run() {
    place_nodes();
    bound_motion();
    for (int n = 0; n < request_.likely_count; ++n)
      if (hits_likely(request_.likely[n])) return;
    for (int i = m_.body_count - 1; i >= 0; --i) {  // the farther from the base, the likelier a hit
      if (!is_open_body(i)) continue;
      check_obstacles(i, place_body(i));
      if (done()) return;
    }
    check_self();
  }

 private:
  static constexpr unsigned all_lanes = (1u << kWidth) - 1;

  SRMP_INLINE bool done() const { return alive_ == 0 || (!request_.every_lane && is_decided(request_, result_)); }

  SRMP_INLINE bool is_open(int pair) const { return !request_.open_pairs || request_.open_pairs[pair]; }
  SRMP_INLINE bool is_open_body(int body) const { return !request_.open_bodies || request_.open_bodies[body]; }

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
        const V width = load(request_.half_widths + m_.nodes[n].actuated_joint * kLanes + lane_);
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

  /// Computes, when first needed, how far the body can move: joints from the distal to the proximal, each turning what
  /// it carries, which may have moved already.
  __attribute__((noinline)) void move_body(int i) {
    if (moved_[i] != 0.0f) return;
    moved_[i] = 1.0f;
    const KernelBody& body = m_.bodies[i];
    const V3 c = center(i);
    V moved = all(0.0f);
    int stage = body.first_stage;
    for (int n = body.node; n != 0; n = m_.nodes[n].parent) {
      set_row(stages_, stage++, moved);
      if (!request_.half_widths) continue;
      const V width = load(request_.half_widths + m_.nodes[n].actuated_joint * kLanes + lane_);
      if (m_.nodes[n].prismatic) {
        moved = add(moved, width);
        continue;
      }
      const float* f = frames_ + 12 * kWidth * n;
      const V dx = sub(c.x, row(f, 9)), dy = sub(c.y, row(f, 10)), dz = sub(c.z, row(f, 11));
      const V ax = row(f, 2), ay = row(f, 5), az = row(f, 8);
      const V x = sub(mul(dy, az), mul(dz, ay)), y = sub(mul(dz, ax), mul(dx, az)), z = sub(mul(dx, ay), mul(dy, ax));
      const V lever = add(sqrt(sum(mul(x, x), mul(y, y), mul(z, z))), all(body.reach_radius));
      moved = add(moved, mul(width, add(lever, moved)));
    }
    set_row(stages_, stage, moved);
    set_row(margins_, i, moved);
  }

  SRMP_INLINE V3 local(const KernelObstacle& o, const V3& c) const {
    if (o.aligned) return {add(c.x, all(o.offset[0])), add(c.y, all(o.offset[1])), add(c.z, all(o.offset[2]))};
    const float* r = o.rotation;
    return {add(sum(mul(c.x, all(r[0])), mul(c.y, all(r[1])), mul(c.z, all(r[2]))), all(o.offset[0])),
            add(sum(mul(c.x, all(r[3])), mul(c.y, all(r[4])), mul(c.z, all(r[5]))), all(o.offset[1])),
            add(sum(mul(c.x, all(r[6])), mul(c.y, all(r[7])), mul(c.z, all(r[8]))), all(o.offset[2]))};
  }

  /// A place on a field's grid: coordinates in cells, clamped to the grid.
  struct GridPlace {
    V3 at;
    V squared_off;  // of the distance from there to the grid's box
  };
  SRMP_INLINE GridPlace grid_place(const KernelObstacle& o, const V3& c) const {
    const KernelField& f = o.field;
    const V3 p = local(o, c);
    const V x = mul(p.x, all(f.per_cell)), y = mul(p.y, all(f.per_cell)), z = mul(p.z, all(f.per_cell));
    const V3 at{min(max0(x), all(f.last[0])), min(max0(y), all(f.last[1])), min(max0(z), all(f.last[2]))};
    const V dx = mul(sub(x, at.x), all(f.cell)), dy = mul(sub(y, at.y), all(f.cell)),
            dz = mul(sub(z, at.z), all(f.cell));
    return {at, sum(mul(dx, dx), mul(dy, dy), mul(dz, dz))};
  }

  /// A lower bound, see DistanceField.
  __attribute__((noinline)) V squared_distance_to_field(const KernelField& f, const GridPlace& place) const {
    const V one = all(1.0f);
    const V x = truncate(min(place.at.x, all(f.last[0] - 1.0f))), y = truncate(min(place.at.y, all(f.last[1] - 1.0f))),
            z = truncate(min(place.at.z, all(f.last[2] - 1.0f)));
    const V tx = sub(place.at.x, x), ty = sub(place.at.y, y), tz = sub(place.at.z, z);
    const V low = sum(x, mul(y, all(f.row)), mul(z, all(f.layer)));  // whole numbers below 2^24: exact
    const auto along_x = [&](V index) {
      const V a = gather(f.squared, index), b = gather(f.squared, add(index, one));
      return add(a, mul(tx, sub(b, a)));
    };
    const auto along_y = [&](V index) {
      const V a = along_x(index), b = along_x(add(index, all(f.row)));
      return add(a, mul(ty, sub(b, a)));
    };
    const V a = along_y(low), b = along_y(add(low, all(f.layer)));
    const V bend = sum(mul(tx, sub(one, tx)), mul(ty, sub(one, ty)), mul(tz, sub(one, tz)));
    const V inside = sub(add(a, mul(tz, sub(b, a))), mul(all(f.cell * f.cell), bend));
    return add(max0(inside), place.squared_off);
  }

  /// Lanes surely nearer than the radius to what a field describes: an upper bound of the distance through the nearest
  /// grid point.
  SRMP_INLINE unsigned surely_within(const KernelObstacle& o, const V3& c, float radius) const {
    const KernelField& f = o.field;
    const GridPlace place = grid_place(o, c);
    const V x = round(place.at.x), y = round(place.at.y), z = round(place.at.z);
    const V squared = max0(gather(f.squared, sum(x, mul(y, all(f.row)), mul(z, all(f.layer)))));
    const V dx = sub(place.at.x, x), dy = sub(place.at.y, y), dz = sub(place.at.z, z);
    const V to_grid = mul(all(f.cell), sqrt(sum(mul(dx, dx), mul(dy, dy), mul(dz, dz))));
    const V distance = sum(sqrt(squared), to_grid, add(sqrt(place.squared_off), all(f.error)));
    return bits(less(distance, all(radius < f.reach ? radius : f.reach)));
  }

  /// Of an obstacle without a field.
  SRMP_INLINE V squared_distance(const KernelObstacle& o, const V3& c) const {
    auto [x, y, z] = local(o, c);
    z = max0(sub(abs(z), all(o.half[2])));
    if (o.cylinder) {
      const V side = max0(sub(sqrt(add(mul(x, x), mul(y, y))), all(o.half[0])));
      return add(mul(side, side), mul(z, z));
    }
    x = max0(sub(abs(x), all(o.half[0])));
    y = max0(sub(abs(y), all(o.half[1])));
    return sum(mul(x, x), mul(y, y), mul(z, z));
  }

  /// Lanes in which a distance is not proved to exceed the limit.
  SRMP_INLINE unsigned within(V squared, V limit) const { return bits(not_greater(squared, mul(limit, limit))); }

  /// Those of the lanes in which a point is not proved farther away than the limit.
  SRMP_INLINE unsigned near(const KernelObstacle& o, const V3& c, V limit, unsigned lanes) const {
    if (!o.field.squared) return within(squared_distance(o, c), limit) & lanes;
    const GridPlace place = grid_place(o, c);
    lanes &= within(place.squared_off, limit);
    return lanes == 0 ? 0 : within(squared_distance_to_field(o.field, place), limit) & lanes;
  }

  /// A box around something in all lanes, each number in every lane.
  struct Box {
    V3 low, high;
  };
  SRMP_INLINE Box box_around(const V3& c, V reach) const {
    return {{lowest(sub(c.x, reach)), lowest(sub(c.y, reach)), lowest(sub(c.z, reach))},
            {highest(add(c.x, reach)), highest(add(c.y, reach)), highest(add(c.z, reach))}};
  }

  /// Which of the next kWidth pairs of a body have an obstacle that is not apart from the box.
  SRMP_INLINE unsigned near_box(const Box& box, const float* obstacles) const {
    const auto apart = [&](int axis, V low, V high) {
      return either(less(high, load_any(obstacles + axis * kLanes)),
                    less(load_any(obstacles + (axis + 3) * kLanes), low));
    };
    return ~bits(either(either(apart(0, box.low.x, box.high.x), apart(1, box.low.y, box.high.y)),
                        apart(2, box.low.z, box.high.z))) &
           all_lanes;
  }

  void check_obstacles(int i, const V3& c) {
    const KernelBody& body = m_.bodies[i];
    const Box box = box_around(c, sum(any_moved_, all(body.padding), all(body.radius)));
    for (int k = 0; k < body.pairs; k += kWidth) {
      const float* obstacles = m_.pair_boxes + body.first_box + k / kLanes * (6 * kLanes) + k % kLanes;
      const int count = body.pairs - k;
      unsigned left = near_box(box, obstacles);
      if (count < kWidth) left &= (1u << count) - 1;  // an endless motion is not apart from where there is no pair
      for (; left != 0; left &= left - 1) {
        const int pair = body.first_pair + k + __builtin_ctz(left);
        if (is_open(pair) && check_obstacle(i, c, pair)) return;
      }
    }
  }

  /// True when that ends the run.
  SRMP_INLINE bool check_obstacle(int i, const V3& c, int pair) {
    const KernelBody& body = m_.bodies[i];
    const KernelObstacle& o = m_.obstacles[m_.pair_obstacles[pair]];
    move_body(i);
    const V margin = add(row(margins_, i), all(body.padding));
    const unsigned pending = near(o, c, sum(margin, all(body.radius), all(o.radius)), alive_);
    if (pending == 0) return false;
    check_closely(i, o, pair, pending, margin);
    return done();
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

  /// Do they hit in some lanes? The bodies are not placed yet.
  __attribute__((noinline)) bool hits_likely(const KernelHit& likely) {
    current_ = likely.of;
    if (current_.body >= 0) {
      const KernelObstacle& o = m_.obstacles[m_.pair_obstacles[current_.pair]];
      const KernelBody& body = m_.bodies[current_.body];
      return hits_obstacle(o, body, likely.sphere, fine(body, m_.spheres[likely.sphere]), alive_);
    }
    const KernelSelfPair& pair = m_.self_pairs[current_.pair - m_.pair_count];
    const V3 a = fine(m_.bodies[pair.a], m_.spheres[likely.sphere]),
             b = fine(m_.bodies[pair.b], m_.spheres[likely.other]);
    return hits_body(pair, likely.sphere, likely.other, between(a, b), alive_);
  }

  /// Does one of the spheres inside of a body surely hit the obstacle? True when that ends the run.
  SRMP_INLINE bool inside_hits(const KernelObstacle& o, const KernelBody& body, unsigned mask) {
    for (int b = body.first_inner; b < body.first_inner + body.inners; ++b)
      if (hits_obstacle(o, body, b, fine(body, m_.spheres[b]), mask)) return true;
    return false;
  }

  /// Does one of the spheres inside of a surely hit one inside of b? True when that ends the run.
  SRMP_INLINE bool inside_hits(const KernelSelfPair& pair, unsigned mask) {
    const KernelBody &a = m_.bodies[pair.a], &b = m_.bodies[pair.b];
    for (int i = a.first_inner; i < a.first_inner + a.inners; ++i) {
      const V3 ci = fine(a, m_.spheres[i]);
      for (int j = b.first_inner; j < b.first_inner + b.inners; ++j)
        if (hits_body(pair, i, j, between(ci, fine(b, m_.spheres[j])), mask)) return true;
    }
    return false;
  }

  __attribute__((noinline)) void check_closely(int i, const KernelObstacle& o, int pair, unsigned pending, V margin) {
    const KernelBody& body = m_.bodies[i];
    current_ = {pair, i};
    place_spheres(i);
    const V limit = add(margin, all(o.radius));
    unsigned undecided = 0;
    for (int b = body.first_sphere; b < body.first_sphere + body.spheres; ++b) {
      const KernelSphere& sphere = m_.spheres[b];
      const unsigned around =
          near(o, coarse(b), add(limit, all(sphere.radius)), body.exact ? pending : pending & ~undecided);
      if (around == 0) continue;
      if (body.exact && o.exact && hits_obstacle(o, body, b, coarse(b), around)) return;
      if (sphere.children == 0) {
        undecided |= around;
        continue;
      }
      for (int k = 0; k < sphere.children && (around & ~undecided); ++k) {
        const KernelSphere& child = m_.spheres[m_.children[sphere.first_child + k]];
        undecided |= near(o, fine(body, child), add(limit, all(child.radius)), around & ~undecided);
      }
    }
    if (undecided == 0) return;
    if (const unsigned open = undecided & ~proofs_only_; open && o.exact && o.size > body.capacity)
      if (inside_hits(o, body, open)) return;
    report(undecided);
  }

  /// Does a sphere of a body surely hit the obstacle in some lanes of `mask`? True when that ends the run.
  SRMP_INLINE bool hits_obstacle(const KernelObstacle& o, const KernelBody& body, int sphere, const V3& center,
                                 unsigned mask) {
    const float radius = m_.spheres[sphere].radius + body.padding + o.inner_radius;
    if (!(radius > 0.0f)) return false;
    const unsigned hits = o.field.squared ? surely_within(o, center, radius)
                                          : bits(less(squared_distance(o, center), all(radius * radius)));
    return hit(hits & mask, sphere, -1);
  }

  /// Do spheres of two bodies surely hit in some lanes of `mask`? True when that ends the run.
  SRMP_INLINE bool hits_body(const KernelSelfPair& pair, int a, int b, V squared, unsigned mask) {
    const float radius = m_.spheres[a].radius + m_.spheres[b].radius + pair.padding - pair.error;
    return radius > 0.0f && hit(bits(less(squared, all(radius * radius))) & mask, a, b);
  }

  SRMP_INLINE bool hit(unsigned hits, int sphere, int other) {
    hits &= alive_;
    if (hits == 0) return false;
    result_.colliding = static_cast<LaneMask>(result_.colliding | hits << lane_);
    result_.hit = {current_, sphere, other};
    alive_ &= ~hits;
    return done();
  }

  /// The current pair is undecided in these lanes.
  SRMP_INLINE void report(unsigned lanes) {
    lanes &= alive_;
    if (lanes == 0) return;
    const auto shifted = static_cast<LaneMask>(lanes << lane_);
    LaneMask& of_pair = result_.pair_lanes[current_.pair];
    if (of_pair == 0) result_.undecided_pairs[result_.undecided_count++] = current_;
    of_pair = static_cast<LaneMask>(of_pair | shifted);
    result_.undecided = static_cast<LaneMask>(result_.undecided | shifted);
    alive_ &= ~(lanes & proofs_only_);
  }

  static SRMP_INLINE V between(const V3& a, const V3& b) {
    const V x = sub(a.x, b.x), y = sub(a.y, b.y), z = sub(a.z, b.z);
    return sum(mul(x, x), mul(y, y), mul(z, z));
  }

  void check_self() {
    for (int k = 0; k < m_.self_pair_count; ++k) {
      if (!is_open(m_.pair_count + k)) continue;
      const KernelSelfPair& pair = m_.self_pairs[k];
      const KernelBody &a = m_.bodies[pair.a], &b = m_.bodies[pair.b];
      const V padding = all(pair.padding + pair.error), radii = all(a.radius + b.radius);
      const V squared = between(center(pair.a), center(pair.b));
      if ((within(squared, add(add(any_moved_, padding), radii)) & alive_) == 0) continue;
      move_body(pair.a);
      move_body(pair.b);
      const V limit = sum(row(stages_, pair.stage_a), row(stages_, pair.stage_b), padding);
      const unsigned pending = within(squared, add(limit, radii)) & alive_;
      if (pending == 0) continue;
      check_self_closely(k, pair, pending, limit);
      if (done()) return;
    }
  }

  __attribute__((noinline)) void check_self_closely(int k, const KernelSelfPair& pair, unsigned pending, V limit) {
    const KernelBody &a = m_.bodies[pair.a], &b = m_.bodies[pair.b];
    current_ = {m_.pair_count + k, -1};
    place_spheres(pair.a);
    place_spheres(pair.b);
    const V3 ca = center(pair.a), cb = center(pair.b);
    int count = 0;  // spheres of b near the one around a
    for (int j = b.first_sphere; j < b.first_sphere + b.spheres; ++j) {
      const unsigned lanes = within(between(ca, coarse(j)), add(limit, all(m_.spheres[j].radius + a.radius))) & pending;
      if (lanes == 0) continue;
      self_near_[2 * count] = static_cast<float>(j);
      self_near_[2 * count++ + 1] = static_cast<float>(lanes);
    }
    if (count == 0) return;
    unsigned undecided = 0;
    for (int i = a.first_sphere; i < a.first_sphere + a.spheres && !(undecided & ends_); ++i) {
      const V3 ci = coarse(i);
      const float ri = m_.spheres[i].radius;
      const unsigned around = within(between(ci, cb), add(limit, all(ri + b.radius))) & pending & ~undecided;
      if (around == 0) continue;
      for (int n = 0; n < count; ++n) {
        const unsigned both = around & static_cast<unsigned>(self_near_[2 * n + 1]);
        if (both == 0) continue;
        const int j = static_cast<int>(self_near_[2 * n]);
        const V squared = between(ci, coarse(j));
        const unsigned near = within(squared, add(limit, all(ri + m_.spheres[j].radius))) & both & ~undecided;
        if (near == 0) continue;
        if (pair.exact && a.exact && b.exact && hits_body(pair, i, j, squared, near)) return;
        undecided |= finer(a, m_.spheres[i], ci, b, m_.spheres[j], coarse(j), limit, near);
      }
    }
    if (undecided == 0) return;
    if (const unsigned open = undecided & ~proofs_only_;
        open && pair.exact && a.capacity == 0.0f && b.capacity == 0.0f && inside_hits(pair, open))
      return;
    report(undecided);
  }

  /// Children of a coarse sphere that are near another body's coarse sphere, found one by one as needed. Each is placed
  /// once, however many spheres of the other body it is compared with.
  class NearChildren {
   public:
    SRMP_INLINE NearChildren(const Slice& slice, const KernelBody& body, const KernelSphere& parent, const V3& other,
                             V reach, unsigned near)
        : slice_(slice), body_(body), parent_(parent), other_(other), reach_(reach), near_(near) {}

    /// Is there one more, at `index`?
    SRMP_INLINE bool has(int index) {
      for (; index == found_ && next_ < parent_.children; ++next_) {
        const KernelSphere& child = slice_.m_.spheres[slice_.m_.children[parent_.first_child + next_]];
        const V3 c = slice_.fine(body_, child);
        const unsigned lanes = slice_.within(between(other_, c), add(reach_, all(child.radius))) & near_;
        if (lanes == 0) continue;
        slice_.set_row(slice_.near_, 3 * found_, c.x);
        slice_.set_row(slice_.near_, 3 * found_ + 1, c.y);
        slice_.set_row(slice_.near_, 3 * found_ + 2, c.z);
        slice_.near_radii_[found_] = child.radius;
        slice_.near_lanes_[found_++] = static_cast<float>(lanes);  // small whole numbers: exact
      }
      return index < found_;
    }
    SRMP_INLINE V3 center(int i) const {
      return {slice_.row(slice_.near_, 3 * i), slice_.row(slice_.near_, 3 * i + 1),
              slice_.row(slice_.near_, 3 * i + 2)};
    }
    SRMP_INLINE float radius(int i) const { return slice_.near_radii_[i]; }
    SRMP_INLINE unsigned lanes(int i) const { return static_cast<unsigned>(slice_.near_lanes_[i]); }

   private:
    const Slice& slice_;
    const KernelBody& body_;
    const KernelSphere& parent_;
    const V3 other_;
    const V reach_;
    const unsigned near_;
    int next_{}, found_{};
  };

  /// Two coarse spheres are near: their children, or the sphere itself where there is none.
  unsigned finer(const KernelBody& a, const KernelSphere& sphere_a, const V3& ca, const KernelBody& b,
                 const KernelSphere& sphere_b, const V3& cb, V limit, unsigned near) const {
    if (sphere_a.children == 0 && sphere_b.children == 0) return near;
    NearChildren of_b(*this, b, sphere_b, ca, add(limit, all(sphere_a.radius)), near);
    unsigned undecided = 0;
    if (sphere_a.children == 0) {
      for (int j = 0; (near & ~undecided) && of_b.has(j); ++j) undecided |= of_b.lanes(j);
      return undecided;
    }
    for (int i = 0; i < sphere_a.children && (near & ~undecided); ++i) {
      const KernelSphere& fine_a = m_.spheres[m_.children[sphere_a.first_child + i]];
      const V3 ci = fine(a, fine_a);
      const V reach = add(limit, all(fine_a.radius));
      const unsigned left = within(between(ci, cb), add(reach, all(sphere_b.radius))) & near & ~undecided;
      if (left == 0) continue;
      if (sphere_b.children == 0) {
        undecided |= left;
        continue;
      }
      for (int j = 0; (left & ~undecided) && of_b.has(j); ++j)
        if (of_b.lanes(j) & left & ~undecided)
          undecided |= within(between(ci, of_b.center(j)), add(reach, all(of_b.radius(j)))) & of_b.lanes(j) & left;
    }
    return undecided;
  }

  const KernelModel& m_;
  const KernelRequest& request_;
  KernelResult& result_;
  const int lane_;
  const unsigned proofs_only_, ends_;  // of this slice
  unsigned alive_{all_lanes};          // lanes that are not decided yet
  KernelPair current_{};               // what is being checked
  V any_moved_;                        // an upper bound of how far a body can move
  float *frames_, *centers_, *stages_, *margins_, *spheres_, *near_, *near_radii_, *near_lanes_, *placed_, *moved_,
      *self_near_;
};

}  // namespace

void SRMP_KERNEL(const KernelModel& model, const KernelRequest& request, float* scratch, KernelResult& result) {
  for (int lane = 0; lane < request.used; lane += kWidth) {
    Slice(model, request, scratch, result, lane).run();
    if (!request.every_lane && is_decided(request, result)) return;
  }
}

}  // namespace srmp::batch
