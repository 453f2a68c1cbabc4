// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace kestrel {

/// Corrects the ranges of a laser with a known range error. Cheap triangulating lasers may be wrong
/// by several percent, and the error changes with the distance. Without a correction the estimated
/// motion is too short or too long.
class RangeCorrection {
 public:
  /// Parses "range:correction, range:correction", both in m, with ascending measured ranges. The
  /// correction is linear between two ranges and from 0 at range 0 to the first; it is constant
  /// beyond the last. An empty text corrects nothing. Throws std::invalid_argument with the text if
  /// it is invalid.
  explicit RangeCorrection(const std::string& text);

  bool isEmpty() const { return knots_.empty(); }

  /// The corrected range, m. A value that is not a finite positive range is returned unchanged.
  float corrected(float range) const;

 private:
  std::vector<std::pair<float, float>> knots_;  ///< (measured range, correction), m
};

}  // namespace kestrel
