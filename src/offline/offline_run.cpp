// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/offline_run.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/sensor/attitude_tracker.h"
#include "kestrel_slam/sensor/height_tracker.h"
#include "kestrel_slam/sensor/scan_projector.h"

namespace kestrel_slam {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kKilobytesPerMegabyte = 1024.0;
constexpr double kMillisecondsPerSecond = 1e3;
// The path is measured in steps of this length, so that the jitter of a vehicle that stands still
// does not count.
constexpr double kDistanceStep_m = 0.1;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// VmHWM rather than getrusage, whose figure may be that of the parent before it started us.
double peakMemoryMb() {
  std::ifstream status("/proc/self/status");
  for (std::string key; status >> key;) {
    double kilobytes = 0.0;
    if (key == "VmHWM:" && status >> kilobytes) return kilobytes / kKilobytesPerMegabyte;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / kKilobytesPerMegabyte;
}

/// The place of a scan in the recording, for warnings.
std::string placeText(double recorded_s, std::size_t number) {
  std::ostringstream text;
  text.precision(1);
  text << std::fixed << "at " << recorded_s << " s (scan " << number << ")";
  return text.str();
}

/// Counts scans of one kind and remembers the first.
struct Occurrence {
  std::size_t count = 0;
  std::string first;

  void add(const std::string& place) {
    if (count++ == 0) first = place;
  }
};

HeightConfig heightConfig(const ProjectorConfig& projector) {
  HeightConfig config;
  config.fixed_m = projector.height_m;
  return config;
}

class Runner {
 public:
  Runner(Recording& recording, const SlamConfig& config, const RunOptions& options)
      : recording_(recording),
        projector_(config.projector),
        attitude_(config.attitude),
        height_(heightConfig(config.projector)),
        mapper_(config.mapper),
        memory_limit_mb_(config.mapper.grid.memory_limit_mb),
        options_(options),
        use_imu_(options.use_imu && !recording.imu().samples.empty()) {}

  OfflineRun run(const ProgressCallback& progress) {
    const Clock::time_point start = Clock::now();
    RecordedScan scan;
    const std::size_t total = std::min(options_.max_scans, recording_.scanCount());
    while (read_ < options_.max_scans && readNext(scan)) {
      ++read_;
      if (!first_time_) first_time_ = scan.time;
      run_.duration_s = scan.time - *first_time_;
      if (perturb(options_.perturbation, read_, scan)) {
        processScan(scan);
      } else {
        ++run_.left_out;
      }
      if (progress && !progress({read_, total, run_.duration_s})) {
        run_.warnings.push_back("stopped early, after " + std::to_string(read_) + " of " +
                                std::to_string(total) + " scans");
        break;
      }
    }
    run_.processing_s = secondsSince(start);
    finish();
    return std::move(run_);
  }

 private:
  /// False at the end, and where the recording breaks off.
  bool readNext(RecordedScan& scan) {
    try {
      return recording_.next(scan);
    } catch (const std::exception& error) {
      run_.warnings.push_back("the recording breaks off after " + std::to_string(read_) +
                              " scans: " + error.what());
      return false;
    }
  }

  void processScan(const RecordedScan& scan) {
    const Clock::time_point start = Clock::now();
    Projection projection = project(scan);
    if (projection.error != ScanError::kNone) {
      drop(projection);
      return;
    }
    projection.scan.time = scan.time;
    const MapperResult result =
        mapper_.process(projection.scan, options_.use_odometry ? scan.odom_T_base : std::nullopt);
    velocity_ = result.velocity;
    record(scan, result, kMillisecondsPerSecond * secondsSince(start));
    if (options_.observer) options_.observer(projection.scan, result);
  }

  Projection project(const RecordedScan& scan) {
    VehicleState vehicle;
    if (use_imu_) {
      const double end = (scan.cloud ? sweepTimes(*scan.cloud) : sweepTimes(scan.scan)).last;
      readImuUpTo(end);
      readHeightsUpTo(end);
      vehicle.attitude = &attitude_.buffer();
      vehicle.velocity = velocity_;
      vehicle.height_m = height_.height(scan.scan.stamp);
    }
    const Eigen::Isometry3d mounting = options_.base_T_laser.value_or(scan.base_T_laser);
    const Projection projection = scan.cloud ? projector_.project(*scan.cloud, mounting, vehicle)
                                             : projector_.project(scan.scan, mounting, vehicle);
    height_.addProjection(scan.scan.stamp, projection);
    return projection;
  }

  /// One reading beyond `time`, so that the attitude at `time` is known; like a live projector,
  /// which waits for it.
  void readImuUpTo(double time) {
    const RecordedImu& imu = recording_.imu();
    const Eigen::Quaterniond base_R_imu(imu.base_T_imu.linear());
    while (next_imu_ < imu.samples.size()) {
      const std::optional<double> latest = attitude_.buffer().latest();
      if (latest && *latest >= time) return;
      attitude_.add(imu.samples[next_imu_++], base_R_imu);
    }
  }

  void readHeightsUpTo(double time) {
    const std::vector<HeightSample>& heights = recording_.heights();
    for (; next_height_ < heights.size() && heights[next_height_].stamp <= time; ++next_height_) {
      height_.addRange(heights[next_height_], &attitude_.buffer());
    }
  }

  void drop(const Projection& projection) {
    const std::string reason = toString(projection.error);
    if (run_.dropped[reason]++ == 0) {
      run_.warnings.push_back("scans dropped (" + reason + "), the first " + place() + ": " +
                              projection.message);
    }
  }

  void record(const RecordedScan& scan, const MapperResult& result, double ms) {
    ScanRecord entry;
    entry.time = scan.time;
    entry.state = result.state;
    entry.score = result.match.score;
    entry.evaluation = result.evaluation;
    entry.ms = ms;
    entry.iterations = result.match.iterations;
    entry.searched = result.searched;
    entry.inserted = result.inserted;
    entry.map_bytes = mapper_.memoryBytes();
    entry.degenerate = result.match.degenerate;
    entry.uncertain = result.uncertain;
    run_.scans.push_back(entry);
    run_.trajectory.push_back({scan.scan.stamp, result.pose});
    addDistance(result.pose);
    if (result.state == MatchState::kLost) lost_.add(place());
    if (result.map_full) full_.add(place());
    if (options_.use_odometry && !scan.odom_T_base) without_odometry_.add(place());
  }

  void addDistance(const Pose2& pose) {
    if (!last_counted_) last_counted_ = pose;
    const double step = (last_counted_->inverse() * pose).distance();
    if (step < kDistanceStep_m) return;
    run_.distance_m += step;
    last_counted_ = pose;
  }

  std::string place() const { return placeText(run_.duration_s, read_); }

  void warn(const Occurrence& occurrence, const std::string& what, const std::string& advice) {
    if (occurrence.count == 0) return;
    run_.warnings.push_back(std::to_string(occurrence.count) + " of " +
                            std::to_string(run_.scans.size()) + " scans " + what + ", the first " +
                            occurrence.first + (advice.empty() ? "" : "; " + advice));
  }

  void finish() {
    for (const auto& [reason, count] : recording_.skipped()) run_.dropped[reason] += count;
    const auto& read_warnings = recording_.warnings();
    run_.warnings.insert(run_.warnings.begin(), read_warnings.begin(), read_warnings.end());
    warn(lost_, "fitted nowhere and did not enter the map", "");
    std::ostringstream limit;
    limit << memory_limit_mb_;
    warn(full_, "met a full map, parts of them are missing in it",
         "the memory limit is " + limit.str() + " MB");
    warn(without_odometry_, "had no odometry and used the laser alone", "");
    run_.map = mapper_.snapshot();
    run_.map_memory_bytes = mapper_.memoryBytes();
    run_.peak_memory_mb = peakMemoryMb();
  }

  Recording& recording_;
  ScanProjector projector_;
  AttitudeTracker attitude_;
  HeightTracker height_;
  Mapper mapper_;
  double memory_limit_mb_;
  RunOptions options_;
  bool use_imu_;
  std::size_t next_imu_ = 0, next_height_ = 0;
  Eigen::Vector2d velocity_ = Eigen::Vector2d::Zero();  ///< in base_stabilized, of the last scan

  OfflineRun run_;
  std::size_t read_ = 0;
  std::optional<double> first_time_;
  std::optional<Pose2> last_counted_;
  Occurrence lost_, full_, without_odometry_;
};

}  // namespace

std::size_t OfflineRun::droppedCount() const {
  std::size_t count = 0;
  for (const auto& entry : dropped) count += entry.second;
  return count;
}

double OfflineRun::speedFactor() const {
  return processing_s > 0.0 ? duration_s / processing_s : 0.0;
}

OfflineRun runOffline(Recording& recording, const SlamConfig& config, const RunOptions& options,
                      const ProgressCallback& progress) {
  return Runner(recording, config, options).run(progress);
}

}  // namespace kestrel_slam
