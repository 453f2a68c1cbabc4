// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel {
namespace {

/// Scans with the errors of a broken driver, a truncated message or flipped bits.
class GarbageScans {
 public:
  LaserScan next() {
    LaserScan scan;
    scan.stamp = field(1e9);
    scan.angle_min = field(-2.0);
    scan.angle_increment = field(0.01);
    scan.time_increment = field(0.0);
    scan.range_min = field(0.1);
    scan.range_max = field(30.0);
    scan.ranges.resize(random_() % 400);
    for (float& range : scan.ranges) range = anyFloat();
    return scan;
  }

  Eigen::Isometry3d mounting() {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() = Eigen::Vector3d(field(0.1), field(-0.1), field(0.2));
    pose.rotate(Eigen::Quaterniond(field(1.0), field(0.0), field(0.0), field(0.0)).normalized());
    return pose;
  }

 private:
  /// Mostly the valid value, so that many scans are projected; sometimes an arbitrary one.
  double field(double sane) { return random_() % 16 != 0 ? sane : static_cast<double>(anyFloat()); }

  /// A plausible range in half of the cases, else 32 arbitrary bits: NaN, infinities, denormal
  /// numbers.
  float anyFloat() {
    const auto bits = static_cast<std::uint32_t>(random_());
    if (bits % 2 == 0) return static_cast<float>(bits % 40000) * 1e-3F;
    float value = 0.0F;
    std::memcpy(&value, &bits, sizeof value);
    return bits % 5 == 0 ? std::numeric_limits<float>::infinity() : value;
  }

  std::mt19937_64 random_{117};
};

TEST(ScanProjector, GarbageGivesFiniteRaysOrAnError) {
  GarbageScans garbage;
  ScanProjector projector{ProjectorConfig()};
  std::size_t used = 0, refused = 0;
  for (int i = 0; i < 20000; ++i) {
    const LaserScan scan = garbage.next();
    const Projection result = projector.project(scan, garbage.mounting());
    (result.error == ScanError::kNone ? used : refused) += 1;
    ASSERT_EQ(result.error == ScanError::kNone, !result.scan.rays.empty());
    ASSERT_EQ(result.error == ScanError::kNone, result.message.empty());
    for (const PlanarRay& ray : result.scan.rays) {
      ASSERT_TRUE(ray.origin.allFinite() && ray.end.allFinite()) << "scan " << i;
      ASSERT_LE((ray.end - ray.origin).norm(), 80.0F * 1.001F + ray.origin.norm() * 1e-6F);
    }
    if (result.error != ScanError::kNone) continue;
    const BeamCounts& counts = result.counts;
    ASSERT_EQ(counts.hits + counts.clears + counts.invalid + counts.too_close + counts.masked +
                  counts.mixed + counts.floor + counts.ceiling + counts.outside,
              scan.ranges.size());
    ASSERT_EQ(counts.hits, result.scan.hitCount());
  }
  EXPECT_GT(used, 5000U);  // both cases must occur
  EXPECT_GT(refused, 1000U);
}

}  // namespace
}  // namespace kestrel
