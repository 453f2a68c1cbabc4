// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/tracking/tracker.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "kestrel_slam/geometry/angles.h"
#include "object_clusters.h"
#include "track_list.h"
#include "vehicle_mask.h"
#include "visibility.h"

namespace kestrel {
namespace {

constexpr double kMaxGap = 5.0;          ///< s; after a longer gap, the tracks start anew
constexpr double kForgetEvery_m = 10.0;  ///< the grids forget what is far after this distance
constexpr double kMaxPosition = 1e6;     ///< m; poses beyond this are wrong
constexpr double kSharpSigma = 0.3;      ///< m; twice the sigma of a place that counts as known
/// At a grazing angle, the returns of neighboring beams on a wall are this many beam spacings
/// apart.
constexpr double kGrazingFactor = 6.0;
constexpr double kNoiseStep = 0.1;  ///< s, of scans at 10 Hz
constexpr int kModes = 3;           ///< motion models: constant velocity, standing, turn
/// Share of a new direction in what was found again: as probable as that it went on as before.
constexpr double kNewDirection = 0.5;
constexpr double kStandingJitter =
    0.1;  ///< m/sqrt(s): the visible part of a person who stands changes

std::vector<GridRay<2>> raysOf(const PlanarScan& scan, const Pose2& odom_T_base) {
  const auto c = static_cast<float>(std::cos(odom_T_base.yaw));
  const auto s = static_cast<float>(std::sin(odom_T_base.yaw));
  const Eigen::Vector2f t = odom_T_base.translation().cast<float>();
  const auto toOdom = [&](const Eigen::Vector2f& p) {
    return Eigen::Vector2f(t.x() + c * p.x() - s * p.y(), t.y() + s * p.x() + c * p.y());
  };
  std::vector<GridRay<2>> rays;
  rays.reserve(scan.rays.size());
  for (const PlanarRay& ray : scan.rays) {
    rays.push_back({toOdom(ray.origin), toOdom(ray.end), ray.hit, ray.no_return || ray.presumed});
  }
  return rays;
}

/// Rays that ended at something new which goes on in something static: most of it is a wall that
/// comes into view.
std::vector<bool> attachedToStatic(const std::vector<GridRay<2>>& rays,
                                   const std::vector<CellMotion>& motion, double beam_step,
                                   const TrackerConfig& config) {
  std::vector<bool> attached(rays.size(), false);
  const auto spread = [&](std::size_t i, std::size_t last) {
    if (motion[i] != CellMotion::kNew) return;
    const bool source = motion[last] == CellMotion::kStatic || attached[last];
    const double range = static_cast<double>((rays[i].end - rays[i].origin).norm());
    const double gap = std::max(config.join_gap_m, kGrazingFactor * beam_step * range);
    if (source && static_cast<double>((rays[i].end - rays[last].end).norm()) < gap) {
      attached[i] = true;
    }
  };
  for (std::size_t i = 1; i < rays.size(); ++i) spread(i, i - 1);
  for (std::size_t i = rays.size(); i-- > 1;) spread(i - 1, i);
  return attached;
}

/// The accelerations are for scans at 10 Hz. At a higher rate, those of neighboring scans are not
/// independent: the noise is scaled, so that it adds up to the same after the same time.
std::vector<MotionModel<5>> motionsOf(const TrackerConfig& config, double seconds) {
  const double scale = seconds > 0.0 ? std::sqrt(std::max(1.0, kNoiseStep / seconds)) : 1.0;
  const double acceleration = scale * config.acceleration_sigma;
  return {constantVelocity<5, 2>(acceleration, 0.3),
          standing<5, 2>(kStandingJitter, config.start_speed_sigma),
          constantTurn<2>(acceleration, scale * config.turn_acceleration_sigma)};
}

PhdModel<5, 2> modelOf(const TrackerConfig& config) {
  PhdModel<5, 2> model;
  model.clutter = [density = config.clutter_per_m2](const auto&) { return density; };
  model.expect = expectPosition<5, 2>;
  model.detection_where_seen = config.detection;
  return model;
}

}  // namespace

struct Tracker::State {
  explicit State(const TrackerConfig& c)
      : config(c), grid(c.grid), filter(modelOf(c), c.phd), tracks(c) {}

  TrackerConfig config;
  MotionGrid<2> grid;
  PhdFilter<5, 2> filter;
  TrackList tracks;
  VehicleMask mask;
  Result result;
  std::optional<double> time;
  Eigen::Vector2d forgotten_at = Eigen::Vector2d::Zero();
  std::vector<ObjectCluster> objects;  ///< of the last scan
  /// Whether a target may be an object of this scan, as far as it was asked.
  std::vector<std::vector<std::pair<TargetLabel, bool>>> causes;  ///< by object

