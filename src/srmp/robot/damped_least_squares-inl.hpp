// srmp::damped_least_squares_* for one instruction set, chosen by the flags of the including file, which defines
// SRMP_DAMPED_LEAST_SQUARES as its name. A seed a lane: what a lane computes depends on no other. No include guard:
// once per kernel file.

#include <limits>
#include <numbers>

#include "srmp/core/double_lanes-inl.hpp"
#include "srmp/robot/damped_least_squares.hpp"

namespace srmp {

namespace {

constexpr double max_step = 0.5;  // [rad or m] largest change of a joint in one step, because the Jacobian is local
constexpr double min_damping = 1e-9;
constexpr double progress = 0.998;  // of the squared error that was best: more is none
constexpr int patience = 6;         // a seed is abandoned after this many steps without progress: 1 in 100 would arrive
constexpr int polish_steps = 3;     // after the tolerance is met, where convergence is quadratic
constexpr int rows = 6;             // of a Jacobian: linear, angular

Lanes all(double value) { return Lanes{} + value; }
Lanes least(Lanes a, Lanes b) { return a < b ? a : b; }
Lanes most(Lanes a, Lanes b) { return a < b ? b : a; }
Lanes magnitude(Lanes a) { return a < 0.0 ? -a : a; }
Lanes whole(Lanes a) { return (a + 0x1.8p52) - 0x1.8p52; }  // the nearest whole number, below 2^51

Lanes square_root(Lanes a) {
  for (std::size_t i = 0; i < lane_count; ++i) a[i] = __builtin_sqrt(a[i]);
  return a;
}

bool any(LaneNumbers truths) {
  std::int64_t all = 0;
  for (std::size_t i = 0; i < lane_count; ++i) all |= truths[i];
  return all != 0;
}

struct SinCos {
  Lanes sine, cosine;
};

/// Within three units in the last place for angles below 10^5 [rad]: Cody and Waite's reduction to an eighth of a turn,
/// then Taylor polynomials.
SinCos sine_and_cosine(Lanes angle) {
  const Lanes quarters = whole(angle * (2.0 / std::numbers::pi));
  // Pi / 2 in three parts of 33, 33 and 53 bits: the first two products are exact.
  Lanes x = angle - quarters * 0x1.921fb544p+0;
  x = x - quarters * 0x1.0b4611a6p-34;
  x = x - quarters * 0x1.3198a2e037073p-69;
  const Lanes square = x * x;
  constexpr double odd_factorials[] = {355687428096000.0, -1307674368000.0, 6227020800.0, -39916800.0,
                                       362880.0,          -5040.0,          120.0,        -6.0};
  constexpr double even_factorials[] = {
      -6402373705728000.0, 20922789888000.0, -87178291200.0, 479001600.0, -3628800.0, 40320.0, -720.0, 24.0, -2.0};
  Lanes sine{}, cosine{};
  for (const double factorial : odd_factorials) sine = sine * square + 1.0 / factorial;
  for (const double factorial : even_factorials) cosine = cosine * square + 1.0 / factorial;
  sine = x + x * (square * sine);
  cosine = 1.0 + square * cosine;
  const Lanes quarter = quarters - 4.0 * whole(quarters * 0.25);  // -2 to 2
  const LaneNumbers odd = (quarter == 1.0) | (quarter == -1.0), behind = (quarter == 2.0) | (quarter == -2.0);
  const Lanes s = odd ? cosine : sine, c = odd ? sine : cosine;
  return {(behind | (quarter == -1.0)) ? -s : s, (behind | (quarter == 1.0)) ? -c : c};
}

struct Vector {
  Lanes x, y, z;
};
Vector operator+(const Vector& a, const Vector& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vector operator-(const Vector& a, const Vector& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vector operator*(const Vector& a, Lanes b) { return {a.x * b, a.y * b, a.z * b}; }
Vector operator*(const Vector& a, double b) { return {a.x * b, a.y * b, a.z * b}; }
Vector cross(const Vector& a, const Vector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// A frame in that of the target: the axes and the origin.
struct Frame {
  Vector x, y, z, origin;

  Vector rotated(double a, double b, double c) const { return x * a + y * b + z * c; }
  /// Goes on to a frame that is given in this one.
  void append(const double* rotation, const double* translation) {
    origin = origin + rotated(translation[0], translation[1], translation[2]);
    const double* r = rotation;
    *this = {rotated(r[0], r[3], r[6]), rotated(r[1], r[4], r[7]), rotated(r[2], r[5], r[8]), origin};
  }
};

/// The rotation from the frame to the target: its axis, as long as DampedLeastSquares::tolerance says, which is never
/// less than the angle.
Vector rotation_to_target(const Frame& f) {
  // Four candidates for the quaternion, each times four times another of its components, of which the largest is taken.
  const Lanes w = 1.0 + f.x.x + f.y.y + f.z.z, x = 1.0 + f.x.x - f.y.y - f.z.z, y = 1.0 - f.x.x + f.y.y - f.z.z,
              z = 1.0 - f.x.x - f.y.y + f.z.z;
  const Lanes wx = f.y.z - f.z.y, wy = f.z.x - f.x.z, wz = f.x.y - f.y.x;
  const Lanes xy = f.x.y + f.y.x, xz = f.x.z + f.z.x, yz = f.y.z + f.z.y;
  Lanes best = w, scalar = w;
  Vector vector{wx, wy, wz};
  const auto prefer = [&](Lanes square, Lanes of_w, const Vector& v) {
    const LaneNumbers larger = square > best;
    best = larger ? square : best;
    scalar = larger ? of_w : scalar;
    vector = {larger ? v.x : vector.x, larger ? v.y : vector.y, larger ? v.z : vector.z};
  };
  prefer(x, wx, {x, xy, xz});
  prefer(y, wy, {xy, y, yz});
  prefer(z, wz, {xz, yz, z});
  const Lanes length = square_root(scalar * scalar + (vector.x * vector.x + vector.y * vector.y + vector.z * vector.z));
  const Lanes scale = 4.0 / (length + magnitude(scalar));
  return vector * (scalar < 0.0 ? scale : -scale);
}

/// The same for the shortest rotation that aligns one of the frame's axes with the target's.
Vector alignment(const Frame& f, int axis) {
  const Vector current = axis == 0 ? f.x : axis == 1 ? f.y : f.z;
  const Vector required{all(axis == 0), all(axis == 1), all(axis == 2)};
  const Vector turn = cross(current, required);
  const Lanes cosine = axis == 0 ? current.x : axis == 1 ? current.y : current.z;
  const Lanes square = turn.x * turn.x + turn.y * turn.y + turn.z * turn.z;
  const LaneNumbers opposite = (cosine < 0.0) & (square < 1e-20);
  const Lanes half = square_root(most((1.0 + cosine) * 0.5, all(1e-24))), scale = 2.0 / (half * (1.0 + half));
  constexpr double half_turn = 2.0 * std::numbers::sqrt2;  // about an axis between the two others
  return {opposite ? all(axis == 0 ? 0.0 : half_turn) : turn.x * scale,
          opposite ? all(axis == 1 ? 0.0 : half_turn) : turn.y * scale,
          opposite ? all(axis == 2 ? 0.0 : half_turn) : turn.z * scale};
}

/// As many seeds as there are lanes.
class SeedLanes {
 public:
  explicit SeedLanes(const DampedLeastSquares& problem) : problem_(problem) {
    for (int row = 0; row < rows; ++row) free_[row] = problem.tolerance[row] == infinity;
    free_angles_ = free_[3] + free_[4] + free_[5];
  }

  void run(std::size_t count, double* configurations, bool* reached) {
    std::size_t next = 0;
    for (std::size_t i = 0; i < count; ++i) reached[i] = false;
    for (std::size_t c = 0; c < problem_.planned_count; ++c) q_[c] = Lanes{};
    const auto start = [&](std::size_t lane) {
      seeds_[lane] = {.busy = next < count, .configuration = configurations, .reached = reached + next};
      if (next == count) return;
      seeds_[lane].configuration += next++ * problem_.planned_count;
      for (std::size_t c = 0; c < problem_.planned_count; ++c) q_[c][lane] = seeds_[lane].configuration[c];
    };
    for (std::size_t lane = 0; lane < lane_count; ++lane) start(lane);
    for (bool busy = count > 0; busy;) {
      evaluate();
      bool done[lane_count];
      for (std::size_t lane = 0; lane < lane_count; ++lane) done[lane] = seeds_[lane].busy && !goes_on(lane);
      advance();
      busy = false;
      for (std::size_t lane = 0; lane < lane_count; ++lane) {
        if (done[lane]) start(lane);
        busy = busy || seeds_[lane].busy;
      }
    }
  }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  static constexpr std::size_t max_joints = DampedLeastSquares::max_joints;

  struct Seed {
    bool busy;
    double* configuration;  // the seed, then the best solution
    bool* reached;
    int steps{}, since_best{}, polished{};
    double best{infinity}, solution{infinity};  // squared errors
  };

  /// Computes error and Jacobian, with zeros for free axes.
  void evaluate() {
    Frame f{{all(1.0), Lanes{}, Lanes{}}, {Lanes{}, all(1.0), Lanes{}}, {Lanes{}, Lanes{}, all(1.0)}, {}};
    for (std::size_t k = 0; k < problem_.joint_count; ++k) {
      const ChainJoint& joint = problem_.joints[k];
      f.append(joint.rotation, joint.translation);
      axes_[k] = f.z;
      const Lanes position = q_[joint.planned] * joint.ratio;
      if (joint.prismatic) {
        f.origin = f.origin + f.z * position;
      } else {
        const auto [sine, cosine] = sine_and_cosine(position);
        const Vector x = f.x * cosine + f.y * sine;
        f.y = f.y * cosine - f.x * sine;
        f.x = x;
      }
      origins_[k] = f.origin;
    }
    f.append(problem_.end_rotation, problem_.end_translation);
    const Vector angular = free_angles_ == 1 ? alignment(f, free_[3] ? 0 : free_[4] ? 1 : 2) : rotation_to_target(f);
    const Lanes error[rows] = {-f.origin.x, -f.origin.y, -f.origin.z, angular.x, angular.y, angular.z};
    square_ = Lanes{};
    within_ = LaneNumbers{} - 1;
    for (int row = 0; row < rows; ++row) {
      error_[row] = free_[row] ? Lanes{} : error[row];
      square_ += error_[row] * error_[row];
      within_ &= magnitude(error_[row]) <= problem_.tolerance[row];
    }
    find_jacobian(f.origin);
  }

  void find_jacobian(const Vector& end) {
    for (std::size_t c = 0; c < problem_.planned_count; ++c)
      for (int row = 0; row < rows; ++row) jacobian_[c][row] = Lanes{};
    for (std::size_t k = 0; k < problem_.joint_count; ++k) {
      const ChainJoint& joint = problem_.joints[k];
      const Vector axis = axes_[k] * joint.ratio, linear = joint.prismatic ? axis : cross(axis, end - origins_[k]);
      const Vector angular = joint.prismatic ? Vector{} : axis;
      const Lanes column[rows] = {linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
      for (int row = 0; row < rows; ++row)
        if (!free_[row]) jacobian_[joint.planned][row] += column[row];
    }
  }

  /// Keeps the configuration of the lane if it is the best one yet; false: the seed ends here.
  bool goes_on(std::size_t lane) {
    Seed& seed = seeds_[lane];
    const double error = square_[lane];
    if (!(error < infinity)) return false;
    if (within_[lane] && error < seed.solution) {
      seed.solution = error;
      *seed.reached = true;
      for (std::size_t c = 0; c < problem_.planned_count; ++c) seed.configuration[c] = q_[c][lane];
    }
    if (*seed.reached && seed.polished++ == polish_steps) return false;
    seed.since_best = error < progress * seed.best ? 0 : seed.since_best + 1;
    if (error < seed.best) seed.best = error;
    if (seed.since_best > patience) return false;
    return ++seed.steps < problem_.max_iterations || (*seed.reached && seed.polished < polish_steps);
  }

  /// One damped step within the limits. Joints that the step would move beyond a limit are held, and the step is solved
  /// again for the other joints.
  void advance() {
    Lanes step[max_joints];
    for (std::size_t round = 0; round <= problem_.planned_count; ++round) {
      find_step(step);
      LaneNumbers any_held{};
      for (std::size_t c = 0; c < problem_.planned_count; ++c) {
        const LaneNumbers held =
            ((q_[c] <= problem_.lower[c]) & (step[c] < 0.0)) | ((q_[c] >= problem_.upper[c]) & (step[c] > 0.0));
        any_held |= held;
        for (Lanes& entry : jacobian_[c]) entry = held ? Lanes{} : entry;
      }
      if (!any(any_held)) break;
    }
    Lanes largest = all(1e-300);
    for (std::size_t c = 0; c < problem_.planned_count; ++c) largest = most(largest, magnitude(step[c]));
    const Lanes scale = least(all(1.0), max_step / largest);
    for (std::size_t c = 0; c < problem_.planned_count; ++c)
      q_[c] = least(most(q_[c] + step[c] * scale, all(problem_.lower[c])), all(problem_.upper[c]));
  }

  /// step = J^T (J J^T + damping)^-1 error, the damping falling with the error (Sugihara 2011), by a Cholesky
  /// decomposition L D L^T.
  void find_step(Lanes* step) const {
    Lanes a[rows][rows];  // the lower triangle: J J^T + damping, then L
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j <= i; ++j) a[i][j] = i == j ? 0.05 * square_ + min_damping : Lanes{};
    for (std::size_t c = 0; c < problem_.planned_count; ++c)
      for (int i = 0; i < rows; ++i)
        for (int j = 0; j <= i; ++j) a[i][j] += jacobian_[c][i] * jacobian_[c][j];
    Lanes inverse[rows], y[rows];  // of D
    for (int j = 0; j < rows; ++j) {
      for (int k = 0; k < j; ++k) {
        const Lanes of_l_d = a[j][k];
        a[j][k] *= inverse[k];
        a[j][j] -= of_l_d * a[j][k];
      }
      inverse[j] = 1.0 / a[j][j];
      for (int i = j + 1; i < rows; ++i)
        for (int k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
    }
    for (int i = 0; i < rows; ++i) {
      y[i] = error_[i];
      for (int k = 0; k < i; ++k) y[i] -= a[i][k] * y[k];
    }
    for (int i = rows; i-- > 0;) {
      y[i] *= inverse[i];
      for (int k = i + 1; k < rows; ++k) y[i] -= a[k][i] * y[k];
    }
    for (std::size_t c = 0; c < problem_.planned_count; ++c) {
      step[c] = Lanes{};
      for (int row = 0; row < rows; ++row) step[c] += jacobian_[c][row] * y[row];
    }
  }

  const DampedLeastSquares& problem_;
  bool free_[rows];  // axes
  int free_angles_;
  Seed seeds_[lane_count];
  Lanes q_[max_joints];
  Vector axes_[max_joints], origins_[max_joints];  // of the chain
  Lanes jacobian_[max_joints][rows];               // by planned joint
  Lanes error_[rows];
  Lanes square_;        // of the error
  LaneNumbers within_;  // the tolerances
};

}  // namespace

void SRMP_DAMPED_LEAST_SQUARES(const DampedLeastSquares& problem, std::size_t count, double* configurations,
                               bool* reached) {
  SeedLanes(problem).run(count, configurations, reached);
}

}  // namespace srmp
