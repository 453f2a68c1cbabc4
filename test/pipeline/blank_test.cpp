// SPDX-License-Identifier: BSD-3-Clause
// Flights in which the laser sees nothing for some time.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <vector>

#include "kestrel_slam/pipeline/pipeline.h"
#include "room.h"

namespace kestrel {
namespace {

constexpr double kScanStep = 0.1, kImuStep = 0.01;  // s
constexpr double kBeforeBlank = 4.0, kAfterBlank = 2.0;
constexpr int kBlankBeams = 180;
constexpr double kGravity = 9.81;
/// A pose is right within these, besides three standard deviations.
constexpr double kRightM = 0.1, kRightRad = 0.05;

/// A room of 12 m × 9 m in which every view is unique.
std::vector<room::Segment> uniqueRoom() {
  return {{-6, -4.5, 6, -4.5}, {6, -4.5, 6, 4.5},  {6, 4.5, -6, 4.5},  {-6, 4.5, -6, -4.5},
          {3.5, 2.5, 5, 2.5},  {5, 2.5, 5, 3.5},   {5, 3.5, 3.5, 3.5}, {3.5, 3.5, 3.5, 2.5},
          {-6, 1, -4, 1},      {-1, -4.5, -1, -3}, {2, -4.5, 3, -3.5}};
}

/// A square room: it looks the same after a rotation by 90 degrees.
std::vector<room::Segment> squareRoom() {
  return {{-4, -4, 4, -4}, {4, -4, 4, 4}, {4, 4, -4, 4}, {-4, 4, -4, -4}};
}

/// A smooth random motion around the middle of the room: about 1 m/s, with turns of up to 1.5
/// rad/s.
class Motion {
 public:
  explicit Motion(std::mt19937& random) {
    std::uniform_real_distribution<double> phase(-kPi, kPi), rate(0.4, 0.9), turn(-1.5, 1.5);
    for (double* value : {&phase_x_, &phase_y_, &phase_yaw_}) *value = phase(random);
    for (double* value : {&rate_x_, &rate_y_, &rate_yaw_}) *value = rate(random);
    turn_ = turn(random);
  }

  Pose2 at(double t) const {
    return {1.2 * std::sin(rate_x_ * t + phase_x_), 1.2 * std::sin(rate_y_ * t + phase_y_),
            turn_ / rate_yaw_ * std::sin(rate_yaw_ * t + phase_yaw_)};
  }
  double yawRate(double t) const { return turn_ * std::cos(rate_yaw_ * t + phase_yaw_); }
  Eigen::Vector2d acceleration(double t) const {
    const Pose2 p = at(t);
    return {-rate_x_ * rate_x_ * p.x, -rate_y_ * rate_y_ * p.y};
  }

 private:
  double phase_x_, phase_y_, phase_yaw_, rate_x_, rate_y_, rate_yaw_, turn_;
};

enum class Blank { kNoHits, kNoScans, kNothing };  ///< kNothing: no IMU either

struct Setting {
  unsigned seed = 1;
  bool imu = false, filter = false;
  Blank blank = Blank::kNoHits;
  double blank_s = 1.0;
  bool square = false;
  int dust = 0;  ///< hits in each blank scan
};

struct Outcome {
  double worst_sigmas = 0.0;   ///< largest error of a component, in standard deviations
  double worst_matched = 0.0;  ///< the same for the scans after the blank that are not lost
  bool right_or_lost = true;   ///< all poses after the blank
  bool lost_at_end = false;
  bool right_at_end = false;
};

class BlankFlight {
 public:
  explicit BlankFlight(const Setting& setting)
      : setting_(setting),
        random_(setting.seed),
        motion_(random_),
        walls_(setting.square ? squareRoom() : uniqueRoom()),
        pipeline_(configOf(setting)) {
    pipeline_.on_scan = [this](const MappedSweep& sweep) { judge(sweep); };
    pipeline_.reset(motion_.at(0.0));
  }

  Outcome fly() {
    const double end = kBeforeBlank + setting_.blank_s + kAfterBlank;
    int scans = 0;
    for (int i = 0; i * kImuStep < end; ++i) {
      const double t = i * kImuStep;
      const bool is_silent = setting_.blank == Blank::kNothing && isBlank(t);
      if (setting_.imu && !is_silent) addImu(t);
      if (t >= scans * kScanStep) addScan(scans++ * kScanStep);
    }
    pipeline_.finish();
    return outcome_;
  }

 private:
  static PipelineConfig configOf(const Setting& setting) {
    PipelineConfig config;
    config.level = !setting.imu;
    config.use_filter = setting.filter;
    return config;
  }

  bool isBlank(double t) const { return t >= kBeforeBlank && t < kBeforeBlank + setting_.blank_s; }

  void addImu(double t) {
    std::normal_distribution<double> noise(0.0, 1.0);
    const Eigen::Vector2d a = Eigen::Rotation2Dd(-motion_.at(t).yaw) * motion_.acceleration(t);
    ImuSample sample;
    sample.stamp = t;
    sample.world_R_imu = Eigen::AngleAxisd(motion_.at(t).yaw, Eigen::Vector3d::UnitZ());
    sample.angular_velocity =
        Eigen::Vector3d(0, 0, motion_.yawRate(t) + 0.003) +
        0.01 * Eigen::Vector3d(noise(random_), noise(random_), noise(random_));
    sample.linear_acceleration =
        Eigen::Vector3d(a.x(), a.y(), kGravity) +
        0.02 * Eigen::Vector3d(noise(random_), noise(random_), noise(random_));
    pipeline_.addImu(sample, Eigen::Isometry3d::Identity(), t);
  }

