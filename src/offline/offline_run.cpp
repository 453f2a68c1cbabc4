// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/offline/offline_run.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "kestrel_slam/graph/scan_poses.h"
#include "kestrel_slam/graph/submap_graph.h"
#include "kestrel_slam/offline/arrival_order.h"
#include "kestrel_slam/offline/polish.h"
#include "kestrel_slam/offline/saved_session.h"
#include "kestrel_slam/session/graph_session.h"
#include "peak_memory.h"
#include "report_samples.h"
#include "stage_clock.h"

namespace kestrel {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kMillisecondsPerSecond = 1e3;
// The path length is measured in steps of this length. So the pose noise of a stationary vehicle is
// not counted.
constexpr double kDistanceStep_m = 0.1;

double secondsSince(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Describes the position of a scan in the recording, for warnings.
std::string placeText(double recorded_s, std::size_t number) {
  std::ostringstream text;
  text.precision(1);
  text << std::fixed << "at " << recorded_s << " s (scan " << number << ")";
  return text.str();
}

/// Counts scans with one kind of problem and stores the position of the first.
struct Occurrence {
  std::size_t count = 0;
  std::string first;

  void add(const std::string& place) {
    if (count++ == 0) first = place;
  }
};

/// A problem of scans that were used all the same.
struct Doubt {
  Occurrence scans;
  std::string text;  ///< of the first
};

/// Longer than the limit of a live projector, because a recording has no real-time limit.
constexpr double kMaxWait_s = 1.0;
constexpr std::size_t kQueueSize = 200;

PipelineConfig pipelineConfigOf(const Recording& recording, const SlamConfig& config,
                                const RunOptions& options) {
  PipelineConfig result;
  result.slam = config;
  result.filter = options.filter;
  result.use_filter = options.use_filter;
  result.coupling = options.coupling;
  result.level = !options.use_imu || recording.imu().samples.empty();
  result.max_wait_s = kMaxWait_s;
  result.queue_size = kQueueSize;
  return result;
}

class Runner {
 public:
  Runner(Recording& recording, const SlamConfig& config, const RunOptions& options)
      : recording_(recording),
        config_(pipelineConfigOf(recording, config, options)),
        messages_(recording, !config_.level),
        pipeline_(config_),
        options_(options),
        odometry_(options.perturbation.odometry),
        polish_(config.mapper) {
    pipeline_.on_scan = [this](const MappedSweep& sweep) { record(sweep); };
    pipeline_.on_drop = [this](const DroppedSweep& sweep) { drop(sweep); };
    if (options_.localize_in) localize();
    pipeline_.on_filter = options_.filter_observer;
    pipeline_.on_stage = [this](PipelineStage stage) { stages_.begin(stage); };
    if (options_.session) {
      const double resolution_m = config.mapper.grid.resolution_m;
      pipeline_.continueWith(graphRecordOf(*options_.session, resolution_m), options_.start);
    }
    pipeline_.on_problem = [this](const ImuFault& problem, double time) { warn(problem, time); };
  }

  OfflineRun run(const ProgressCallback& progress) {
    const Clock::time_point start = Clock::now();
    const std::size_t total = std::min(options_.max_scans, recording_.scanCount());
    bool stopped = false;
    ArrivingMessage message;
    while (readNext(message)) {
      const auto* scan = std::get_if<RecordedScan>(&message.message);
      if (scan != nullptr && read_ == options_.max_scans) break;
      add(message);
      if (scan == nullptr || !progress || progress({read_, total, run_.duration_s})) continue;
      run_.warnings.push_back("stopped early, after " + std::to_string(read_) + " of " +
                              std::to_string(total) + " scans");
      stopped = true;
      break;
    }
    if (!stopped) pipeline_.finish();
    run_.processing_s = secondsSince(start);
    finish();
    return std::move(run_);
  }

 private:
  void localize() {
    pipeline_.localizeIn(std::move(*options_.localize_in));
    if (options_.start) pipeline_.setPose(options_.start->mean, options_.start->covariance);
  }

  /// Returns false at the end of the recording and after a read error.
  bool readNext(ArrivingMessage& message) {
    try {
      return messages_.next(message);
    } catch (const std::exception& error) {
      run_.warnings.push_back("the recording ends with an error after " + std::to_string(read_) +
                              " scans: " + error.what());
      return false;
    }
  }

  void add(ArrivingMessage& message) {
    if (auto* scan = std::get_if<RecordedScan>(&message.message)) {
      addScan(*scan, message.arrival);
      return;
    }
    const Clock::time_point start = work_start_ = Clock::now();
    stages_.resume();
    if (const auto* sample = std::get_if<ImuSample>(&message.message)) {
      pipeline_.addImu(*sample, recording_.imu().base_T_imu, message.arrival);
    } else {
      pipeline_.addRange(std::get<HeightSample>(message.message), message.arrival);
    }
    if (work_start_ == start) work_s_ += secondsSince(start);
    stages_.begin(PipelineStage::kFilter);
  }

  void addScan(RecordedScan& scan, double arrival) {
    ++read_;
    if (!first_time_) first_time_ = scan.time;
    if (!first_stamp_) first_stamp_ = arrival;
    run_.duration_s = scan.time - *first_time_;
    if (!options_.odometry.empty()) scan.odom_T_base = poseAt(options_.odometry, scan.scan.stamp);
    if (scan.odom_T_base) scan.odom_T_base = odometry_.next(*scan.odom_T_base);
    if (!perturb(options_.perturbation, read_, scan)) {
      ++run_.left_out;
      return;
    }
    PipelineScan input;
    if (scan.cloud) {
      input.data = std::move(*scan.cloud);
    } else {
      input.data = std::move(scan.scan);
    }
    input.base_T_laser = options_.base_T_laser.value_or(scan.base_T_laser);
    if (options_.use_odometry) input.odom_T_base = scan.odom_T_base;
    input.time = scan.time;
    input.number = read_;
    work_start_ = Clock::now();
    stages_.resume();
    pipeline_.addScan(std::move(input), arrival);
  }

  void drop(const DroppedSweep& sweep) {
    if (run_.dropped[sweep.reason]++ > 0) return;
    run_.drop_messages[sweep.reason] = sweep.message;
    run_.warnings.push_back("scans dropped (" + sweep.reason + "), the first " +
                            placeOf(sweep.input) + ": " + sweep.message);
  }

  void noteWarnings(const MappedSweep& sweep) {
    for (const ScanWarning& warning : sweep.projected.projection.warnings) {
      Doubt& doubt = doubts_[warning.kind];
      if (doubt.scans.count == 0) doubt.text = warning.text;
      doubt.scans.add(placeOf(sweep.input));
    }
  }

  void warn(const ImuFault& problem, double time) {
    std::ostringstream place;
    place.precision(1);
    place << std::fixed << " (noticed after " << time - first_stamp_.value_or(time) << " s)";
    run_.warnings.push_back(problem.message + place.str());
    says_filter_ |= problem.reason == kFilterRefusesImu;
  }

  /// Processing time of projector, filter and mapper since the previous scan, ms.
  double takeWork() {
    const double ms = kMillisecondsPerSecond * (work_s_ + secondsSince(work_start_));
    work_s_ = 0.0;
    work_start_ = Clock::now();
    return ms;
  }

  void record(const MappedSweep& sweep) {
    const MapperResult& result = sweep.result;
    ScanRecord entry;
    entry.ms = takeWork();
    entry.stage_ms = stages_.take();
    entry.time = sweep.scan.time;
    entry.state = result.state;
    entry.score = result.match.score;
    entry.evaluation = result.evaluation;
    entry.iterations = result.match.iterations;
    entry.searched = result.searched;
    entry.inserted = result.inserted;
    entry.map_bytes = pipeline_.mapper().memoryBytes();
    entry.degenerate = result.match.degenerate;
    entry.uncertain = result.uncertain;
    entry.known = result.match.known;
    entry.constraint = result.match.constraint;
    if (result.match.degenerate || result.match.mostly_predicted || result.match.unclear_along)
      entry.degenerate_direction = result.match.degenerate_direction;
    entry.carried = result.carried;
    entry.ambiguous = result.match.ambiguous;
    entry.reason = result.reason;
    entry.odom_T_base = sweep.input.odom_T_base;
    entry.filter = sampleOf(pipeline_.filter().output());
    entry.tracker = sampleOf(sweep.moving);
    run_.scans.push_back(entry);
    run_.trajectory.push_back({sweep.scan.stamp, result.pose});
    if (const SubmapGraph* graph = pipeline_.graph())
      tracked_.push_back(trackedScan(result, graph->keyframes().size()));
    if (options_.polish) polish_.keep(sweep.scan);
    addDistance(result.pose);
    const std::string place = placeOf(sweep.input);
    if (result.reason == kPlaceUnknown) {
      unlocated_.add(place);
    } else if (result.state == MatchState::kLost) {
      lost_.add(place);
    }
    if (result.map_full) full_.add(place);
    if (options_.use_odometry && !sweep.input.odom_T_base) without_odometry_.add(place);
    noteWarnings(sweep);
    if (options_.observer) options_.observer(sweep.scan, result);
    if (options_.sweep_observer) options_.sweep_observer(sweep);
    stages_.resume();
  }

  void addDistance(const Pose2& pose) {
    if (!last_counted_) last_counted_ = pose;
    const double step = (last_counted_->inverse() * pose).distance();
    if (step < kDistanceStep_m) return;
    run_.distance_m += step;
    last_counted_ = pose;
  }

  /// Corrects the poses and the map by the loops that were found.
  void correct(SubmapGraph& graph) {
    graph.finish();
    run_.graph = resultOf(graph, run_.trajectory);
    run_.trajectory = corrected(run_.trajectory, tracked_, graph);
    if (options_.polish) run_.trajectory = polish_.polished(run_.trajectory, graph);
    for (std::size_t i = 0; i < run_.scans.size(); ++i)
      run_.scans[i].uncertain = placedAt(run_.trajectory[i].pose, run_.scans[i].uncertain);
    run_.map = options_.polish ? mapAlong(run_.trajectory, graph, config_.slam.mapper.grid)
                               : mapOf(graph, config_.slam.mapper.grid);
    run_.session = savedSession(graph, config_.slam, options_.session.get(), run_);
    for (const std::string& warning : partWarnings(graph)) run_.warnings.push_back(warning);
  }

  void finishFilter() {
    run_.filter = pipeline_.filter().status(recording_.imu().samples.back().stamp);
    if (pipeline_.filter().output() || says_filter_) return;
    run_.warnings.push_back("the pose filter does not run: " + run_.filter->message);
  }

  std::string placeOf(const PipelineScan& scan) const {
    return placeText(scan.time.value_or(0.0) - first_time_.value_or(0.0), scan.number);
  }

  void warn(const Occurrence& occurrence, const std::string& what, const std::string& advice) {
    if (occurrence.count == 0) return;
    run_.warnings.push_back(std::to_string(occurrence.count) + " of " +
                            std::to_string(run_.scans.size()) + " scans " + what + ", the first " +
                            occurrence.first + (advice.empty() ? "" : "; " + advice));
  }

  void finish() {
    for (const auto& [reason, count] : recording_.skipped()) {
      run_.dropped[reason] += count;
      const std::string message = recording_.warningOf(reason);
      if (!message.empty()) run_.drop_messages.emplace(reason, message);
    }
    const auto& read_warnings = recording_.warnings();
    run_.warnings.insert(run_.warnings.begin(), read_warnings.begin(), read_warnings.end());
    for (const auto& [kind, doubt] : doubts_) {
      run_.warnings.push_back(std::to_string(doubt.scans.count) + " of " +
                              std::to_string(run_.scans.size()) + " scans (" + kind +
                              "), the first " + doubt.scans.first + ": " + doubt.text);
    }
    warn(lost_, "did not match the map and were not inserted", "");
    warn(unlocated_, "came when the vehicle was in a new map whose place was unknown", "");
    std::ostringstream limit;
    limit << config_.slam.mapper.grid.memory_limit_mb;
    warn(full_, "came after the map was full, so that it is not complete",
         "the memory limit is " + limit.str() + " MB; raise map_memory_limit_mb or map_resolution");
    const bool known = config_.slam.mapper.known_poses;
    warn(without_odometry_,
         known ? "had no known pose" : "had no odometry and were matched with the laser only", "");
    run_.map = pipeline_.mapper().snapshot();
    if (SubmapGraph* graph = pipeline_.graph()) correct(*graph);
    run_.map_memory_bytes = pipeline_.mapper().memoryBytes();
    run_.peak_memory_mb = peakMemoryMb();
    if (config_.use_filter && !config_.level) finishFilter();
  }

  Recording& recording_;
  PipelineConfig config_;
  ArrivalOrder messages_;
  Pipeline pipeline_;
  RunOptions options_;
  OdometryDistortion odometry_;
  Polish polish_;
  StageClock stages_;
  Clock::time_point work_start_;  ///< start time of the current pipeline call
  double work_s_ = 0.0;           ///< time in earlier calls since the last scan

  OfflineRun run_;
  std::vector<TrackedScan> tracked_;
  std::size_t read_ = 0;
  std::optional<double> first_time_;
  std::optional<double> first_stamp_;  ///< arrival of the first scan, s
  std::optional<Pose2> last_counted_;
  Occurrence lost_, unlocated_, full_, without_odometry_;
  std::map<std::string, Doubt> doubts_;  ///< by kind
  bool says_filter_ = false;             ///< a warning says why the filter does not run
};

}  // namespace

OfflineRun runOffline(Recording& recording, const SlamConfig& config, const RunOptions& options,
                      const ProgressCallback& progress) {
  return Runner(recording, config, options).run(progress);
}

}  // namespace kestrel
