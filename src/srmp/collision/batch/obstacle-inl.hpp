// Lanes of points beside obstacles: distances, and what comes near. No include guard: once per kernel file.

#include "srmp/collision/batch/kernel.hpp"
#include "srmp/collision/batch/simd-inl.hpp"

namespace srmp::batch {
namespace {

struct V3 {
  V x, y, z;
};
SRMP_INLINE V3 operator+(const V3& a, const V3& b) { return {add(a.x, b.x), add(a.y, b.y), add(a.z, b.z)}; }
SRMP_INLINE V3 operator-(const V3& a, const V3& b) { return {sub(a.x, b.x), sub(a.y, b.y), sub(a.z, b.z)}; }
SRMP_INLINE V3 operator*(const V3& a, V b) { return {mul(a.x, b), mul(a.y, b), mul(a.z, b)}; }
SRMP_INLINE V dot(const V3& a, const V3& b) { return sum(mul(a.x, b.x), mul(a.y, b.y), mul(a.z, b.z)); }
SRMP_INLINE V squared_norm(const V3& a) { return dot(a, a); }
SRMP_INLINE V norm(const V3& a) { return sqrt(squared_norm(a)); }
SRMP_INLINE V3 cross(const V3& a, const V3& b) {
  return {sub(mul(a.y, b.z), mul(a.z, b.y)), sub(mul(a.z, b.x), mul(a.x, b.z)), sub(mul(a.x, b.y), mul(a.y, b.x))};
}

/// By the obstacle's rotation, or its transpose: the steps in memory to the next row and the next column tell which.
SRMP_INLINE V3 rotated(const KernelObstacle& o, const V3& c, int to_row, int to_column) {
  if (o.aligned) return c;
  const auto along = [&](int i) {
    const float* r = o.rotation + i * to_row;
    return sum(mul(c.x, all(r[0])), mul(c.y, all(r[to_column])), mul(c.z, all(r[2 * to_column])));
  };
  return {along(0), along(1), along(2)};
}

/// A direction in the obstacle's frame.
SRMP_INLINE V3 turned(const KernelObstacle& o, const V3& c) { return rotated(o, c, 3, 1); }

/// A direction that is given in the obstacle's frame.
SRMP_INLINE V3 turned_back(const KernelObstacle& o, const V3& c) { return rotated(o, c, 1, 3); }

SRMP_INLINE V3 local(const KernelObstacle& o, const V3& c) {
  return turned(o, c) + V3{all(o.offset[0]), all(o.offset[1]), all(o.offset[2])};
}

/// A place on a field's grid: coordinates in cells, clamped to the grid.
struct GridPlace {
  V3 at;
  V squared_off;  // of the distance from there to the grid's box
};
SRMP_INLINE GridPlace grid_place(const KernelObstacle& o, const V3& c) {
  const KernelField& f = o.field;
  const V3 p = local(o, c);
  const V x = mul(p.x, all(f.per_cell)), y = mul(p.y, all(f.per_cell)), z = mul(p.z, all(f.per_cell));
  const V3 at{min(max0(x), all(f.last[0])), min(max0(y), all(f.last[1])), min(max0(z), all(f.last[2]))};
  const V dx = mul(sub(x, at.x), all(f.cell)), dy = mul(sub(y, at.y), all(f.cell)), dz = mul(sub(z, at.z), all(f.cell));
  return {at, sum(mul(dx, dx), mul(dy, dy), mul(dz, dz))};
}

/// A lower bound, see DistanceField.
__attribute__((noinline)) inline V squared_distance_to_field(const KernelField& f, const GridPlace& place) {
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
SRMP_INLINE unsigned surely_within(const KernelObstacle& o, const V3& c, float radius) {
  const KernelField& f = o.field;
  const GridPlace place = grid_place(o, c);
  const V x = round(place.at.x), y = round(place.at.y), z = round(place.at.z);
  const V squared = max0(gather(f.squared, sum(x, mul(y, all(f.row)), mul(z, all(f.layer)))));
  const V dx = sub(place.at.x, x), dy = sub(place.at.y, y), dz = sub(place.at.z, z);
  const V to_grid = mul(all(f.cell), sqrt(sum(mul(dx, dx), mul(dy, dy), mul(dz, dz))));
  const V distance = sum(sqrt(squared), to_grid, add(sqrt(place.squared_off), all(f.error)));
  return bits(less(distance, all(radius < f.reach ? radius : f.reach)));
}

/// From the nearest point of an obstacle without a field, in its frame.
SRMP_INLINE V3 from_nearest(const KernelObstacle& o, const V3& c) {
  const V3 p = local(o, c);
  const auto beyond = [](V x, float half) { return sub(x, max(min(x, all(half)), all(-half))); };
  const V z = beyond(p.z, o.half[2]);
  if (!o.cylinder) return {beyond(p.x, o.half[0]), beyond(p.y, o.half[1]), z};
  const V from_axis = sqrt(add(mul(p.x, p.x), mul(p.y, p.y)));
  const V share = quotient(max0(sub(from_axis, all(o.half[0]))), max(from_axis, all(1e-30f)));
  return {mul(p.x, share), mul(p.y, share), z};
}

/// Of an obstacle without a field.
SRMP_INLINE V squared_distance(const KernelObstacle& o, const V3& c) {
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
SRMP_INLINE unsigned within(V squared, V limit) { return bits(not_greater(squared, mul(limit, limit))); }

/// Those of the lanes in which a point is not proved farther away than the limit.
SRMP_INLINE unsigned near(const KernelObstacle& o, const V3& c, V limit, unsigned lanes) {
  if (!o.field.squared) return within(squared_distance(o, c), limit) & lanes;
  const GridPlace place = grid_place(o, c);
  lanes &= within(place.squared_off, limit);
  return lanes == 0 ? 0 : within(squared_distance_to_field(o.field, place), limit) & lanes;
}

/// The place x + s velocity, |s| <= 1, that is nearest to zero.
SRMP_INLINE V3 nearest_to_zero(const V3& x, const V3& velocity) {
  const V s = quotient(dot(x, velocity), max(squared_norm(velocity), all(1e-30f)));
  return x - velocity * max(min(s, all(1.0f)), all(-1.0f));
}

/// Those of the lanes in which a point is not proved to stay farther away than the limit from what is beyond a plane.
/// It is away from that in the middle of the interval, and moves with the velocity, but for what the limit holds.
SRMP_INLINE unsigned approaches(const V3& away, const V3& velocity, V limit, unsigned lanes) {
  const V squared = squared_norm(away), nearer = abs(dot(away, velocity));
  return bits(not_greater(sub(squared, nearer), mul(sqrt(squared), limit))) & lanes;
}

}  // namespace
}  // namespace srmp::batch