  void addScan(double t) {
    if (isBlank(t) && setting_.blank != Blank::kNoHits) return;
    std::normal_distribution<double> noise(0.0, 0.01);
    LaserScan scan;
    scan.stamp = t;
    scan.angle_min = -kPi;
    scan.angle_increment = 2.0 * kPi / kBlankBeams;
    scan.range_min = 0.05, scan.range_max = 20.0;
    for (int i = 0; i < kBlankBeams; ++i) {
      const double angle = scan.angle_min + i * scan.angle_increment;
      const double range = room::cast(walls_, motion_.at(t), angle) + noise(random_);
      scan.ranges.push_back(isBlank(t) ? std::numeric_limits<float>::infinity()
                                       : static_cast<float>(range));
    }
    for (int i = 0; isBlank(t) && i < setting_.dust; ++i) {
      scan.ranges[random_() % kBlankBeams] = 0.3F + 0.001F * static_cast<float>(random_() % 3000);
    }
    PipelineScan input;
    input.data = scan;
    pipeline_.addScan(input, t);
  }

  void judge(const MappedSweep& sweep) {
    const double t = stampOf(sweep.input.data);
    if (t < kBeforeBlank) return;
    const MapperResult& result = sweep.result;
    const Eigen::Vector3d error = offsetOf(result.pose, motion_.at(t));
    const Eigen::Vector3d sigmas = result.covariance.diagonal().cwiseSqrt();
    const double worst = error.cwiseAbs().cwiseQuotient(sigmas).maxCoeff();
    outcome_.worst_sigmas = std::max(outcome_.worst_sigmas, worst);
    if (isBlank(t)) return;
    const bool lost = result.state == MatchState::kLost;
    const bool right = error.head<2>().norm() < kRightM && std::abs(error.z()) < kRightRad;
    outcome_.right_or_lost &= right || lost;
    outcome_.lost_at_end = lost;
    outcome_.right_at_end = right && !lost;
  }

  static Eigen::Vector3d offsetOf(const Pose2& pose, const Pose2& truth) {
    return {pose.x - truth.x, pose.y - truth.y, normalizeAngle(pose.yaw - truth.yaw)};
  }

  Setting setting_;
  std::mt19937 random_;
  Motion motion_;
  std::vector<room::Segment> walls_;
  Pipeline pipeline_;
  Outcome outcome_;
};

Outcome fly(const Setting& setting) { return BlankFlight(setting).fly(); }

TEST(MapperBlank, ForAThousandRandomFlightsTheTruthIsWithinThreeSigmas) {
  constexpr std::array<const char*, 3> names = {"no hits", "no scans", "no data"};
  int outside = 0, wrong = 0, lost = 0;
  for (unsigned seed = 1; seed <= 1000; ++seed) {
    std::mt19937 random(seed + 5000);
    Setting setting;
    setting.seed = seed;
    setting.imu = seed % 3 != 0;
    setting.filter = seed % 3 == 1;
    setting.blank = static_cast<Blank>(seed / 3 % 3);
    setting.square = seed % 5 == 0;
    setting.dust = seed % 7 < 2 ? 8 : 0;
    setting.blank_s = std::uniform_real_distribution<double>(0.1, 5.0)(random);
    const Outcome outcome = fly(setting);
    outside += outcome.worst_sigmas > 3.0 ? 1 : 0;
    lost += outcome.lost_at_end ? 1 : 0;
    if (outcome.right_or_lost) continue;
    ++wrong;
    std::printf("wrong: seed %u, IMU %d, filter %d, %s for %.2f s, square %d\n", seed, setting.imu,
                setting.filter, names[seed / 3 % 3], setting.blank_s, setting.square);
  }
  std::printf("of 1000 flights: %d beyond 3 sigmas, %d wrong, %d lost at the end\n", outside, wrong,
              lost);
  EXPECT_LE(outside, 10);
  EXPECT_LE(wrong, 3);
  EXPECT_LE(lost, 1000 / 8);  // in the square room, without data of an IMU
}

TEST(MapperBlank, EveryLengthEndsRightWithAndWithoutImu) {
  for (const double seconds : {0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0}) {
    for (const bool imu : {false, true}) {
      for (const Blank blank : {Blank::kNoHits, Blank::kNoScans}) {
        Setting setting;
        setting.seed = 3;
        setting.imu = imu;
        setting.blank = blank;
        setting.blank_s = seconds;
        const Outcome outcome = fly(setting);
        EXPECT_LT(outcome.worst_sigmas, 3.0) << seconds << " s, IMU " << imu;
        EXPECT_TRUE(outcome.right_or_lost && outcome.right_at_end) << seconds << " s, IMU " << imu;
      }
    }
  }
}

TEST(MapperBlank, InARoomThatLooksTheSameAfterATurnTheGyroFindsThePose) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Setting setting;
    setting.seed = seed;
    setting.imu = setting.square = true;
    setting.blank_s = 3.0;
    const Outcome outcome = fly(setting);
    EXPECT_TRUE(outcome.right_or_lost && outcome.right_at_end) << seed;
    setting.imu = false;
    EXPECT_TRUE(fly(setting).lost_at_end) << seed << ": four poses fit, so it must stay lost";
  }
}

TEST(MapperBlank, ThePoseFilterDoesNotGetPredictedPoses) {
  MapperResult result;
  result.state = MatchState::kDegraded;
  result.carried = true;
  EXPECT_EQ(matchedPoseOf(result, 0.0).state, MatchState::kLost);
  PoseFilter filter;
  EXPECT_FALSE(fuse(matchedPoseOf(result, 0.0), filter));
}

}  // namespace
}  // namespace kestrel
