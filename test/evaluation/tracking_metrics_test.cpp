// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/tracking_metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kestrel_slam/evaluation/assignment.h"
#include "kestrel_slam/geometry/random.h"

namespace kestrel {
namespace {

/// The smallest sum over all permutations.
double cheapestByBruteForce(const Eigen::MatrixXd& costs) {
  const Eigen::MatrixXd wide = costs.rows() <= costs.cols() ? costs : costs.transpose();
  std::vector<int> columns(static_cast<std::size_t>(wide.cols()));
  std::iota(columns.begin(), columns.end(), 0);
  double best = 1e300;
  do {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < wide.rows(); ++i) {
      sum += wide(i, columns[static_cast<std::size_t>(i)]);
    }
    best = std::min(best, sum);
  } while (std::next_permutation(columns.begin(), columns.end()));
  return best;
}

TEST(Assignment, IsTheCheapestOfAll) {
  Random random(1);
  for (int trial = 0; trial < 60; ++trial) {
    const int rows = 1 + trial % 6, columns = 1 + (trial / 6) % 6;
    Eigen::MatrixXd costs(rows, columns);
    for (int i = 0; i < rows; ++i) {
      for (int j = 0; j < columns; ++j) costs(i, j) = random.uniform(-5.0, 5.0);
    }
    const std::vector<int> column_of = cheapestAssignment(costs);
    double sum = 0.0;
    int assigned = 0;
    std::vector<bool> used(static_cast<std::size_t>(columns), false);
    for (int i = 0; i < rows; ++i) {
      const int j = column_of[static_cast<std::size_t>(i)];
      if (j < 0) continue;
      EXPECT_FALSE(used[static_cast<std::size_t>(j)]);
      used[static_cast<std::size_t>(j)] = true;
      sum += costs(i, j);
      ++assigned;
    }
    EXPECT_EQ(assigned, std::min(rows, columns));
    EXPECT_NEAR(sum, cheapestByBruteForce(costs), 1e-9);
  }
}

PointSet points(const std::vector<double>& xs) {
  PointSet result;
  for (const double x : xs) result.emplace_back(Eigen::Vector2d(x, 0.0));
  return result;
}

TEST(SetDistances, OspaByHand) {
  // Distances 1 and 2, one point missing: (1 + 2 + 10) / 3.
  const SetDistance d = ospa(points({0, 10, 20}), points({1, 12}), 10.0);
  EXPECT_NEAR(d.total, 13.0 / 3.0, 1e-12);
  EXPECT_NEAR(d.localization, 1.0, 1e-12);
  EXPECT_NEAR(d.cardinality, 10.0 / 3.0, 1e-12);
  EXPECT_EQ(d.missed, 1U);
  EXPECT_EQ(ospa({}, {}, 10.0).total, 0.0);
  EXPECT_EQ(ospa({}, points({1}), 10.0).total, 10.0);
  // Too far: the cutoff, as a distance.
  EXPECT_NEAR(ospa(points({0}), points({50}), 10.0).localization, 10.0, 1e-12);
}

TEST(SetDistances, GospaByHand) {
  const SetDistance d = gospa(points({0, 10, 20}), points({1, 12, 80}), 10.0);
  EXPECT_NEAR(d.total, std::sqrt(1.0 + 4.0 + 2.0 * 100.0 / 2.0), 1e-12);
  EXPECT_EQ(d.missed, 1U);
  EXPECT_EQ(d.extra, 1U);
}

TrackedObject object(long id, double x, bool counts = true) {
  return {id, Eigen::Vector3d(x, 0.0, 0.0), counts};
}

TEST(ClearMotCounter, CountsMatchesAndErrorsByHand) {
  ClearMotCounter counter(1.0);
  counter.add({{object(1, 0.0), object(2, 5.0)}, {object(7, 0.2), object(8, 5.4)}});
  counter.add({{object(1, 0.0), object(2, 5.0)}, {object(7, 0.2)}});  // one missed
  counter.add(
      {{object(1, 0.0), object(2, 5.0)}, {object(9, 0.0), object(8, 5.0)}});  // switch, found
  counter.add({{object(1, 0.0)}, {object(9, 0.5), object(10, 3.0)}});         // one false
  const ClearMot& m = counter.result();
  EXPECT_EQ(m.frames, 4U);
  EXPECT_EQ(m.truths, 7U);
  EXPECT_EQ(m.matches, 6U);
  EXPECT_EQ(m.misses, 1U);
  EXPECT_EQ(m.switches, 1U);
  EXPECT_EQ(m.fragments, 1U);
  EXPECT_EQ(m.false_tracks, 1U);
  EXPECT_NEAR(m.mota(), 1.0 - 3.0 / 7.0, 1e-12);
  EXPECT_NEAR(m.motp(), (0.2 + 0.4 + 0.2 + 0.0 + 0.0 + 0.5) / 6.0, 1e-12);
  EXPECT_NEAR(counter.identityShares().at(1), 0.5, 1e-12);
}

TEST(ClearMotCounter, KeepsAPairThoughAnotherIsNearer) {
  ClearMotCounter counter(1.0);
  counter.add({{object(1, 0.0)}, {object(7, 0.1)}});
  counter.add({{object(1, 0.0)}, {object(7, 0.9), object(8, 0.1)}});
  EXPECT_EQ(counter.result().switches, 0U);
  EXPECT_EQ(counter.result().false_tracks, 1U);
}

TEST(ClearMotCounter, ObjectThatDoesNotCountHidesItsTrack) {
  ClearMotCounter counter(1.0);
  counter.add({{object(1, 0.0, false), object(2, 5.0, false)}, {object(7, 0.1)}});
  EXPECT_EQ(counter.result().truths, 0U);
  EXPECT_EQ(counter.result().false_tracks, 0U);
  EXPECT_EQ(counter.result().misses, 0U);
}

TEST(ClearMotCounter, SwitchWhileTheObjectDoesNotCountIsOne) {
  ClearMotCounter counter(1.0);
  counter.add({{object(1, 0.0)}, {object(7, 0.1)}});
  counter.add({{object(1, 0.0, false)}, {object(8, 0.1)}});
  counter.add({{object(1, 0.0)}, {object(8, 0.1)}});
  EXPECT_EQ(counter.result().switches, 1U);
}

TEST(ClearMotCounter, MatchesAsManyAsPossible) {
  // The cheapest pair alone would leave the second object without a track.
  ClearMotCounter counter(1.0);
  counter.add({{object(1, 0.0), object(2, 0.9)}, {object(7, 0.8), object(8, -0.9)}});
  EXPECT_EQ(counter.result().matches, 2U);
}

}  // namespace
}  // namespace kestrel
