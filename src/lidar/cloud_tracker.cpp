// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/lidar/cloud_tracker.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "cloud_objects.h"
#include "cloud_track_list.h"
#include "lidar_view.h"
#include "localization.h"
#include "moving_points.h"
#include "sweep_points.h"
#include "sweep_rays.h"

namespace kestrel {
namespace {

constexpr double kMaxGap = 5.0;         ///< s; after a longer gap, tracks and maps start anew
constexpr double kMaxLost = 1.0;        ///< s without localization, the same
constexpr double kForgetEvery_m = 5.0;  ///< the maps forget what is far after this distance
constexpr std::size_t kFewestPoints = 100;
constexpr int kModes = 3;                ///< motion models: constant velocity, standing, turn
constexpr double kSharpSigma = 0.3;      ///< m; twice the sigma of a place that counts as known
constexpr double kStandingJitter = 0.2;  ///< m/sqrt(s): the visible part of an object changes

PhdModel<7, 3> modelOf(const CloudTrackerConfig& config) {
  PhdModel<7, 3> model;
  model.motions = {constantVelocity<7, 3>(config.acceleration_sigma, 0.3),
                   standing<7, 3>(kStandingJitter, config.start_speed_sigma),
                   constantTurn<3>(config.acceleration_sigma, config.turn_acceleration_sigma)};
  model.clutter = [density = config.clutter_per_m3](const auto&) { return density; };
  model.expect = expectPosition<7, 3>;
  return model;
}

std::vector<Eigen::Vector3f> transformed(const std::vector<Eigen::Vector3f>& points,
                                         const Eigen::Isometry3d& pose) {
  const Eigen::Matrix3f rotation = pose.linear().cast<float>();
  const Eigen::Vector3f translation = pose.translation().cast<float>();
  std::vector<Eigen::Vector3f> result;
  result.reserve(points.size());
  for (const Eigen::Vector3f& point : points) result.push_back(rotation * point + translation);
  return result;
}

std::vector<bool> inverted(std::vector<bool> flags) {
  flags.flip();
  return flags;
}

}  // namespace

struct CloudTracker::State {
  explicit State(const CloudTrackerConfig& c)
      : config(c),
        surfaces(c.surface_resolution_m),
        grid(c.grid),
        filter(modelOf(c), c.phd),
        tracks(c) {}

  CloudTrackerConfig config;
  SurfaceMap surfaces;
  MotionGrid<3> grid;
  PhdFilter<7, 3> filter;
  CloudTrackList tracks;
  Result result;
  std::optional<double> time;  ///< of the last sweep
  double mapped_at = 0.0;      ///< of the last sweep that is in the maps
  Eigen::Isometry3d mapped_pose = Eigen::Isometry3d::Identity();           ///< then
  bool is_motion_known = false;                                            ///< `rate` is measured
  Eigen::Matrix<double, 6, 1> rate = Eigen::Matrix<double, 6, 1>::Zero();  ///< of the lidar
  Eigen::Vector3d forgotten_at = Eigen::Vector3d::Zero();
  std::vector<CloudObject> objects;  ///< of the last sweep

  /// Empty if the sweep can be used.
  std::string problemOf(const PointCloud& cloud) const {
    if (!std::isfinite(cloud.stamp)) return "the stamp of the cloud is not a number; skipped";
    if (time && cloud.stamp <= *time) {
      return "the stamp of the cloud is not newer than that of the last one; skipped. Check the "
             "clock of the lidar";
    }
    if (cloud.points.empty()) return "the cloud has no points; skipped";
    return "";
  }

  void impose(double seconds) {
    grid.impose(
        [&](const Eigen::Vector3f& cell) -> Eigen::Vector3f {
          return (seconds * tracks.velocityAt(cell.cast<double>())).cast<float>();
        },
        config.max_speed* seconds);
  }

  /// Voxels with what moves, and with what belongs to a track.
  std::vector<MovingVoxel> movingVoxels(const Voxels& voxels, const MotionGrid<3>::Result& inserted,
                                        const std::vector<Eigen::Vector3f>& points) {
    std::vector<MovingVoxel> moving;
    std::vector<std::uint32_t> slot(voxels.sums.size(), VoxelTable::kNone);
    for (std::uint32_t v = 0; v < voxels.sums.size(); ++v) {
      const Eigen::Vector3d& centroid = voxels.sums[v].mean;
      const bool wanted =
          inserted.motion[v] == CellMotion::kMoving || tracks.claims(centroid, grid);
      if (!wanted) continue;
      if (moving.size() == config.max_moving_voxels) {
        result.saturated = true;
        break;
      }
      slot[v] = static_cast<std::uint32_t>(moving.size());
      moving.push_back({v, centroid, {}, inserted.was_free[v], inserted.has_come[v]});
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::uint32_t v = voxels.voxel_of[i];
      if (v == VoxelTable::kNone || slot[v] == VoxelTable::kNone) continue;
      moving[slot[v]].points.push_back(points[i]);
    }
    return moving;
  }