  bool accepts(const PlanarScan& scan, const Pose2& pose) const {
    return pose.isFinite() && std::hypot(pose.x, pose.y) < kMaxPosition &&
           std::isfinite(scan.time) && (!time || scan.time > *time) && !scan.rays.empty();
  }

  void impose(double seconds) {
    grid.impose(
        [&](const Eigen::Vector2f& cell) -> Eigen::Vector2f {
          return (seconds * tracks.velocityAt(cell.cast<double>())).cast<float>();
        },
        config.imposed_m);
  }

  void forgetFar(const Eigen::Vector2d& position) {
    if ((position - forgotten_at).norm() < kForgetEvery_m) return;
    forgotten_at = position;
    grid.forgetFar(position.cast<float>());
  }

  /// Points of what moves, and of what has stopped where a track is.
  std::vector<MovingPoint> movingPoints(const std::vector<GridRay<2>>& rays,
                                        const MotionGrid<2>::Result& inserted,
                                        const std::vector<bool>& is_vehicle, double beam_step) {
    const std::vector<bool> attached = attachedToStatic(rays, inserted.motion, beam_step, config);
    std::vector<MovingPoint> points;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const Eigen::Vector2d end = rays[i].end.cast<double>();
      const CellMotion motion = result.motion[i];
      const bool wanted = motion == CellMotion::kMoving ||
                          (motion == CellMotion::kNew && !attached[i]) ||
                          (motion == CellMotion::kStopped && tracks.covers(end));
      if (!wanted || is_vehicle[i]) continue;
      if (points.size() == config.max_points) {
        result.saturated = true;
        break;
      }
      points.push_back({end, inserted.was_free[i], inserted.has_come[i], i});
    }
    return points;
  }

  /// What objects that move have in space that was not known belongs to the dynamic map.
  void claimNew() {
    for (const LabeledTarget<5>& target : filter.targets()) {
      if (target.observation < 0 || !tracks.hasMoved(target.label)) continue;
      for (const auto& point : objects[static_cast<std::size_t>(target.observation)].points) {
        grid.claim(point.cast<float>());
      }
    }
  }

  /// The nearest objects, at most as many as the filter may get.
  void limitObjects(const Visibility& visibility) {
    if (objects.size() <= config.max_observations) return;
    result.saturated = true;
    std::stable_sort(objects.begin(), objects.end(), [&](const auto& a, const auto& b) {
      return visibility.rangeOf(a.observation.value) < visibility.rangeOf(b.observation.value);
    });
    objects.resize(config.max_observations);
  }

  /// A target that was just observed at this place, with any velocity.
  PhdComponent<5> startAt(const ObjectCluster& object, double weight) const {
    PhdComponent<5> start;
    start.weight = weight;
    start.mean.setZero();
    start.mean.head<2>() = object.observation.value;
    start.covariance.setZero();
    start.covariance.topLeftCorner<2, 2>() = object.observation.noise;
    const double speed = config.birth_speed_sigma;
    start.covariance.diagonal().segment<2>(2).setConstant(speed * speed);
    start.covariance(4, 4) = 0.1;
    return start;
  }

  /// New targets at the observations of the last scan that no target explains. And what was found
  /// there after it had been hidden may have turned meanwhile: its velocity is not known.
  std::vector<PhdComponent<5>> births() const {
    std::vector<PhdComponent<5>> result_births;
    const std::vector<double>& explained = filter.explained();
    for (std::size_t i = 0; i < explained.size() && i < objects.size(); ++i) {
      result_births.push_back(startAt(objects[i], config.birth_weight * (1.0 - explained[i])));
    }
    for (const LabeledTarget<5>& target : filter.targets()) {
      if (target.observation < 0 || !tracks.wasFoundAgain(target.label)) continue;
      result_births.push_back(
          startAt(objects[static_cast<std::size_t>(target.observation)], kNewDirection));
      result_births.back().label = target.label;
    }
    return result_births;
  }

  bool mayCause(TargetLabel label, std::size_t observation) {
    auto& asked = causes[observation];
    const auto known =
        std::find_if(asked.begin(), asked.end(), [&](const auto& a) { return a.first == label; });
    if (known != asked.end()) return known->second;
    asked.emplace_back(label, tracks.mayBe(label, objects[observation], grid));
    return asked.back().second;
  }

