// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace kestrel {

/// What is added to the ranges of a laser whose error is known. Cheap lasers, that triangulate, may
/// be wrong by several per cent, and by a share that changes with the distance: a vehicle that
/// trusts them moves too little or too much.
class RangeCorrection {
 public:
  /// Reads "range:correction, range:correction", both in m, the measured ranges in ascending order:
  /// linear between them, from zero at the range 0 to the first, constant beyond the last. An empty
  /// text corrects nothing. Throws std::invalid_argument that quotes the text.
  explicit RangeCorrection(const std::string& text);

  bool isEmpty() const { return knots_.empty(); }

  /// The true range for a measured one, m. What is no finite positive range stays as it is.
  float corrected(float range) const;

 private:
  std::vector<std::pair<float, float>> knots_;  ///< (measured range, what is added), m
};

}  // namespace kestrel