  /// The nearest objects, at most as many as the filter may get.
  void limitObjects(const LidarView& view) {
    if (objects.size() <= config.max_observations) return;
    result.saturated = true;
    std::stable_sort(objects.begin(), objects.end(), [&](const auto& a, const auto& b) {
      return view.rangeOf(a.observation.value) < view.rangeOf(b.observation.value);
    });
    objects.resize(config.max_observations);
  }

  /// New targets at the observations of the last sweep that no target explains.
  std::vector<PhdComponent<7>> births() const {
    std::vector<PhdComponent<7>> births;
    const std::vector<double>& explained = filter.explained();
    for (std::size_t i = 0; i < explained.size() && i < objects.size(); ++i) {
      PhdComponent<7> birth;
      birth.weight = config.birth_weight * (1.0 - explained[i]);
      birth.mean.setZero();
      birth.mean.head<3>() = objects[i].observation.value;
      birth.covariance.setZero();
      birth.covariance.topLeftCorner<3, 3>() = objects[i].observation.noise;
      const double speed = config.birth_speed_sigma, climb = config.birth_climb_sigma;
      birth.covariance.diagonal().tail<4>() << speed * speed, speed * speed, climb * climb, 0.1;
      births.push_back(birth);
    }
    return births;
  }

  void setModel(double seconds, const LidarView& view) {
    PhdModel<7, 3>& model = filter.model();
    const double change = 0.5 * (1.0 - std::exp(-config.mode_change_per_s * seconds));
    model.mode_transition = Eigen::MatrixXd::Constant(kModes, kModes, change);
    model.mode_transition.diagonal().setConstant(1.0 - (kModes - 1) * change);
    model.survival = [p = std::exp(-seconds / config.lifetime_s)](const auto&) { return p; };
    model.detection = [this, &view](const PhdComponent<7>& component) {
      const Eigen::Vector3d center = component.mean.head<3>();
      const Eigen::Vector2d size = tracks.sizeAt(center.head<2>());
      // Over the places where it may be: the share of them that is visible.
      const double sigma = std::sqrt(component.covariance.topLeftCorner<2, 2>().trace() / 2.0);
      if (sigma > config.lost_sigma_m) return 0.0;
      const double width = size.x() + std::max(0.0, 2.0 * sigma - kSharpSigma);
      return config.detection * view.visibleShare(center, width, size.y());
    };
  }

  /// A target whose place is not known any more would explain whatever appears around it.
  void forgetLost() {
    std::map<TargetLabel, double> variance;
    for (const PhdComponent<7>& component : filter.components()) {
      const double own = component.covariance.topLeftCorner<2, 2>().trace() / 2.0;
      const auto [known, is_new] = variance.emplace(component.label, own);
      if (!is_new) known->second = std::min(known->second, own);
    }
    for (const auto& [label, least] : variance) {
      if (least > config.lost_sigma_m * config.lost_sigma_m) filter.forget(label);
    }
  }

  void follow(double seconds, const std::vector<MovingVoxel>& moving, const LidarView& view) {
    const std::vector<PhdComponent<7>> new_targets = births();
    objects = findCloudObjects(moving, view, config,
                               [this](const Eigen::Vector2d& at) { return tracks.shapeAt(at); });
    limitObjects(view);
    std::vector<Observation<3>> observations;
    for (const CloudObject& object : objects) observations.push_back(object.observation);
    setModel(seconds, view);
    // Births are targets of the last sweep: they move until this one like all others.
    filter.add(new_targets);
    filter.predict(seconds, {});
    filter.update(observations);
    forgetLost();
    tracks.update(filter, objects, moving, view, grid);
    result.tracks = tracks.tracks();
  }

  /// What does not move becomes a part of the map for the localization. `points`: of the sweep, in
  /// the map.
  void extendSurfaces(const std::vector<Eigen::Vector3f>& points, const Voxels& voxels,
                      const std::vector<CellMotion>& motion, const std::vector<MovingVoxel>& moving,
                      const Ground& ground) {
    std::vector<bool> stands;
    for (const CellMotion of_voxel : motion) stands.push_back(of_voxel == CellMotion::kStatic);
    for (const MovingVoxel& voxel : moving) stands[voxel.number] = false;
    std::vector<bool> is_static(points.size(), true);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::uint32_t v = voxels.voxel_of[i];
      if (v != VoxelTable::kNone) is_static[i] = stands[v];
    }
    const Voxels cells = voxelize(points, is_static, config.surface_resolution_m);
    surfaces.add(cells, result.pose.translation(), groundNormals(ground, cells, result.pose));
  }

  void forgetFar() {
    const Eigen::Vector3d at = result.pose.translation();
    if ((at - forgotten_at).norm() < kForgetEvery_m) return;
    forgotten_at = at;
    grid.forgetFar(at.cast<float>());
    surfaces.forgetFar(at, config.max_range_m);
  }

