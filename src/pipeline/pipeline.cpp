// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/pipeline/pipeline.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "kestrel_slam/graph/submap_graph.h"

namespace kestrel {
namespace {

ProjectionStageConfig projectionConfigOf(const PipelineConfig& config) {
  return {config.slam.projector, config.slam.attitude, config.level, config.level_without_imu,
          config.max_wait_s};
}

}  // namespace

const char* toString(PipelineStage stage) {
  constexpr const char* kNames[kPipelineStages] = {"filter", "projection", "matching", "graph"};
  return kNames[static_cast<std::size_t>(stage)];
}

Pipeline::Pipeline(const PipelineConfig& config)
    : config_(config),
      projection_(projectionConfigOf(config)),
      filter_(config.filter),
      mapping_(config.slam.mapper, config.slam.tracker),
      queue_(config.queue_size) {
  startGraph();
}

void Pipeline::advance(double arrival) {
  now_ = std::max(now_, arrival);
  deliverPoses();
}

void Pipeline::deliverPoses() {
  for (; !poses_.empty() && poses_.front().arrival <= now_; poses_.pop_front()) {
    fuse(poses_.front().pose, filter_);
  }
}

Pipeline::~Pipeline() = default;

void Pipeline::startGraph() {
  if (!config_.slam.mapper.usesGraph()) return;
  graph_ = std::make_unique<SubmapGraph>(config_.slam.mapper, config_.slam.loops);
}

void Pipeline::addImu(const ImuSample& sample, const Eigen::Isometry3d& base_T_imu,
                      double arrival) {
  advance(arrival);
  if (config_.level) return;
  if (projection_.gyroInDegrees()) imu_check_.convertGyro();
  const CheckedImu reading = imu_check_.check(sample, base_T_imu);
  projection_.addImu(reading);
  processQueue();  // a live node also does this before the new filter state arrives
  if (!config_.use_filter) return;
  updateFilter(reading);
  processQueue();
}

void Pipeline::updateFilter(const CheckedImu& reading) {
  if (!filter_.addImu(reading)) return;
  const FilterOutput& output = *filter_.output();
  FilteredMotion motion = motionOf(output);
  motion.gives_attitude &= config_.coupling.attitude;
  motion.gives_prediction &= config_.coupling.prediction;
  if (!config_.coupling.height) motion.height_m.reset();
  projection_.addMotion(motion);
  if (on_filter) on_filter(output);
}

void Pipeline::addRange(const HeightSample& sample, double arrival, bool is_upright) {
  advance(arrival);
  projection_.addRange(sample, is_upright);
  if (!config_.use_filter) return;
  if (is_upright) {
    filter_.addFloorHeight(sample);
  } else {
    filter_.addRange(sample);
  }
}

void Pipeline::addBarometer(const HeightSample& sample, double arrival) {
  advance(arrival);
  if (config_.use_filter && config_.coupling.barometer) filter_.addBarometer(sample);
}

void Pipeline::addScan(PipelineScan scan, double arrival) {
  advance(arrival);
  const SweepTimes times = sweepTimes(scan.data);
  const std::optional<WaitingScan> removed = queue_.push({std::move(scan), times, now_});
  if (removed) drop(removed->scan, "overload", "too many scans are waiting for their attitude");
  processQueue();
  reportProblems();
}

void Pipeline::finish() {
  finished_ = true;
  deliverPoses();
  processQueue();
  reportProblems();
}

void Pipeline::processQueue() {
  queue_.process([this](const WaitingScan& waiting) { return handle(waiting); },
                 [](const WaitingScan& waiting) { return frameOf(waiting.scan.data); });
}

/// True if the scan is finished (mapped or dropped).
bool Pipeline::handle(const WaitingScan& waiting) {
  const double waited =
      finished_ ? std::numeric_limits<double>::infinity() : now_ - waiting.arrival;
  const SweepDecision decision = projection_.judge(waiting.times, waited, now_);
  if (decision.kind == SweepDecision::kWait) return false;
  if (decision.kind == SweepDecision::kDrop) {
    drop(waiting.scan, decision.reason, decision.message);
  } else {
    map(waiting.scan, decision.kind == SweepDecision::kProjectLevel);
  }
  return true;
}

void Pipeline::map(const PipelineScan& scan, bool level) {
  begin(PipelineStage::kProjection);
  ProjectedSweep projected =
      projection_.project(scan.data, scan.base_T_laser, level, scan.odom_T_base);
  Projection& projection = projected.projection;
  const double stamp = stampOf(scan.data);
  for (const auto& height : {projection.mirror_height_m, projection.floor_height_m}) {
    if (height && config_.use_filter) filter_.addFloorHeight({stamp, *height});
  }
  if (projection.error != ScanError::kNone) {
    drop(scan, toString(projection.error), projection.message);
    return;
  }
  begin(PipelineStage::kMapping);
  MapperResult result = mapping_.process(projection.scan, scan.odom_T_base, scan.time);
  begin(PipelineStage::kGraph);
  if (graph_) addToGraph(projection.scan, result);
  begin(PipelineStage::kFilter);
  const MatchedPose pose = matchedPoseOf(result, stamp);
  projection_.addVelocity(stamp, knownVelocity(result), knownYawRate(result));
  if (config_.use_filter) poses_.push_back({now_ + config_.coupling.match_s, pose});
  if (on_scan) on_scan({scan, projected, projection.scan, result, mapping_.moving()});
}

void Pipeline::addToGraph(const PlanarScan& scan, MapperResult& result) {
  graph_->add(scan, result);
  if (lost_.add(result, scan.time)) {
    mapping_.reset(graph_->mapTLocal() * result.pose);
    graph_->beginPart(std::nullopt);
  }
  if (!graph_->isLocated()) noteUnlocated(result);
}

void Pipeline::drop(const PipelineScan& scan, const std::string& reason,
                    const std::string& message) {
  if (on_drop) on_drop({scan, reason, message});
}

void Pipeline::reportProblems() {
  if (!on_problem) return;
  std::vector<ImuFault> problems = projection_.problems(now_);
  for (ImuFault& problem : problemsOfFilter()) problems.push_back(std::move(problem));
  for (const ImuFault& problem : problems) {
    if (reported_.insert(problem.reason).second) on_problem(problem, now_);
  }
}

std::vector<ImuFault> Pipeline::problemsOfFilter() {
  constexpr double kLasting_s = 1.0;  // shorter refusals end by themselves
  std::vector<ImuFault> problems;
  if (!config_.use_filter || config_.level) return problems;
  const FilterStatus status = filter_.status(now_);
  if (status.health != FilterHealth::kBadImu) {
    filter_bad_since_.reset();
  } else if (!filter_bad_since_) {
    filter_bad_since_ = now_;
  } else if (now_ - *filter_bad_since_ > kLasting_s) {
    problems.push_back(
        {kFilterRefusesImu, "the pose filter does not use the IMU: " + status.message});
  }
  for (const auto& [reason, count] : status.resets) {
    problems.push_back({"filter: " + reason, "the pose filter was started again: " + reason});
  }
  return problems;
}

void Pipeline::setPose(const Pose2& map_T_base, const Eigen::Matrix3d& covariance) {
  mapping_.setPose(map_T_base);
  filter_.setPose(map_T_base, covariance);
}

void Pipeline::localizeIn(Submap map) {
  graph_.reset();
  mapping_.localizeIn(std::move(map));
}

void Pipeline::reset(const Pose2& map_T_base) {
  queue_.clear();
  poses_.clear();
  mapping_.reset(map_T_base);
  startGraph();
}

void Pipeline::continueWith(GraphRecord record, const std::optional<GaussianPose2>& map_T_base) {
  if (!graph_) throw std::invalid_argument("a session needs the parameter graph");
  reset(map_T_base ? map_T_base->mean : Pose2());
  graph_ =
      std::make_unique<SubmapGraph>(config_.slam.mapper, config_.slam.loops, std::move(record));
  graph_->beginPart(map_T_base);
}

}  // namespace kestrel
