// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/map/compact_scan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "map/scans_of_lasers.h"
#include "room.h"
#include "temporary_folder.h"

namespace kestrel {
namespace {

constexpr float kMaxErrorM = 0.002F;

bool sameFlags(const PlanarRay& a, const PlanarRay& b) {
  return a.hit == b.hit && a.known == b.known && a.no_return == b.no_return &&
         a.presumed == b.presumed;
}

/// Everything that holds for every scan.
void expectRoundTrip(const std::vector<PlanarRay>& rays) {
  const CompactScan scan(rays);
  const std::vector<PlanarRay> decoded = scan.rays();
  ASSERT_EQ(decoded.size(), rays.size());
  EXPECT_EQ(scan.rayCount(), rays.size());
  Points hits;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_LE((decoded[i].end - rays[i].end).norm(), kMaxErrorM) << i;
    EXPECT_LE((decoded[i].origin - rays[i].origin).norm(), kMaxErrorM) << i;
    EXPECT_TRUE(sameFlags(decoded[i], rays[i])) << i;
    if (rays[i].hit) hits.push_back(decoded[i].end);
  }
  EXPECT_EQ(scan.hits(), hits);
  EXPECT_EQ(scan.hitCount(), hits.size());
  EXPECT_EQ(CompactScan(decoded), scan) << "a scan that was rounded once is kept exactly";
  EXPECT_EQ(CompactScan::fromBytes(scan.bytes()), scan);
}

/// Rays in no order, with any flags.
std::vector<PlanarRay> randomRays(std::mt19937& random, std::size_t count, float size_m) {
  std::uniform_real_distribution<float> position(-size_m, size_m);
  std::uniform_int_distribution<int> flags(0, 15);
  std::vector<PlanarRay> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const int kind = flags(random);
    PlanarRay ray{{position(random), position(random)},
                  {position(random), position(random)},
                  (kind & 1) != 0};
    ray.known = (kind & 2) != 0;
    ray.no_return = (kind & 4) != 0;
    ray.presumed = (kind & 8) != 0;
    rays.push_back(ray);
  }
  return rays;
}

TEST(CompactScan, KeepsAnyRays) {
  std::mt19937 random(5);
  for (const std::size_t count : {0U, 1U, 2U, 3U, 63U, 500U}) {
    for (const float size_m : {0.001F, 0.1F, 5.0F, 65.0F, 9000.0F}) {
      expectRoundTrip(randomRays(random, count, size_m));
    }
  }
}

TEST(CompactScan, KeepsTheScansOfAllLasers) {
  for (const LaserScans& laser : scansOfLasers()) {
    SCOPED_TRACE(laser.name);
    for (const PlanarScan& scan : laser.scans) expectRoundTrip(scan.rays);
  }
}

TEST(CompactScan, NeedsAtMostFourBytesABeam) {
  for (const LaserScans& laser : scansOfLasers()) {
    double bytes = 0.0;
    for (const PlanarScan& scan : laser.scans) {
      bytes += static_cast<double>(CompactScan(scan.rays).memoryBytes());
    }
    const double per_beam = bytes / static_cast<double>(laser.scans.size() * laser.beams);
    std::printf("%-41s %4zu beams: %.2f bytes a beam\n", laser.name.c_str(), laser.beams, per_beam);
    EXPECT_LE(per_beam, 4.0) << laser.name;
  }
}

TEST(CompactScan, HasTheSameBytesOnEveryMachine) {
  std::vector<PlanarRay> rays;
  rays.push_back({{0.0F, 0.0F}, {1.0F, -0.5F}, true});
  rays.push_back({{0.0F, 0.0F}, {1.001F, 0.25F}, true});
  rays.push_back({{0.5F, 0.0F}, {0.0F, 0.0F}, false});
  const std::string expected(
      "\x03"               // rays
      "\x11\x02\x00\x01"   // two hits, one clear
      "\x80\x08\xFF\x03"   // 512, -256
      "\x02\x80\x06"       // +1, +384
      "\x00\x00"           // the first clear
      "\x02\x00\x00"       // two rays from the origin
      "\x01\x80\x04\x00",  // one from 256, 0
      21);
  EXPECT_EQ(CompactScan(rays).bytes(), expected);
}

TEST(CompactScan, LeavesOutRaysThatNoMapCanHold) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  std::vector<PlanarRay> rays;
  for (const float bad : {kNan, kInf, -kInf, 1e30F, 16385.0F}) {
    rays.push_back({{0.0F, 0.0F}, {bad, 0.0F}, true});
    rays.push_back({{0.0F, bad}, {1.0F, 0.0F}, false});
  }
  EXPECT_EQ(CompactScan(rays), CompactScan());
  const PlanarRay far{{-16384.0F, 16384.0F}, {16384.0F, -16384.0F}, true};
  rays.push_back(far);
  expectRoundTrip({far, {-far.origin, -far.end, true}});
  EXPECT_EQ(CompactScan(rays).rayCount(), 1U);
}

TEST(CompactScan, IsEmptyByDefault) {
  EXPECT_EQ(CompactScan(), CompactScan(std::vector<PlanarRay>()));
  EXPECT_TRUE(CompactScan().rays().empty());
  EXPECT_TRUE(CompactScan().hits().empty());
}

/// The reason why the bytes are refused; empty if they are a scan, which is then used.
std::string reasonOf(const std::string& bytes) {
  try {
    const CompactScan scan = CompactScan::fromBytes(bytes);
    EXPECT_EQ(scan.rays().size(), scan.rayCount());
    EXPECT_EQ(scan.hits().size(), scan.hitCount());
    return "";
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

TEST(CompactScan, RefusesDamagedBytesWithAReason) {
  EXPECT_EQ(reasonOf(""), "it ends too early");
  EXPECT_EQ(reasonOf("\xFF\xFF\xFF\xFF\x0F"), "it has fewer rays than it says");
  EXPECT_EQ(reasonOf("\xFF\xFF\xFF\xFF\x1F"), "a number is too large");
  EXPECT_EQ(reasonOf(std::string("\x01\x11\x00\x00\x00\x00\x00\x00", 8)),
            "a run has a wrong length");
  EXPECT_EQ(reasonOf(std::string("\x01\x11\x02\x00\x00\x00\x00\x00", 8)),
            "a run has a wrong length");
  EXPECT_EQ(reasonOf(std::string("\x01\xFF\x02\x01\x00\x00\x01\x00\x00", 9)),
            "a ray has an unknown kind");
  EXPECT_EQ(reasonOf(std::string("\x01\x11\x01\xFE\xFF\xFF\xFF\x0F\x00\x01\x00\x00", 12)),
            "a position is too far away");
  EXPECT_EQ(reasonOf(CompactScan().bytes() + "x"), "bytes follow its last ray");
}

TEST(CompactScan, AnyDamageGivesAScanOrAReason) {
  const std::string bytes = CompactScan(room::scanFrom(Pose2(0.5, 0.2, 0.1)).rays).bytes();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    EXPECT_NE(reasonOf(bytes.substr(0, i)), "");
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = bytes;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      reasonOf(damaged);
    }
  }
}

}  // namespace
}  // namespace kestrel