  void setModel(double seconds, const Visibility& visibility) {
    PhdModel<5, 2>& model = filter.model();
    model.motions = motionsOf(config, seconds);
    const double change = 0.5 * (1.0 - std::exp(-config.mode_change_per_s * seconds));
    model.mode_transition = Eigen::MatrixXd::Constant(kModes, kModes, change);
    model.mode_transition.diagonal().setConstant(1.0 - (kModes - 1) * change);
    model.survival = [p = std::exp(-seconds / config.lifetime_s)](const auto&) { return p; };
    model.may_cause = [this](const PhdComponent<5>& component, std::size_t observation) {
      return mayCause(component.label, observation);
    };
    // Where nearly all places of a target are hidden, scans are not independent: it stays hidden.
    model.missed = [hidden = kHiddenShare * config.detection](double detection) {
      return detection < hidden ? 1.0 : 1.0 - detection;
    };
    model.detection = [&](const PhdComponent<5>& component) {
      const Eigen::Vector2d center = component.mean.head<2>();
      // Over the places where it may be: the share of them that is visible.
      const double sigma = std::sqrt(component.covariance.topLeftCorner<2, 2>().trace() / 2.0);
      const double width = tracks.widthAt(center) + std::max(0.0, 2.0 * sigma - kSharpSigma);
      return config.detection * visibility.visibleShare(center, width);
    };
  }

  void process(const PlanarScan& scan, const Pose2& pose) {
    const double seconds = time ? scan.time - *time : 0.0;
    time = scan.time;
    const std::vector<GridRay<2>> rays = raysOf(scan, pose);
    const Visibility visibility(rays);
    tracks.predict(seconds);
    impose(seconds);
    const auto& inserted = grid.insert(rays, seconds);
    result.motion = inserted.motion;
    result.saturated = inserted.full;
    forgetFar(pose.translation());
    const std::vector<PhdComponent<5>> new_targets = births();
    objects =
        findObjects(movingPoints(rays, inserted, mask.update(scan, pose), visibility.beamStep()),
                    rays, visibility, config, [&](const auto& points, const auto& numbers) {
                      return tracks.stoodBefore(points, numbers, grid);
                    });
    limitObjects(visibility);
    std::vector<Observation<2>> observations;
    for (const ObjectCluster& object : objects) observations.push_back(object.observation);
    setModel(seconds, visibility);
    causes.assign(objects.size(), {});
    // Births are targets of the last scan: they move until this one like all others.
    filter.add(new_targets);
    filter.predict(seconds, {});
    filter.update(observations);
    tracks.update(filter, objects, visibility, grid);
    claimNew();
    result.tracks = tracks.tracks();
    result.is_moving.assign(rays.size(), false);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const bool may_move =
          result.motion[i] != CellMotion::kNone && result.motion[i] != CellMotion::kStatic;
      result.is_moving[i] = may_move && tracks.showsAt(rays[i].end.cast<double>(), 0.0);
    }
    result.used = true;
  }
};

Tracker::Tracker(const TrackerConfig& config) : state_(std::make_unique<State>(config)) {}
Tracker::~Tracker() = default;
Tracker::Tracker(Tracker&&) noexcept = default;
Tracker& Tracker::operator=(Tracker&&) noexcept = default;

const Tracker::Result& Tracker::process(const PlanarScan& scan, const Pose2& odom_T_base) {
  state_->result.used = false;
  if (!state_->accepts(scan, odom_T_base)) return state_->result;
  if (state_->time && scan.time - *state_->time > kMaxGap) reset();
  state_->process(scan, odom_T_base);
  return state_->result;
}

const Tracker::Result& Tracker::result() const { return state_->result; }

std::vector<bool> Tracker::expectMoving(const PlanarScan& scan, const Pose2& odom_T_base) const {
  std::vector<bool> moving(scan.rays.size(), false);
  const double seconds = state_->time ? scan.time - *state_->time : 0.0;
  if (!state_->tracks.showsAny() || !(seconds < kMaxGap) || !odom_T_base.isFinite()) return moving;
  for (std::size_t i = 0; i < scan.rays.size(); ++i) {
    if (!scan.rays[i].hit) continue;
    moving[i] = state_->tracks.showsAt(odom_T_base * scan.rays[i].end.cast<double>(), seconds);
  }
  return moving;
}

const MotionGrid<2>& Tracker::grid() const { return state_->grid; }

void Tracker::reset() {
  const long next_id = state_->tracks.nextId();
  state_ = std::make_unique<State>(state_->config);
  state_->tracks.continueFrom(next_id);
}

const char* toString(SizeClass size) {
  switch (size) {
    case SizeClass::kSmall:
      return "small";
    case SizeClass::kPerson:
      return "person";
    case SizeClass::kMedium:
      return "medium";
    default:
      return "vehicle";
  }
}

SizeClass sizeClassOf(double size) {
  constexpr double kSmall = 0.25, kPerson = 1.2, kMedium = 2.5;  // m
  if (size < kSmall) return SizeClass::kSmall;
  if (size < kPerson) return SizeClass::kPerson;
  return size < kMedium ? SizeClass::kMedium : SizeClass::kVehicle;
}

const char* toString(TrackState state) {
  switch (state) {
    case TrackState::kTentative:
      return "tentative";
    case TrackState::kConfirmed:
      return "confirmed";
    default:
      return "coasting";
  }
}

}  // namespace kestrel
