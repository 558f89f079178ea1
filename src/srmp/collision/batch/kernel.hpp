#pragma once

// What the kernels see: plain data, no library types, so that translation units built for different instruction sets
// share no inline functions. Internal.

#include <cstdint>

namespace srmp::batch {

constexpr int kLanes = 16;  ///< configurations a block; processed as 1 x 16, 2 x 8 or 4 x 4 lanes with equal bits
using LaneMask = std::uint16_t;

/// An actuated joint; its frame is on the axis, z along it. Node 0 is the robot's base. Parents before children.
struct KernelNode {
  int parent;
  int actuated_joint;  // row of the values, -1 for the base
  int prismatic;
  float rotation[9];  // of the frame at value 0 in the parent's, row by row
  float translation[3];
  float reach;  // how far anything that the joint moves can be from its axis, with a body's reach_radius
  // Where the rotation only exchanges axes: the parent's axis that x, y and z are along, and in which direction.
  int exchanges;
  int axis[3];
  float direction[3];
};

struct KernelSphere {
  float x, y, z;  // in the node's frame
  float radius;
  int first_child, children;  // into Model::children; 0 children: nothing finer
  int cluster;                // inside: spheres of a body that overlap, directly or through others, are of one
};

/// A fine sphere, as part of a coarse one.
struct KernelChild {
  float x, y, z;  // from the coarse one's centre, in the node's frame
  float radius;
  int sphere;
};

/// A rigid part of the robot (a link, an attached object) covered by spheres: one around all, coarse ones, fine ones.
struct KernelBody {
  int node;
  int depth;        // nodes from this one up to the base, both counted
  int first_stage;  // of how it moves relative to each of them, from its own to the base, in the scratch memory
  float x, y, z;    // sphere around all, in the node's frame
  float radius;
  float reach_radius;         // of the core (0: a sphere), for motion bounds: float error included
  float rounding;             // float error of a point that turns by 1 rad
  float padding;              // kept clear of obstacles
  int first_sphere, spheres;  // coarse
  int first_inner, inners;    // spheres inside
  float capacity;             // nothing of a larger diameter can be inside without contact; 0 for solids
  int exact;                  // the coarse spheres are the body itself
  int first_pair, pairs;      // obstacles to check against, into Model::pair_obstacles
  int first_box;              // blocks of their boxes, into Model::pair_boxes
};

/// A DistanceField, in the kernel's numbers.
struct KernelField {
  const float* squared;  // null: none
  float row, layer;      // grid points along x; along x times those along y
  float last[3];         // of the grid's indices
  float cell, per_cell;  // edge of a cell, and 1 / edge
  float error, reach;
};

/// A rounded box (sphere and capsule: a box without extent), a cylinder along z, or anything with a distance field.
struct KernelObstacle {
  int cylinder;
  int aligned;         // rotation is the identity
  int exact;           // the shape is the object, not something around it
  float rotation[9];   // world to local, row by row
  float offset[3];     // local = rotation * world + offset; a field's grid starts at local 0
  float half[3];       // half extents; cylinder: radius, unused, half length
  float size;          // a lower bound of its diameter
  float radius;        // rounding, padding and float error, for proofs of "free"
  float inner_radius;  // rounding and padding less float error, for proofs of "hit"
  KernelField field;
};

struct KernelSelfPair {
  int a, b;
  int exact;
  int stage_a, stage_b;  // of how the two move relative to their last common node
  float padding;         // kept clear between the two
  float error;
  float kept, radii;  // padding and error, and the radii of both bodies' spheres, each added up
};

struct KernelModel {
  const KernelNode* nodes;
  int node_count;
  const KernelBody* bodies;
  int body_count;
  int stage_count;
  const KernelSphere* spheres;  // coarse, then fine, then inner
  int coarse_count;
  const KernelChild* children;
  int max_children;  // of a sphere
  const KernelObstacle* obstacles;
  const int* pair_obstacles;
  const float* pair_boxes;  // kLanes pairs of a body a block: lowest x, y, z of what is near, then the highest; a box
                            // apart from all of a body leaves nothing that is near
  int pair_count;           // body-obstacle pairs; self pairs are numbered after them
  const KernelSelfPair* self_pairs;
  int self_pair_count;
};

/// A body and an obstacle, or two bodies.
struct KernelPair {
  int pair;  // -1: none
  int body;  // the one with the obstacle; -1: two bodies
};

/// A sphere of a body inside an obstacle or another body's sphere.
struct KernelHit {
  KernelPair of;
  int sphere, other;  // of two bodies: one of a, one of b
};

struct KernelRequest {
  const float* values;       // [actuated joint][kLanes]: angle (|.| <= 2 pi) or travel
  const float* half_widths;  // [actuated joint][kLanes]: how far it may be from there, with the sign in which it moves,
                             // all at constant velocity; null: exactly there
  int every_lane;            // go on after a collision, until it is known which lanes collide
  int proofs_only;           // only whether lanes are free matters: one undecided pair decides that of a lane
  LaneMask decisive;         // lanes in which it ends the run; none with every_lane
  const char* open_pairs;    // [pair_count + self_pair_count]: only these are checked; null: all
  const char* open_bodies;   // [body_count]: those of these pairs; null: all
  const KernelHit* likely;   // tested first; whether a hit is found does not depend on them
  int likely_count;
  int only_likely;  // nothing else is tested, and what is not hit is not said to be undecided
  int used;         // lanes from here on are copies of the one before: they need no check
};

struct KernelResult {
  LaneMask undecided;    // lanes with a pair that is not proved free
  LaneMask colliding;    // lanes that surely collide at their sample; where only proofs matter, those too in which
                         // spheres that cover two bodies overlap there; unless every_lane, the first found ends the run
  KernelHit hit;         // of the colliding lanes, one
  LaneMask* pair_lanes;  // [pair_count + self_pair_count], zero on entry: lanes in which the pair is undecided
  KernelPair* undecided_pairs;  // room for as many: those of which these are not zero
  int undecided_count;
};

using KernelFunction = void (*)(const KernelModel&, const KernelRequest&, float* scratch, KernelResult&);

/// Floats of scratch memory (64-byte aligned) that a kernel needs.
inline int scratch_floats(const KernelModel& m) {
  return kLanes * (12 * m.node_count + 5 * m.body_count + 8 * m.stage_count + 3 * m.coarse_count + 3 * m.max_children) +
         2 * m.max_children + 2 * m.coarse_count;
}

void run_portable(const KernelModel&, const KernelRequest&, float* scratch, KernelResult&);
#if defined(__x86_64__) && !defined(SRMP_PORTABLE_ONLY)
void run_avx2(const KernelModel&, const KernelRequest&, float* scratch, KernelResult&);
void run_avx512(const KernelModel&, const KernelRequest&, float* scratch, KernelResult&);
#endif

}  // namespace srmp::batch
