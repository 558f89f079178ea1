// CellDecomposition, by flood fill of the same boxes on a grid.
#include "srmp/search/cell_decomposition.hpp"

#include <boost/test/unit_test.hpp>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "srmp/search/rrt_connect.hpp"

using namespace srmp::search;
using Outcome = CellDecomposition::Outcome;

namespace {

/// Cubes of a grid over [0, 1]^n, some of them blocked.
struct Grid {
  std::size_t axes, per_axis;
  std::vector<char> blocked, wraps;

  std::size_t size() const { return blocked.size(); }
  std::size_t coordinate(std::size_t cube, std::size_t axis) const {
    for (std::size_t k = 0; k < axis; ++k) cube /= per_axis;
    return cube % per_axis;
  }
  std::size_t stride(std::size_t axis) const {
    std::size_t result = 1;
    for (std::size_t k = 0; k < axis; ++k) result *= per_axis;
    return result;
  }
  Eigen::VectorXd middle(std::size_t cube) const {
    Eigen::VectorXd point(static_cast<Eigen::Index>(axes));
    for (std::size_t k = 0; k < axes; ++k)
      point[static_cast<Eigen::Index>(k)] = (static_cast<double>(coordinate(cube, k)) + 0.5) / double(per_axis);
    return point;
  }
  CellLabel label(const Cell& cell) const {
    bool some_free = false, some_blocked = false;
    for (std::size_t cube = 0; cube < size(); ++cube) {
      bool shares = true;
      for (std::size_t k = 0; k < axes; ++k) {
        const auto i = static_cast<Eigen::Index>(k);
        const double low = double(coordinate(cube, k)) / double(per_axis), high = low + 1.0 / double(per_axis);
        shares = shares && low < cell.high[i] && cell.low[i] < high;
      }
      if (shares) (blocked[cube] ? some_blocked : some_free) = true;
    }
    if (some_free && some_blocked) return CellLabel::mixed;
    return some_free ? CellLabel::free : CellLabel::blocked;
  }
  std::vector<char> reached(std::size_t from) const {
    std::vector<char> done(size());
    std::vector<std::size_t> open{from};
    done[from] = 1;
    while (!open.empty()) {
      const std::size_t cube = open.back();
      open.pop_back();
      for (std::size_t k = 0; k < axes; ++k)
        for (const int step : {-1, 1}) {
          const std::size_t at = coordinate(cube, k), last = per_axis - 1;
          if (at == (step < 0 ? 0 : last) && !wraps[k]) continue;
          const std::size_t next_at = step < 0 ? (at == 0 ? last : at - 1) : (at == last ? 0 : at + 1);
          const std::size_t next = cube - at * stride(k) + next_at * stride(k);
          if (blocked[next] || done[next]) continue;
          done[next] = 1;
          open.push_back(next);
        }
    }
    return done;
  }
};

Grid random_grid(std::size_t axes, RandomSequence& random) {
  Grid grid{axes, axes == 1 ? 32u : axes == 2 ? 16u : 8u, {}, {}};
  grid.blocked.resize(grid.stride(axes));
  const double part = axes == 1 ? 0.1 : axes == 2 ? 0.4 : 0.65;
  for (char& blocked : grid.blocked) blocked = random.next() < part;
  for (std::size_t k = 0; k < axes; ++k) grid.wraps.push_back(random.next() < 0.5);
  return grid;
}

Cell unit_box(std::size_t axes) {
  const auto n = static_cast<Eigen::Index>(axes);
  return {Eigen::VectorXd::Zero(n), Eigen::VectorXd::Ones(n)};
}

}  // namespace

BOOST_AUTO_TEST_CASE(there_is_a_proof_where_a_flood_fill_does_not_come_and_nowhere_else) {
  RandomSequence random(3);
  int proved = 0, unproved = 0;
  for (int world = 0; world < 400; ++world) {
    const Grid grid = random_grid(1 + static_cast<std::size_t>(world) % 3, random);
    std::vector<std::size_t> free;
    for (std::size_t cube = 0; cube < grid.size(); ++cube)
      if (!grid.blocked[cube]) free.push_back(cube);
    if (free.size() < 2) continue;
    const auto draw = [&] { return free[static_cast<std::size_t>(random.next() * double(free.size()))]; };
    const std::size_t from = draw();
    const std::vector<char> reached = grid.reached(from);
    std::vector<Cell> labelled;
    CellDecomposition cells({.whole = unit_box(grid.axes), .wraps = grid.wraps},
                            [&](const Cell& cell, std::size_t parent) {
                              if (random.next() < 0.01) throw std::runtime_error("stopped");
                              if (parent != CellDecomposition::no_cell) {
                                BOOST_TEST((labelled[parent].low.array() <= cell.low.array()).all());
                                BOOST_TEST((labelled[parent].high.array() >= cell.high.array()).all());
                              }
                              labelled.push_back(cell);
                              return grid.label(cell);
                            });
    for (const std::size_t to : {draw(), draw()}) {  // the second one profits from the first
      Outcome outcome = Outcome::unfinished;
      for (std::size_t limit = cells.cells() + 10; outcome == Outcome::unfinished; limit += 10) try {
          outcome = cells.run(grid.middle(from), grid.middle(to), limit);
          BOOST_REQUIRE(cells.cells() <= limit);
        } catch (const std::runtime_error&) {  // what is stopped may go on
        }
      BOOST_REQUIRE_EQUAL(outcome == Outcome::no_path, !reached[to]);
      ++(reached[to] ? unproved : proved);
      if (reached[to]) continue;
      BOOST_TEST(!cells.barrier().empty());
      for (const std::size_t cell : cells.barrier()) BOOST_TEST((grid.label(labelled[cell]) == CellLabel::blocked));
    }
  }
  BOOST_TEST(proved > 100);
  BOOST_TEST(unproved > 100);
}

BOOST_AUTO_TEST_CASE(a_barrier_thinner_than_cells_can_be_proves_nothing) {
  const Eigen::VectorXd from = Eigen::VectorXd::Constant(1, 0.1), to = Eigen::VectorXd::Constant(1, 0.9);
  for (const double width : {1e-2, 1e-5}) {
    CellDecomposition cells({.whole = unit_box(1)}, [&](const Cell& cell, std::size_t) {
      const double low = 0.7 - width / 2, high = 0.7 + width / 2;
      if (cell.high[0] <= low || cell.low[0] >= high) return CellLabel::free;
      return cell.low[0] >= low && cell.high[0] <= high ? CellLabel::blocked : CellLabel::mixed;
    });
    BOOST_TEST((cells.run(from, to, 10'000) == (width > 1e-3 ? Outcome::no_path : Outcome::unproved)));
  }
}

BOOST_AUTO_TEST_CASE(from_an_end_that_is_not_free_nothing_is_proved) {
  const Eigen::VectorXd from = Eigen::VectorXd::Constant(1, 0.1), to = Eigen::VectorXd::Constant(1, 0.9);
  CellDecomposition cells({.whole = unit_box(1)}, [](const Cell&, std::size_t) { return CellLabel::blocked; });
  BOOST_TEST((cells.run(from, to, 100) == Outcome::unproved));
}
