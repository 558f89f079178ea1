#include "srmp/collision/cubic_segments.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace srmp::detail {

namespace {

constexpr Eigen::Index max_linear_segments = 64;  // a line is fitted to no more of them

/// The polynomial's coefficient for the arguments r, s, t (its polar form).
double blossom(const std::array<double, 4>& c, double r, double s, double t) {
  const auto mix = [](double x, double y, double w) { return x + w * (y - x); };
  const double a = mix(c[0], c[1], r), b = mix(c[1], c[2], r), d = mix(c[2], c[3], r);
  return mix(mix(a, b, s), mix(b, d, s), t);
}

}  // namespace

std::pair<CubicSegments::Interval, CubicSegments::Interval> CubicSegments::Interval::halves() const {
  Interval left = *this, right = *this;
  if (in_one_segment())
    left.v = right.u = (u + v) / 2.0;
  else
    left.to = right.from = (from + to) / 2;
  return {left, right};
}

template <class Visit>
void CubicSegments::for_each_block(Eigen::Index from, Eigen::Index to, Visit&& visit) const {
  while (from < to) {
    std::size_t level = 0;
    while (level + 1 < low_.size() && from % (Eigen::Index{2} << level) == 0 && from + (Eigen::Index{2} << level) <= to)
      ++level;
    visit(low_[level].row(from >> level).data(), high_[level].row(from >> level).data());
    from += Eigen::Index{1} << level;
  }
}

void CubicSegments::range(const Interval& at, Range& range) const {
  if (at.in_one_segment()) return range_of_segment(at, range);
  const Eigen::Index mid = (at.from + at.to) / 2;
  range.middle = motion_.positions.row(mid).transpose();
  range.time = motion_.times[mid];
  std::fill(range.change.begin(), range.change.end(), 0.0);
  for_each_block(at.from, at.to, [&](const double* low, const double* high) {
    for (std::size_t j = 0; j < range.change.size(); ++j) {
      const double middle = range.middle[static_cast<Eigen::Index>(j)];
      range.change[j] = std::max({range.change[j], high[j] - middle, middle - low[j]});
    }
  });
  if (at.to - at.from <= max_linear_segments) return fit_line(at, range);
  std::fill(range.linear.begin(), range.linear.end(), 0.0);
  range.rest = range.change;
}

double CubicSegments::time(const Interval& at, double fraction) const {
  return (1.0 - fraction) * motion_.times[at.from] + fraction * motion_.times[at.to];  // those of rows bit for bit
}

double CubicSegments::time_of(const Interval& at, bool end) const {
  if (!at.in_one_segment()) return motion_.times[end ? at.to : at.from];
  return time(at, end ? at.v : at.u);
}

CubicSegments::Coefficients CubicSegments::coefficients(Eigen::Index segment, Eigen::Index joint) const {
  const double a = motion_.positions(segment, joint), b = motion_.positions(segment + 1, joint);
  if (motion_.velocities.rows() == 0) return {a, a + (b - a) / 3.0, b - (b - a) / 3.0, b};
  const double third = (motion_.times[segment + 1] - motion_.times[segment]) / 3.0;
  const double arrival =
      motion_.arrivals ? (*motion_.arrivals)(segment + 1, joint) : motion_.velocities(segment + 1, joint);
  return {a, a + third * motion_.velocities(segment, joint), b - third * arrival, b};
}

void CubicSegments::range_of_segment(const Interval& at, Range& range) const {
  const double m = (at.u + at.v) / 2.0;
  range.time = time(at, m);
  for (Eigen::Index j = 0; j < range.middle.size(); ++j) {
    const Coefficients &c = of(at.from, j),
                       part = std::array{blossom(c, at.u, at.u, at.u), blossom(c, at.u, at.u, at.v),
                                         blossom(c, at.u, at.v, at.v), blossom(c, at.v, at.v, at.v)};
    const double middle = range.middle[j] = blossom(c, m, m, m), linear = (part[3] - part[0]) / 2.0;
    double change = 0.0, rest = 0.0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      change = std::max(change, std::abs(part[i] - middle));
      rest = std::max(rest, std::abs(part[i] - middle - (static_cast<double>(i) / 1.5 - 1.0) * linear));
    }
    const auto joint = static_cast<std::size_t>(j);
    range.change[joint] = change, range.linear[joint] = linear, range.rest[joint] = rest;
  }
}

/// Fits a line through the middle to several segments.
void CubicSegments::fit_line(const Interval& at, Range& range) const {
  const double duration = motion_.times[at.to] - motion_.times[at.from];
  const double half = std::max(range.time - motion_.times[at.from], motion_.times[at.to] - range.time);
  Eigen::Map<Eigen::VectorXd> slope(range.linear.data(), range.middle.size()), rest(range.rest.data(), slope.size());
  slope = (motion_.positions.row(at.to) - motion_.positions.row(at.from)).transpose() / duration;
  rest.setZero();
  for (Eigen::Index segment = at.from; segment < at.to; ++segment) {
    const double start = motion_.times[segment] - range.time;
    const double third = (motion_.times[segment + 1] - motion_.times[segment]) / 3.0;
    for (Eigen::Index j = 0; j < slope.size(); ++j) {
      const Coefficients& c = of(segment, j);
      for (std::size_t i = 0; i < c.size(); ++i)
        rest[j] =
            std::max(rest[j], std::abs(c[i] - range.middle[j] - slope[j] * (start + static_cast<double>(i) * third)));
    }
  }
  slope *= half;
}

/// Computes the ranges of 1, 2, 4, … segments, so that any run of segments is a few blocks.
void CubicSegments::build() {
  const Eigen::Index segments = motion_.positions.rows() - 1, dof = motion_.positions.cols();
  coefficients_.reserve(static_cast<std::size_t>(segments * dof));
  for (Eigen::Index i = 0; i < segments; ++i)
    for (Eigen::Index j = 0; j < dof; ++j) coefficients_.push_back(coefficients(i, j));
  for (std::size_t level = 0; segments >> level > 0; ++level) {
    const Eigen::Index count = segments >> level;
    RowMatrix &low = low_.emplace_back(count, dof), &high = high_.emplace_back(count, dof);
    for (Eigen::Index i = 0; i < count; ++i)
      for (Eigen::Index j = 0; j < dof; ++j) {
        if (level == 0) {
          const Coefficients& c = of(i, j);
          std::tie(low(i, j), high(i, j)) = std::minmax({c[0], c[1], c[2], c[3]});
        } else {
          low(i, j) = std::min(low_[level - 1](2 * i, j), low_[level - 1](2 * i + 1, j));
          high(i, j) = std::max(high_[level - 1](2 * i, j), high_[level - 1](2 * i + 1, j));
        }
      }
  }
}

}  // namespace srmp::detail
