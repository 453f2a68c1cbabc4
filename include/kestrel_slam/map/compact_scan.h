// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kestrel_slam/sensor/planar_scan.h"

namespace kestrel {

/// All rays of a scan in about two bytes each, in their order and with their flags. Positions are
/// rounded to multiples of kStepM. Rays that were rounded once are kept exactly.
///
/// Bytes, all numbers as varints, signed numbers as zigzag varints:
///   number of rays
///   kinds: runs of (two kinds in one byte, number of rays), which take turns within a run
///   ends: difference of x and y to the previous end of the same kind, in steps
///   origins: runs of (number of rays, difference of x and y to the previous origin, in steps)
/// Walls give small differences, and neighboring beams have nearly the same origin.
class CompactScan {
 public:
  static constexpr float kStepM = 1.0F / 512.0F;  ///< a power of two: decoding is exact
  /// Rays with a larger coordinate and rays that are not finite are left out.
  static constexpr float kMaxCoordinateM = 16384.0F;

  CompactScan() : CompactScan(std::vector<PlanarRay>()) {}
  explicit CompactScan(const std::vector<PlanarRay>& rays);

  /// Takes what bytes() gave. Throws std::invalid_argument with the reason if the bytes are no
  /// scan.
  static CompactScan fromBytes(std::string bytes);

  /// The same on all machines.
  const std::string& bytes() const { return bytes_; }
  std::size_t rayCount() const { return ray_count_; }
  std::size_t hitCount() const { return hit_count_; }
  std::size_t memoryBytes() const { return sizeof *this + bytes_.capacity(); }

  std::vector<PlanarRay> rays() const;
  /// The end points of all hits, in the order of the rays. Does not decode the origins.
  Points hits() const;

 private:
  explicit CompactScan(std::string bytes);

  std::string bytes_;
  std::size_t ray_count_ = 0;
  std::size_t hit_count_ = 0;
};

inline bool operator==(const CompactScan& a, const CompactScan& b) {
  return a.bytes() == b.bytes();
}

}  // namespace kestrel
