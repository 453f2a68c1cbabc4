// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/evaluation/assignment.h"

#include <limits>

namespace kestrel {
namespace {

/// Shortest augmenting paths with potentials; at most as many rows as columns. Index 0 of rows and
/// columns is a dummy.
class Hungarian {
 public:
  explicit Hungarian(const Eigen::MatrixXd& costs)
      : costs_(costs),
        rows_(static_cast<std::size_t>(costs.rows())),
        columns_(static_cast<std::size_t>(costs.cols())),
        row_potential_(rows_ + 1, 0.0),
        column_potential_(columns_ + 1, 0.0),
        row_of_(columns_ + 1, 0),
        previous_(columns_ + 1, 0) {}

  std::vector<int> solve() {
    for (std::size_t row = 1; row <= rows_; ++row) addRow(row);
    std::vector<int> result(rows_, -1);
    for (std::size_t column = 1; column <= columns_; ++column) {
      if (row_of_[column] > 0) result[row_of_[column] - 1] = static_cast<int>(column) - 1;
    }
    return result;
  }

 private:
  void addRow(std::size_t row) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    slack_.assign(columns_ + 1, kInfinity);
    used_.assign(columns_ + 1, false);
    row_of_[0] = row;
    std::size_t column = 0;
    do {
      used_[column] = true;
      column = extend(column);
    } while (row_of_[column] != 0);
    while (column != 0) {
      row_of_[column] = row_of_[previous_[column]];
      column = previous_[column];
    }
  }

  /// Adds the nearest column to the tree of shortest paths and returns it.
  std::size_t extend(std::size_t column) {
    const std::size_t row = row_of_[column];
    std::size_t nearest = 0;
    double step = std::numeric_limits<double>::infinity();
    for (std::size_t j = 1; j <= columns_; ++j) {
      if (used_[j]) continue;
      const double reduced =
          costs_(static_cast<Eigen::Index>(row) - 1, static_cast<Eigen::Index>(j) - 1) -
          row_potential_[row] - column_potential_[j];
      if (reduced < slack_[j]) {
        slack_[j] = reduced;
        previous_[j] = column;
      }
      if (slack_[j] < step) {
        step = slack_[j];
        nearest = j;
      }
    }
    movePotentials(step);
    return nearest;
  }

  void movePotentials(double step) {
    for (std::size_t j = 0; j <= columns_; ++j) {
      if (used_[j]) {
        row_potential_[row_of_[j]] += step;
        column_potential_[j] -= step;
      } else {
        slack_[j] -= step;
      }
    }
  }

  const Eigen::MatrixXd& costs_;
  std::size_t rows_, columns_;
  std::vector<double> row_potential_, column_potential_, slack_;
  std::vector<std::size_t> row_of_, previous_;
  std::vector<bool> used_;
};

}  // namespace

std::vector<int> cheapestAssignment(const Eigen::MatrixXd& costs) {
  if (costs.rows() <= costs.cols()) return Hungarian(costs).solve();
  const Eigen::MatrixXd transposed = costs.transpose();
  const std::vector<int> row_of = Hungarian(transposed).solve();
  std::vector<int> result(static_cast<std::size_t>(costs.rows()), -1);
  for (std::size_t column = 0; column < row_of.size(); ++column) {
    if (row_of[column] >= 0) {
      result[static_cast<std::size_t>(row_of[column])] = static_cast<int>(column);
    }
  }
  return result;
}

}  // namespace kestrel
