// The kernel, included once per instruction set by kernel_*.cpp, which names the entry point SRMP_KERNEL. The result of
// a lane depends on this lane alone, so it does not depend on how many lanes an instruction set has.

#include "srmp/collision/batch/robot_lanes-inl.hpp"

namespace srmp::batch {
namespace {

/// Is a lane found that is not free, where one such lane decides the request?
SRMP_INLINE bool is_decided(const KernelRequest& request, const KernelResult& result) {
  return (result.colliding | (result.undecided & request.decisive)) != 0;
}

/// One slice of kWidth lanes of a block.
class Slice : RobotLanes {
 public:
  SRMP_INLINE Slice(const KernelModel& model, const KernelRequest& request, float* scratch, KernelResult& result,
                    int first_lane)
      : RobotLanes(model, request, scratch, first_lane),
        result_(result),
        proofs_only_(request.proofs_only ? all_lanes : 0),
        ends_((static_cast<unsigned>(request.decisive) >> first_lane) & all_lanes) {
    near_ = beyond();
    near_radii_ = near_ + 3 * kWidth * m_.max_children;
    near_lanes_ = near_radii_ + m_.max_children;
    self_near_ = near_lanes_ + m_.max_children;
  }

  void run() {
    place_nodes();
    bound_motion();
    for (int n = 0; n < request_.likely_count; ++n)
      if (hits_likely(request_.likely[n])) return;
    if (request_.only_likely) return;
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

  /// Those of the lanes in which a sphere of a body is not proved to stay away from an obstacle. Where that is convex,
  /// it is beyond the plane through its nearest point, and only the velocity towards that counts.
  SRMP_INLINE unsigned comes_near(const KernelObstacle& o, int i, const V3& x, float radius, unsigned lanes) const {
    const Motion m = motion(m_.bodies[i]);
    const V kept = all(radius + m_.bodies[i].padding + o.radius);
    lanes = near(o, x, add(m.reach, kept), lanes);
    if (lanes == 0 || o.field.squared || !request_.half_widths) return lanes;
    return approaches(from_nearest(o, x), turned(o, velocity_of(i, m, x)), add(m.bend, kept), lanes);
  }

  /// Lanes in which two things have gaps larger than the limit, measured along the line through two points at a
  /// distance.
  SRMP_INLINE unsigned clear(V distance, const Ends& gaps, V limit) const {
    return bits(less(limit, gaps.start)) & bits(less(limit, gaps.end)) & bits(less(all(1e-6f), distance));
  }

  /// Those lanes in which the plane through the point of a convex obstacle that is nearest to the centre of a sphere,
  /// at x, keeps the sphere's children away.
  SRMP_INLINE unsigned keeps_away(const KernelObstacle& o, int i, const KernelSphere& sphere, const V3& x) const {
    const V3 away = from_nearest(o, x);
    const V distance = norm(away);
    const V3 direction = turned_back(o, away * quotient(all(1.0f), distance));
    const Motion m = motion(m_.bodies[i]);
    const V nearer = dot(direction, velocity_of(i, m, x));
    const Ends ends = min_along(direction, i, m, sphere);
    return clear(distance, {add(sub(distance, nearer), ends.start), add(add(distance, nearer), ends.end)},
                 add(m.bend, all(m_.bodies[i].padding + o.radius)));
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

  /// The box leaves out only what the lanes would leave out one by one: what is nearer than the farthest that anything
  /// moves is left to them.
  void check_obstacles(int i, const V3& c) {
    const KernelBody& body = m_.bodies[i];
    if (body.pairs == 0) return;
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
    const unsigned pending = comes_near(o, i, c, body.radius, alive_);
    if (pending == 0) return false;
    check_closely(i, o, pair, pending);
    return done();
  }

  /// Do they hit in some lanes? The bodies are not placed yet.
  __attribute__((noinline)) bool hits_likely(const KernelHit& likely) {
    current_ = likely.of;
    if (!is_open(current_.pair)) return false;
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
    const V3 around_b = center(pair.b);
    for (int i = a.first_inner; i < a.first_inner + a.inners; ++i) {
      const V3 ci = fine(a, m_.spheres[i]);
      const unsigned around = mask & within(between(ci, around_b), all(m_.spheres[i].radius + b.radius + pair.kept));
      if (around == 0) continue;
      for (int j = b.first_inner; j < b.first_inner + b.inners; ++j)
        if (hits_body(pair, i, j, between(ci, fine(b, m_.spheres[j])), around)) return true;
    }
    return false;
  }

  __attribute__((noinline)) void check_closely(int i, const KernelObstacle& o, int pair, unsigned pending) {
    const KernelBody& body = m_.bodies[i];
    current_ = {pair, i};
    place_spheres(i);
    unsigned undecided = 0;
    for (int b = body.first_sphere; b < body.first_sphere + body.spheres; ++b) {
      const KernelSphere& sphere = m_.spheres[b];
      unsigned around = comes_near(o, i, coarse(b), sphere.radius, body.exact ? pending : pending & ~undecided);
      if (around == 0) continue;
      if (body.exact && o.exact && hits_obstacle(o, body, b, coarse(b), around)) return;
      if (sphere.children == 0) {
        undecided |= around;
        continue;
      }
      if (!o.field.squared) around &= ~keeps_away(o, i, sphere, coarse(b));
      for (int k = 0; k < sphere.children && (around & ~undecided); ++k) {
        const KernelSphere& child = m_.spheres[m_.children[sphere.first_child + k].sphere];
        undecided |= comes_near(o, i, fine(body, child), child.radius, around & ~undecided);
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
    if (!(radius > 0.0f)) return false;
    mask &= bits(less(squared, all(radius * radius)));
    if (mask != 0 && m_.bodies[pair.b].capacity != 0.0f) mask = stick_out(pair.a, a, pair.b, b, pair.error, mask);
    if (mask != 0 && m_.bodies[pair.a].capacity != 0.0f) mask = stick_out(pair.b, b, pair.a, a, pair.error, mask);
    return hit(mask, a, b);
  }

  /// Those of the lanes in which the cluster of a body's inner sphere sticks out of the convex hull of another body's
  /// coarse spheres, in a direction from a sphere inside that one. Where clusters of two bodies overlap, and each
  /// sticks out of the other's hull, their surfaces intersect: otherwise the outer boundary of what one encloses, which
  /// is connected and which the other's cluster crosses, would be inside the other, and so within its hull. A solid
  /// body collides with what is inside it too: then only its own cluster has to stick out. A gap below the padding
  /// counts.
  __attribute__((noinline)) unsigned stick_out(int body, int sphere, int other, int from_inner, float error,
                                               unsigned lanes) const {
    const KernelBody &of = m_.bodies[body], &beside = m_.bodies[other];
    const V3 from = fine(beside, m_.spheres[from_inner]);
    unsigned out = 0;
    for (int k = of.first_inner; k < of.first_inner + of.inners && out != lanes; ++k) {
      if (m_.spheres[k].cluster != m_.spheres[sphere].cluster) continue;
      const V3 away = fine(of, m_.spheres[k]) - from;
      const V distance = norm(away), reach = add(distance, all(m_.spheres[k].radius));
      unsigned left = lanes & ~out & bits(less(all(1e-6f), distance));
      for (int b = beside.first_sphere; b < beside.first_sphere + beside.spheres && left != 0; ++b) {
        const KernelSphere& around = m_.spheres[b];
        const V free = sub(reach, all(around.radius + error));
        left &= bits(less(dot(away, fine(beside, around) - from), mul(free, distance)));
      }
      out |= left;
    }
    return out;
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

  static SRMP_INLINE V between(const V3& a, const V3& b) { return squared_norm(a - b); }

  /// Two bodies that move relative to each other: from where their last common node is.
  struct TwoBodies {
    int a, b;
    Motion motion_a, motion_b;
    V reach, bend;   // of both, with what is kept clear between them
    float touching;  // the largest gap between two spheres, less float error, that is no gap
  };

  /// Those of the lanes in which a sphere of a and one of b are not proved to stay apart.
  SRMP_INLINE unsigned come_near(const TwoBodies& two, const V3& xa, const V3& xb, float radii, unsigned lanes) const {
    const V3 away = xa - xb;
    lanes &= within(squared_norm(away), add(two.reach, all(radii)));
    if (lanes == 0 || !request_.half_widths) return lanes;
    const V3 velocity = velocity_of(two.a, two.motion_a, xa) - velocity_of(two.b, two.motion_b, xb);
    return within(squared_norm(nearest_to_zero(away, velocity)), add(two.bend, all(radii))) & lanes;
  }

  /// Those of the lanes in which a sphere of a and one of b surely overlap.
  SRMP_INLINE unsigned overlap(const TwoBodies& two, const V3& xa, const V3& xb, float radii, unsigned lanes) const {
    const float distance = radii + two.touching;
    if (lanes == 0 || !(distance > 0.0f)) return 0;
    return lanes & bits(less(between(xa, xb), all(distance * distance)));
  }

  void check_self() {
    for (int k = m_.self_pair_count - 1; k >= 0; --k) {  // the farther from the base, the likelier a hit
      if (!is_open(m_.pair_count + k)) continue;
      const KernelSelfPair& pair = m_.self_pairs[k];
      const V kept = all(pair.kept);
      const V3 ca = center(pair.a), cb = center(pair.b);
      if ((within(between(ca, cb), sum(any_moved_, kept, all(pair.radii))) & alive_) == 0) continue;
      move_body(pair.a);
      move_body(pair.b);
      const Motion of_a = motion(pair.stage_a), of_b = motion(pair.stage_b);
      const TwoBodies two{pair.a,
                          pair.b,
                          of_a,
                          of_b,
                          sum(of_a.reach, of_b.reach, kept),
                          sum(of_a.bend, of_b.bend, kept),
                          pair.padding - pair.error};
      const unsigned pending = come_near(two, ca, cb, pair.radii, alive_);
      if (pending == 0) continue;
      check_self_closely(k, pair, pending, two);
      if (done()) return;
    }
  }

  __attribute__((noinline)) void check_self_closely(int k, const KernelSelfPair& pair, unsigned pending,
                                                    const TwoBodies& two) {
    const KernelBody &a = m_.bodies[pair.a], &b = m_.bodies[pair.b];
    current_ = {m_.pair_count + k, -1};
    place_spheres(pair.b);
    const V3 ca = center(pair.a), cb = center(pair.b);
    int count = 0;  // spheres of b near the one around a
    for (int j = b.first_sphere; j < b.first_sphere + b.spheres; ++j) {
      const unsigned lanes = come_near(two, ca, coarse(j), m_.spheres[j].radius + a.radius, pending);
      if (lanes == 0) continue;
      self_near_[2 * count] = static_cast<float>(j);
      self_near_[2 * count++ + 1] = static_cast<float>(lanes);
    }
    if (count == 0) return;
    place_spheres(pair.a);
    unsigned undecided = 0;
    for (int i = a.first_sphere; i < a.first_sphere + a.spheres && !(undecided & ends_); ++i) {
      const V3 ci = coarse(i);
      const float ri = m_.spheres[i].radius;
      const unsigned around = come_near(two, ci, cb, ri + b.radius, pending & ~undecided);
      if (around == 0) continue;
      for (int n = 0; n < count; ++n) {
        const unsigned both = around & static_cast<unsigned>(self_near_[2 * n + 1]) & ~undecided;
        if (both == 0) continue;
        const int j = static_cast<int>(self_near_[2 * n]);
        const V3 cj = coarse(j);
        const unsigned near = come_near(two, ci, cj, ri + m_.spheres[j].radius, both);
        if (near == 0) continue;
        if (pair.exact && a.exact && b.exact && hits_body(pair, i, j, between(ci, cj), near)) return;
        const Near found = finer(two, m_.spheres[i], ci, m_.spheres[j], cj, near);
        undecided |= found.undecided;
        if (found.overlapping == 0) continue;
        // Spheres may reach beyond those around them: where all overlap, nothing could prove those lanes free.
        unsigned all_overlap = overlap(two, ci, cj, ri + m_.spheres[j].radius, found.overlapping);
        all_overlap = overlap(two, ci, cb, ri + b.radius, all_overlap);
        all_overlap = overlap(two, ca, cj, m_.spheres[j].radius + a.radius, all_overlap);
        if (hit(overlap(two, ca, cb, pair.radii, all_overlap), i, j)) return;
      }
    }
    if (undecided == 0) return;
    if (const unsigned open = undecided & ~proofs_only_; open && pair.exact && inside_hits(pair, open)) return;
    report(undecided);
  }

  /// Children of a coarse sphere that are near another body's coarse sphere, found one by one as needed. Each is placed
  /// once, however many spheres of the other body it is compared with.
  class NearChildren {
   public:
    SRMP_INLINE NearChildren(const Slice& slice, const TwoBodies& two, const KernelSphere& parent, const V3& other,
                             float radius, unsigned near)
        : slice_(slice), two_(two), parent_(parent), other_(other), radius_(radius), near_(near) {}

    /// Is there one more, at `index`?
    SRMP_INLINE bool has(int index) {
      for (; index == found_ && next_ < parent_.children; ++next_) {
        const KernelSphere& child = slice_.m_.spheres[slice_.m_.children[parent_.first_child + next_].sphere];
        const V3 c = slice_.fine(slice_.m_.bodies[two_.b], child);
        const unsigned lanes = slice_.come_near(two_, other_, c, radius_ + child.radius, near_);
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
    const TwoBodies& two_;
    const KernelSphere& parent_;
    const V3 other_;
    const float radius_;
    const unsigned near_;
    int next_{}, found_{};
  };

  /// Those of the lanes in which a plane between two coarse spheres, perpendicular to the line through their centres,
  /// separates their children.
  SRMP_INLINE unsigned separated(const TwoBodies& two, const KernelSphere& sphere_a, const V3& xa,
                                 const KernelSphere& sphere_b, const V3& xb) const {
    const V3 away = xa - xb;
    const V distance = norm(away), inverse = quotient(all(1.0f), distance);
    const V3 direction = away * inverse, back = xb - xa;
    const V nearer = dot(direction, velocity_of(two.a, two.motion_a, xa) - velocity_of(two.b, two.motion_b, xb));
    const Ends a = min_along(direction, two.a, two.motion_a, sphere_a);
    const Ends b = min_along(back * inverse, two.b, two.motion_b, sphere_b);
    return clear(distance, {sum(sub(distance, nearer), a.start, b.start), sum(add(distance, nearer), a.end, b.end)},
                 two.bend);
  }

  struct Near {
    unsigned undecided{};    // lanes that are not proved free
    unsigned overlapping{};  // of those, where only proofs matter: some in which spheres surely overlap
  };

  /// Two coarse spheres are near: their children, or the sphere itself where there is none.
  Near finer(const TwoBodies& two, const KernelSphere& sphere_a, const V3& ca, const KernelSphere& sphere_b,
             const V3& cb, unsigned near) const {
    Near found;
    const auto note = [&](const V3& xa, float ra, const V3& xb, float rb, unsigned lanes) {
      found.undecided |= lanes;
      lanes = overlap(two, xa, xb, ra + rb, lanes & proofs_only_);
      lanes = overlap(two, xa, cb, ra + sphere_b.radius, lanes);
      found.overlapping |= overlap(two, ca, xb, sphere_a.radius + rb, lanes);
    };
    if (sphere_a.children == 0 && sphere_b.children == 0) {
      note(ca, sphere_a.radius, cb, sphere_b.radius, near);
      return found;
    }
    near &= ~separated(two, sphere_a, ca, sphere_b, cb);
    if (near == 0) return found;
    NearChildren of_b(*this, two, sphere_b, ca, sphere_a.radius, near);
    if (sphere_a.children == 0) {
      for (int j = 0; (near & ~found.undecided) && of_b.has(j); ++j)
        note(ca, sphere_a.radius, of_b.center(j), of_b.radius(j), of_b.lanes(j) & ~found.undecided);
      return found;
    }
    for (int i = 0; i < sphere_a.children && (near & ~found.undecided); ++i) {
      const KernelSphere& fine_a = m_.spheres[m_.children[sphere_a.first_child + i].sphere];
      const V3 ci = fine(m_.bodies[two.a], fine_a);
      const unsigned left = come_near(two, ci, cb, fine_a.radius + sphere_b.radius, near & ~found.undecided);
      if (left == 0) continue;
      if (sphere_b.children == 0) {
        note(ci, fine_a.radius, cb, sphere_b.radius, left);
        continue;
      }
      for (int j = 0; (left & ~found.undecided) && of_b.has(j); ++j)
        if (const unsigned both = of_b.lanes(j) & left & ~found.undecided) {
          const float radii = fine_a.radius + of_b.radius(j);
          note(ci, fine_a.radius, of_b.center(j), of_b.radius(j), come_near(two, ci, of_b.center(j), radii, both));
        }
    }
    return found;
  }

  KernelResult& result_;
  const unsigned proofs_only_, ends_;  // of this slice
  unsigned alive_{all_lanes};          // lanes that are not decided yet
  KernelPair current_{};               // what is being checked
  float *near_, *near_radii_, *near_lanes_, *self_near_;
};

}  // namespace

void SRMP_KERNEL(const KernelModel& model, const KernelRequest& request, float* scratch, KernelResult& result) {
  for (int lane = 0; lane < request.used; lane += kWidth) {
    Slice(model, request, scratch, result, lane).run();
    if (!request.every_lane && is_decided(request, result)) return;
  }
}

}  // namespace srmp::batch