  void process(const LidarSweep& sweep, const SweepPoints& usable,
               const std::optional<Eigen::Isometry3d>& predicted) {
    if (!time) mapped_at = sweep.cloud.stamp;
    time = sweep.cloud.stamp;
    const double seconds = *time - mapped_at;
    const Ground ground = findGround(usable.points, config.ground);
    result.used = true;
    result.saturated = usable.thinned;
    const SweepPlace place = findSweep(usable.points, ground, surfaces, config,
                                       predicted.value_or(mapped_pose * changeOf(rate, seconds)),
                                       searchRadius(seconds, is_motion_known));
    result.localized = place.found;
    result.pose = place.pose;
    result.tracks.clear();
    const std::vector<Eigen::Vector3f> points = transformed(usable.points, result.pose);
    if (!place.contradicted) {
      noteMotion(seconds);
      map(sweep, usable, ground, points, seconds);
    }
    markMovingPoints({sweep.cloud.points.size(), usable, ground, points}, result.tracks,
                     result.moving, result.ground);
  }

  void noteMotion(double seconds) {
    is_motion_known = seconds > 0.0;
    if (is_motion_known) rate = rateOf(mapped_pose.inverse() * result.pose, seconds);
    mapped_pose = result.pose;
    mapped_at = *time;
  }

  /// `points`: of the sweep, in the map.
  void map(const LidarSweep& sweep, const SweepPoints& usable, const Ground& ground,
           const std::vector<Eigen::Vector3f>& points, double seconds) {
    const double resolution = config.grid.resolution_m;
    const Voxels voxels = voxelize(points, inverted(ground.is_ground), resolution);
    const SweepRays beams(grid, config, result.pose);
    std::vector<GridRay<3>> rays =
        beams.measured(voxels, voxelize(points, ground.is_ground, resolution));
    beams.addUnanswered(sweep.unanswered, usable.points, ground, rays);
    tracks.predict(seconds);
    impose(seconds);
    const auto& inserted = grid.insert(rays, seconds);
    if (inserted.full) result.saturated = true;
    const LidarView view(usable.points, result.pose);
    const std::vector<MovingVoxel> moving = movingVoxels(voxels, inserted, points);
    follow(seconds, moving, view);
    extendSurfaces(points, voxels, inserted.motion, moving, ground);
    forgetFar();
  }

  bool isLostForLong() const { return time && *time - mapped_at > kMaxLost && !result.localized; }
};

CloudTracker::CloudTracker(const CloudTrackerConfig& config)
    : state_(std::make_unique<State>(config)) {}
CloudTracker::~CloudTracker() = default;
CloudTracker::CloudTracker(CloudTracker&&) noexcept = default;
CloudTracker& CloudTracker::operator=(CloudTracker&&) noexcept = default;

const CloudTracker::Result& CloudTracker::process(
    const LidarSweep& sweep, const std::optional<Eigen::Isometry3d>& predicted) {
  if (state_->time && sweep.cloud.stamp - *state_->time > kMaxGap) startAnew();
  State& state = *state_;
  state.result.used = false;
  state.result.problem = state.problemOf(sweep.cloud);
  if (!state.result.problem.empty()) return state.result;
  const CloudTrackerConfig& config = state.config;
  const SweepPoints usable = usablePoints(sweep.cloud, config.min_range_m, config.max_range_m,
                                          config.max_points, state.rate);
  if (usable.points.size() < kFewestPoints) {
    state.result.problem = "the cloud has only " + std::to_string(usable.points.size()) +
                           " points within the range of the lidar; skipped";
    return state.result;
  }
  if (predicted && !predicted->matrix().allFinite()) {
    state.result.problem = "the predicted pose is not finite; skipped";
    return state.result;
  }
  state.process(sweep, usable, predicted);
  if (state.isLostForLong()) {
    startAnew();
    state_->process(sweep, usable, predicted.value_or(state_->result.pose));
    state_->result.localized = false;
    state_->result.problem = "the lidar was not localized for a second; maps and tracks start anew";
  } else if (usable.thinned) {
    state.result.problem = "the cloud has " + std::to_string(sweep.cloud.points.size()) +
                           " points; only " + std::to_string(config.max_points) + " are used";
  }
  return state_->result;
}

/// The lidar has not moved as far as anybody knows.
void CloudTracker::startAnew() {
  const Eigen::Isometry3d pose = state_->result.pose;
  reset();
  state_->result.pose = state_->mapped_pose = pose;
}

void CloudTracker::reset() {
  const long next_id = state_->tracks.nextId();
  state_ = std::make_unique<State>(state_->config);
  state_->tracks.continueFrom(next_id);
}

const Eigen::Isometry3d& CloudTracker::pose() const { return state_->result.pose; }
std::optional<double> CloudTracker::stamp() const { return state_->time; }
const SurfaceMap& CloudTracker::surfaces() const { return state_->surfaces; }
const MotionGrid<3>& CloudTracker::grid() const { return state_->grid; }
std::size_t CloudTracker::memoryBytes() const {
  return state_->surfaces.memoryBytes() + state_->grid.memoryBytes();
}

}  // namespace kestrel
